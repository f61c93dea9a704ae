"""Integrate stiff equations for many movements at once, whatever the stiffness.

One linearly implicit Runge-Kutta method of order 3 (ROS34PW2 of Rang and Angermann, BIT 45:761,
2005): L-stable, with an embedded solution of order 2 for the choice of step. It is a W-method: its
order does not depend on how good the Jacobian is, only its stability for the stiff parts does, so
that the stiff springs enter it exactly and the turning of the arm not at all.

All movements share one step; the worst of them chooses it.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from jaxtyping import Float

# Coefficients of ROS34PW2.
GAMMA = 4.3586652150845900e-01
ALPHA = np.array(
    [
        [0.0, 0.0, 0.0],
        [8.7173304301691801e-01, 0.0, 0.0],
        [8.4457060015369423e-01, -1.1299064236484185e-01, 0.0],
        [0.0, 0.0, 1.0],
    ]
)
GAMMAS = np.array(
    [
        [0.0, 0.0, 0.0],
        [-8.7173304301691801e-01, 0.0, 0.0],
        [-9.0338057013044082e-01, 5.4180672388095326e-02, 0.0],
        [2.4212380706095346e-01, -1.2232505839045147e00, 5.4526025533510214e-01],
    ]
)
WEIGHTS = np.array(
    [
        2.4212380706095346e-01,
        -1.2232505839045147e00,
        1.5452602553351020e00,
        4.3586652150845900e-01,
    ]
)
EMBEDDED = np.array([3.7810903145819369e-01, -9.6042292212423178e-02, 0.5, 2.1793326075422950e-01])

Batch = Float[np.ndarray, "movements joints"]


class Slope(NamedTuple):
    """The right-hand side and its (approximate) Jacobian for all movements."""

    velocity: np.ndarray  # (B, n)
    jacobian: np.ndarray  # (B, n, n)


class Slopes(Protocol):
    """The equations of motion; the Jacobian is asked for once a step, the velocity four times."""

    def __call__(self, t: float, q: Batch, /) -> Slope:
        """Give velocity and approximate Jacobian at a time and posture (B, n)."""
        ...

    def velocity(self, t: float, q: Batch, /) -> Batch:
        """Give the velocity alone."""
        ...


@dataclass(frozen=True)
class StepControl:
    """How finely to integrate.

    Attributes:
        tolerance: error allowed in one step (rad or m), for the worst joint of all movements.
        max_steps: steps tried before giving up.
    """

    tolerance: float = 1e-8
    max_steps: int = 5000


def integrate_lockstep(
    slopes: Slopes, start: Batch, time: np.ndarray, control: StepControl
) -> tuple[np.ndarray, float]:
    """Integrate q' = slopes(t, q) and give q at the times asked.

    Args:
        slopes: velocity (B, n) and approximate Jacobian (B, n, n) at a time and posture.
        start: (B, n) where the movements start (rad or m).
        time: (S,) increasing times of output (s).
        control: tolerance and limit on steps.

    Returns:
        Positions (B, S, n), NaN from where the integration stopped, and the time reached (s):
        the last of `time` if all went well.
    """
    out = np.full((len(start), len(time), start.shape[1]), np.nan)
    q, t = start.copy(), float(time[0])
    out[:, 0] = q
    h = float(time[1] - time[0]) / 8.0
    n_left = control.max_steps
    first = slopes(t, q)
    for i in range(1, len(time)):
        while t < time[i]:
            if n_left == 0 or h < 1e-14 * max(1.0, abs(t)):
                return out, t
            n_left -= 1
            step = min(h, float(time[i]) - t)
            tried, error = _step(slopes, t, q, step, first)
            ratio = error / control.tolerance
            if ratio <= 1.0:
                t = float(time[i]) if step >= time[i] - t else t + step
                q = tried
                first = slopes(t, q)
            grow = 0.9 * max(ratio, 1e-6) ** (-1.0 / 3.0) if np.isfinite(ratio) else 0.1
            proposed = step * min(5.0, max(0.1, grow))
            # A step cut short by the output grid says nothing against the longer one.
            h = max(h, proposed) if ratio <= 1.0 and step < h else proposed
        out[:, i] = q
    return out, t


def _step(
    slopes: Slopes, t: float, q: np.ndarray, h: float, first: Slope
) -> tuple[np.ndarray, float]:
    """Take one step from `first`; the error is infinite where the step left the numbers."""
    n = q.shape[1]
    matrix = np.eye(n) - h * GAMMA * first.jacobian
    stages: list[np.ndarray] = []
    for i in range(4):
        if i == 0:
            velocity = first.velocity
        else:
            point = q + sum(ALPHA[i, j] * stages[j] for j in range(i))
            if not np.isfinite(point).all():
                return q, np.inf
            velocity = slopes.velocity(t + h * ALPHA[i].sum(), point)
        right = h * velocity
        for j in range(i):
            coupled = GAMMAS[i, j] * stages[j]
            right = right + h * np.einsum("bij,bj->bi", first.jacobian, coupled)
        try:
            stages.append(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return q, np.inf
    tried = q + sum(WEIGHTS[i] * stages[i] for i in range(4))
    error = sum((WEIGHTS[i] - EMBEDDED[i]) * stages[i] for i in range(4))
    if not np.isfinite(tried).all():
        return q, np.inf
    return tried, float(np.abs(error).max())
