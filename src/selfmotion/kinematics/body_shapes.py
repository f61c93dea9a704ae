"""Head, trunk and thighs as simple shapes that the arm may not enter.

They cut out of a workspace what lies inside the person (``workspace(..., blocked=body.inside)``,
[DeBoon] figs 8 and 9) and keep postures out of thorax and head (``clearance``; the excluded set of
[Li2022] eqs 1 and 3). Neither paper gives sizes. Heights and the width of the hips are shares of
the stature H after Drillis and Contini (1966), Body segment parameters, as drawn in Winter's
Biomechanics and Motor Control of Human Movement, fig. 4.1. All depths, the breadth of chest and
head, radii and offsets are estimates of round numbers for an adult, marked so below, and meant to
be edited.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_between, require_shape
from selfmotion.errors import UnknownNameError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_frame import SHOULDER, BodyFrame
from selfmotion.kinematics.chain import Tip
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.solid_shapes import Capsule, Ellipsoid, Shape

Posture = Literal["seated", "standing"]
POSTURES: tuple[Posture, ...] = ("seated", "standing")
# Shapes that the arm is kept out of where none are named.
AGAINST = ("thorax", "neck", "head")
# Heights as shares of the stature (Drillis and Contini).
HIP, KNEE, CHIN = 0.530, 0.285, 0.870
HIP_BREADTH = 0.191
# Estimates, shares of the stature: breadth (between the hanging arms) and depth of the chest, and
# heights of its top and bottom.
CHEST_BREADTH, CHEST_DEPTH, CHEST_TOP, CHEST_BOTTOM = 0.150, 0.145, 0.855, 0.545
# Estimates: head breadth and length, how far it is before the shoulders, radius of the neck.
HEAD_BREADTH, HEAD_LENGTH, HEAD_FORWARD, NECK = 0.088, 0.113, 0.015, 0.034
# Estimates: pelvis depth and half height, hip centre beside the middle, radius of the thigh.
PELVIS_DEPTH, PELVIS_HALF_HEIGHT, HIP_ASIDE, THIGH = 0.130, 0.070, 0.050, 0.045
# Places along a segment that are looked at, and again between the neighbours of the nearest.
PLACES = 17


@dataclass(frozen=True)
class SegmentRadii:
    """How thick the arm is where it meets the body (m); estimates.

    They are below half the girth, as skin and muscle give way on both sides: an arm that hangs
    down touches the chest and must stay allowed.

    Attributes:
        upper_arm: radius of the upper arm.
        forearm: radius of the forearm.
        hand: half the thickness of the hand.
        skipped: share of the upper arm, from the shoulder on, that is not looked at.

    Raises:
        RangeError: a number is not allowed.
    """

    upper_arm: float = 0.020
    forearm: float = 0.030
    hand: float = 0.015
    skipped: float = 0.25

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("upper_arm", "forearm", "hand"):
            require_between(name, getattr(self, name), 0.0, 0.5)
        require_between("skipped", self.skipped, 0.0, 0.95)


@dataclass(frozen=True, eq=False)
class BodyShapes:
    """Named shapes in an arm's ground frame, together one body.

    Attributes:
        shapes: name to shape.
    """

    shapes: Mapping[str, Shape]

    def __post_init__(self) -> None:
        """Make the mapping read-only."""
        object.__setattr__(self, "shapes", MappingProxyType(dict(self.shapes)))

    @classmethod
    def of(
        cls, arm: Arm, posture: Posture = "seated", *, stature: float | None = None
    ) -> "BodyShapes":
        """Build an adult's body around an arm.

        The middle plane is that of the ground's origin, as for `mirror`; where the shoulder lies
        in it, the arm counts as a right one and the middle is put at its left.

        Args:
            arm: whose shoulder, taken at the posture of zeros, and directions place the body.
            posture: seated (thighs forward) or standing (thighs down).
            stature: m; left out: from the arm's lengths, or 1.75 m where it has none.

        Raises:
            UnknownNameError: there is no such posture.
            RangeError: stature outside 0.5 to 2.5 m.

        Example:
            >>> from selfmotion.arms import load_arm
            >>> body = BodyShapes.of(load_arm("upper_limb"))
            >>> list(body.shapes)
            ['head', 'neck', 'thorax', 'pelvis', 'right thigh', 'left thigh']
            >>> body.inside([[0.0, 0.0, -0.2], [0.0, 0.5, 0.0]])
            array([ True, False])
        """
        if posture not in POSTURES:
            raise unknown_name("posture of the body", posture, POSTURES)
        return cls(_adult(BodyFrame.of(arm, stature), posture == "seated"))

    def distance(self, points: ArrayLike) -> Float[np.ndarray, " points"]:
        """Give the signed distance (m) of points (K, 3) to the nearest shape.

        Exact outside; inside, where shapes overlap, the point may be deeper than said.
        """
        array = as_float_array("points", points, ndim=2)
        require_shape("points", array, (None, 3))
        out = np.full(len(array), np.inf)
        for shape in self.shapes.values():
            np.minimum(out, shape.distance(array), out=out)
        return out

    def inside(self, points: ArrayLike) -> Bool[np.ndarray, " points"]:
        """Tell which points (K, 3) are inside a shape, as `workspace` wants it for `blocked`."""
        return self.distance(points) < 0

    def with_shape(self, name: str, shape: Shape) -> "BodyShapes":
        """Give the same body with a shape added, or put in the place of one of that name."""
        return BodyShapes({**self.shapes, name: shape})

    def without(self, *names: str) -> "BodyShapes":
        """Give the same body without some shapes.

        Raises:
            UnknownNameError: there is no such shape.
        """
        for name in names:
            if name not in self.shapes:
                raise self._unknown(name)
        return BodyShapes({key: s for key, s in self.shapes.items() if key not in names})

    def clearance(
        self,
        arm: Arm,
        *,
        against: Sequence[str] | None = None,
        radii: SegmentRadii | None = None,
    ) -> Callable[[Float[np.ndarray, "samples coords"]], Float[np.ndarray, " samples"]]:
        """Give a function of postures (K, n): how far the arm is outside the body (K,) (m).

        Upper arm (but for its part at the shoulder), forearm and hand are capsules. Along a
        segment the distance to a convex shape is convex, so its least value is looked for between
        the neighbours of the nearest of some places: at the default body it is over by less than
        0.02 mm outside and down to 2 cm inside (0.3 mm deeper), and by less than half the finer
        spacing (segment / 256) at any.

        Args:
            arm: in whose ground the body was placed.
            against: names of shapes; left out: thorax, neck and head, as far as there are.
            radii: of the segments.

        Raises:
            UnknownNameError: a shape that is named does not exist.

        Example:
            >>> from selfmotion.arms import load_arm
            >>> arm = load_arm("upper_limb_anatomical")
            >>> clear = BodyShapes.of(arm).clearance(arm)
            >>> bool(clear(np.clip(np.zeros((1, 9)), arm.lower, arm.upper))[0] > 0)
            True
        """
        names = [name for name in AGAINST if name in self.shapes] if against is None else against
        for name in names:
            if name not in self.shapes:
                raise self._unknown(name)
        shapes = [self.shapes[name] for name in names]
        chosen = SegmentRadii() if radii is None else radii
        tips = _segment_tips(arm)

        def clear(q: Float[np.ndarray, "samples coords"]) -> Float[np.ndarray, " samples"]:
            points = tip_positions(arm.chain, q, tips)
            out = np.full(len(points), np.inf)
            spans = (
                (0, chosen.skipped, chosen.upper_arm),
                (1, 0.0, chosen.forearm),
                (2, 0.0, chosen.hand),
            )
            for i, skipped, radius in spans:
                a, b = points[:, i], points[:, i + 1]
                for shape in shapes:
                    near = segment_distance(shape, a + skipped * (b - a), b)
                    np.minimum(out, near - radius, out=out)
            return out

        return clear

    def _unknown(self, name: str) -> UnknownNameError:
        return unknown_name("shape of the body", name, tuple(self.shapes))


def segment_distance(
    shape: Shape, start: Float[np.ndarray, "samples 3"], end: Float[np.ndarray, "samples 3"]
) -> Float[np.ndarray, " samples"]:
    """Give the least signed distance (m) of segments to a convex shape; see `clearance`."""
    low, high = np.zeros(len(start)), np.ones(len(start))
    least = np.full(len(start), np.inf)
    for _ in range(2):
        share = low + (high - low) * np.linspace(0.0, 1.0, PLACES)[:, None]
        places = start + share[:, :, None] * (end - start)
        found = shape.distance(places.reshape(-1, 3)).reshape(PLACES, -1)
        nearest = found.argmin(axis=0)
        column = np.arange(len(start))
        np.minimum(least, found[nearest, column], out=least)
        low = share[np.maximum(nearest - 1, 0), column]
        high = share[np.minimum(nearest + 1, PLACES - 1), column]
    return least


def _at(frame: BodyFrame, right: float, forward: float, height: float) -> np.ndarray:
    """Give a place (m) by shares of the stature; heights as of someone who stands."""
    return frame.middle + frame.stature * frame.axes @ [right, forward, height - SHOULDER]


def _ellipsoid(
    frame: BodyFrame, forward: float, breadth: float, depth: float, heights: tuple[float, float]
) -> Ellipsoid:
    """Give an ellipsoid in the middle plane, by shares of the stature."""
    low, high = heights
    half = 0.5 * frame.stature * np.array([breadth, depth, high - low])
    return Ellipsoid(_at(frame, 0.0, forward, 0.5 * (low + high)), half, frame.axes)


def _adult(frame: BodyFrame, seated: bool) -> dict[str, Shape]:
    """Give the shapes of an adult: thighs forward where seated, down where standing."""
    pelvis = (HIP - PELVIS_HALF_HEIGHT, HIP + PELVIS_HALF_HEIGHT)
    shapes: dict[str, Shape] = {
        "head": _ellipsoid(frame, HEAD_FORWARD, HEAD_BREADTH, HEAD_LENGTH, (CHIN, 1.0)),
        "neck": Capsule(
            _at(frame, 0.0, 0.0, SHOULDER),
            _at(frame, 0.0, HEAD_FORWARD, CHIN),
            NECK * frame.stature,
        ),
        "thorax": _ellipsoid(frame, 0.0, CHEST_BREADTH, CHEST_DEPTH, (CHEST_BOTTOM, CHEST_TOP)),
        "pelvis": _ellipsoid(frame, 0.0, HIP_BREADTH, PELVIS_DEPTH, pelvis),
    }
    thigh = HIP - KNEE
    knee = (thigh, HIP) if seated else (0.0, KNEE)
    for name, aside in (("right thigh", HIP_ASIDE), ("left thigh", -HIP_ASIDE)):
        shapes[name] = Capsule(
            _at(frame, aside, 0.0, HIP), _at(frame, aside, *knee), THIGH * frame.stature
        )
    return shapes


def _segment_tips(arm: Arm) -> list[Tip]:
    """Give shoulder, elbow, wrist and the farthest known landmark of the hand."""
    last = "middle_knuckle" if "middle_knuckle" in arm.landmarks else "hand"
    return [arm.tip(name) for name in ("shoulder", "elbow", "wrist", last)]
