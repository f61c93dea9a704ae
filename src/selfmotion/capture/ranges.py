"""Ranges of motion from recordings in which one joint at a time is moved through its range.

[DeBoon] section 4.2: the person moves one joint as far as it goes, several times, and the extremes
are the joint's limits. The paper takes the absolute extremes; one bad frame would then set a limit.

The rule here: an end of the range is the angle at or beyond which the joint spent `held` seconds
(0.1 s) in total in a recording; of a recording without times, the angle beyond which 0.5 % of its
samples lie. That is a percentile whose tail does not depend on how long the person rests. Of
several recordings of a joint the farthest ends count, as in the paper. Where the movement was
repeated, the scatter of its turning points says how well the ends are known.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import require_between
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.motion.recording import Recording

# Samples that a recording must hold, and the angle between samples that no joint moves (rad).
FEWEST, JUMP = 10, np.pi
# A joint counts as the one tested if the next one moves less than this part of what it moves.
CLEAR = 0.6
# A joint that moves no further than this (rad) is at rest.
STILL = np.pi / 180
# A movement has gone to and fro when it passed these parts of the range.
LOW_PART, HIGH_PART = 0.25, 0.75


@dataclass(frozen=True)
class RangeRule:
    """How the ends of a range are read from a recording.

    Attributes:
        held: time spent at or beyond an end (s).
        tail: share of the samples beyond an end, where a recording has no times.

    Raises:
        RangeError: a number is out of bounds.
    """

    held: float = 0.1
    tail: float = 0.005

    def __post_init__(self) -> None:
        """Check the numbers."""
        require_between("held", self.held, 0.0, 10.0)
        require_between("tail", self.tail, 0.0, 0.25)


@dataclass(frozen=True)
class JointRange:
    """The range of one joint, as recorded.

    Attributes:
        joint: which.
        low: rad.
        high: rad.
        repeats: how often the joint went to and fro, over all recordings.
        scatter: standard deviation of the turning points at an end (rad), the larger of both ends;
            NaN with fewer than two repeats.
        sources: where it was recorded.
    """

    joint: str
    low: float
    high: float
    repeats: int
    scatter: float
    sources: tuple[str, ...]


def joint_range(
    joint: str, recordings: Sequence[Recording], *, rule: RangeRule | None = None
) -> JointRange:
    """Read the range of one joint from recordings of it.

    Args:
        joint: which; a recording of a single joint may call it otherwise.
        recordings: of the joint moved through its range; gaps (NaN) are left out.
        rule: what counts as an end.

    Raises:
        RangeError: no recording, too few samples, or an angle that jumps by half a turn.
        UnknownNameError: a recording of several joints does not hold this one.

    Example:
        >>> t = np.arange(0, 6, 0.01)
        >>> bend = np.deg2rad(70 - 60 * np.cos(np.pi * t))
        >>> test = Recording(t, q=bend[:, None], joints=("elbow_flexion",))
        >>> found = joint_range("elbow_flexion", [test])
        >>> [round(float(np.degrees(v)), 1) for v in (found.low, found.high)], found.repeats
        ([10.1, 129.9], 3)
    """
    if not recordings:
        raise RangeError(f"{joint}: 0 recordings; at least one is needed")
    used = rule or RangeRule()
    angles = [_angles(joint, recording) for recording in recordings]
    ends = np.array(
        [_ends(a, r, used) for a, r in zip(angles, recordings, strict=True)], dtype=np.float64
    )
    low, high = float(ends[:, 0].min()), float(ends[:, 1].max())
    turns = [_turns(a, low, high) for a in angles]
    lows, highs = (np.concatenate([t[i] for t in turns]) for i in (0, 1))
    scatter = max((float(np.std(v, ddof=1)) for v in (lows, highs) if len(v) > 1), default=np.nan)
    sources = tuple(recording.name for recording in recordings)
    return JointRange(joint, low, high, min(len(lows), len(highs)), scatter, sources)


def joint_moved(recording: Recording, arm: Arm) -> str:
    """Tell which joint of an arm a recording moves through its range.

    Raises:
        RangeError: it holds no joint of the arm, or several move about as far.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> t = np.arange(0, 2, 0.01)
        >>> both = np.stack([np.sin(np.pi * t), 0.1 * np.sin(t)], axis=1)
        >>> test = Recording(t, q=both, joints=("elbow_flexion", "wrist_flexion"))
        >>> joint_moved(test, load_arm("upper_limb"))
        'elbow_flexion'
    """
    known = [joint for joint in recording.joints if joint in arm.joints]
    if recording.q is None or not known:
        raise RangeError(
            f"{recording.name}: holds no angles of {arm.name}; its joints are "
            f"{', '.join(arm.joints)}"
        )
    travel = {}
    for joint in known:
        q, j = _angles(joint, recording), arm.chain.index(joint)
        width = float(arm.upper[j] - arm.lower[j])
        travel[joint] = float(np.ptp(q)) / (width if 0 < width < np.inf else 2 * np.pi)
    if not any(np.ptp(_angles(joint, recording)) > STILL for joint in known):
        raise RangeError(
            f"{recording.name}: no joint moves by more than {np.rad2deg(STILL):.0f} degree; say "
            f"which joint it tests, as in {known[0]}=FILE"
        )
    order = sorted(travel, key=lambda joint: -travel[joint])
    if len(order) > 1 and travel[order[1]] > CLEAR * travel[order[0]]:
        raise RangeError(
            f"{recording.name}: {order[0]} and {order[1]} both move; say which joint it tests, as "
            f"in {order[0]}=FILE"
        )
    return order[0]


def _angles(joint: str, recording: Recording) -> Float[np.ndarray, " samples"]:
    """Give the angles of a joint without gaps."""
    q = recording.array("q")
    if joint in recording.joints:
        column = recording.joints.index(joint)
    elif recording.n_joints == 1:
        column = 0
    else:
        raise unknown_name(f"joint of {recording.name}", joint, recording.joints)
    angles = q[:, column]
    known = np.flatnonzero(np.isfinite(angles))
    if len(known) < FEWEST:
        raise RangeError(
            f"{recording.name}: {len(known)} samples of {joint}; a range needs at least {FEWEST}"
        )
    step = np.abs(np.diff(angles[known]))
    if step.max() > JUMP:
        at = recording.time[known[int(step.argmax()) + 1]]
        unit = "s" if recording.timed else "(sample)"
        raise RangeError(
            f"{recording.name}: {joint} jumps by {np.rad2deg(step.max()):.0f} degrees at "
            f"{at:.4g} {unit}; angles must go on without wrapping around"
        )
    return angles[known]


def _ends(
    angles: Float[np.ndarray, " samples"], recording: Recording, rule: RangeRule
) -> tuple[float, float]:
    """Give the angles at or beyond which the joint was for long enough."""
    n = len(angles)
    rate = recording.rate
    beyond = rule.tail * n if rate is None else rule.held * rate
    k = min(max(int(round(beyond)), 1), (n + 1) // 2)
    ordered = np.sort(angles)
    return float(ordered[k - 1]), float(ordered[n - k])


def _turns(
    angles: Float[np.ndarray, " samples"], low: float, high: float
) -> tuple[Float[np.ndarray, " lows"], Float[np.ndarray, " highs"]]:
    """Give the turning points at the low and at the high end, one for each time it got there."""
    width = high - low
    state = np.zeros(len(angles), dtype=np.int64)
    state[angles <= low + LOW_PART * width] = -1
    state[angles >= low + HIGH_PART * width] = 1
    seen = np.flatnonzero(state)
    if width <= 0 or not len(seen):
        return np.zeros(0), np.zeros(0)
    starts = seen[np.flatnonzero(np.diff(state[seen], prepend=0))]
    parts = np.split(angles, starts[1:])
    lows = [part.min() for part, s in zip(parts, state[starts], strict=True) if s < 0]
    highs = [part.max() for part, s in zip(parts, state[starts], strict=True) if s > 0]
    return np.array(lows), np.array(highs)
