import mujoco
import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.viewer.bones import simplified, skeleton_of
from selfmotion.viewer.scene import (
    activation_colours,
    ground_to_ground,
    landmark_line,
    muscle_lines,
)

Q = np.array([0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1])


@pytest.fixture(scope="module")
def model():
    return load_musculoskeletal_arm()


def test_bones_are_where_the_chain_puts_them(model):
    skeleton = skeleton_of(model)
    assert skeleton is not None
    positions, quaternions = skeleton.place(Q)
    names = [bone.name for bone in skeleton.bones]
    elbow = tip_positions(model.arm.chain, Q[None], [model.arm.tip("elbow")])[0, 0]
    np.testing.assert_allclose(positions[names.index("ulna_r")], elbow, atol=1e-10)
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-12)


def test_a_moved_arm_leaves_the_trunk(model):
    skeleton = skeleton_of(model)
    assert skeleton is not None
    names = [bone.name for bone in skeleton.bones]
    before, after = skeleton.place(Q)[0], skeleton.place(Q + 0.3)[0]
    moved = np.linalg.norm(after - before, axis=1) > 1e-9
    assert not moved[names.index("hat_skull")] and moved[names.index("3mc_r")]


def test_simplified_stays_within_a_cell_of_the_surface(model):
    m = model.geometry.model
    mesh = m.mesh("2mc_r").id
    first, count = m.mesh_vertadr[mesh], m.mesh_vertnum[mesh]
    v = np.asarray(m.mesh_vert[first : first + count], dtype=float)
    start, number = m.mesh_faceadr[mesh], m.mesh_facenum[mesh]
    f = np.asarray(m.mesh_face[start : start + number], dtype=np.int64)
    fewer, faces = simplified(v, f, 0.002)
    assert len(faces) < 0.5 * len(f) and faces.max() < len(fewer)
    nearest = np.min(np.linalg.norm(fewer[:, None] - v[None], axis=2), axis=1)
    assert nearest.max() < 0.002 * np.sqrt(3.0)


def test_muscle_lines_are_as_long_as_the_paths_without_wrapping(model):
    lines = muscle_lines(model, Q, np.full(63, 0.2))
    assert lines.points.shape == lines.colours.shape
    lengths = model.geometry.lengths(Q[None])[0]
    pieces = np.linalg.norm(np.diff(lines.points, axis=1)[:, 0], axis=1).sum()
    # Arcs around wrapping surfaces are longer than the chords drawn for them.
    assert 0.9 * lengths.sum() < pieces <= lengths.sum() + 1e-9


def test_activation_darkens_and_the_unknown_is_pale():
    colours = activation_colours(np.array([0.0, 0.2, 0.4, 1.0, np.nan])).astype(int)
    brightness = colours.sum(axis=1)
    assert brightness[0] > brightness[1] > brightness[2] == brightness[3]
    assert (colours[4] == colours[0]).all()


@pytest.mark.parametrize("name", ["upper_limb_anatomical", "exoskeleton", "srs7"])
def test_grounds_fall_together(model, name):
    arm, shown = load_arm(name), model.arm
    T = ground_to_ground(arm, shown)
    np.testing.assert_allclose(T[:3, :3] @ arm.up, shown.up, atol=1e-12)
    np.testing.assert_allclose(T[:3, :3] @ arm.forward, shown.forward, atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    q = np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)
    there = np.clip(np.zeros(7), shown.lower, shown.upper)
    shoulder = T[:3, :3] @ landmark_line(arm, q[None])[0, 0] + T[:3, 3]
    np.testing.assert_allclose(shoulder, landmark_line(shown, there[None])[0, 0], atol=1e-12)


def test_a_model_without_meshes_has_no_skeleton(model):
    bare = mujoco.MjSpec.from_string(
        """<mujoco><worldbody><body><joint name="j" axis="0 1 0"/>
        <geom size="0.05"/></body></worldbody></mujoco>"""
    ).compile()
    from dataclasses import replace

    geometry = replace(model.geometry, model=bare)
    assert skeleton_of(replace(model, geometry=geometry)) is None
