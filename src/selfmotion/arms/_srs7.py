"""The 7-DoF spherical-revolute-spherical arm of [Li2022] Table I.

doi 10.1109/TNSRE.2022.3198400. Rows are modified Denavit-Hartenberg (Craig). Ground as in the
paper's base frame: x forward, y up, z right. The table's constants a0 and θ0, which it does not
give, place the shoulder; here the shoulder's position in the ground does that, with θ0 = 0.
"""

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arms._body import DEGREE, Body, check_lengths, loads
from selfmotion.arms._serial import Joint, Z, at, craig, serial_chain
from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Tip

# Degrees: the ranges of the musculoskeletal arm that this one stands for (Saul et al. 2015, doi
# 10.1080/10255842.2014.916698); its axial rotation is counted against the plane of elevation
# there, so that here it may take any angle.
LIMITS_DEG = {
    "elevation_plane": (-95.0, 130.0),
    "shoulder_elevation": (0.0, 180.0),
    "shoulder_rotation": (-180.0, 180.0),
    "elbow_flexion": (0.0, 130.0),
    "wrist_pronation": (-90.0, 90.0),
    "wrist_deviation": (-10.0, 25.0),
    "wrist_flexion": (-70.0, 70.0),
}

# Frame 0 has z up, x to the right and y forward; columns are its axes in the ground.
_R_GROUND_0 = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
# Frame 7 to the hand frame, whose axes are those of the ground when the arm hangs at zero.
_R_7_HAND = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])

QUARTER = np.pi / 2


def srs7(
    lengths: ArrayLike | None = None,
    *,
    shoulder: ArrayLike = (0.0, 0.0, 0.0),
    body: Body | None = None,
) -> Arm:
    """Build the 7-DoF arm: three axes in the shoulder, one in the elbow, three in the wrist.

    At zero the right arm hangs with the thumb forward. The plane of elevation is 0 sideways and
    positive forwards; elbow flexion, pronation, ulnar deviation and wrist flexion are positive.
    The hand is the wrist-centre frame, whose axes at zero are x forward, y up, z right.

    Args:
        lengths: (2,) upper arm d_se and forearm d_ew (m); left out: those of the body.
        shoulder: (3,) shoulder centre in the ground (m).
        body: whose masses and default lengths; left out: 70 kg, 1.75 m.

    Raises:
        ShapeError: not two lengths, or the shoulder is not a point.
        RangeError: a length is not a positive number.

    Example:
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = srs7([0.3, 0.25])
        >>> T = forward_kinematics(arm.chain, [0, 0, 0, np.pi / 2, 0, 0, 0], arm.tip("hand"))
        >>> (T[0, :3, 3].round(6) + 0.0).tolist()  # no negative zero
        [0.25, -0.3, 0.0]
    """
    person = body or Body()
    if lengths is None:
        lengths = [person.length("upper_arm"), person.length("forearm")]
    sizes = check_lengths(("upper_arm", "forearm"), lengths)
    upper, fore = sizes.values()
    centre = as_float_array("shoulder", shoulder)
    require_shape("shoulder", centre, (3,))
    require_finite("shoulder", centre)
    base = at(centre, _R_GROUND_0)
    offsets = (
        base @ craig(twist=0.0),
        craig(twist=QUARTER),
        craig(twist=-QUARTER, angle=QUARTER, d=-upper),
        craig(twist=QUARTER),
        craig(twist=-QUARTER, d=-fore),
        craig(twist=-QUARTER, angle=QUARTER),
        craig(twist=QUARTER),
    )
    chain = serial_chain(
        [
            Joint(name, Z, (low * DEGREE, high * DEGREE), offset)
            for (name, (low, high)), offset in zip(LIMITS_DEG.items(), offsets, strict=True)
        ]
    )
    origin, hand = np.zeros(3), person.length("hand")
    wrist_frame = at(rotation=_R_7_HAND)
    return Arm(
        name="srs7",
        chain=chain,
        landmarks={
            "shoulder": Tip(GROUND, at(centre)),
            "elbow": Tip(3),
            "wrist": Tip(6, wrist_frame),
            "hand": Tip(6, wrist_frame),
            "palm": Tip(6, wrist_frame @ at((0.0, -hand, 0.0))),
        },
        lengths=sizes,
        gravity=np.array([0.0, -9.81, 0.0]),
        up=np.array([0.0, 1.0, 0.0]),
        forward=np.array([1.0, 0.0, 0.0]),
        source="Li 2022, Table I; limits Saul 2015; lengths and masses of de Leva 1996",
        **loads(
            7,
            [
                (2, person.segment("upper_arm", start=(0, 0, upper), end=origin)),
                (3, person.segment("forearm", start=origin, end=(0, -fore, 0))),
                (6, person.hand(wrist=origin, towards=_R_7_HAND @ np.array([0.0, -1.0, 0.0]))),
            ],
        ),
    )
