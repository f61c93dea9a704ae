"""Hybrid inverse kinematics: postures of a 7-DoF arm for a hand pose, spaced by swivel angle.

Implements [Li2022] Table II and eqs 6, 7 and 13 (doi 10.1109/TNSRE.2022.3198400): the closed form
of the arm's relative gives a start for every swivel angle, and damped least squares bring it onto
the hand pose of the real arm, with shoulder elevation and elbow flexion at rest by turns so that
the swivel angle stays nearly what was asked for. Deviations: coupled coordinates follow the
coupling of the chain, which may be a curve, and not a constant matrix W; nothing rests after the
first `RESTING_STEPS` steps.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, as_float_array, require_finite
from selfmotion.errors import ShapeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.srs import N_BRANCHES, SrsRelative
from selfmotion.redundancy.feasible import arm_swivel
from selfmotion.redundancy.refine import check_poses, refine
from selfmotion.redundancy.tracing import inside_turn

if TYPE_CHECKING:
    import pandas as pd

# Coordinates that rest by turns: shoulder elevation and elbow flexion ([Li2022] section III-B).
RESTING = (1, 3)
# Postures closer than this (rad) are the same.
_SAME = 1e-6
# They rest in the first steps only: where that converges slowly, all coordinates take the last
# steps, which by then are too small to move the swivel angle.
RESTING_STEPS, MAX_ITERATIONS = 6, 16
# Starts farther outside the limits (rad) or out of reach (sines) than this lead nowhere.
MARGIN, OUT_OF_REACH = 0.6, 0.5


@dataclass(frozen=True, eq=False)
class HybridPostures:
    """Postures for one hand pose, one for each swivel angle and branch that was reached.

    Attributes:
        arm: the arm.
        T_hand: the hand pose.
        q: (K, 7) postures on the pose (rad).
        asked: (K,) swivel angle of the relative, ψ_S (rad).
        swivel: (K,) swivel angle of the arm, ψ_H (rad); `asked - swivel` is eq. 13.
        branch: (K,) which of the eight closed-form branches the start came from.
        feasible: (K,) whether the posture is inside the joint limits.
        start_error: (K, 2) position (m) and rotation (rad) error of the start, eq. 6.
        iterations: (K,) steps of the refinement.
    """

    arm: Arm
    T_hand: Transform
    q: Float[np.ndarray, "samples 7"]
    asked: Float[np.ndarray, " samples"]
    swivel: Float[np.ndarray, " samples"]
    branch: np.ndarray
    feasible: Bool[np.ndarray, " samples"]
    start_error: Float[np.ndarray, "samples 2"]
    iterations: np.ndarray

    @property
    def uncertainty(self) -> Float[np.ndarray, " samples"]:
        """Give ψ_S - ψ_H (rad), brought into half a turn ([Li2022] eq. 13)."""
        gap = self.asked - self.swivel
        return (gap + np.pi) % (2 * np.pi) - np.pi

    def to_frame(self) -> "pd.DataFrame":
        """Give a table: swivel angles, whether feasible, then coordinates by name."""
        import pandas as pd

        table = pd.DataFrame(self.q, columns=list(self.arm.joints))
        table.insert(0, "swivel_asked", self.asked)
        table.insert(1, "swivel", self.swivel)
        table.insert(2, "branch", self.branch)
        table.insert(3, "feasible", self.feasible)
        return table


def hybrid_ik(
    arm: Arm,
    T_hand: ArrayLike,
    swivel: ArrayLike | None = None,
    *,
    relative: SrsRelative | None = None,
) -> HybridPostures:
    """Give postures for a hand pose at given swivel angles ([Li2022] Table II).

    Args:
        arm: with seven free coordinates.
        T_hand: (4, 4) hand pose in the ground (m).
        swivel: angles ψ_S (rad); left out: the whole turn by steps of 2 degrees.
        relative: the arm's closed-form relative, if it is at hand.

    Returns:
        The postures reached from starts that are not far (`MARGIN`) outside the joint limits.
        Those that came from different branches of the closed form but are the same posture stand
        once.

    Raises:
        ModelError: the arm has not seven free coordinates, or a shoulder of an unknown kind.
        RangeError: T_hand is not a rigid transform.
        ShapeError: T_hand holds more than one pose.

    Example:
        >>> import numpy as np
        >>> from selfmotion.arms import srs7
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> arm = srs7()
        >>> pose = forward_kinematics(arm.chain, arm.middle(), arm.tip("hand"))
        >>> found = hybrid_ik(arm, pose, np.deg2rad([40.0, 45.0, 50.0]))
        >>> bool(np.abs(found.uncertainty).max() < 1e-6)
        True
    """
    goals = check_poses(T_hand)
    if len(goals) != 1:
        raise ShapeError(f"T_hand: {len(goals)} poses given; expected one")
    if swivel is None:
        asked = np.arange(-np.pi, np.pi - 1e-9, np.deg2rad(2.0))
    else:
        asked = np.atleast_1d(as_float_array("swivel", swivel))
    require_finite("swivel", asked)
    known = SrsRelative.of(arm) if relative is None else relative
    starts, out = known.postures(goals[0], asked)
    wanted = np.repeat(asked, N_BRANCHES)
    branch = np.tile(np.arange(N_BRANCHES), len(asked))
    starts, out = starts.reshape(-1, 7), out.ravel()
    excess = np.maximum(arm.lower - starts, starts - arm.upper).max(axis=1)
    worth = (out < OUT_OF_REACH) & (excess < MARGIN)
    turns = np.ones((MAX_ITERATIONS + 1, 7))
    for step in range(RESTING_STEPS):
        turns[step, RESTING[step % len(RESTING)]] = 0.0
    before = refine(arm, starts[worth], goals[0], max_iterations=0)
    after = refine(arm, starts[worth], goals[0], turns=turns, max_iterations=MAX_ITERATIONS)
    q = inside_turn(arm, after.q)
    keep = after.reached & ~_repeated(q, wanted[worth])
    q = q[keep]
    slack = 1e-9
    return HybridPostures(
        arm,
        goals[0],
        q,
        wanted[worth][keep],
        arm_swivel(arm, q),
        branch[worth][keep],
        np.asarray(((q >= arm.lower - slack) & (q <= arm.upper + slack)).all(axis=1)),
        np.column_stack([before.position_error, before.rotation_error])[keep],
        after.iterations[keep],
    )


def _repeated(q: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Tell which postures stand earlier already for the same swivel angle."""
    out = np.zeros(len(q), dtype=bool)
    for step in range(1, N_BRANCHES):  # starts of one swivel angle stand side by side
        alike = np.abs(q[step:] - q[:-step]).max(axis=1) < _SAME
        out[step:] |= alike & (asked[step:] == asked[:-step])
    return out
