"""Map one workspace onto another: teleoperation between people of different reach.

[DeBoon] section 1: a helper and a person whose reach is limited move devices, whose positions are
normalised by their workspaces, so that what lies outside the person's reach comes inside it. The
paper leaves the map open (it cites a nonlinear one); this is the radial one.

Definition: seen from a centre, a point x lies in the direction u at the share s of the way to the
envelope, ``x = c + s r(u) u`` with r the distance of the envelope. Its image has the same u and
s: ``y = c' + s r'(u) u``. The map is continuous, keeps directions from the centre, takes envelope
to envelope and centre to centre, is the identity for equal envelopes, and its inverse is the map
the other way round, exactly. Points outside (s > 1) stay outside by the same share.

The centre is a place at the same distance from both shoulders, in lengths of the arm, and as deep
inside both workspaces as can be; of places that are alike the one in front of the shoulder.

What it does not promise: with ``kind="outermost"`` the envelopes hold hollows, and an image may
fall into one (`fill` says how much of each envelope is reached). With ``kind="unbroken"`` images
are reached, up to what lies between the directions looked at, but workspace behind a hollow counts
as outside.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.methods.reaching.envelope import Envelope, Kind, checked_points, reach_envelope
from selfmotion.methods.reaching.ik_seeds import evenly
from selfmotion.methods.reaching.ik_tasks import HandRows
from selfmotion.methods.reaching.screen import ReachScreen, reach_screen
from selfmotion.provenance import Provenance, hash_arrays

# Points that tell how much of an envelope is reached.
FILL_POINTS = 4096
# Points that the centre is chosen from, and what being in front is worth against depth.
CENTRE_POINTS, IN_FRONT = 4096, 0.05


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
    centres: tuple[ArrayLike, ArrayLike] | None = None,
    kind: Kind = "outermost",
    subdivisions: int = 3,
    threads: int = 1,
) -> WorkspaceMapping:
    """Build the map from the workspace of one arm onto that of another.

    Args:
        source: arm, with its limits, whose hand positions are given.
        target: arm onto whose workspace they go.
        centres: (3,) m of each; left out: see `common_centres`.
        kind: of both envelopes: outermost or unbroken.
        subdivisions: how fine the envelopes are; see `reach_envelope`.
        threads: how many threads share the points.

    Raises:
        RangeError: a workspace is empty, a centre is not inside it, or the grounds of the two
            arms have other axes.

    Example:
        >>> from selfmotion.arms import load_arm
        >>> helper = load_arm("upper_limb")
        >>> person = helper.with_limits({"elbow_flexion": (1.12, 1.99)})
        >>> mapping = workspace_mapping(helper, person, subdivisions=1)
        >>> there = mapping.map_points([[0.2, 0.5, 0.0]])
        >>> bool(abs(mapping.inverse.map_points(there) - [0.2, 0.5, 0.0]).max() < 1e-12)
        True
    """
    middles = common_centres(source, target) if centres is None else centres
    ends = [
        reach_envelope(arm, middle, kind=kind, subdivisions=subdivisions, threads=threads)
        for arm, middle in zip((source, target), middles, strict=True)
    ]
    limits = [a for arm in (source, target) for a in (arm.lower, arm.upper)]
    provenance = Provenance(
        "workspace_mapping",
        inputs={"limits": hash_arrays(*limits)},
        choices={
            "source": source.name,
            "target": target.name,
            "kind": kind,
            "subdivisions": subdivisions,
        },
    )
    return WorkspaceMapping(
        ends[0], ends[1], (_fill(source, ends[0]), _fill(target, ends[1])), provenance
    )


def common_centres(
    source: Arm, target: Arm
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Choose the centre of each workspace (m): deep inside both, and at the same place.

    The same place: from the shoulder, in lengths of the stretched arm. Of places that are as deep
    the one further forward is taken.

    Raises:
        RangeError: no place is inside both, or the grounds of the two arms have other axes.
    """
    for name in ("up", "forward"):
        if not np.allclose(getattr(source, name), getattr(target, name)):
            raise RangeError(
                f"{name} is {getattr(source, name).tolist()} for {source.name} and "
                f"{getattr(target, name).tolist()} for {target.name}: allowed are arms whose "
                "grounds have the same axes"
            )
    screens = [reach_screen(HandRows(a, ("x", "y", "z")), n_points=1024) for a in (source, target)]
    shoulders, spans = zip(*(_shoulder_and_span(a) for a in (source, target)), strict=True)
    points = evenly(CENTRE_POINTS, screens[1].low, screens[1].high)
    places = (points - shoulders[1]) / spans[1]
    depths = [_depth(s, shoulders[i] + spans[i] * places) / spans[i] for i, s in enumerate(screens)]
    depth = np.minimum(*depths)
    if depth.max() <= 0:
        raise RangeError(
            f"no place is reached by both {source.name} and {target.name}, counted from their "
            "shoulders: name the centres"
        )
    worth = np.where(depth > 0, depth + IN_FRONT * places @ target.forward, -np.inf)
    best = places[int(np.argmax(worth))]
    return shoulders[0] + spans[0] * best, shoulders[1] + spans[1] * best


def _shoulder_and_span(arm: Arm) -> tuple[np.ndarray, float]:
    """Give the shoulder at mid-range (m), and the length of the segments beyond it (m)."""
    tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist", "hand")]
    marks = tip_positions(arm.chain, arm.middle()[None], tips)[0]
    return marks[0], float(np.linalg.norm(np.diff(marks, axis=0), axis=1).sum())


def _depth(screen: ReachScreen, points: np.ndarray) -> np.ndarray:
    """Give the distance (m) of points to the nearest of them that is not reached; 0 there."""
    from scipy.spatial import KDTree

    reached = screen.decide(points).reachable
    depth = np.zeros(len(points))
    if reached.any() and not reached.all():
        depth[reached] = KDTree(points[~reached]).query(points[reached])[0]
    box = np.minimum(points - screen.low, screen.high - points).min(axis=1)
    return np.minimum(depth, np.maximum(box, 0.0))


def _fill(arm: Arm, envelope: Envelope) -> float:
    """Give the share of points within an envelope that are reached."""
    screen = reach_screen(HandRows(arm, ("x", "y", "z")), n_points=1024)
    points = evenly(FILL_POINTS, envelope.vertices.min(axis=0), envelope.vertices.max(axis=0))
    inside = points[envelope.gauge(points) <= 1.0]
    return float(screen.decide(inside).reachable.mean()) if len(inside) else 0.0
