"""Maps over the space that the hand reaches: room to the joint limits, manipulability, effort.

A regular grid of points is decided by inverse kinematics; at each point reached the self-motion
leaves many postures, and a map shows the best of them ("margin", "manipulability", "effort"):

- ``margin``: the largest share of its half range that every joint can keep from its limits: 1 is
  mid-range in all joints, 0 is a point that is reached at a limit only. Found by narrowing all
  limits alike until the point is out of reach, so it is a search with restarts at each step and
  not a local one. Joints without a range or without limits do not count.
- ``manipulability``: the largest ``sqrt(det(J Jᵀ))`` of the hand's position (m³; m² for an arm in
  a plane), by a local search along the self-motion from several postures.
- ``effort``: the least muscle effort that holds the hand there ([Li2022] eq. 3), whatever its
  orientation: a local search along the self-motion, ended by `natural_posture` for the hand's
  orientation that it came to. For arms with muscles.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, freeze, require_shape
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.methods.reaching.ik_seeds import evenly, finite_limits
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.limit_margin import best_margin
from selfmotion.methods.reaching.map_result import Grid, WorkspaceMaps
from selfmotion.methods.reaching.screen import reach_box, reach_screen
from selfmotion.methods.reaching.self_motion_search import climb
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.static_optimization import EffortOptions, muscle_effort
from selfmotion.provenance import Provenance, hash_arrays

MAPS = ("margin", "manipulability", "effort")
# Postures from which the local searches start.
STARTS = 3
# Torque that no muscle gives (N m) counts as so much effort, so that the search leaves it.
MISSING_EFFORT = 1e3


@dataclass(frozen=True, eq=False)
class Mapper:
    """An arm made ready for maps.

    Attributes:
        arm: the arm.
        maps: which maps.
        muscles: the same arm with muscles, for effort.
        finder: finds natural postures, for effort.
    """

    arm: Arm
    maps: tuple[str, ...]
    muscles: MusculoskeletalArm | None = None
    finder: PostureFinder | None = field(default=None, repr=False)

    @classmethod
    def of(cls, model: Arm | MusculoskeletalArm, maps: Sequence[str]) -> "Mapper":
        """Prepare an arm.

        Raises:
            UnknownNameError: there is no such map.
            RangeError: no map is named, or effort is asked of an arm without muscles.
        """
        if not maps:
            raise RangeError(f"no map is named; allowed are {', '.join(MAPS)}")
        for name in maps:
            if name not in MAPS:
                raise unknown_name("map", name, MAPS)
        chosen = tuple(name for name in MAPS if name in maps)
        arm = model.arm if isinstance(model, MusculoskeletalArm) else model
        if "effort" not in chosen:
            return cls(arm, chosen)
        if not isinstance(model, MusculoskeletalArm):
            raise RangeError(
                f"map effort: {arm.name} has no muscles; allowed is an arm with muscles, as myoarm"
            )
        return cls(arm, chosen, model, PostureFinder.of(model))

    def grid(self, spacing: float) -> Grid:
        """Give the grid that holds all that the arm reaches."""
        return Grid.around(*reach_box(HandRows(self.arm, ("x", "y", "z"))), spacing)

    def at(self, points: ArrayLike) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Give which points (K, 3) are reached, postures (K, n), and the maps at them.

        Raises:
            ShapeError: the points are not (K, 3).
        """
        x = np.atleast_2d(as_float_array("points", points))
        require_shape("points", x, (None, 3))
        task = HandRows(self.arm, ("x", "y", "z"))
        reach = reach_screen(task, n_points=1024 if len(x) > 2000 else 128).decide(x)
        rows = np.flatnonzero(reach.reachable)
        q = reach.q.copy()
        q[~reach.reachable] = np.nan
        values = {name: np.full(len(x), np.nan) for name in self.maps}
        if "margin" in self.maps and len(rows):
            q[rows], values["margin"][rows] = best_margin(task, x[rows], q[rows])
        if "manipulability" in self.maps and len(rows):
            values["manipulability"][rows] = self._climbed(task, x[rows], q[rows])
        if "effort" in self.maps:
            for k in rows:
                values["effort"][k] = self._least_effort(task, x[k : k + 1], q[k])
        return reach.reachable, q, values

    def _climbed(self, task: HandRows, x: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Give the largest manipulability at points."""
        best = np.zeros(len(x))
        for start in self._starts(task, x, q):
            best = np.maximum(best, climb(task, x, start, manipulability_of(self.arm))[1])
        return best

    def _starts(self, task: HandRows, x: np.ndarray, q: np.ndarray) -> list[np.ndarray]:
        """Give the posture known, and others that meet the same points."""
        out = [q]
        for first in evenly(STARTS - 1, *finite_limits(self.arm)):
            found = solve_ik(task, x, start=np.repeat(first[None], len(x), axis=0))
            out.append(np.where(found.solved[:, None], found.q, q))
        return out

    def _least_effort(self, task: HandRows, x: np.ndarray, q: np.ndarray) -> float:
        """Give the least effort found at a point (1, 3); NaN where no activation holds the arm."""
        if self.muscles is None or self.finder is None:
            raise RangeError(f"map effort: {self.arm.name} has no muscles")
        starts = np.concatenate(self._starts(task, x, q[None]))
        targets = np.repeat(x, len(starts), axis=0)
        found, value = climb(task, targets, starts, minus_effort(self.muscles, self.finder.effort))
        best = found[np.argmax(value)]
        held = muscle_effort(self.muscles, best, options=self.finder.effort)
        pose = forward_kinematics(self.arm.chain, best, self.arm.tip("hand"))[0]
        natural = self.finder.find(pose)
        known = [float(held.effort[0])] if held.status[0] else []
        known += [natural.effort] if natural.status and np.isfinite(natural.effort) else []
        return min(known, default=float("nan"))


def workspace_maps(
    model: Arm | MusculoskeletalArm,
    maps: Sequence[str] = ("margin", "manipulability"),
    *,
    spacing: float = 0.05,
    blocked: Callable[[np.ndarray], np.ndarray] | None = None,
) -> WorkspaceMaps:
    """Map an arm's workspace over a grid.

    Args:
        model: the arm with the limits that shall hold; with muscles where effort is asked for.
        maps: which of margin, manipulability, effort.
        spacing: of the grid (m).
        blocked: which points do not count, as the body's ``inside``.

    Raises:
        UnknownNameError: there is no such map.
        RangeError: the spacing is not allowed, effort is asked of an arm without muscles, or no
            grid point is reached.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> found = workspace_maps(load_arm("upper_limb"), ["margin"], spacing=0.3)
        >>> bool((found.values["margin"][found.reached] >= 0).all())
        True
    """
    mapper = Mapper.of(model, maps)
    grid = mapper.grid(spacing)
    x = grid.points
    rows = np.arange(len(x)) if blocked is None else np.flatnonzero(~blocked(x))
    return assemble(mapper, grid, [(rows, *mapper.at(x[rows]))])


Part = tuple[np.ndarray, np.ndarray, np.ndarray, Mapping[str, np.ndarray]]


def assemble(mapper: Mapper, grid: Grid, parts: Sequence[Part]) -> WorkspaceMaps:
    """Put parts of a grid together: rows of the points, reached, postures, values.

    Raises:
        RangeError: no grid point is reached.
    """
    n_points = int(np.prod(grid.shape))
    reached = np.zeros(n_points, dtype=np.bool_)
    q = np.full((n_points, mapper.arm.n_joints), np.nan)
    values = {name: np.full(n_points, np.nan) for name in mapper.maps}
    for rows, here, postures, found in parts:
        reached[rows], q[rows] = here, postures
        for name in mapper.maps:
            values[name][rows] = found[name]
    if not reached.any():
        raise RangeError(
            f"no point of the grid is reached by {mapper.arm.name}: spacing {grid.spacing:g} m is "
            "too wide, or the limits or the body leave nothing"
        )
    return WorkspaceMaps(
        mapper.arm,
        grid,
        freeze(reached),
        MappingProxyType({name: freeze(value) for name, value in values.items()}),
        freeze(q),
        Provenance(
            "workspace_maps",
            inputs={"limits": hash_arrays(mapper.arm.lower, mapper.arm.upper)},
            choices={
                "arm": mapper.arm.name,
                "maps": list(mapper.maps),
                "spacing": grid.spacing,
                **({} if mapper.muscles is None else {"convention": mapper.muscles.convention}),
            },
        ),
    )


def manipulability_of(arm: Arm) -> Callable[[np.ndarray], np.ndarray]:
    """Give the function of postures (K, n) that gives sqrt(det(J Jᵀ)) of the hand's position.

    Axes along which no joint moves the hand, as the third of a planar arm, do not count.
    """
    tip = arm.tip("hand")
    some = geometric_jacobian(arm.chain, evenly(16, *finite_limits(arm)), tip)[:, :3]
    axes = np.flatnonzero(np.abs(some).max(axis=(0, 2)) > 1e-12)

    def value(q: np.ndarray) -> np.ndarray:
        J = geometric_jacobian(arm.chain, q, tip)[:, axes]
        A = J @ J.mT
        if len(axes) != 3:
            return np.sqrt(np.maximum(np.linalg.det(A), 0.0))
        across = np.cross(A[:, 1], A[:, 2])
        return np.sqrt(np.maximum(np.einsum("ki,ki->k", A[:, 0], across), 0.0))

    return value


def minus_effort(
    model: MusculoskeletalArm, options: EffortOptions
) -> Callable[[np.ndarray], np.ndarray]:
    """Give the function of postures (K, n) that gives minus the effort, less what is missing."""

    def value(q: np.ndarray) -> np.ndarray:
        found = muscle_effort(model, q, options=options)
        return -found.effort - MISSING_EFFORT * np.abs(found.missing).max(axis=1)

    return value
