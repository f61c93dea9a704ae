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
from numba import njit

from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.static_optimization import (
    TORQUE_TOLERANCE,
    EffortOptions,
    muscle_problem,
)
from selfmotion.redundancy.feasible import FeasibleInterval

# First spacing of the samples (rad along the curve; a degree of swivel is about 0.04).
FIRST_GAP = 0.15
# The same for a curve that is drawn: fine enough to look smooth.
DRAWN_GAP = 0.03
# Curvature is taken so many times as large as the samples around show it.
SAFETY = 2.0
# Gaps are not halved below this (rad along the curve, about 0.01 degrees of swivel).
SMALLEST_GAP = 5e-4
MAX_ROUNDS = 24
# With more gaps than this over which a path jumps, it is rough (wraps that are solved for
# approximately): jumps are then followed to gaps of a quarter of a degree of swivel, and farther
# only where they may hide the least effort.
MANY_JUMPS = 8
ROUGH_GAP = 0.012
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
        out = np.empty((len(self.arc) - 1, self.lengths.shape[1]))
        _unexplained(self.arc, self.lengths, self.slopes, out)
        return out


def effort_curve(
    model: MusculoskeletalArm,
    interval: FeasibleInterval,
    options: EffortOptions,
    *,
    tolerance: float,
    best: float = np.inf,
    gap: float = FIRST_GAP,
) -> EffortCurve:
    """Sample effort along an interval until its minima are certain.

    Args:
        model: arm with muscles.
        interval: stretch of the manifold.
        options: how effort is computed.
        tolerance: relative error of effort at the least minimum.
        best: least effort known elsewhere: gaps that cannot go below it are left as they are.
        gap: spacing of the samples at first (rad along the curve).
    """
    sampler = _Sampler(model, interval, options)
    length = interval.arc[-1]
    count = max(int(np.ceil(length / gap)), 4) + 1
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
    places = np.empty(2 * len(sampler.arc))
    jump = (sampler.unexplained() > JUMP).any(axis=1)
    count = _doubts(sampler.arc, sampler.effort, jump, tolerance, best, places)
    return np.unique(places[:count])


@njit(cache=True)
def _doubts(s, E, jump, tolerance, best, places):
    """Fill places with what `_next_places` gives; returns how many there are."""
    n = s.shape[0]
    least = best
    for i in range(n):
        least = min(least, E[i])
    allowed = 0.5 * tolerance * max(least, 1e-12)
    second = np.zeros(n)
    for i in range(1, n - 1):
        a, b = s[i] - s[i - 1], s[i + 1] - s[i]
        second[i] = abs(2.0 * ((E[i + 1] - E[i]) / b - (E[i] - E[i - 1]) / a) / (a + b))
    if n > 2:
        second[0], second[n - 1] = second[1], second[n - 2]
    few = jump.sum() <= MANY_JUMPS
    dip, taken = np.empty(n - 1), np.zeros(n - 1, np.bool_)
    count = 0
    for i in range(n - 1):
        gap = s[i + 1] - s[i]
        # The greatest second derivative seen around the gap.
        dip[i] = SAFETY * max(second[i], second[i + 1]) * gap * gap / 8.0
        low = min(E[i], E[i + 1]) - dip[i]
        taken[i] = low < least - allowed and gap > 2.0 * SMALLEST_GAP
        if jump[i] and gap > 4.0 * SMALLEST_GAP:
            # On either side of a jump effort goes on as it does beside the gap.
            steep = abs(E[i] - E[i - 1]) / (s[i] - s[i - 1]) if i > 0 else 0.0
            if i + 2 < n:
                steep = max(steep, abs(E[i + 2] - E[i + 1]) / (s[i + 2] - s[i + 1]))
            low = min(E[i], E[i + 1]) - SAFETY * steep * gap
            taken[i] = taken[i] or few or gap > ROUGH_GAP or low < least - allowed
        if taken[i]:
            places[count] = 0.5 * (s[i] + s[i + 1])
            count += 1
    for i in range(1, n - 1):
        if not (E[i] < E[i - 1] and E[i] <= E[i + 1]):
            continue
        a, b = s[i] - s[i - 1], s[i + 1] - s[i]
        if max(a, b) <= 2.0 * SMALLEST_GAP or taken[i - 1] or taken[i]:
            continue
        # The least minimum is pinned down further, for its place and not for its value.
        share = 0.005 if E[i] <= (1.0 + tolerance) * least else 0.2
        if max(dip[i - 1], dip[i]) < share * tolerance * max(E[i], 1e-12):
            continue
        places[count] = _vertex(s[i - 1], s[i], s[i + 1], E[i - 1], E[i], E[i + 1])
        count += 1
    return count


@njit(cache=True)
def _unexplained(s, lengths, slopes, out):
    """Fill out (K - 1, M): what leaves the change in length over a gap unexplained (m).

    Moment arms explain most. Where they are not minus the derivative of length (OpenSim's moving
    path points and ellipsoids), the rest goes on from gap to gap at one rate, and a jump does not:
    so the lesser of what arms leave, and what arms and the rate in a gap beside it leave.
    """
    n_gaps, n_muscles = out.shape
    for i in range(n_gaps):
        gap = s[i + 1] - s[i]
        for m in range(n_muscles):
            slope, ahead = slopes[i, m], slopes[i + 1, m]
            left = lengths[i + 1, m] - lengths[i, m] - 0.5 * gap * (slope + ahead)
            least = abs(left)
            for j in (i - 1, i + 1):
                # A smooth path leaves h^3 l'''/12 of what moment arms explain.
                if least > JUMP and 0 <= j < n_gaps:
                    other = s[j + 1] - s[j]
                    rest = lengths[j + 1, m] - lengths[j, m]
                    rest -= 0.5 * other * (slopes[j, m] + slopes[j + 1, m])
                    least = min(least, abs(left - gap / other * rest))
            # What the change of slope itself explains is let pass.
            out[i, m] = max(least - 0.1 * gap * abs(ahead - slope), 0.0)


@njit(cache=True)
def _vertex(s0, s1, s2, E0, E1, E2):
    """Give the vertex of the parabola through three samples, kept away from all of them."""
    a, b = s1 - s0, s2 - s1
    left, right = (E1 - E0) / a, (E2 - E1) / b
    curvature = (right - left) / (a + b)
    x = s1
    if curvature > 0.0:
        x = s1 - (left * b + right * a) / (a + b) / (2.0 * curvature)
    # A vertex on a sample tells nothing new: go a step into the wider side instead.
    clear = 0.1 * max(a, b)
    if abs(x - s1) < clear:
        x = s1 + clear if b > a else s1 - clear
    return min(max(x, s0 + 0.05 * a), s2 - 0.05 * b)
