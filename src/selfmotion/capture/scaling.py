"""Fit an arm of the library to a person: segment lengths, the shoulder's place, joint ranges."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_finite, require_shape
from selfmotion.errors import ModelError, RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Chain, Tip
from selfmotion.kinematics.forward import body_frames, tip_positions

# Segment: the landmarks at its ends.
SEGMENTS = {
    "upper_arm": ("shoulder", "elbow"),
    "forearm": ("elbow", "wrist"),
    "hand": ("wrist", "hand"),
}
GIRDLE = "girdle"
# Two lengths that differ by less are the same (m).
SAME_LENGTH = 1e-9

# Adult joint ranges, degrees: mean and two standard deviations of Boone & Azen (1979, J Bone Joint
# Surg Am 61:756, 109 men), which 95 % of people do not leave; abduction down to horizontal
# adduction past straight forward; forearm counted from full supination at 90 degrees. Shoulder
# girdle: clavicular ranges of Ludewig et al. (2009, doi 10.2106/JBJS.G.01483) and textbooks.
ADULT_RANGES_DEG = {
    "scapula_protraction": (-30.0, 30.0),
    "scapula_elevation": (-15.0, 45.0),
    "shoulder_flexion": (-81.3, 180.0),
    "shoulder_adduction": (-62.5, 180.0),
    "shoulder_rotation": (-78.0, 120.7),
    "elbow_flexion": (-6.8, 154.1),
    "wrist_deviation": (-29.5, 43.6),
    "wrist_flexion": (-87.7, 89.0),
    "wrist_pronation": (0.3, 176.0),
}


def with_adult_ranges(arm: Arm) -> Arm:
    """Give `upper_limb_anatomical` the ranges of adults in place of one person's (Table 3).

    Raises:
        UnknownNameError: the arm does not have these joints.

    Example:
        >>> from selfmotion.arms import upper_limb_anatomical
        >>> arm = with_adult_ranges(upper_limb_anatomical())
        >>> [round(float(np.degrees(v[5])), 1) for v in (arm.lower, arm.upper)]
        [-6.8, 154.1]
    """
    ranges = {
        joint: (np.deg2rad(low), np.deg2rad(high))
        for joint, (low, high) in ADULT_RANGES_DEG.items()
    }
    return arm.with_limits(ranges)


def segment_lengths(arm: Arm) -> dict[str, float]:
    """Give the distances (m) from shoulder to elbow, wrist and hand, in the middle posture.

    Example:
        >>> from selfmotion.arms import upper_limb_anatomical
        >>> {k: round(v, 3) for k, v in segment_lengths(upper_limb_anatomical()).items()}
        {'upper_arm': 0.286, 'forearm': 0.259, 'hand': 0.074}
    """
    names = ("shoulder", "elbow", "wrist", "hand")
    q = np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)
    points = tip_positions(arm.chain, q, [arm.tip(name) for name in names])[0]
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return dict(zip(SEGMENTS, apart.tolist(), strict=True))


def scale_arm(arm: Arm, lengths: Mapping[str, float]) -> Arm:
    """Give the arm of a person with other segment lengths.

    Everything between the joints of a segment grows with its length: joint offsets, landmarks and
    centres of mass; moments of inertia grow with the square of it. Masses stay.

    Args:
        arm: any arm of the library.
        lengths: segment (`upper_arm`, `forearm`, `hand`) to length (m); segments not named stay.

    Raises:
        UnknownNameError: a segment does not exist.
        RangeError: a length is not positive, or the arm's segment has no length to scale.
        ModelError: the arm's lengths do not follow, since its landmarks are off its joints.

    Example:
        >>> from selfmotion.arms import srs7
        >>> round(segment_lengths(scale_arm(srs7([0.3, 0.25]), {"forearm": 0.27}))["forearm"], 6)
        0.27
    """
    now = segment_lengths(arm)
    factors = {GIRDLE: 1.0} | dict.fromkeys(SEGMENTS, 1.0)
    for segment, length in lengths.items():
        if segment not in SEGMENTS:
            raise unknown_name("segment", segment, tuple(SEGMENTS))
        if not 0.0 < length < np.inf:
            raise RangeError(f"length of {segment} = {length:g} m: must be positive")
        if now[segment] < SAME_LENGTH:
            raise RangeError(f"arm {arm.name}: its {segment} has no length that could be scaled")
        factors[segment] = length / now[segment]
    of_joint, of_body = _segments(arm)
    chain = arm.chain
    offsets = chain.offsets.copy()
    offsets[:, :3, 3] *= np.array([factors[s] for s in of_joint])[:, None]
    by_body = np.array([factors[s] for s in of_body])
    scaled = replace(
        arm,
        chain=replace(chain, offsets=offsets),
        landmarks=_scaled_landmarks(arm, factors, by_body),
        lengths={**arm.lengths, **{k: float(v) for k, v in lengths.items()}},
        com=arm.com * by_body[:, None],
        inertia=arm.inertia * by_body[:, None, None] ** 2,
    )
    for segment, length in lengths.items():
        found = segment_lengths(scaled)[segment]
        if abs(found - length) > 1e-6:
            raise ModelError(
                f"arm {arm.name}: its {segment} became {found:g} m instead of {length:g} m, since "
                "a landmark is off its joint"
            )
    return scaled


def place_shoulder(arm: Arm, shoulder: ArrayLike) -> Arm:
    """Put the shoulder centre of the zero posture somewhere else in the ground frame.

    For an arm with a shoulder girdle the girdle's joints stay where they are and the shoulder
    moves relative to them, so that it is there with the girdle at rest; without one the whole arm
    is moved.

    Args:
        arm: any arm of the library.
        shoulder: (3,) where the shoulder centre shall be at q = 0 (m).

    Example:
        >>> from selfmotion.arms import upper_limb_anatomical
        >>> arm = place_shoulder(upper_limb_anatomical(), [0.15, -0.03, -0.02])
        >>> tip_positions(arm.chain, np.zeros(9), [arm.tip("shoulder")])[0, 0].round(3).tolist()
        [0.15, -0.03, -0.02]
    """
    wanted = as_float_array("shoulder", shoulder, ndim=1)
    require_shape("shoulder", wanted, (3,))
    require_finite("shoulder", wanted)
    tip = arm.tip("shoulder")
    chain = arm.chain
    offsets = chain.offsets.copy()
    zero = np.zeros(arm.n_joints)
    move = wanted - tip_positions(chain, zero, [tip])[0, 0]
    if tip.joint == GROUND:
        offsets[chain.parent == GROUND, :3, 3] += move
        marks = {k: _moved(t, move) if t.joint == GROUND else t for k, t in arm.landmarks.items()}
        return replace(arm, chain=replace(chain, offsets=offsets), landmarks=marks)
    parent = int(chain.parent[tip.joint])
    turn = np.eye(3) if parent == GROUND else body_frames(chain, zero)[0, parent, :3, :3]
    offsets[tip.joint, :3, 3] += turn.T @ move
    return replace(arm, chain=replace(chain, offsets=offsets))


def path_to(chain: Chain, joint: int) -> list[int]:
    """List the joints from the ground to this one."""
    path: list[int] = []
    while joint != GROUND:
        path.append(int(joint))
        joint = chain.parent[joint]
    return path[::-1]


def _segments(arm: Arm) -> tuple[list[str], list[str]]:
    """Give the segment that each joint's offset lies in, and the one that each body belongs to."""
    chain = arm.chain
    ends = {
        name: set(path_to(chain, arm.tip(name).joint)) for name in ("shoulder", "elbow", "wrist")
    }

    def of(joint: int) -> str:
        if joint in ends["shoulder"]:
            return GIRDLE
        if joint in ends["elbow"]:
            return "upper_arm"
        return "forearm" if joint in ends["wrist"] else "hand"

    of_joint = [of(i) for i in range(len(chain.names))]
    onward = path_to(chain, arm.tip("hand").joint)
    of_body = []
    for i in range(len(chain.names)):
        at = onward.index(i) if i in onward else -1
        if at == len(onward) - 1:
            fixed = np.linalg.norm(arm.tip("wrist").transform[:3, 3]) > SAME_LENGTH
            of_body.append("forearm" if fixed else "hand")
        else:
            of_body.append(of_joint[onward[at + 1]] if at >= 0 else of_joint[i])
    return of_joint, of_body


def _scaled_landmarks(
    arm: Arm, factors: Mapping[str, float], by_body: np.ndarray
) -> dict[str, Tip]:
    """Move landmarks with the segment that ends at them; others with the body they are on."""
    own = {"shoulder": GIRDLE} | {end: segment for segment, (_, end) in SEGMENTS.items()}
    scaled = {}
    for name, tip in arm.landmarks.items():
        if tip.joint == GROUND:
            scaled[name] = tip
            continue
        factor = factors[own[name]] if name in own else by_body[tip.joint]
        place = tip.transform[:3, 3]
        moved = factor * place
        wrist = arm.tip("wrist")
        beyond = name not in ("shoulder", "elbow", "wrist")
        if tip.joint == wrist.joint and beyond:  # the hand may be fixed to the forearm
            start = wrist.transform[:3, 3]
            moved = factors["forearm"] * start + factor * (place - start)
        scaled[name] = _moved(tip, moved - place)
    return scaled


def _moved(tip: Tip, move: np.ndarray) -> Tip:
    T = tip.transform.copy()
    T[:3, 3] += move
    return Tip(tip.joint, T)
