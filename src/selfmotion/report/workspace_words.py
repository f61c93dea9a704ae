"""A workspace in the words of a clinician: which movement's limit bounds it, and where."""

from collections.abc import Mapping

import numpy as np

from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.methods.reaching.boundary import BODY, LENGTH, NAMES, BoundaryLimits
from selfmotion.methods.reaching.regained import Share
from selfmotion.report.theme import words

# (lower, upper): the movement that a limit ends, as angles count on the anatomical arm.
MOVEMENTS = {
    "scapula_protraction": ("drawing the shoulder back", "bringing the shoulder forward"),
    "scapula_elevation": ("lowering the shoulder girdle", "raising the shoulder girdle"),
    "shoulder_flexion": ("shoulder extension", "shoulder flexion"),
    "shoulder_adduction": ("adduction across the body", "shoulder abduction"),
    "shoulder_rotation": ("internal rotation of the shoulder", "external rotation of the shoulder"),
    "elbow_flexion": ("elbow extension", "elbow flexion"),
    "wrist_deviation": ("radial deviation", "ulnar deviation"),
    "wrist_flexion": ("wrist extension", "wrist flexion"),
    "wrist_pronation": ("supination", "pronation"),
}
# The printed model of [DeBoon] counts these the other way round, or about another axis.
PRINTED = {
    "scapula_elevation": ("raising the shoulder girdle", "lowering the shoulder girdle"),
    "shoulder_adduction": ("shoulder abduction", "adduction across the body"),
    "shoulder_rotation": (
        "rotation of the shoulder, lower end",
        "rotation of the shoulder, upper end",
    ),
    "wrist_deviation": ("rotation of the forearm, lower end", "rotation of the forearm, upper end"),
    "wrist_pronation": ("rotation of the hand, lower end", "rotation of the hand, upper end"),
}
PLACES = (("to the outside", "across the body"), ("in front", "behind"), ("above", "below"))
INNER = "close to the shoulder, on the inner side"
# A place is named if so much of a limit's boundary lies there; so many are named.
NAMED, MOST = 0.18, 3
# Limits that bound less than this (%) are not told.
LEAST = 2.0
# A boundary that moves less than this by a degree is as good as that of a straight joint (mm).
HARDLY = 1.0


def joint_title(arm: Arm, joint: str) -> str:
    """Give what a clinician calls a joint of this arm."""
    if joint == "shoulder_adduction" and is_anatomical(arm):
        return "shoulder abduction"
    return words(joint)


def zero_words(arm: Arm) -> str:
    """Say where the zero of cuts and slices lies."""
    if arm.name.startswith("upper_limb"):
        return "Zero is the joint of collarbone and breastbone, at the height of the shoulders."
    return "Zero is the origin of the model."


def is_anatomical(arm: Arm) -> bool:
    """Tell whether angles count as in the clinic."""
    return arm.name.startswith("upper_limb_anatomical")


def movement(arm: Arm, joint: str, side: int) -> str:
    """Give the movement that a limit of this arm ends.

    Args:
        arm: whose convention counts.
        joint: which.
        side: 1 for the upper limit, -1 for the lower one.
    """
    end = "upper" if side > 0 else "lower"
    fallback = (f"{words(joint)}, {end} end",) * 2
    if not arm.name.startswith("upper_limb"):
        return fallback[0]
    table: Mapping[str, tuple[str, str]] = MOVEMENTS
    if not is_anatomical(arm):
        table = {**MOVEMENTS, **PRINTED}
    return table.get(joint, fallback)[1 if side > 0 else 0]


def bound_title(arm: Arm, joint: int, side: int) -> str:
    """Give what bounds: a movement, the length of the arm, or the own body."""
    return NAMES[joint] if joint < 0 else movement(arm, arm.joints[joint], side)


def boundary_sentences(limits: BoundaryLimits) -> list[str]:
    """Say which limits bound a workspace, where, and what a degree more would give."""
    frame = BodyFrame.of(limits.arm)
    out = []
    table = limits.to_frame()
    for row, (joint, side) in zip(table.to_dict("records"), limits.limit_names(), strict=True):
        share = float(row["share_percent"])
        if share < LEAST:
            continue
        where = _places(limits, limits.chosen(joint, side), frame)
        if joint == LENGTH:
            out.append(f"The length of the stretched arm: {share:.0f} % of the boundary, {where}.")
        elif joint == BODY:
            out.append(f"The person's own body: {share:.0f} % of the boundary.")
        else:
            gain = float(row["mm_per_degree"])
            what = bound_title(limits.arm, joint, side)
            out.append(
                f"{what[0].upper()}{what[1:]}, which ends at {degrees(row['at_deg'])}°: "
                f"{share:.0f} % of the boundary, {where}. A degree more would move it by "
                f"{gain:.1f} mm there"
                f"{' (the joint is nearly straight)' if gain < HARDLY else ''}."
            )
    return out


def _places(limits: BoundaryLimits, chosen: np.ndarray, frame: BodyFrame) -> str:
    """Name where these points of the boundary are, seen from the shoulder."""
    away = limits.points[chosen] - frame.shoulder
    local = away @ frame.outward_axes
    inner = np.einsum("ki,ki->k", np.nan_to_num(limits.normals[chosen]), away) < 0
    axis = np.abs(local).argmax(axis=1)
    positive = local[np.arange(len(local)), axis] > 0
    counts: dict[str, float] = {INNER: float(inner.mean())}
    for i, (plus, minus) in enumerate(PLACES):
        here = (axis == i) & ~inner
        counts[plus] = float((here & positive).mean())
        counts[minus] = float((here & ~positive).mean())
    named = [p for p in sorted(counts, key=lambda p: -counts[p]) if counts[p] >= NAMED][:MOST]
    return "mainly " + joined(named) if named else "spread all around"


def regained_sentences(arm: Arm, regained: Mapping[str, Share]) -> list[str]:
    """Say what each joint alone would give back, the largest part first."""
    out = []
    for joint, share in sorted(regained.items(), key=lambda item: -item[1].part):
        if not share.points:
            continue
        out.append(
            f"{joint_title(arm, joint)}: {1e2 * share.part:.0f} ± {1e2 * share.standard_error:.0f} "
            f"% of what is lost ({1e3 * share.volume:.0f} litres) would come back if this joint "
            "alone had its free range."
        )
    return [text[0].upper() + text[1:] for text in out]


def degrees(value: float) -> str:
    """Write whole degrees with a true minus."""
    return f"{round(float(value)) + 0:d}".replace("-", "−")


def joined(parts: list[str]) -> str:
    """Join with commas and an "and".

    Example:
        >>> joined(["above", "below", "behind"])
        'above, below and behind'
    """
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
