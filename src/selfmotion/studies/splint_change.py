"""What a splinted joint changes: the same wrist paths, with the same preferences, in fewer ranges.

The recorded paths of the wrist are followed twice by the person's arm, with the costs that the
person's own weights give the joints ([Khoramshahi2022] as the velocity cost of [DeBoon] section 5):
once with all ranges, once with the splint. What moves more is compensation. The weights are then
identified from both, as they would be from recordings: those after tell what an observer would
call the person's preferences, though nothing but a range has changed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from jaxtyping import Float

from selfmotion.capture.attach import attach_arm
from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.constrained_path import FollowedPath, PathCosts, follow
from selfmotion.methods.identification import identify_weights
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.motion.recording import Recording, Study
from selfmotion.redundancy.task import Position

# The splint of [DeBoon] section 4.3 (rad).
SPLINT: Mapping[str, tuple[float, float]] = {"elbow_flexion": (1.12, 1.99)}
# A joint that moves more by this share of what the splinted one moves less compensates.
NAMED_SHARE = 0.1
# Samples of a path that are followed.
SAMPLES_A_SECOND = 25.0


@dataclass(frozen=True, eq=False)
class SplintChange:
    """What changes with a splint, over all movements.

    Attributes:
        joints: names (n).
        excursion_before: (n,) mean range of each joint in a movement, free (rad).
        excursion_after: (n,) the same with the splint.
        reached: share of the path's samples that the splinted arm meets.
        by_condition: task to that share.
        before: weights identified from the free paths; None where none could be.
        after: the same with the splint.
        failed: (movement, why) of what could not be followed.
    """

    joints: tuple[str, ...]
    excursion_before: Float[np.ndarray, " joints"]
    excursion_after: Float[np.ndarray, " joints"]
    reached: float
    by_condition: Mapping[str, float]
    before: WeightEstimate | None
    after: WeightEstimate | None
    failed: tuple[tuple[str, str], ...]

    @property
    def compensation(self) -> tuple[str, ...]:
        """Joints that move more, the most first, among them those that matter."""
        change = self.excursion_after - self.excursion_before
        lost = -float(change[change < 0].sum())
        order = np.argsort(-change)
        return tuple(self.joints[i] for i in order if change[i] > max(NAMED_SHARE * lost, 1e-6))

    def sentence(self) -> str:
        """Say it in words."""
        less = self.excursion_before - self.excursion_after
        most = self.joints[int(np.argmax(less))].replace("_", " ").capitalize()
        named = ", ".join(j.replace("_", " ") for j in self.compensation) or "no joint"
        return (
            f"With the splint {self.reached:.0%} of the wrist's paths can still be followed. "
            f"{most} moves {np.degrees(less.max()):.0f}° less a movement; {named} "
            f"{'moves' if len(self.compensation) < 2 else 'move'} more."
        )

    def to_frame(self) -> pd.DataFrame:
        """Give a table, one row a joint; angles in degrees, weights NaN where not identified."""
        nothing = np.full(len(self.joints), np.nan)
        return pd.DataFrame(
            {
                "joint": self.joints,
                "excursion_before_deg": np.degrees(self.excursion_before),
                "excursion_after_deg": np.degrees(self.excursion_after),
                "weight_before": nothing if self.before is None else self.before.weights,
                "weight_after": nothing if self.after is None else self.after.weights,
            }
        )


def splint_change(
    arm: Arm,
    recordings: Sequence[Recording],
    weights: Float[np.ndarray, " joints"],
    *,
    splint: Mapping[str, tuple[float, float]] = SPLINT,
) -> SplintChange:
    """Follow recorded wrist paths with and without a splint.

    Args:
        arm: of the person.
        recordings: movements with q (rad).
        weights: (n,) the person's weights; joints without one carry a stated stand-in.
        splint: joint to the range that is left (rad).

    Raises:
        UnknownNameError: the arm has no such joint.
        RangeError: the weights do not fit, or no movement could be followed.
    """
    if weights.shape != (arm.n_joints,) or not (np.isfinite(weights) & (weights > 0)).all():
        raise RangeError(f"weights: {arm.n_joints} positive numbers are needed")
    held = {joint: _within(arm, joint, kept) for joint, kept in splint.items()}
    arms = (arm, arm.with_limits(held))
    pairs: list[tuple[Recording, FollowedPath, FollowedPath]] = []
    failed: list[tuple[str, str]] = []
    for recording in recordings:
        try:
            free, limited = (_followed(a, recording, weights) for a in arms)
        except SelfmotionError as error:
            failed.append((recording.name, str(error)))
        else:
            pairs.append((recording, free, limited))
    if not pairs:
        why = failed[0][1] if failed else "there is none"
        raise RangeError(f"no movement could be followed: {why}")
    met = np.array([limited.met.mean() for _, _, limited in pairs])
    tasks = np.array([str(r.labels.condition) for r, _, _ in pairs])
    return SplintChange(
        arm.joints,
        np.mean([np.ptp(free.q, axis=0) for _, free, _ in pairs], axis=0),
        np.mean([np.ptp(limited.q, axis=0) for _, _, limited in pairs], axis=0),
        float(met.mean()),
        {task: float(met[tasks == task].mean()) for task in dict.fromkeys(tasks.tolist())},
        _identified(arms[0], [(r, free) for r, free, _ in pairs]),
        _identified(arms[1], [(r, limited) for r, _, limited in pairs]),
        tuple(failed),
    )


def _within(arm: Arm, joint: str, kept: tuple[float, float]) -> tuple[float, float]:
    i = arm.chain.index(joint)
    low, high = max(arm.lower[i], kept[0]), min(arm.upper[i], kept[1])
    if not low <= high:
        raise RangeError(f"{joint}: the splint leaves nothing of the person's range")
    return float(low), float(high)


def _followed(
    arm: Arm, recording: Recording, weights: Float[np.ndarray, " joints"]
) -> FollowedPath:
    q = recording.array("q")
    seen = np.flatnonzero(np.isfinite(q).all(axis=1))
    if len(seen) < 3:
        raise RangeError(f"{recording.name}: {len(seen)} samples with all joints; 3 are needed")
    rate = recording.rate or SAMPLES_A_SECOND
    kept = seen[:: max(1, round(rate / SAMPLES_A_SECOND))]
    path = Position(arm, "wrist").value(q[kept])
    task = HandRows(arm, ("x", "y", "z"), "wrist")
    start = np.clip(q[kept[0]], arm.lower, arm.upper)
    costs = PathCosts(velocity=weights)
    return follow(task, path, time=recording.time[kept], start=start, costs=costs)


def _identified(
    arm: Arm, followed: Sequence[tuple[Recording, FollowedPath]]
) -> WeightEstimate | None:
    """Identify weights from paths that could be followed, in their samples that were met."""
    made = []
    for recording, path in followed:
        if path.met.mean() < 0.9 or len(path.time) < 5:
            continue
        plain = Recording(
            path.time, q=path.q, joints=arm.joints, labels=recording.labels, source=recording.source
        )
        made.append(attach_arm(plain, arm, task=Position(arm, "wrist")))
    if len(made) < 2:
        return None
    return identify_weights(Study(tuple(made)))
