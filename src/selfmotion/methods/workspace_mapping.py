"""Map one workspace onto another: teleoperation between people of different reach.

[DeBoon] section 1: a helper and a person whose reach is limited move devices, whose positions are
normalised by their workspaces, so that what lies outside the person's reach comes inside it. The
paper leaves the map open (it cites a nonlinear one); this is the radial one.

Definition: seen from a centre, a point x lies in the direction u at the share s of the way to the
envelope, ``x = c + s r(u) u`` with r the distance of the envelope. Its image has the same u and
s: ``y = c' + s r'(u) u``. The map is continuous, keeps directions from the centre, takes envelope
to envelope and centre to centre, is the identity for equal envelopes, and its inverse is the map
the other way round, exactly. Points outside (s > 1) stay outside by the same share.

What it does not promise: the envelope is that of the outermost points reached (`Envelope`), so an
image may fall into a hollow of the other workspace; `workspace_mapping(...).fill` says how much of
each envelope is reached.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.kinematics.arm import Arm
from selfmotion.methods.reaching.envelope import Envelope, checked_points, reach_envelope
from selfmotion.methods.reaching.ik_seeds import evenly
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import reach_screen
from selfmotion.provenance import Provenance, hash_arrays

# Points that tell how much of an envelope is reached.
FILL_POINTS = 4096


@dataclass(frozen=True, eq=False)
class WorkspaceMapping:
    """A map from one workspace onto another.

    Attributes:
        source: envelope of the workspace that points come from.
        target: envelope of the workspace that they go to.
        fill: share of either envelope that is reached; below 1 there are hollows.
        provenance: version, hashes, choices.
    """

    source: Envelope
    target: Envelope
    fill: tuple[float, float]
    provenance: Provenance

    def map_points(self, points: ArrayLike) -> Float[np.ndarray, "points 3"]:
        """Map points (K, 3) of the source to the target (m).

        Raises:
            ShapeError: the points are not (K, 3).
            NotFiniteError: a point is not finite.
        """
        v = checked_points(points) - self.source.centre
        scale = self.scale(points)
        return self.target.centre + scale[:, None] * v

    def scale(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give the factor (K,) by which the distance from the centre changes at points (K, 3)."""
        v = checked_points(points) - self.source.centre
        here, there = self.source.gauge(points), self.target.gauge(self.target.centre + v)
        return np.divide(here, there, out=np.ones(len(v)), where=there > 0)

    @property
    def inverse(self) -> "WorkspaceMapping":
        """The map the other way round."""
        return WorkspaceMapping(
            self.target, self.source, (self.fill[1], self.fill[0]), self.provenance
        )

    def summary(self) -> str:
        """Say how the two differ."""
        a, b = self.source.volume, self.target.volume
        return (
            f"The envelopes hold {1e3 * a:.0f} and {1e3 * b:.0f} litres, of which "
            f"{100 * self.fill[0]:.0f} % and {100 * self.fill[1]:.0f} % are reached; lengths "
            f"change by the factor {(b / a) ** (1 / 3):.2f} on average."
        )


def workspace_mapping(
    source: Arm,
    target: Arm,
    *,
    centres: tuple[ArrayLike | None, ArrayLike | None] = (None, None),
    subdivisions: int = 3,
    threads: int = 1,
) -> WorkspaceMapping:
    """Build the map from the workspace of one arm onto that of another.

    Args:
        source: arm, with its limits, whose hand positions are given.
        target: arm onto whose workspace they go.
        centres: (3,) m of each; left out: the centroid of what is reached.
        subdivisions: how fine the envelopes are; see `reach_envelope`.
        threads: how many threads share the points.

    Raises:
        RangeError: a workspace is empty, or a centre is not inside it.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> helper = load_arm("upper_limb")
        >>> person = helper.with_limits({"elbow_flexion": (1.12, 1.99)})
        >>> mapping = workspace_mapping(helper, person, subdivisions=1)
        >>> there = mapping.map_points([[0.2, 0.5, 0.0]])
        >>> bool(abs(mapping.inverse.map_points(there) - [0.2, 0.5, 0.0]).max() < 1e-12)
        True
    """
    ends = [
        reach_envelope(arm, centre=centre, subdivisions=subdivisions, threads=threads)
        for arm, centre in zip((source, target), centres, strict=True)
    ]
    limits = [a for arm in (source, target) for a in (arm.lower, arm.upper)]
    provenance = Provenance(
        "workspace_mapping",
        inputs={"limits": hash_arrays(*limits)},
        choices={"source": source.name, "target": target.name, "subdivisions": subdivisions},
    )
    return WorkspaceMapping(
        ends[0], ends[1], (_fill(source, ends[0]), _fill(target, ends[1])), provenance
    )


def _fill(arm: Arm, envelope: Envelope) -> float:
    """Give the share of points within an envelope that are reached."""
    screen = reach_screen(HandRows(arm, ("x", "y", "z")), n_points=1024)
    points = evenly(FILL_POINTS, envelope.vertices.min(axis=0), envelope.vertices.max(axis=0))
    inside = points[envelope.gauge(points) <= 1.0]
    return float(screen.decide(inside).reachable.mean()) if len(inside) else 0.0
