"""What maps over a workspace are: values on a regular grid."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import freeze, require_between
from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

UNITS = MappingProxyType({"margin": "share of half range", "manipulability": "m³", "effort": "1"})
# Grids beyond this are a slip in the spacing.
MOST_POINTS = 2_000_000


@dataclass(frozen=True, eq=False)
class Grid:
    """A regular grid, its x running fastest as in VTK.

    Attributes:
        origin: (3,) first point (m).
        spacing: distance between neighbours (m).
        shape: numbers of points along x, y and z.
    """

    origin: Float[np.ndarray, "3"]
    spacing: float
    shape: tuple[int, int, int]

    @property
    def points(self) -> Float[np.ndarray, "points 3"]:
        """All points (m)."""
        z, y, x = np.meshgrid(*(np.arange(n) for n in self.shape[::-1]), indexing="ij")
        return self.origin + self.spacing * np.stack([x, y, z], axis=-1).reshape(-1, 3)

    def axis(self, i: int) -> Float[np.ndarray, " along"]:
        """Give the coordinates along an axis (m)."""
        return self.origin[i] + self.spacing * np.arange(self.shape[i])

    def volume(self, values: np.ndarray) -> np.ndarray:
        """Give values (K,) of the points as an array (x, y, z)."""
        return values.reshape(self.shape[::-1]).transpose(2, 1, 0)

    @classmethod
    def around(cls, low: np.ndarray, high: np.ndarray, spacing: float) -> "Grid":
        """Give the grid on multiples of the spacing that holds a box.

        Raises:
            RangeError: the spacing is not positive, or makes more than `MOST_POINTS` points.
        """
        require_between("spacing", spacing, 1e-4, 1.0)
        first, last = np.floor(low / spacing), np.ceil(high / spacing)
        counts = (last - first + 1).astype(int)
        if np.prod(counts.astype(float)) > MOST_POINTS:
            raise RangeError(
                f"spacing = {spacing:g} m: {' x '.join(map(str, counts))} points; allowed are "
                f"{MOST_POINTS} at most"
            )
        return cls(
            freeze(spacing * first), spacing, (int(counts[0]), int(counts[1]), int(counts[2]))
        )


@dataclass(frozen=True, eq=False)
class WorkspaceMaps:
    """Maps over a grid.

    Attributes:
        arm: whose they are.
        grid: where.
        reached: (K,) which points are reached.
        values: map to (K,); NaN where the point is not reached, or nothing holds the arm there.
        q: (K, n) postures of the largest margin, or reached ones where margin was not asked for.
        provenance: version, hashes, choices.
    """

    arm: Arm
    grid: Grid
    reached: Bool[np.ndarray, " points"]
    values: Mapping[str, Float[np.ndarray, " points"]]
    q: Float[np.ndarray, "points coords"]
    provenance: Provenance

    def to_frame(self) -> "pd.DataFrame":
        """Give a table of the points reached: x, y, z (m), the maps, the posture (rad or m)."""
        import pandas as pd

        rows = self.reached
        columns: dict[str, np.ndarray] = dict(
            zip(("x", "y", "z"), self.grid.points[rows].T, strict=True)
        )
        columns |= {name: value[rows] for name, value in self.values.items()}
        columns |= dict(zip(self.arm.joints, self.q[rows].T, strict=True))
        return pd.DataFrame(columns)

    def to_xarray(self) -> "xr.Dataset":
        """Give the maps as arrays over x, y and z (m); its ``to_zarr`` writes Zarr."""
        import xarray as xr

        axes = ("x", "y", "z")
        fields = {"reached": self.reached, **self.values}
        return xr.Dataset(
            {
                k: (axes, self.grid.volume(v), {"units": UNITS.get(k, "1")})
                for k, v in fields.items()
            },
            coords={name: self.grid.axis(i) for i, name in enumerate(axes)},
        )

    def summary(self) -> str:
        """Say how much is reached and where each map is best."""
        litres = 1e3 * self.grid.spacing**3 * int(self.reached.sum())
        text = [f"{int(self.reached.sum())} of {len(self.reached)} grid points are reached"]
        text[0] += f" ({litres:.0f} litres by counting cells)"
        points = self.grid.points
        for name, value in self.values.items():
            if np.isfinite(value).any():
                best = int(np.nanargmin(value) if name == "effort" else np.nanargmax(value))
                x = " ".join(f"{1e3 * c:.0f}" for c in points[best])
                text.append(
                    f"{name}: median {np.nanmedian(value):.3g}, best {value[best]:.3g} at {x} mm"
                )
        return "; ".join(text) + "."
