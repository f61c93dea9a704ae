"""What is found for a hand pose: the posture, every local minimum, jumps of effort."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.errors import Status
from selfmotion.methods.effort.curve import JUMP, SMALLEST_GAP, EffortCurve
from selfmotion.muscles.static_optimization import HELD
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

# Another minimum within this share of the least effort is a tie; a valley is as wide as effort
# stays within it.
TIE = 1e-3
# Valleys wider than this (rad of swivel) are flat: effort does not say where to stand in them.
FLAT = np.deg2rad(5.0)


@dataclass(frozen=True, eq=False)
class LocalMinimum:
    """A posture of locally least effort.

    Attributes:
        q: (7,) posture (rad).
        swivel: swivel angle (rad).
        effort: muscle effort.
        interval: which feasible interval it is in.
        at: the joint limit or body that it leans on, or nothing.
        valley: swivel angles (rad) between which effort stays within `TIE` of it.
        tied: whether its effort is within `TIE` of the least.
        beside_jump: whether effort jumps within 0.1 degrees of it.
    """

    q: Float[np.ndarray, "7"]
    swivel: float
    effort: float
    interval: int
    at: str
    valley: tuple[float, float]
    tied: bool
    beside_jump: bool

    @property
    def flat(self) -> bool:
        """Whether the valley is so wide that effort does not determine the swivel angle."""
        return bool(self.valley[1] - self.valley[0] > FLAT)


@dataclass(frozen=True)
class Jump:
    """A place where a muscle's path jumps over what it wraps, and effort with it.

    Attributes:
        swivel: swivel angle (rad).
        muscles: those whose length jumps.
        effort: effort on either side.
    """

    swivel: float
    muscles: tuple[str, ...]
    effort: tuple[float, float]


@dataclass(frozen=True, eq=False)
class NaturalPosture:
    """The posture of least muscle effort for one hand pose.

    Attributes:
        coordinates: names of the seven coordinates.
        q: (7,) posture (rad); NaN where there is none.
        swivel: swivel angle (rad).
        effort: muscle effort.
        activations: by muscle, (M,).
        muscles: names of the M muscles.
        minima: every local minimum, the least first.
        feasible_swivel: feasible intervals of swivel angle (rad), body shapes excluded.
        jumps: places where effort is discontinuous.
        drift: how far the hand is from its pose: m and rad (the paper's search drifts).
        status: whether a posture was found, and what to know about it.
        n_evaluations: postures for which effort was computed.
        provenance: model, convention, search.
    """

    coordinates: tuple[str, ...]
    q: Float[np.ndarray, "7"]
    swivel: float
    effort: float
    activations: Float[np.ndarray, " muscles"]
    muscles: tuple[str, ...]
    minima: tuple[LocalMinimum, ...]
    feasible_swivel: tuple[tuple[float, float], ...]
    jumps: tuple[Jump, ...]
    drift: tuple[float, float]
    status: Status
    n_evaluations: int
    provenance: Provenance

    def to_frame(self) -> "pd.DataFrame":
        """Give the local minima as a table, the least first."""
        import pandas as pd

        rows = [
            {"swivel": m.swivel, "effort": m.effort, "interval": m.interval, "at": m.at}
            | {"tied": m.tied, "flat": m.flat, "beside_jump": m.beside_jump}
            | dict(zip(self.coordinates, m.q.tolist(), strict=True))
            for m in self.minima
        ]
        return pd.DataFrame(rows)


def local_minima(
    curves: list[EffortCurve], muscles: tuple[str, ...], *, tolerance: float, exclude: bool
) -> tuple[list[LocalMinimum], list[Jump]]:
    """Give local minima, the least first, and jumps."""
    jumps: list[Jump] = []
    raw: list[tuple[float, int, int, bool]] = []
    any_held = any(bool(curve.held.any()) for curve in curves)
    for number, curve in enumerate(curves):
        gaps = _jump_gaps(curve, tolerance)
        swivel = curve.interval.swivel_near(curve.arc)
        for g in gaps:
            which = np.flatnonzero(curve.unexplained[g] > JUMP)
            names = tuple(muscles[m] for m in which)
            sides = (float(curve.effort[g]), float(curve.effort[g + 1]))
            jumps.append(Jump(float(0.5 * (swivel[g] + swivel[g + 1])), names, sides))
        edges = 0.5 * (curve.arc[:-1] + curve.arc[1:])[gaps]
        for i in curve.minima():
            if not curve.held[i] and any_held:
                continue
            beside = bool((np.abs(edges - curve.arc[i]) < 8 * SMALLEST_GAP).any())
            if not (beside and exclude):
                raw.append((float(curve.effort[i]), number, i, beside))
    raw.sort()
    least = raw[0][0] if raw else np.inf
    minima = [
        _minimum(curves[number], number, i, beside=beside, tied=bool(E <= (1 + TIE) * least))
        for E, number, i, beside in raw
    ]
    return minima, jumps


def _jump_gaps(curve: EffortCurve, tolerance: float) -> np.ndarray:
    """Give the gaps, as fine as gaps get, over which path and effort both jump."""
    E = curve.effort
    fine = np.diff(curve.arc) <= 8 * SMALLEST_GAP
    moved = np.abs(np.diff(E)) > tolerance * np.minimum(E[1:], E[:-1])
    return np.flatnonzero(fine & moved & (curve.unexplained > JUMP).any(axis=1))


def _minimum(curve: EffortCurve, number: int, i: int, *, beside: bool, tied: bool) -> LocalMinimum:
    swivel = curve.interval.swivel_near(curve.arc)
    swivel[i] = curve.interval.swivel_at(curve.q[i : i + 1])[0]
    low, high = (_valley_end(swivel, curve.effort, i, step) for step in (-1, 1))
    at = ""
    if i == 0:
        at = curve.interval.ends[0]
    elif i == len(curve.arc) - 1:
        at = curve.interval.ends[1]
    valley = (float(min(low, high)), float(max(low, high)))
    return LocalMinimum(
        curve.q[i], float(swivel[i]), float(curve.effort[i]), number, at, valley, tied, beside
    )


def _valley_end(swivel: np.ndarray, E: np.ndarray, i: int, step: int) -> float:
    """Give the swivel angle up to which effort stays within `TIE`, by lines between samples."""
    bound = (1 + TIE) * E[i]
    j = i
    while 0 <= j + step < len(E):
        k = j + step
        if E[k] > bound:
            rise = max(E[k] - E[j], 1e-300)
            # Effort rises from the minimum as a square: so does the share of the gap.
            share = np.sqrt((bound - E[j]) / rise) if j == i else (bound - E[j]) / rise
            return float(swivel[j] + share * (swivel[k] - swivel[j]))
        j = k
    return float(swivel[j])


def verdict(held: Status, minima: list[LocalMinimum], drift: tuple[float, float]) -> Status:
    """Say what to know about the posture found."""
    if not held:
        return held
    least, notes = minima[0], []
    ties = sum(m.tied for m in minima) - 1
    if ties > 0:
        notes.append(f"{ties} other minimum(s) within {TIE:g} of its effort")
    if least.flat:
        low, high = np.rad2deg(least.valley)
        notes.append(f"flat valley from {low:.1f} to {high:.1f} deg of swivel")
    if least.beside_jump:
        notes.append("beside a jump of effort")
    if held.sentence != HELD:
        notes.append(held.sentence.removeprefix(f"{HELD}; "))
    if least.at:
        notes.append(f"at the limit {least.at}")
    if drift[0] > 1e-6:
        notes.append(f"the hand is {1e3 * drift[0]:.1f} mm off its pose")
    return Status(True, "; ".join(["least effort found", *notes]))
