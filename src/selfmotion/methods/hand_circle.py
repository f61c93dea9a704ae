"""A device that leads the hand round a circle: which arcs are feasible, and the joints along them.

[DeBoon] scenarios 2 and 3: the palm on a circle in the sagittal or coronal plane, its roll held.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import require_finite
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.methods.constrained_path import Arc, PathCosts, device_circle
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.feasible_arcs import feasible_arcs
from selfmotion.methods.reaching.held_rows import (
    POSITION,
    checked_rows,
    describe,
    held_options,
    held_provenance,
    with_angles,
)
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import reach_options
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class DeviceCircle:
    """A circle on which a device leads the hand.

    Attributes:
        plane: "yz" (sagittal), "xz" (coronal) or "xy".
        centre: m.
        radius: m.

    Raises:
        RangeError: another plane, or a radius that is not positive.
    """

    plane: str
    centre: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        """Check plane, centre and radius."""
        require_finite("centre of the circle", np.array([*self.centre, self.radius]))
        self.points(np.zeros(1))

    def points(self, angles: ArrayLike) -> Float[np.ndarray, "samples 3"]:
        """Give points (m) at angles (rad) from the plane's first axis towards its second."""
        return device_circle(self.centre, self.radius, self.plane, angles)


@dataclass(frozen=True, eq=False)
class CircleReach:
    """Which arcs of a circle the hand can follow.

    Attributes:
        arm: with the limits that hold.
        circle: the circle.
        held: orientation rows held (rad).
        arcs: feasible arcs, with joint trajectories along them.
        provenance: version, hashes, choices.
    """

    arm: Arm
    circle: DeviceCircle
    held: Mapping[str, float]
    arcs: tuple[Arc, ...]
    provenance: Provenance

    @property
    def share(self) -> float:
        """Share of the circle that is feasible."""
        return float(sum(arc.last - arc.first for arc in self.arcs) / (2 * np.pi))

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row an arc: its ends (degrees), length (m), whether it is followed."""
        import pandas as pd

        rows = [
            {
                "from_deg": np.rad2deg(arc.first),
                "to_deg": np.rad2deg(arc.last),
                "length_m": self.circle.radius * (arc.last - arc.first),
                "without_jump": arc.path.status.ok,
                "followed": arc.path.status.sentence,
            }
            for arc in self.arcs
        ]
        columns = ["from_deg", "to_deg", "length_m", "without_jump", "followed"]
        return pd.DataFrame(rows, columns=pd.Index(columns))

    def trajectories(self) -> "pd.DataFrame":
        """Give the joints along all arcs: arc, angle on the circle (rad), x, y, z (m), joints."""
        import pandas as pd

        parts = []
        for number, arc in enumerate(self.arcs):
            frame = pd.DataFrame(arc.path.q, columns=pd.Index(self.arm.joints))
            points = self.circle.points(arc.path.time)
            for place, name in enumerate(POSITION):
                frame.insert(place, name, points[:, place])
            frame.insert(0, "angle", arc.path.time)
            frame.insert(0, "arc", number)
            parts.append(frame.assign(error_mm=1e3 * arc.path.error, met=arc.path.met))
        return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()

    def summary(self) -> str:
        """Say how much of the circle is feasible, and whether it is followed."""
        jumps = sum(not arc.path.status.ok for arc in self.arcs)
        text = (
            f"{100 * self.share:.0f} % of the circle of radius {1e3 * self.circle.radius:.0f} mm "
            f"in {len(self.arcs)} {'arc' if len(self.arcs) == 1 else 'arcs'}"
        )
        if jumps:
            return f"{text}; for {jumps} no way without a jump of a joint was found."
        return f"{text}, followed without a jump."


def circle_reach(
    arm: Arm,
    circle: DeviceCircle,
    held: Mapping[str, float] | None = None,
    *,
    n_samples: int = 120,
    costs: PathCosts | None = None,
) -> CircleReach:
    """Find the arcs of a circle that the hand can follow, with its orientation held.

    Args:
        arm: with the limits that hold.
        circle: of the device.
        held: rot_x, rot_y, rot_z (rad) to their values; left out: the orientation is free.
        n_samples: angles tried.
        costs: what the joints pay along the way.

    Raises:
        UnknownNameError: there is no such row.
        RangeError: a position is held as well, or no part of the circle is feasible: the message
            says which constraint leaves nothing.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> circle = DeviceCircle("yz", (0.15, 0.36, -0.16), 0.27)
        >>> found = circle_reach(load_arm("upper_limb"), circle, {"rot_y": 0.0}, n_samples=16)
        >>> 0.0 < found.share <= 1.0
        True
    """
    values = checked_rows(held) if held else {}
    for row in values:
        if row in POSITION:
            raise RangeError(f"{row} is held, and a circle too: the circle holds x, y and z")
    arcs = _arcs(arm, circle, values, n_samples, costs)
    if not arcs:
        raise RangeError(_why_no_arc(arm, circle, values, n_samples))
    provenance = held_provenance("circle_reach", arm, values)
    provenance.choices["circle"] = [circle.plane, *circle.centre, circle.radius]
    return CircleReach(arm, circle, MappingProxyType(values), arcs, provenance)


def _arcs(
    arm: Arm,
    circle: DeviceCircle,
    held: Mapping[str, float],
    n_samples: int,
    costs: PathCosts | None = None,
) -> tuple[Arc, ...]:
    task = HandRows(arm, (*POSITION, *held))

    def path(angles: np.ndarray) -> np.ndarray:
        return with_angles(circle.points(angles), held)

    return feasible_arcs(task, path, n_samples=n_samples, costs=costs)


def _why_no_arc(arm: Arm, circle: DeviceCircle, held: Mapping[str, float], n_samples: int) -> str:
    """Say which constraint leaves nothing of a circle."""
    place = ", ".join(f"{1e3 * value:g}" for value in circle.centre)
    text = f"no part of the circle of {1e3 * circle.radius:g} mm about {place} mm is feasible"
    points = circle.points(np.arange(n_samples) * (2 * np.pi / n_samples))
    found = solve_ik(HandRows(arm, POSITION), points, options=reach_options())
    if not found.solved.any():
        short = 1e3 * float(found.position_error.min())
        return f"{text}: all of it is out of reach, the nearest point by {short:.0f} mm"
    for row in held:
        fewer = {name: value for name, value in held.items() if name != row}
        task = HandRows(arm, (*POSITION, *fewer))
        if solve_ik(task, with_angles(points, fewer), options=held_options(1)).solved.any():
            return f"{text} with {describe({row: held[row]})}; without it some is"
    return f"{text} with {describe(held)}; the place alone is in reach"
