"""From results to what can be drawn: points, segments and colours, without any viewer.

Everything is in the ground of the arm that is shown (m). Colours are those of the reports: muscles
by activation, the task blue, the null space orange; what limits leave blue, what they take orange.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8

from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.methods.workspace import Region
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.report.posture_figures import ACTIVATION
from selfmotion.report.theme import NULL, TASK
from selfmotion.report.workspace_figures import KEPT, LOST

# Activation from which on a muscle has its darkest colour.
FULL_COLOUR = 0.4
# Points of a cloud that are drawn at most.
MOST_POINTS = 6000
LINE = ("shoulder", "elbow", "wrist", "hand")


def rgb(colour: str) -> tuple[int, int, int]:
    """Give the three numbers of a colour written as #RRGGBB.

    >>> rgb("#0072B2")
    (0, 114, 178)
    """
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


TASK_RGB, NULL_RGB = rgb(TASK), rgb(NULL)
KEPT_RGB, LOST_RGB = rgb(KEPT), rgb(LOST)


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight pieces with a colour at each end.

    Attributes:
        points: (S, 2, 3) ends (m).
        colours: (S, 2, 3).
    """

    points: Float[np.ndarray, "pieces 2 3"]
    colours: UInt8[np.ndarray, "pieces 2 3"]


def linear_light(colours: UInt8[np.ndarray, "*any 3"]) -> UInt8[np.ndarray, "*any 3"]:
    """Take colours from sRGB to linear light, as viser's shader wants those of vertices.

    >>> linear_light(np.array([[255, 188, 0]], dtype=np.uint8)).tolist()
    [[255, 128, 0]]
    """
    c = colours / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return (255 * linear).round().astype(np.uint8)


def activation_colours(
    activations: Float[np.ndarray, " muscles"],
) -> UInt8[np.ndarray, "muscles 3"]:
    """Give each muscle its colour; one whose activation is not known is pale."""
    shares = np.clip(np.nan_to_num(activations, nan=0.0) / FULL_COLOUR, 0.0, 1.0)
    return (255 * np.asarray(ACTIVATION(shares))[:, :3]).round().astype(np.uint8)


def muscle_lines(
    model: MusculoskeletalArm,
    q: Float[np.ndarray, " coords"],
    activations: Float[np.ndarray, " muscles"],
) -> Lines:
    """Give the paths of all muscles in a posture, coloured by activation.

    Args:
        model: arm with muscles.
        q: (n,) posture (rad).
        activations: (M,), 0 to 1; NaN where not known.
    """
    paths = model.geometry.paths(q)
    colours = activation_colours(activations)
    pieces = [np.stack([path[:-1], path[1:]], axis=1) for path in paths]
    owner = np.repeat(np.arange(len(paths)), [len(p) for p in pieces])
    return Lines(np.concatenate(pieces), np.repeat(colours[owner][:, None], 2, axis=1))


def landmark_line(
    arm: Arm, q: Float[np.ndarray, "samples coords"]
) -> Float[np.ndarray, "samples 4 3"]:
    """Give shoulder, elbow, wrist and hand in the ground (m)."""
    return tip_positions(arm.chain, q, [arm.tip(name) for name in LINE])


def cloud(
    region: Region, *, slab: tuple[np.ndarray, np.ndarray, float] | None = None
) -> Float[np.ndarray, "points 3"]:
    """Give points inside a region, thinned evenly to what a viewer can show (m).

    Args:
        region: with its points.
        slab: a point, a direction and half the thickness (m); left out: all of space.
    """
    inside = region.points[region.inside]
    if slab is not None:
        point, direction, half = slab
        inside = inside[np.abs((inside - point) @ direction) <= half]
    return inside[:: max(1, -(-len(inside) // MOST_POINTS))]


def ground_to_ground(source: Arm, shown: Arm) -> Float[np.ndarray, "4 4"]:
    """Give the transform that takes the ground of one arm to that of another.

    Right, forward and up fall together, and so do the shoulders, each with its arm in the middle of
    its ranges.
    """
    R = _axes(shown) @ _axes(source).T
    here, there = (
        landmark_line(arm, np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)[None])[0, 0]
        for arm in (source, shown)
    )
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, there - R @ here
    return T


def _axes(arm: Arm) -> np.ndarray:
    """Give right, forward and up as columns."""
    return np.column_stack([np.cross(arm.forward, arm.up), arm.forward, arm.up])
