"""The 4-DoF shoulder-elbow arm of [Khoramshahi2022] experiment 1 (the ABLE exoskeleton).

doi 10.1371/journal.pone.0278228. Ground: x forward, y left, z up, origin at the shoulder; at
zero the straight arm hangs. R = Rx(q1) Rz(q2) Ry(-q3) at the shoulder, Ry(-q4) at the elbow:
an elevation about the anteroposterior axis, axial rotation, flexion in the plane that the two
define, elbow flexion. The elbow alone changes the distance from shoulder to hand, so that no
motion that keeps the hand in place can use it (z4 = 0) and its weight cannot be identified.
"""

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arms._body import BOONE_AZEN, DEGREE, Body, check_lengths, loads
from selfmotion.arms._serial import Joint, X, Y, Z, at, serial_chain
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Tip
from selfmotion.spatial import unit


def exoskeleton(
    lengths: ArrayLike | None = None,
    *,
    body: Body | None = None,
    elevation_axis: ArrayLike = (1.0, 0.0, 0.0),
) -> Arm:
    """Build the 4-DoF shoulder-elbow arm with the wrist held by an orthosis.

    Positive q2 turns the bent forearm to the left (inward, for a right arm), q3 and q4 flex. With
    the default elevation axis positive q1 raises the arm to the left. The paper counts elevation
    positive and calls q2 positive when inward, which no one formula gives for either side: for a
    right arm recorded with elevation positive, pass ``elevation_axis=(-1, 0, 0)``. IK weights do
    not depend on that sign as long as q and the Jacobian agree.

    Limits: the exoskeleton's are not given by the paper (and were never met); those of a
    shoulder and an elbow are used (Boone & Azen 1979), for elevation to either side.

    Args:
        lengths: (2,) upper arm, forearm with hand (m); left out: those of the body.
        body: whose masses and default lengths; left out: 70 kg, 1.75 m.
        elevation_axis: (3,) axis of q1 in the ground.

    Raises:
        ShapeError: not two lengths.
        RangeError: a length is not a positive number, or the axis has no direction.

    Example:
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = exoskeleton([0.3, 0.35])
        >>> T = forward_kinematics(arm.chain, [0, 0, 0, np.pi / 2], arm.tip("hand"))
        >>> (T[0, :3, 3].round(6) + 0.0).tolist()  # no negative zero
        [0.35, 0.0, -0.3]
    """
    person = body or Body()
    forearm, hand = person.length("forearm"), person.length("hand")
    if lengths is None:
        lengths = [person.length("upper_arm"), forearm + hand]
    sizes = check_lengths(("upper_arm", "forearm_and_hand"), lengths)
    upper, lower = sizes.values()
    deg = {name: value * DEGREE for name, value in BOONE_AZEN.items()}
    elevation = deg["shoulder_abduction"]
    inward, outward = deg["shoulder_inward_rotation"], deg["shoulder_outward_rotation"]
    flexion = (-deg["shoulder_extension"], deg["shoulder_flexion"])
    elbow = (-deg["elbow_extension"], deg["elbow_flexion"])
    axis = unit("elevation_axis", elevation_axis)
    chain = serial_chain(
        [
            Joint("shoulder_elevation", axis, (-elevation, elevation), at()),
            Joint("shoulder_rotation", Z, (-outward, inward), at()),
            Joint("shoulder_flexion", -Y, flexion, at()),
            Joint("elbow_flexion", -Y, elbow, at((0.0, 0.0, -upper))),
        ]
    )
    origin, tip = np.zeros(3), np.array([0.0, 0.0, -lower])
    wrist = tip * forearm / (forearm + hand)
    return Arm(
        name="exoskeleton",
        chain=chain,
        landmarks={
            "shoulder": Tip(GROUND),
            "elbow": Tip(3),
            "wrist": Tip(3, at(wrist)),
            "hand": Tip(3, at(tip)),
        },
        lengths=sizes,
        forward=X,
        source=(
            "Khoramshahi 2022, experiment 1 (ABLE); limits Boone & Azen 1979; lengths and masses "
            "of de Leva 1996, without the device"
        ),
        **loads(
            4,
            [
                (2, person.segment("upper_arm", start=origin, end=(0, 0, -upper))),
                (3, person.segment("forearm", start=origin, end=wrist)),
                (3, person.hand(wrist=wrist, towards=tip)),
            ],
        ),
    )
