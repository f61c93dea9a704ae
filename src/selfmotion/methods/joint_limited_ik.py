"""Inverse kinematics inside joint limits: the posture that brings the hand to a target.

The default is Levenberg-Marquardt in the box of joint limits with an active set, started again
from postures near the target if it stops short. Beside it stands the published scheme: [DeBoon]
eqs 10 to 16 (J Biomech Eng), which stiffens joints near their limits by a tangent mapping.

Deviations from the paper: the orientation error is a turn on the rotation group (eqs 4 to 6 with
one arctangent alias poses), eq. 12's repeated rows are read as rows of x, y, z, φ, ψ, γ, and the
published scheme may clip the task error of a step, without which it often diverges.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_finite
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.methods.reaching.attempts import persist, run
from selfmotion.methods.reaching.ik_arrays import Goals, Rows
from selfmotion.methods.reaching.ik_seeds import SeedTable, finite_limits, model_of, seed_table
from selfmotion.methods.reaching.ik_tasks import HandRows, as_hand_rows, goals_of
from selfmotion.provenance import Provenance, hash_arrays
from selfmotion.redundancy.task import Pose, Position

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class IkOptions:
    """When a target counts as reached, how long to try, and by which scheme.

    Attributes:
        scheme: "box" (default) or "published" ([DeBoon] eqs 10 to 16).
        position_tolerance: m.
        rotation_tolerance: rad.
        max_iterations: of one start: steps tried ("box") or taken ("published").
        restarts: starts after the first; 0 for a single start. The published scheme has none. A
            pose that is missed by little is given four times as many more.
        threads: how many threads share the targets.
        gain_step: k0 dt of eq. 16 in one step (published).
        damping: μ of eq. 15 (published).
        error_clip: longest task error (m) that a step tries to close (published); infinity for
            the letter of the paper.

    Raises:
        RangeError: a tolerance, count or gain is not positive.
    """

    scheme: Literal["box", "published"] = "box"
    position_tolerance: float = 1e-6
    rotation_tolerance: float = 1e-5
    max_iterations: int = 40
    restarts: int = 20
    threads: int = 1
    gain_step: float = 1.0
    damping: float = 1e-6
    error_clip: float = 0.03

    def __post_init__(self) -> None:
        """Check the numbers."""
        names = ("position_tolerance", "rotation_tolerance", "max_iterations", "threads")
        for name in (*names, "gain_step", "error_clip"):
            if not getattr(self, name) > 0:
                raise RangeError(f"{name} = {getattr(self, name):g}: must be above 0")
        for name in ("position_tolerance", "rotation_tolerance"):
            if not np.isfinite(getattr(self, name)):
                raise RangeError(f"{name} = {getattr(self, name):g}: must be finite")
        for name in ("max_iterations", "restarts", "threads"):
            if not isinstance(getattr(self, name), int | np.integer):
                raise RangeError(f"{name} = {getattr(self, name)}: must be a whole number")
        for name in ("restarts", "damping"):
            if not getattr(self, name) >= 0:
                raise RangeError(f"{name} = {getattr(self, name):g}: allowed is 0 and above")
        if self.scheme not in ("box", "published"):
            raise RangeError(f"scheme = {self.scheme!r}: allowed is 'box' or 'published'")


@dataclass(frozen=True, eq=False)
class IkSolution:
    """Postures for targets; where one was not reached, the nearest posture found.

    For positions that is the nearest there is to 1 mm in 199 of 200 and to 7 mm in the others. With
    other rows there are often two nearest postures that differ by some mm, far apart, and the
    nearer one may be missed; seldom, by some centimetres.

    Attributes:
        task: what was held.
        q: (K, n) postures inside the limits (rad or m).
        position_error: (K,) m.
        rotation_error: (K,) rad; 0 where no orientation is held.
        solved: (K,) whether the errors are within the tolerances.
        iterations: (K,) steps tried, over all starts.
        restarts: (K,) starts after the first.
        status: whether all targets were reached, and a sentence.
        provenance: version, hashes, choices.
    """

    task: HandRows
    q: Float[np.ndarray, "samples coords"]
    position_error: Float[np.ndarray, " samples"]
    rotation_error: Float[np.ndarray, " samples"]
    solved: Bool[np.ndarray, " samples"]
    iterations: Int[np.ndarray, " samples"]
    restarts: Int[np.ndarray, " samples"]
    status: Status
    provenance: Provenance

    def sentences(self) -> list[str]:
        """Say for each target "solved" or what is missing."""
        return [
            "solved" if ok else _shortfall(self.task, near, turned)
            for ok, near, turned in zip(
                self.solved, self.position_error, self.rotation_error, strict=True
            )
        ]

    def to_frame(self) -> "pd.DataFrame":
        """Give a table: one row a target, joints in rad, errors in mm and degrees."""
        import pandas as pd

        frame = pd.DataFrame(self.q, columns=pd.Index(self.task.arm.joints))
        frame["error_mm"] = 1e3 * self.position_error
        frame["error_deg"] = np.rad2deg(self.rotation_error)
        frame["iterations"] = self.iterations
        frame["status"] = self.sentences()
        return frame


def solve_ik(
    task: HandRows | Position | Pose,
    target: ArrayLike,
    *,
    start: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    options: IkOptions | None = None,
    seeds: SeedTable | None = None,
) -> IkSolution:
    """Find postures inside the joint limits that bring the hand to targets.

    Args:
        task: what is held: `Position`, `Pose`, or any rows as `HandRows`.
        target: (m,) or (K, m) in the task's rows (m, rad); poses also as (K, 4, 4).
        start: (n,) or (K, n) first postures (rad or m), moved inside the limits if they lie
            outside; left out: the posture of a table whose hand is nearest to the target.
        weights: (n,) positive weights of the joints, as `identify_weights` gives: a joint with a
            large weight moves less. Left out: all alike.
        options: tolerances, restarts, scheme.
        seeds: table to start again from; left out: one is made.

    Returns:
        A posture for each target, with its errors and whether it was reached. q never leaves the
        limits.

    Raises:
        ShapeError: target, start or weights do not fit the task.
        NotFiniteError: an array holds NaN or infinite values.
        RangeError: a weight is not positive, or the seed table belongs to other limits.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> from selfmotion.redundancy.task import Position
        >>> solution = solve_ik(Position(load_arm("upper_limb")), [[0.2, 0.4, -0.1]])
        >>> bool(solution.solved[0]), bool(solution.position_error[0] < 1e-6)
        (True, True)
    """
    opts = options or IkOptions()
    rows_task = as_hand_rows(task)
    goals = goals_of(task, target)
    if opts.scheme == "box" and (opts.restarts or start is None):
        seeds = seed_table(rows_task) if seeds is None else seeds
        _check_seeds(seeds, rows_task)
    first = _starts(rows_task, goals, start)
    rows = Rows(
        np.array(rows_task.axes, dtype=np.int64),
        rows_task.mode,
        rows_task.rotation_scale,
        mobility_of(rows_task, weights),
    )
    out = run(model_of(rows_task), rows, goals, (first, start is None), opts, seeds)
    if opts.scheme == "box" and opts.restarts and seeds is not None and not out.solved.all():
        persist(rows_task, rows, goals, opts, seeds, out)
    q, errors, counts, solved = out
    missed = int((~solved).sum())
    sentence = f"{len(q) - missed} of {len(q)} targets reached"
    if missed:
        worst = int(np.argmax(np.where(solved, -1.0, errors[:, 0] + errors[:, 1])))
        sentence += f"; target {worst}: {_shortfall(rows_task, *errors[worst])}"
    choices = {"scheme": opts.scheme, "rows": ",".join(rows_task.rows), "arm": rows_task.arm.name}
    inputs = {"target": hash_arrays(goals.position, goals.rotation), "start": hash_arrays(first)}
    return IkSolution(
        rows_task,
        freeze(q),
        freeze(errors[:, 0].copy()),
        freeze(errors[:, 1].copy()),
        freeze(solved),
        freeze(counts[:, 0].copy()),
        freeze(counts[:, 1].copy()),
        Status(missed == 0, sentence),
        Provenance("solve_ik", inputs=inputs, choices=choices),
    )


def _check_seeds(seeds: SeedTable, task: HandRows) -> None:
    made_for = seeds.task
    same = np.array_equal(made_for.arm.lower, task.arm.lower) and np.array_equal(
        made_for.arm.upper, task.arm.upper
    )
    if not same or made_for.rows != task.rows:
        raise RangeError(
            f"the seed table is for rows {','.join(made_for.rows)} and other limits: make one with "
            "seed_table for this task"
        )


def _starts(task: HandRows, goals: Goals, start: ArrayLike | None) -> np.ndarray:
    """Give first postures inside the limits, one for all targets or one each."""
    if start is None:
        return 0.5 * np.sum(finite_limits(task.arm), axis=0)[None]
    first = np.atleast_2d(as_float_array("start", start))
    n, n_targets = task.arm.n_joints, len(goals.position)
    if first.ndim != 2 or first.shape[1] != n or len(first) not in (1, n_targets):
        raise ShapeError(
            f"start has shape {np.shape(start)}; expected ({n},) or ({n_targets}, {n})"
        )
    require_finite("start", first)
    return np.clip(first, task.arm.lower, task.arm.upper)


def mobility_of(task: HandRows, weights: ArrayLike | None) -> Float[np.ndarray, " coords"]:
    """Give the inverse weights of the joints, scaled to a mean of 1.

    Raises:
        ShapeError: not one weight for each joint.
        RangeError: a weight is not positive and finite.
    """
    n = task.arm.n_joints
    if weights is None:
        return np.ones(n)
    W = as_float_array("weights", weights)
    if W.shape != (n,):
        raise ShapeError(f"weights have shape {W.shape}; expected ({n},)")
    if not (np.isfinite(W).all() and (W > 0).all()):
        i = int(np.argmin(np.where(np.isfinite(W), W, -np.inf)))
        raise RangeError(f"weight of {task.arm.joints[i]} = {W[i]:g}: must be above 0 and finite")
    inverse = W.min() / W
    return inverse / inverse.mean()


def _shortfall(task: HandRows, near: float, turned: float) -> str:
    """Say what is missing to a target."""
    missing = [f"{1e3 * near:.3g} mm" if near < 1.0 else f"{near:.4g} m"] if task.axes else []
    if task.angles:
        missing.append(f"{np.rad2deg(turned):.3g} degrees")
    return f"not reached: {' and '.join(missing)} short"
