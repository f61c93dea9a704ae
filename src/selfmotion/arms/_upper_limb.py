"""The 9-DoF upper limb complex of [DeBoon]: as printed, and with its anatomy put right.

Implements Table 1 (modified Denavit-Hartenberg), Table 3 (limits) and the lengths of section 4.2
(J Biomech Eng). Ground: origin at the right sternoclavicular joint, x to the right, y forward,
z up.

The printed model, taken at its word, has four oddities; each has a named correction in
`Corrections`. Table 3 has lost the upper limits of the wrist's three joints: 29.6, 79.2 and 152.9
degrees are assumed, the total arcs of Boone & Azen (1979) less the side that is printed.
"""

from dataclasses import astuple, dataclass, fields

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arms._body import DEGREE, Body, check_lengths, loads
from selfmotion.arms._serial import Joint, X, Y, Z, at, craig, serial_chain
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Tip

JOINTS = (
    "scapula_protraction",
    "scapula_elevation",
    "shoulder_flexion",
    "shoulder_adduction",
    "shoulder_rotation",
    "elbow_flexion",
    "wrist_deviation",
    "wrist_flexion",
    "wrist_pronation",
)
SEGMENTS = ("clavicle", "upper_arm", "forearm", "hand")
LENGTHS = (0.188, 0.286, 0.259, 0.074)  # m, section 4.2; the hand to the palm's centre

# Degrees, Table 3; the last three upper limits are assumptions (see above).
LIMITS_DEG = (
    (-14.1, 13.4),
    (-6.4, 12.2),
    (-21.3, 180.0),
    (0.4, 160.7),
    (-68.0, 133.0),
    (15.8, 150.7),
    (-27.9, 29.6),
    (-72.1, 79.2),
    (-5.0, 152.9),
)
SPLINT_DEG = (64.2, 114.0)  # of the elbow, with the brace of section 4.2
REST_DEG = (0.0, 0.0, 0.0, 90.0, 0.0, 20.0, 0.0, 0.0, 0.0)  # Table 3; the arm hangs

QUARTER = np.pi / 2


@dataclass(frozen=True)
class Corrections:
    """Which of the printed model's oddities are put right; none by default.

    Attributes:
        shoulder_rotation_offset: θ5 counts from a quarter turn further out, so that at θ5 = 0
            the elbow of a hanging arm flexes forward; as printed it flexes towards the belly.
        scapula_sign: θ2 is positive upwards, so that Table 3's 12.2 degrees are elevation and
            its 6.4 degrees depression; as printed it is positive downwards.
        universal_wrist: pronation turns about the forearm's axis before the wrist (positive from
            palm forward to palm back), deviation (positive ulnar) and flexion turn about two axes
            across the hand. As printed the wrist is Z-Y-Z: its "deviation" turns about the
            forearm and its "pronation" about the hand, so that there is no true deviation and
            both axes fall on one line at θ8 = 0.
        abduction_from_hanging: θ4 is 0 for a hanging arm and positive sideways and up, so that
            Table 3's 0.4 to 160.7 degrees are abduction. As printed θ4 is 90 degrees when
            hanging, 0.4 with the arm out to the side and 160.7 with it across the body.
    """

    shoulder_rotation_offset: bool = False
    scapula_sign: bool = False
    universal_wrist: bool = False
    abduction_from_hanging: bool = False


PRINTED = Corrections()
ANATOMICAL = Corrections(True, True, True, True)


def upper_limb(
    lengths: ArrayLike = LENGTHS,
    *,
    corrections: Corrections = PRINTED,
    body: Body | None = None,
) -> Arm:
    """Build the 9-DoF upper limb complex, as printed unless corrections are named.

    Args:
        lengths: (4,) clavicle, upper arm, forearm, wrist to palm centre (m).
        corrections: which oddities of the printed model are put right.
        body: whose masses; left out: 70 kg, 1.75 m. The shoulder girdle carries none: de Leva's
            tables count it to the trunk.

    Returns:
        The arm; its hand is the palm centre (frame 10 of Table 1), z along the hand.

    Raises:
        ShapeError: not four lengths.
        RangeError: a length is not a positive number.

    Example:
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = upper_limb()
        >>> T = forward_kinematics(arm.chain, upper_limb_rest(), arm.tip("hand"))
        >>> (1e3 * T[0, :3, 3]).round(2).tolist()
        [74.11, 0.0, -598.92]
    """
    person = body or Body()
    sizes = check_lengths(SEGMENTS, lengths)
    clavicle, upper, fore, palm = sizes.values()
    joints = _girdle_and_shoulder(clavicle, upper, corrections)
    joints.append(_joint("elbow_flexion", craig(twist=-QUARTER)))
    joints += _wrist(fore, corrections)
    chain = serial_chain(joints, order=JOINTS)
    origin, tip = np.zeros(3), np.array([0.0, 0.0, palm])
    return Arm(
        name="upper_limb_anatomical" if corrections == ANATOMICAL else "upper_limb",
        chain=chain,
        landmarks={
            "sternoclavicular": Tip(GROUND),
            "shoulder": Tip(2),
            "elbow": Tip(5),
            "wrist": Tip(8),
            "hand": Tip(8, at(tip)),
        },
        lengths=sizes,
        source=_source(corrections),
        **loads(
            9,
            [
                (4, person.segment("upper_arm", start=(0, 0, -upper), end=origin)),
                (5, person.segment("forearm", start=origin, end=(0, -fore, 0))),
                (8, person.hand(wrist=origin, towards=tip)),
            ],
        ),
    )


