"""Reach with the hand held: areas and arcs known in closed form, conflicts named."""

import numpy as np
import pytest

from selfmotion.arms import load_arm, planar
from selfmotion.errors import NotFiniteError, RangeError, UnknownNameError
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.hand_circle import DeviceCircle, circle_reach
from selfmotion.methods.hand_constraints import held_reach
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.workspace import WorkspaceOptions
from tests.methods.test_workspace import telescope

QUICK = WorkspaceOptions(n_points=256, shifts=12)
LENGTHS = (0.3, 0.2, 0.1)


def close(found, true):
    error = found.region.standard_error
    assert found.region.volume == pytest.approx(true, abs=5 * error + 2e-3 * true)


def test_a_plane_and_a_line_through_a_shell():
    """The telescope fills the shell from 0.3 to 0.5 m."""
    plane = held_reach(telescope(), {"x": 0.0}, options=QUICK)
    assert plane.unit == "m²"
    close(plane, np.pi * (0.5**2 - 0.3**2))
    line = held_reach(telescope(), {"x": 0.0, "z": 0.0}, options=QUICK)
    assert line.unit == "m"
    close(line, 2 * (0.5 - 0.3))
    assert "reaches" in line.summary() and "orientation free" not in line.summary()


@pytest.mark.parametrize("angle", [0.0, 2.0])
def test_three_links_with_the_last_one_held_reach_the_ring_of_two(angle):
    a, b, c = LENGTHS
    found = held_reach(planar(LENGTHS), {"z": 0.0, "rot_z": angle}, options=QUICK)
    close(found, np.pi * ((a + b) ** 2 - (a - b) ** 2))
    whole = np.pi * (a + b + c) ** 2  # no hollow: 0.3 is less than 0.2 + 0.1 and more
    assert found.by_position.volume == pytest.approx(whole, rel=0.03)
    away = found.region.points - [c * np.cos(angle), c * np.sin(angle), 0.0]
    r = np.linalg.norm(away, axis=1)
    inside = found.region.inside
    assert (r[inside] < a + b + 1e-4).all() and (r[inside] > a - b - 1e-4).all()
    assert not (inside & ~found.by_position.inside).any()


def test_postures_meet_what_is_held():
    arm = load_arm("upper_limb")
    found = held_reach(arm, {"rot_y": 0.3, "x": 0.15}, options=QUICK)
    rows = found.region.inside
    value = HandRows(arm, ("x", "y", "z", "rot_y")).value(found.q[rows])
    np.testing.assert_allclose(value[:, :3], found.region.points[rows], atol=2e-5)
    np.testing.assert_allclose(value[:, 3], 0.3, atol=2e-4)
    np.testing.assert_allclose(found.region.points[:, 0], 0.15)
    assert (found.q[rows] >= arm.lower).all() and (found.q[rows] <= arm.upper).all()
    assert list(found.to_frame().columns[:4]) == ["x", "y", "z", arm.joints[0]]


def test_a_body_takes_its_part():
    half = held_reach(telescope(), {"x": 0.0}, blocked=lambda p: p[:, 2] > 0, options=QUICK)
    close(half, 0.5 * np.pi * (0.5**2 - 0.3**2))


def test_arc_of_a_circle_in_closed_form():
    """Hand held along x: the wrist is on a circle, which meets that of the stretched links."""
    a, b, c = LENGTHS
    radius, centre = 0.25, 0.45
    circle = DeviceCircle("xy", (centre + c, 0.0, 0.0), radius)
    found = circle_reach(planar(LENGTHS), circle, {"rot_z": 0.0}, n_samples=40)
    (arc,) = found.arcs
    # |centre + radius e(t)| = a + b
    t = np.arccos(((a + b) ** 2 - centre**2 - radius**2) / (2 * centre * radius))
    assert arc.first == pytest.approx(t, abs=1e-3)
    assert arc.last == pytest.approx(2 * np.pi - t, abs=1e-3)
    assert found.share == pytest.approx((np.pi - t) / np.pi, abs=1e-3)
    assert arc.path.status.ok and "followed without a jump" in found.summary()
    steps = found.trajectories()
    arm = found.arm
    hand = forward_kinematics(arm.chain, steps[list(arm.joints)].to_numpy(), arm.tip("hand"))
    np.testing.assert_allclose(hand[:, :3, 3], steps[["x", "y", "z"]], atol=2e-5)
    lengths = found.to_frame()["length_m"].to_list()
    assert lengths == pytest.approx([radius * (arc.last - arc.first)])


@pytest.mark.parametrize(
    ("held", "reason"),
    [
        ({"x": 2.0}, "no posture of upper_limb has x = 2000 mm; allowed is about -0.4.* to 0.80"),
        ({"x": 2.0, "rot_y": 0.0}, "has x = 2000 mm; allowed"),
        ({"y": 0.5, "z": 0.5}, "has y = 500 mm and z = 500 mm together"),
        ({"x": 0.1, "y": 0.5, "z": 0.5}, "all held"),
        ({}, "no row of the hand is held"),
    ],
)
def test_constraints_that_leave_nothing_are_named(held, reason):
    with pytest.raises(RangeError, match=reason):
        held_reach(load_arm("upper_limb"), held, options=QUICK)


def test_bad_rows():
    arm = load_arm("upper_limb")
    with pytest.raises(UnknownNameError, match="unknown row 'roll'"):
        held_reach(arm, {"roll": 0.0})
    with pytest.raises(NotFiniteError):
        held_reach(arm, {"rot_x": float("nan")})


@pytest.mark.parametrize(
    ("circle", "held", "reason"),
    [
        (("yz", (0.15, 3.0, 0.0), 0.2), {}, "out of reach, the nearest point by 2"),
        (("yz", (0.15, 0.36, -0.16), 0.2), {"x": 0.1}, "x is held, and a circle too"),
        (("xw", (0.15, 0.36, -0.16), 0.2), {}, "plane = 'xw'"),
        (("yz", (0.15, 0.36, -0.16), -0.2), {}, "radius = -0.2 m"),
    ],
)
def test_bad_circles(circle, held, reason):
    with pytest.raises(RangeError, match=reason):
        circle_reach(load_arm("upper_limb"), DeviceCircle(*circle), held)


def test_a_circle_names_the_angle_that_leaves_nothing():
    arm = planar(LENGTHS).with_limits({"joint_3": (0.0, 0.1)})
    circle = DeviceCircle("xy", (0.55, 0.0, 0.0), 0.03)
    with pytest.raises(RangeError, match="with rot_z = 180 deg; without it some is"):
        circle_reach(arm, circle, {"rot_z": np.pi}, n_samples=16)
