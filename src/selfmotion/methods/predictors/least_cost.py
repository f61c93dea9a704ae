"""The posture of least cost among those that hold the hand pose: what most criteria share."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from selfmotion.errors import Status
from selfmotion.methods.predictors.observation import Prediction, Scene, Stretch

# Cost of postures (K, 7), as (K,) numbers.
Cost = Callable[[Float[np.ndarray, "samples 7"]], Float[np.ndarray, " samples"]]

NOTHING_FEASIBLE = Prediction(
    float("nan"), Status(False, "no posture inside the joint limits holds the hand pose")
)
AT_AN_END = Status(True, "at an end of the feasible interval")


def least_cost(scene: Scene, cost: Cost) -> Prediction:
    """Find the swivel angle of least cost; a parabola refines it between the samples."""
    best, found = np.inf, NOTHING_FEASIBLE
    for stretch in scene.stretches:
        values = cost(stretch.q)
        i = int(np.argmin(values))
        if values[i] < best:
            best, found = float(values[i]), _refined(stretch, values, i)
    return found


def _refined(stretch: Stretch, values: Float[np.ndarray, " samples"], i: int) -> Prediction:
    if i in (0, len(values) - 1):
        return Prediction(float(stretch.swivel[i]), AT_AN_END)
    x, y = stretch.swivel[i - 1 : i + 2], values[i - 1 : i + 2]
    curve, slope, _ = np.polyfit(x - x[1], y - y[1], 2)
    if not curve > 0.0:
        return Prediction(float(x[1]))
    offset = np.clip(-slope / (2.0 * curve), *np.sort(x[[0, 2]] - x[1]))
    return Prediction(float(x[1] + offset))
