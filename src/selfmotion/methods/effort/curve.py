"""Muscle effort along a self-motion manifold, sampled until nothing can hide between samples.

Effort along the curve is continuous and piecewise smooth but where a muscle's path jumps over a
wrapping surface. Samples start evenly spaced. A gap between two samples is halved as long as
effort could dip in it below the least value known: with the curvature seen around the gap, taken
`SAFETY` times, the dip below the chord is at most ``curvature * gap**2 / 8``. Samples beside a
local minimum are refined by parabolas until the minimum is known to the tolerance.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.static_optimization import (
    TORQUE_TOLERANCE,
    EffortOptions,
    muscle_problem,
)
from selfmotion.redundancy.feasible import FeasibleInterval

# First spacing of the samples (rad along the curve; a degree of swivel is about 0.04).
FIRST_GAP = 0.15
# Curvature is taken so many times as large as the samples around show it.
SAFETY = 2.0
# Gaps are not halved below this (rad along the curve, about 0.01 degrees of swivel).
SMALLEST_GAP = 5e-4
MAX_ROUNDS = 24
# Effort is raised by this for each N m that no activation gives, so that held postures win.
_PENALTY = 1e3
# Unexplained change of a path's length between two samples that makes a jump (m): less than the
# shortest that moves effort by 1e-3, more than what samples a gap apart leave unexplained.
JUMP = 2e-4


@dataclass(frozen=True, eq=False)
class EffortCurve:
    """Samples of effort along one interval, in order.

    Attributes:
        interval: the stretch of the manifold.
        arc: (K,) places along it (rad).
        q: (K, 7) postures (rad).
        effort: (K,) muscle effort; raised where no activation holds the posture.
        missing: (K,) greatest missing torque (N m).
        activations: (K, M).
        unexplained: (K - 1, M) change of length between samples beyond what moment arms explain.
        n_evaluations: postures for which effort was computed.
    """

    interval: FeasibleInterval
    arc: Float[np.ndarray, " samples"]
    q: Float[np.ndarray, "samples 7"]
    effort: Float[np.ndarray, " samples"]
    missing: Float[np.ndarray, " samples"]
    activations: Float[np.ndarray, "samples muscles"]
    unexplained: Float[np.ndarray, "gaps muscles"]
    n_evaluations: int

    @property
    def held(self) -> np.ndarray:
        """Tell which samples some activation holds."""
        return self.missing <= TORQUE_TOLERANCE

    def minima(self) -> list[int]:
        """Give the samples that are not above their neighbours, one for each valley."""
        E = self.effort
        out: list[int] = []
        for i in range(len(E)):
            left = i == 0 or E[i] < E[i - 1]
            right = i == len(E) - 1 or E[i] <= E[i + 1]
            if left and right:
                out.append(i)
        return out


class _Sampler:
    """Effort at places of one interval; keeps the samples in order."""

    def __init__(
        self, model: MusculoskeletalArm, interval: FeasibleInterval, options: EffortOptions
    ) -> None:
        self.model, self.interval, self.options = model, interval, options
        n_muscles = len(model.muscles.names)
        self.arc = np.empty(0)
        self.q = np.empty((0, 7))
        self.effort, self.missing = np.empty(0), np.empty(0)
        self.activations = np.empty((0, n_muscles))
        self.lengths, self.slopes = np.empty((0, n_muscles)), np.empty((0, n_muscles))

    def add(self, places: np.ndarray) -> None:
        """Compute effort at more places."""
        interval = self.interval
        q, tangents = interval.at_with_tangent(places)
        problem = muscle_problem(self.model, q, self.options)
        activations, missing, _ = problem.solve(self.options)
        lack = np.abs(missing).max(axis=1)
        short = np.where(lack > TORQUE_TOLERANCE, lack, 0.0)
        effort = (activations**self.options.exponent).sum(axis=1) + _PENALTY * short
        order = np.argsort(np.concatenate([self.arc, places]), kind="stable")
        merged = {
            "arc": places,
            "q": q,
            "effort": effort,
            "missing": lack,
            "activations": activations,
            "lengths": problem.lengths,
            "slopes": problem.slopes(tangents),
        }
        for name, new in merged.items():
            setattr(self, name, np.concatenate([getattr(self, name), new])[order])

    def unexplained(self) -> np.ndarray:
        """Give what moment arms leave of the change in length between samples, (K - 1, M)."""
        gap = np.diff(self.arc)[:, None]
        mean = 0.5 * (self.slopes[1:] + self.slopes[:-1])
        # A smooth path leaves h^3 l'''/12; what the change of slope itself explains is let pass.
        smooth = 0.1 * gap * np.abs(self.slopes[1:] - self.slopes[:-1])
        return np.maximum(np.abs(np.diff(self.lengths, axis=0) - gap * mean) - smooth, 0.0)


def effort_curve(
    model: MusculoskeletalArm,
    interval: FeasibleInterval,
    options: EffortOptions,
    *,
    tolerance: float,
    best: float = np.inf,
) -> EffortCurve:
    """Sample effort along an interval until its minima are certain.

    Args:
        model: arm with muscles.
        interval: stretch of the manifold.
        options: how effort is computed.
        tolerance: relative error of effort at the least minimum.
        best: least effort known elsewhere: gaps that cannot go below it are left as they are.
    """
    sampler = _Sampler(model, interval, options)
    length = interval.arc[-1]
    count = max(int(np.ceil(length / FIRST_GAP)), 4) + 1
    sampler.add(np.linspace(0.0, length, count))
    for _ in range(MAX_ROUNDS):
        places = _next_places(sampler, tolerance, best)
        if len(places) == 0:
            break
        sampler.add(places)
    return EffortCurve(
        interval,
        sampler.arc,
        sampler.q,
        sampler.effort,
        sampler.missing,
        sampler.activations,
        sampler.unexplained(),
        len(sampler.arc),
    )


def _next_places(sampler: _Sampler, tolerance: float, best: float) -> np.ndarray:
    """Give places where effort should be known too: middles of doubtful gaps, vertices."""
    s, E = sampler.arc, sampler.effort
    gap = np.diff(s)
    least = min(best, float(E.min()))
    allowed = 0.5 * tolerance * max(least, 1e-12)
    bend = _bend(s, E)
    dip = SAFETY * bend * gap**2 / 8.0
    low = np.minimum(E[:-1], E[1:]) - dip
    doubtful = (low < least - allowed) & (gap > 2 * SMALLEST_GAP)
    jump = (sampler.unexplained() > JUMP).any(axis=1) & (gap > 4 * SMALLEST_GAP)
    places = [0.5 * (s[:-1] + s[1:])[doubtful | jump]]
    taken = doubtful | jump
    for i in range(1, len(s) - 1):
        if not (E[i] < E[i - 1] and E[i] <= E[i + 1]):
            continue
        a, b = s[i] - s[i - 1], s[i + 1] - s[i]
        if max(a, b) <= 2 * SMALLEST_GAP or taken[i - 1] or taken[i]:
            continue
        # The least minimum is pinned down further, for its place and not for its value.
        share = 0.005 if E[i] <= (1 + tolerance) * least else 0.2
        if max(dip[i - 1], dip[i]) < share * tolerance * max(E[i], 1e-12):
            continue
        places.append(np.array([_vertex(s[i - 1 : i + 2], E[i - 1 : i + 2])]))
    return np.unique(np.concatenate(places))


def _bend(s: np.ndarray, E: np.ndarray) -> np.ndarray:
    """Give the greatest second derivative seen around each gap (K - 1,)."""
    slope = np.diff(E) / np.diff(s)
    second = np.abs(2.0 * np.diff(slope) / (s[2:] - s[:-2]))
    padded = np.concatenate([second[:1], second, second[-1:]])
    return np.maximum(padded[:-1], padded[1:])


def _vertex(s: np.ndarray, E: np.ndarray) -> float:
    """Give the vertex of the parabola through three samples, kept away from all of them."""
    a, b = s[1] - s[0], s[2] - s[1]
    left, right = (E[1] - E[0]) / a, (E[2] - E[1]) / b
    curvature = (right - left) / (a + b)
    x = s[1] - (left * b + right * a) / (a + b) / (2 * curvature) if curvature > 0 else s[1]
    # A vertex on a sample tells nothing new: go a step into the wider side instead.
    clear = 0.1 * max(a, b)
    if abs(x - s[1]) < clear:
        x = s[1] + clear if b > a else s[1] - clear
    return float(np.clip(x, s[0] + 0.05 * a, s[2] - 0.05 * b))
