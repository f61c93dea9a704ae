"""Muscle effort along a self-motion manifold, sampled until nothing can hide between samples.

Effort along the curve is continuous and piecewise smooth but where a muscle's path jumps over a
wrapping surface. Samples start evenly spaced. A gap between two samples is halved as long as
effort could dip in it below the least value known: with the curvature seen around the gap, taken
`SAFETY` times, the dip below the chord is at most ``curvature * gap**2 / 8``; curvature is never
taken across a jump. Jumps are followed by the length of the path that jumps, which is cheap, and
then sampled on either side. Samples beside a local minimum are refined by parabolas until the
minimum is known to the tolerance.
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
# A jump is followed to a gap so small, as the least effort may stand at its very edge.
JUMP_GAP = 1e-4
# A minimum is where a parabola says, if its samples are so near (rad, about a degree of swivel).
NEAR = 0.04
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

    def sides(self, gap: int, muscle: int) -> tuple[float, float]:
        """Give places close on either side of a muscle's jump within a gap, or its middle.

        Of all paths only the one that jumps is asked for: half of a model's jumps take as long to
        follow otherwise as all the rest of the search.
        """
        a, b = self.arc[gap : gap + 2]
        here, there = self.lengths[gap : gap + 2, muscle]
        slope, ahead = (self._rate(gap, muscle, beside) for beside in (gap - 1, gap + 1))
        while b - a > JUMP_GAP:
            middle = 0.5 * (a + b)
            length = self.model.geometry.length(self.interval.at(middle)[0], muscle)
            behind = abs(length - here - slope * (middle - a))
            if behind < abs(there - ahead * (b - middle) - length):
                slope = (length - here) / (middle - a)
                a, here = middle, length
            else:
                ahead = (there - length) / (b - middle)
                b, there = middle, length
        if abs(there - here - 0.5 * (slope + ahead) * (b - a)) < 0.5 * JUMP:
            middle = float(self.arc[gap : gap + 2].mean())
            return middle, middle  # no jump: the path bends fast, and wants more samples
        return float(a), float(b)

    def _rate(self, gap: int, muscle: int, beside: int) -> float:
        """Give the rate of a length at the end of a gap towards the one beside it.

        What moment arms leave in that one goes on, unless the path jumps there too.
        """
        slope = self.slopes[max(gap, beside), muscle]
        if not 0 <= beside < len(self.arc) - 1 or self.unexplained()[beside, muscle] > JUMP:
            return slope
        ends = slice(beside, beside + 2)
        rate = np.diff(self.lengths[ends, muscle])[0] / np.diff(self.arc[ends])[0]
        return slope + rate - self.slopes[ends, muscle].mean()

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
    unexplained = sampler.unexplained()
    jump = np.asarray((unexplained > JUMP).any(axis=1))
    cut = np.zeros(len(unexplained), dtype=np.bool_)
    places = places[: _doubts(sampler.arc, sampler.effort, jump, tolerance, best, places, cut)]
    for i in np.flatnonzero(cut):
        sides = sampler.sides(int(i), int(unexplained[i].argmax()))
        places = np.append(places, sides)
    return np.setdiff1d(places, sampler.arc)


@njit(cache=True)
def _doubts(s, E, jump, tolerance, best, places, cut):
    """Fill places with what `_next_places` gives; returns how many there are.

    Gaps whose jump is to be followed are marked in `cut` instead.
    """
    n = s.shape[0]
    least = best
    for i in range(n):
        least = min(least, E[i])
    allowed = 0.5 * tolerance * max(least, 1e-12)
    second = _curvature(s, E, jump)
    few = jump.sum() <= MANY_JUMPS
    dip, taken = np.empty(n - 1), np.zeros(n - 1, np.bool_)
    count = 0
    for i in range(n - 1):
        gap = s[i + 1] - s[i]
        if jump[i]:
            # On either side of a jump effort goes on as it does beside the gap.
            steep = abs(E[i] - E[i - 1]) / (s[i] - s[i - 1]) if i > 0 else 0.0
            if i + 2 < n:
                steep = max(steep, abs(E[i + 2] - E[i + 1]) / (s[i + 2] - s[i + 1]))
            dip[i] = SAFETY * steep * gap
            low = min(E[i], E[i + 1]) - dip[i]
            cut[i] = gap > 4.0 * SMALLEST_GAP and (few or gap > ROUGH_GAP or low < least - allowed)
            taken[i] = cut[i]
            continue
        if second[i] < 0.0 and second[i + 1] < 0.0:  # not known: a jump on either side
            dip[i] = SAFETY * abs(E[i + 1] - E[i])
            taken[i] = gap > ROUGH_GAP
        else:
            # The greatest second derivative seen around the gap.
            dip[i] = SAFETY * max(second[i], second[i + 1]) * gap * gap / 8.0
        low = min(E[i], E[i + 1]) - dip[i]
        taken[i] = taken[i] or (low < least - allowed and gap > 2.0 * SMALLEST_GAP)
        if taken[i]:
            places[count] = 0.5 * (s[i] + s[i + 1])
            count += 1
    for i in range(1, n - 1):
        if not (E[i] < E[i - 1] and E[i] <= E[i + 1]):
            continue
        if jump[i - 1] or jump[i]:  # the least beside a jump: halve the gap on its smooth side
            g = i if jump[i - 1] else i - 1
            known = jump[g] or taken[g] or dip[g] < 0.005 * tolerance * max(E[i], 1e-12)
            if (
                E[i] <= (1.0 + tolerance) * least
                and not known
                and s[g + 1] - s[g] > ROUGH_GAP / 4.0
            ):
                places[count] = 0.5 * (s[g] + s[g + 1])
                count += 1
            continue
        a, b = s[i] - s[i - 1], s[i + 1] - s[i]
        if max(a, b) <= 2.0 * SMALLEST_GAP or taken[i - 1] or taken[i]:
            continue
        # The least minimum is pinned down further, for its place and not for its value.
        share = 0.005 if E[i] <= (1.0 + tolerance) * least else 0.2
        if max(dip[i - 1], dip[i]) < share * tolerance * max(E[i], 1e-12):
            continue
        vertex = _vertex(s[i - 1], s[i], s[i + 1], E[i - 1], E[i], E[i + 1])
        if max(a, b) < NEAR and abs(vertex - s[i]) < SMALLEST_GAP:
            continue
        # A vertex on a sample tells nothing new: go a step into the wider side instead.
        clear = 0.1 * max(a, b)
        if abs(vertex - s[i]) < clear:
            vertex = s[i] + clear if b > a else s[i] - clear
        places[count] = min(max(vertex, s[i - 1] + 0.05 * a), s[i + 1] - 0.05 * b)
        count += 1
    return count


@njit(cache=True)
def _curvature(s, E, jump):
    """Give the size of the second derivative at samples (K,), from samples of one smooth piece.

    At the ends of a piece it is that of the sample next to them; below 0 where a piece has two
    samples only.
    """
    n = s.shape[0]
    second = np.full(n, -1.0)
    for i in range(1, n - 1):
        if not (jump[i - 1] or jump[i]):
            a, b = s[i] - s[i - 1], s[i + 1] - s[i]
            second[i] = abs(2.0 * ((E[i + 1] - E[i]) / b - (E[i] - E[i - 1]) / a) / (a + b))
    out = second.copy()
    for i in range(n):
        if second[i] < 0.0 and i > 0 and not jump[i - 1]:
            out[i] = second[i - 1]
        if second[i] < 0.0 and i < n - 1 and not jump[i]:
            out[i] = max(out[i], second[i + 1])
    return out


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
    """Give the vertex of the parabola through three samples."""
    a, b = s1 - s0, s2 - s1
    left, right = (E1 - E0) / a, (E2 - E1) / b
    curvature = (right - left) / (a + b)
    if not curvature > 0.0:
        return s1
    return s1 - (left * b + right * a) / (a + b) / (2.0 * curvature)
