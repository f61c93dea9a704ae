"""Compiled distance to an ellipsoid: each point stops as soon as its own root is found."""

import numpy as np
from numba import njit

# Most points need six steps, none more than about fifteen.
MOST_STEPS = 60
# Steps are done when the unknown changes by no more than this share of itself.
STEP_TOLERANCE = 4e-15
# Coordinates of a point below this share of the largest semi-axis count as this share: on a plane
# of symmetry the nearest point may lie on either side, and one of the two is taken.
SMALLEST = 1e-14


@njit(cache=True, error_model="numpy")
def ellipsoid_distance(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Give the signed distance (m) of points (K, 3), in the axes of the ellipsoid."""
    out = np.empty(points.shape[0])
    shortest = np.argmin(half)
    least = half[shortest] ** 2
    floor = SMALLEST * half.max()
    above = half**2 - least
    y = np.empty(3)
    for k in range(points.shape[0]):
        s = 0.0
        for i in range(3):
            y[i] = abs(points[k, i])
            if y[i] < floor:  # not max(), so that NaN stays NaN
                y[i] = floor
            s = max(s, half[i] * y[i] - above[i])
        s = max(s, half[shortest] * y[shortest])
        for _ in range(MOST_STEPS):
            total, slope = 0.0, 0.0
            for i in range(3):
                square = (half[i] * y[i] / (s + above[i])) ** 2
                total += square
                slope += square / (s + above[i])
            step = total * (np.sqrt(total) - 1.0) / slope
            s += step
            if abs(step) <= STEP_TOLERANCE * s:
                break
        square = 0.0
        for i in range(3):
            square += (y[i] / (s + above[i])) ** 2
        out[k] = (s - least) * np.sqrt(square)
    return out
