"""Functions of one coordinate as piecewise cubics: what couplers and joints of an .osim hold.

OpenSim extends a SimmSpline beyond its ends along straight lines; so do these, by end pieces.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

# Far outside any joint's range (rad or m): where end pieces begin and stop.
FAR = 1e3
# A spline whose pieces all lie on one line to this (relative) is that line.
_LINEAR = 1e-9


@dataclass(frozen=True, eq=False)
class Curve:
    """A function of one coordinate.

    Attributes:
        knots: (P,) places, rising.
        values: (P,) values there.
        slopes: (P,) slopes there; beyond the ends the function goes on along them.
    """

    knots: np.ndarray
    values: np.ndarray
    slopes: np.ndarray

    @classmethod
    def line(cls, slope: float, value: float) -> "Curve":
        """Give ``slope * x + value``."""
        return cls(np.zeros(1), np.array([float(value)]), np.array([float(slope)]))

    def __call__(self, x: float) -> tuple[float, float]:
        """Give value and slope at one place."""
        if len(self.knots) == 1 or x <= self.knots[0]:
            i = 0
        elif x >= self.knots[-1]:
            i = -1
        else:
            cubic = CubicHermiteSpline(self.knots, self.values, self.slopes)
            return float(cubic(x)), float(cubic(x, 1))
        slope = float(self.slopes[i])
        return float(self.values[i]) + slope * (x - float(self.knots[i])), slope

    @property
    def as_line(self) -> tuple[float, float] | None:
        """Give slope and value at 0 where the function is a straight line."""
        slope = float(self.slopes[0])
        value = float(self.values[0]) - slope * float(self.knots[0])
        scale = max(float(np.abs(self.values).max()), float(np.abs(self.slopes).max()), 1e-12)
        off = np.abs(self.values - (slope * self.knots + value)).max()
        if off > _LINEAR * scale or np.abs(self.slopes - slope).max() > _LINEAR * scale:
            return None
        return slope, value

    def after(self, inner: "Curve") -> "Curve | None":
        """Give ``self(inner(x))``, or None where neither is a straight line."""
        outer_line, inner_line = self.as_line, inner.as_line
        if outer_line is not None:
            slope, value = outer_line
            return Curve(inner.knots, slope * inner.values + value, slope * inner.slopes)
        if inner_line is None:
            return None
        slope, value = inner_line
        if slope == 0.0:
            return Curve.line(0.0, self(value)[0])
        knots = (self.knots - value) / slope
        order = np.argsort(knots)
        return Curve(knots[order], self.values[order], slope * self.slopes[order])

    def to_ppoly(self) -> PPoly:
        """Give the function as SciPy's piecewise polynomial, straight beyond the ends."""
        x = np.concatenate([[self.knots[0] - FAR], self.knots, [self.knots[-1] + FAR]])
        low = self.values[0] - FAR * self.slopes[0]
        high = self.values[-1] + FAR * self.slopes[-1]
        y = np.concatenate([[low], self.values, [high]])
        s = np.concatenate([self.slopes[:1], self.slopes, self.slopes[-1:]])
        cubic = CubicHermiteSpline(x, y, s)
        c = cubic.c.copy()
        c[:2, 0] = c[:2, -1] = 0.0  # exactly straight, not to rounding of FAR cubed
        c[2, 0], c[2, -1] = self.slopes[0], self.slopes[-1]
        return PPoly(c, x)
