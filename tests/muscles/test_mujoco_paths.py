from dataclasses import replace

import mujoco
import numpy as np
import pytest

from selfmotion.kinematics.mujoco_chain import chain_from_mujoco
from selfmotion.muscles.mujoco_bridge import muscles_from_mujoco

# One muscle over a surface on the upper body, from the ground to a second body; the surface is
# off the straight line by turns of the joints, so that the path meets it in some postures only.
MODEL = """
<mujoco>
  <worldbody>
    <site name="o" pos="0.12 0.03 0.05"/>
    <body name="a">
      <joint name="j1" axis="0 1 0" range="-60 60"/> <joint name="j2" axis="1 0 0" range="-60 60"/>
      <geom name="s" type="{type}" size="{size}" pos="0.01 0.02 -0.05" euler="70 20 10" mass="1"/>
      {side}
      <body name="b" pos="0 0 -0.2">
        <joint name="j3" axis="0.6 0.8 0" range="-90 90"/>
        <joint name="j4" type="slide" axis="0 0 1" range="-0.02 0.02"/>
        <geom size="0.02" pos="0 0 -0.1"/> <site name="i" pos="0.05 0.02 -0.08"/>
        <site name="hand" pos="0 0 -0.2"/>
      </body>
    </body>
  </worldbody>
  <tendon> <spatial name="t"> <site site="o"/> <geom geom="s" {named}/> <site site="i"/>
  </spatial> </tendon>
  <actuator> <muscle name="m" tendon="t" gear="{gear}" lengthrange="0.1 0.5"/> </actuator>
</mujoco>
"""
SIDES = {"none": None, "outside": "0.06 0.09 -0.05", "inside": "0.012 0.02 -0.051"}


def geometry_of(text: str):
    model = mujoco.MjModel.from_xml_string(text)
    chain = chain_from_mujoco(model, tip="hand").chain
    return chain, muscles_from_mujoco(model, chain)[1]


def by_mujoco(geometry, q):
    other = replace(geometry)
    other.__dict__["_tables"] = None  # as for paths that our kernel does not know
    return other.lengths_and_moment_arms(q)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("type_", "size"), [("sphere", "0.04"), ("cylinder", "0.035 0.2")])
def test_paths_over_a_surface_are_those_of_mujoco(type_, size, side):
    place = SIDES[side]
    text = MODEL.format(
        type=type_,
        size=size,
        side="" if place is None else f'<site name="beside" pos="{place}"/>',
        named="" if place is None else 'sidesite="beside"',
        gear="-1.5" if side == "outside" else "1",
    )
    chain, geometry = geometry_of(text)
    q = np.random.default_rng(0).uniform(chain.lower, chain.upper, (400, 4))
    lengths, arms = geometry.lengths_and_moment_arms(q)
    expected, expected_arms = by_mujoco(geometry, q)
    np.testing.assert_allclose(lengths, expected, atol=1e-12)
    # From inside, MuJoCo solves for the angle to 1e-6.
    np.testing.assert_allclose(arms, expected_arms, atol=1e-6 if side == "inside" else 1e-12)
    straight = MODEL.format(type=type_, size="1e-4 0.2", side="", named="", gear="1")
    shortest = np.abs(geometry_of(straight)[1].lengths(q))
    met = np.abs(lengths)[:, 0] / (1.5 if side == "outside" else 1.0) > shortest[:, 0] + 1e-6
    assert 0.02 < met.mean() < 1.0  # some paths meet the surface, others pass it by


def test_every_path_of_the_default_arm_is_that_of_mujoco(muscle_arm):
    q = muscle_arm.arm.random_postures(200, np.random.default_rng(1))
    lengths, arms = muscle_arm.geometry.lengths_and_moment_arms(q)
    expected, expected_arms = by_mujoco(muscle_arm.geometry, q)
    np.testing.assert_allclose(lengths, expected, atol=1e-12)
    np.testing.assert_allclose(arms, expected_arms, atol=1e-7)


def test_paths_with_a_pulley_are_left_to_mujoco():
    text = MODEL.format(type="sphere", size="0.04", side="", named="", gear="1")
    text = text.replace(
        '<site site="i"/>',
        '<site site="i"/> <pulley divisor="2"/> <site site="o"/> <site site="i"/>',
    )
    chain, geometry = geometry_of(text)
    assert geometry._tables is None
    q = np.zeros((1, 4))
    step = 1e-6 * np.eye(4)[0]
    slope = (geometry.lengths(q + step) - geometry.lengths(q - step)) / 2e-6
    np.testing.assert_allclose(geometry.moment_arms(q)[:, :, 0], -slope, atol=1e-8)