def upper_limb_anatomical(lengths: ArrayLike = LENGTHS, *, body: Body | None = None) -> Arm:
    """Build the 9-DoF upper limb complex with all four corrections.

    At zero the arm hangs with the palm forward; positive are protraction and elevation of the
    scapula, shoulder flexion, abduction (the coordinate keeps its name, shoulder_adduction),
    outward rotation, elbow flexion, ulnar deviation, wrist flexion and pronation.

    Raises:
        ShapeError: not four lengths.
        RangeError: a length is not a positive number.

    Example:
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = upper_limb_anatomical()
        >>> bent = [0, 0, 0, 0, 0, np.pi / 2, 0, 0, 0]
        >>> T = forward_kinematics(arm.chain, bent, arm.tip("hand"))
        >>> (1e3 * T[0, :3, 3]).round(2).tolist()
        [188.0, 333.0, -286.0]
    """
    return upper_limb(lengths, corrections=ANATOMICAL, body=body)


def upper_limb_rest(corrections: Corrections = PRINTED) -> Float[np.ndarray, "9"]:
    """Give the rest angles of Table 3 (rad): hanging, with the elbow at 20 degrees."""
    rest = np.array(REST_DEG) * DEGREE
    if corrections.abduction_from_hanging:
        rest[3] = 0.0
    return rest


def _joint(name: str, offset: np.ndarray, axis: np.ndarray = Z) -> Joint:
    low, high = LIMITS_DEG[JOINTS.index(name)]
    return Joint(name, axis, (low * DEGREE, high * DEGREE), offset)


def _girdle_and_shoulder(clavicle: float, upper: float, switches: Corrections) -> list[Joint]:
    """Give rows 1 to 5 of Table 1."""
    elevation = -Z if switches.scapula_sign else Z
    # Hanging is θ4 = 90 degrees: count back from there.
    hanging = QUARTER if switches.abduction_from_hanging else 0.0
    outward = QUARTER if switches.shoulder_rotation_offset else 0.0
    return [
        _joint("scapula_protraction", craig(twist=0.0)),
        _joint("scapula_elevation", craig(twist=-QUARTER, angle=QUARTER), elevation),
        _joint("shoulder_flexion", craig(twist=QUARTER, d=clavicle)),
        _joint(
            "shoulder_adduction",
            craig(twist=-QUARTER, angle=hanging),
            -Z if switches.abduction_from_hanging else Z,
        ),
        _joint("shoulder_rotation", craig(twist=QUARTER, d=upper, angle=outward)),
    ]


def _wrist(fore: float, switches: Corrections) -> list[Joint]:
    """Give rows 7 to 9 of Table 1, or pronation and a universal joint."""
    forearm_end = craig(twist=QUARTER, d=fore)
    if switches.universal_wrist:
        return [
            _joint("wrist_pronation", forearm_end, -Z),
            _joint("wrist_deviation", at(), X),
            _joint("wrist_flexion", at(), Y),
        ]
    return [
        _joint("wrist_deviation", forearm_end),
        _joint("wrist_flexion", craig(twist=-QUARTER)),
        _joint("wrist_pronation", craig(twist=QUARTER)),
    ]


def _source(switches: Corrections) -> str:
    named = [f.name for f, on in zip(fields(switches), astuple(switches), strict=True) if on]
    corrected = f"corrected: {', '.join(named)}" if named else "as printed"
    return (
        f"DeBoon et al. 2020, Tables 1 and 3, {corrected}; wrist upper limits assumed from "
        "Boone & Azen 1979; masses of de Leva 1996"
    )
