"""Planar chains: any number of links on a table, and the hip-shoulder-elbow chain of a screen."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arms._body import DEGREE, Body, check_lengths, loads
from selfmotion.arms._serial import Joint, Z, at, serial_chain
from selfmotion.arrays import as_float_array
from selfmotion.errors import ShapeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Tip
from selfmotion.kinematics.inertia import RigidBody
from selfmotion.spatial import rotation_about, unit

# The share of body mass of upper arm, forearm and hand together (de Leva 1996, male).
ARM_MASS = 0.0271 + 0.0162 + 0.0061


def planar(
    lengths: ArrayLike | None = None,
    *,
    joints: Sequence[str] | None = None,
    body: Body | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Arm:
    """Build an n-link arm in the x-y plane of the ground.

    Angles are relative, counter-clockwise about z; at zero all links lie along +x. The plane is
    horizontal (a table) unless gravity says otherwise. Links are uniform rods that share the
    arm's mass by their length. A planar chain has no limits of its own: they are half a turn
    either way; set a person's with `Arm.with_limits`.

    Args:
        lengths: (n,) link lengths (m); left out: upper arm, forearm and hand of the body.
        joints: names of the joints; left out: joint_1, joint_2, ...
        body: whose mass and default lengths; left out: 70 kg, 1.75 m.
        gravity: (3,) acceleration (m/s²); (0, -9.81, 0) stands the plane upright, with y up.

    Returns:
        The arm. Its shoulder is the first joint, its elbow the second, its wrist the third (the
        tip where there are fewer), its hand the tip.

    Raises:
        ShapeError: no link, or another number of names than links.
        RangeError: a length is not a positive number.

    Example:
        >>> planar([0.3, 0.25]).joints
        ('joint_1', 'joint_2')
    """
    person = body or Body()
    if lengths is None:
        segments = ("upper_arm", "forearm", "hand")
        lengths = [person.length(name) for name in segments]
    n = as_float_array("lengths", lengths, ndim=1).size
    if n == 0:
        raise ShapeError("lengths: a planar arm needs at least one link")
    names = tuple(f"joint_{i + 1}" for i in range(n)) if joints is None else tuple(joints)
    if len(names) != n or len(set(names)) != n:
        raise ShapeError(f"joints = {list(names)}: {n} links need {n} different names")
    links = check_lengths([f"link_{i + 1}" for i in range(n)], lengths)
    sizes = np.array(list(links.values()))
    starts = [0.0, *sizes[:-1]]
    chain = serial_chain(
        [
            Joint(name, Z, (-np.pi, np.pi), at((start, 0.0, 0.0)))
            for name, start in zip(names, starts, strict=True)
        ]
    )
    g = as_float_array("gravity", gravity, ndim=1)
    hand = Tip(n - 1, at((sizes[-1], 0.0, 0.0)))
    rods = [_rod(ARM_MASS * person.mass * size / sizes.sum(), size) for size in sizes]
    return Arm(
        name="planar",
        task="planar",
        chain=chain,
        landmarks={
            "shoulder": Tip(GROUND),
            "elbow": Tip(1) if n > 1 else hand,
            "wrist": Tip(2) if n > 2 else hand,
            "hand": hand,
        },
        lengths=links,
        gravity=g,
        up=_up(g),
        forward=np.array([1.0, 0.0, 0.0]) if abs(_up(g)[1]) > 0.5 else np.array([0.0, 1.0, 0.0]),
        source="n-link planar chain; limits half a turn; uniform rods, arm mass of de Leva 1996",
        **loads(n, list(enumerate(rods))),
    )


def hip_shoulder_elbow(lengths: ArrayLike | None = None, *, body: Body | None = None) -> Arm:
    """Build the planar chain of [Khoramshahi2022] experiment 2: hip, shoulder, elbow.

    The sagittal plane, x forward and y up, so that the task is ``Planar(arm)`` with its default
    axes x and y; gravity along -y. Angles are relative and counter-clockwise (seen with x to the
    right). At zero everything points straight up: hip 0 is an upright trunk, leaning forward is
    negative; the shoulder at -pi hangs along the trunk; the elbow flexes with positive angles.
    The paper does not define its zero; this is the reading under which its rest posture of
    eq. 25, (0, -2.7, 0) rad, is an upright trunk with the arm slightly raised, and its elbow
    limits [0, pi] are those of flexion.

    Limits: elbow [0, pi] from the paper; shoulder 180° of flexion and 60° of extension, hip 80°
    of flexion and 25° of extension (American Academy of Orthopaedic Surgeons 1965).

    Args:
        lengths: (3,) trunk (hip to shoulder), upper arm, forearm with hand (m); left out: those
            of the body (de Leva 1996), since the paper does not give its own.
        body: whose masses and default lengths; left out: 70 kg, 1.75 m.

    Raises:
        ShapeError: not three lengths.
        RangeError: a length is not a positive number.

    Example:
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = hip_shoulder_elbow([0.5, 0.3, 0.35])
        >>> T = forward_kinematics(arm.chain, [0.0, -np.pi, 0.0], arm.tip("hand"))
        >>> T[0, :2, 3].round(6).tolist()
        [0.0, -0.15]
    """
    person = body or Body()
    forearm, hand = person.length("forearm"), person.length("hand")
    if lengths is None:
        lengths = [person.length("trunk_and_head"), person.length("upper_arm"), forearm + hand]
    sizes = check_lengths(("trunk", "upper_arm", "forearm_and_hand"), lengths)
    trunk, upper, lower = sizes.values()
    chain = serial_chain(
        [
            Joint("hip", Z, (-80 * DEGREE, 25 * DEGREE), at(rotation=rotation_about(Z, np.pi / 2))),
            Joint("shoulder", Z, (-4 * np.pi / 3, 0.0), at((trunk, 0.0, 0.0))),
            Joint("elbow", Z, (0.0, np.pi), at((upper, 0.0, 0.0))),
        ]
    )
    origin, wrist = np.zeros(3), np.array([lower * forearm / (forearm + hand), 0.0, 0.0])
    tip = np.array([lower, 0.0, 0.0])
    return Arm(
        name="hip_shoulder_elbow",
        task="planar",
        chain=chain,
        landmarks={
            "hip": Tip(GROUND),
            "shoulder": Tip(1),
            "elbow": Tip(2),
            "wrist": Tip(2, at(wrist)),
            "hand": Tip(2, at(tip)),
        },
        lengths=sizes,
        gravity=np.array([0.0, -9.81, 0.0]),
        up=np.array([0.0, 1.0, 0.0]),
        forward=np.array([1.0, 0.0, 0.0]),
        source=(
            "Khoramshahi 2022, experiment 2; limits: elbow of the paper, others AAOS 1965; "
            "lengths and masses of de Leva 1996"
        ),
        **loads(
            3,
            [
                (0, person.segment("trunk_and_head", start=origin, end=(trunk, 0, 0))),
                (1, person.segment("upper_arm", start=origin, end=(upper, 0, 0))),
                (2, person.segment("forearm", start=origin, end=wrist)),
                (2, person.hand(wrist=wrist, towards=tip)),
            ],
        ),
    )


def _rod(mass: float, length: float) -> RigidBody:
    """Give a thin uniform rod from the origin along x."""
    across = mass * length**2 / 12.0
    return RigidBody(mass, np.array([length / 2, 0.0, 0.0]), np.diag([0.0, across, across]))


def _up(gravity: np.ndarray) -> np.ndarray:
    if not gravity.any():
        return np.array([0.0, 0.0, 1.0])
    return -unit("gravity", gravity)
