"""Marker-based inverse kinematics: the joint angles that bring an arm's markers to those seen.

Weighted least squares over the markers of each frame, inside the joint limits (Lu & O'Connor 1999,
doi 10.1016/S0021-9290(98)00158-4), solved by Levenberg-Marquardt with held limits and started from
the frame before. A small pull towards that frame decides what the markers seen do not.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.typing import ArrayLike

from selfmotion.arrays import JointSamples, as_float_array, freeze, require_shape
from selfmotion.capture import marker_kernels as kernels
from selfmotion.errors import NotFiniteError, RangeError, ShapeError, Status
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Coupling, Tip
from selfmotion.kinematics.forward import tip_positions
from selfmotion.motion.checks import refuse_infinite

# Postures tried where none is known.
N_STARTS = 32
# Closer to a limit than this counts as at it (rad).
AT_LIMIT = 1e-9


@dataclass(frozen=True, eq=False)
class MarkerModel:
    """An arm with markers on its bodies.

    Attributes:
        arm: whose ground frame the markers seen are expressed in.
        tips: marker name to its place on a body of the arm.
        weights: marker name to weight, 1 where not named; errors count by weight times distance².
    """

    arm: Arm
    tips: Mapping[str, Tip]
    weights: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the weights."""
        if not self.tips:
            raise ShapeError("marker model: 0 markers; at least one is needed")
        for name, weight in self.weights.items():
            if name not in self.tips or not 0.0 <= weight < np.inf:
                raise RangeError(
                    f"weight of marker {name!r} = {weight:g}: allowed is 0 and above, for one of "
                    f"{', '.join(self.tips)}"
                )
        object.__setattr__(self, "tips", MappingProxyType(dict(self.tips)))
        object.__setattr__(self, "weights", MappingProxyType(dict(self.weights)))

    @property
    def markers(self) -> tuple[str, ...]:
        """Names of the markers, in the order of the targets."""
        return tuple(self.tips)

    def positions(self, q: ArrayLike) -> Float[np.ndarray, "samples markers 3"]:
        """Give the markers' places (K, M, 3) for postures q (m)."""
        return tip_positions(self.arm.chain, q, list(self.tips.values()))


@dataclass(frozen=True, eq=False)
class MarkerIkOptions:
    """What rarely needs changing.

    Attributes:
        tolerance: step at which a frame is solved (rad).
        max_iterations: for one frame and start; few are used but where limits and errors fight.
        pull: towards the posture of the frame before, m² per rad², beside weights of 1: 1e-6
            counts a radian like a millimetre.
        starts: postures (S, n) tried in the first frame; left out: 32 spread over the ranges.
        retry: all starts are tried again in a frame whose weighted rms error is above this (m).
    """

    tolerance: float = 1e-7
    max_iterations: int = 1000
    pull: float = 1e-7
    retry: float = 0.05
    starts: ArrayLike | None = None

    def __post_init__(self) -> None:
        """Check the numbers."""
        above = self.tolerance > 0.0 and self.retry > 0.0
        if not (above and self.max_iterations >= 1 and self.pull >= 0.0):
            raise RangeError(
                f"tolerance = {self.tolerance:g}, max_iterations = {self.max_iterations}, pull = "
                f"{self.pull:g}, retry = {self.retry:g}: allowed are above 0, 1 and above, 0 and "
                "above, above 0"
            )


@dataclass(frozen=True, eq=False)
class MarkerIk:
    """Joint angles of each frame, and how far the markers stay from where they were seen.

    Attributes:
        joints: names (n).
        q: (K, n) rad; NaN where no marker was seen.
        markers: names (M).
        error: (K, M) distance of each marker (m); NaN where it was not seen.
        iterations: (K,).
        converged: (K,) whether the last step was below the tolerance.
        at_limit: (K, n) whether a joint ended at its limit.
        status: whether all frames converged.
    """

    joints: tuple[str, ...]
    q: JointSamples
    markers: tuple[str, ...]
    error: Float[np.ndarray, "samples markers"]
    iterations: Int[np.ndarray, " samples"]
    converged: Bool[np.ndarray, " samples"]
    at_limit: Bool[np.ndarray, "samples joints"]
    status: Status

    @property
    def rms(self) -> Float[np.ndarray, " samples"]:
        """Root mean square distance of the markers seen, in each frame (m)."""
        seen = np.isfinite(self.error)
        total = np.where(seen, self.error**2, 0.0).sum(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.sqrt(total / seen.sum(axis=1))


def solve_marker_ik(
    model: MarkerModel, targets: ArrayLike, *, options: MarkerIkOptions | None = None
) -> MarkerIk:
    """Find the joint angles that bring the model's markers closest to those seen.

    Args:
        model: the arm and its M markers.
        targets: (K, M, 3) places seen in the arm's ground frame (m); NaN where not seen.
        options: see :class:`MarkerIkOptions`.

    Returns:
        Angles inside the joint limits, errors, and a status.

    Raises:
        ShapeError: the targets do not fit the model's markers.
        NotFiniteError: no marker was seen in any frame, or an infinite place.

    Example:
        >>> from selfmotion.arms import planar
        >>> arm = planar([0.3, 0.25])
        >>> model = MarkerModel(arm, {name: arm.tip(name) for name in ("wrist", "hand")})
        >>> q = np.array([[0.3, 0.9], [0.4, 1.0]])
        >>> bool(np.allclose(solve_marker_ik(model, model.positions(q)).q, q, atol=1e-5))
        True
    """
    chosen = options or MarkerIkOptions()
    seen = as_float_array("targets", targets, ndim=3)
    require_shape("targets", seen, (None, len(model.tips), 3))
    refuse_infinite("targets", seen)
    if not np.isfinite(seen).any():
        raise NotFiniteError(f"targets: none of {', '.join(model.markers)} was seen in any frame")
    seen = np.where(np.isnan(seen).any(axis=2, keepdims=True), np.nan, seen)
    arm = model.arm
    K, n = len(seen), arm.n_joints
    q, error = np.full((K, n), np.nan), np.full((K, len(model.tips)), np.nan)
    iterations, converged = np.zeros(K, np.int64), np.zeros(K, np.bool_)
    numbers = kernels.SolverNumbers(
        chosen.tolerance, chosen.max_iterations, chosen.pull, chosen.retry
    )
    kernels.solve_frames(
        marker_arrays(model), seen, _starts(arm, chosen), numbers, q, error, iterations, converged
    )
    at_limit = (q <= arm.lower + AT_LIMIT) | (q >= arm.upper - AT_LIMIT)
    return MarkerIk(
        arm.joints, q, model.markers, error, iterations, converged, at_limit, _status(q, converged)
    )


def marker_arrays(model: MarkerModel) -> kernels.MarkerArrays:
    """Turn a model into the plain arrays of the kernels."""
    chain = model.arm.chain
    z = chain.z_frames
    body = np.array([tip.joint for tip in model.tips.values()], dtype=np.int64)
    local = np.empty((len(body), 3))
    for m, tip in enumerate(model.tips.values()):
        point = tip.transform[:3, 3]
        local[m] = point if tip.joint == GROUND else z.to_body[tip.joint] @ point
    above = np.zeros((len(z.parent),) * 2, dtype=np.bool_)
    for i, parent in enumerate(z.parent):
        above[i] = above[parent] if parent != GROUND else False
        above[i, i] = True
    coupling = chain.coupling
    return kernels.MarkerArrays(
        z.parent,
        z.joint_type,
        z.rotations,
        z.translations,
        # Read-only in every arm: the kernels are compiled anew for each mixture.
        freeze(np.array(coupling.matrix, order="C")),
        freeze(np.array(coupling.offset)),
        chain.lower,
        chain.upper,
        body,
        local,
        np.array([float(model.weights.get(name, 1.0)) for name in model.tips]),
        above,
        *curve_arrays(coupling),
    )


def curve_arrays(coupling: Coupling) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Give the curves that joints follow as arrays: curve (N), lead, breaks, coefficients."""
    curves = coupling.curves
    order = max((c.curve.c.shape[0] for c in curves), default=1)
    longest = max((len(c.curve.x) for c in curves), default=2)
    count = max(len(curves), 1)
    which = np.full(len(coupling.matrix), -1, dtype=np.int64)
    lead = np.zeros(count, dtype=np.int64)
    breaks = np.full((count, longest), np.inf)
    coefficients = np.zeros((count, order, longest - 1))
    for i, c in enumerate(curves):
        k, pieces = c.curve.c.shape
        which[c.joint], lead[i] = i, c.coordinate
        breaks[i, : len(c.curve.x)] = c.curve.x
        coefficients[i, order - k :, :pieces] = c.curve.c
    return which, lead, breaks, coefficients


def _starts(arm: Arm, options: MarkerIkOptions) -> Float[np.ndarray, "starts coords"]:
    if options.starts is not None:
        starts = np.atleast_2d(as_float_array("starts", options.starts))
        require_shape("starts", starts, (None, arm.n_joints))
        return np.ascontiguousarray(np.clip(starts, arm.lower, arm.upper))
    if not np.isfinite(arm.lower + arm.upper).all():
        raise RangeError(f"arm {arm.name}: a joint has no limits, so starts must be given")
    # Multiples of irrational numbers: spread over the box, the same each time.
    k = np.arange(1, N_STARTS)[:, None] * _square_roots_of_primes(arm.n_joints) % 1.0
    spread = arm.lower + k * (arm.upper - arm.lower)
    return np.concatenate([arm.middle()[None], spread])


def _square_roots_of_primes(count: int) -> np.ndarray:
    primes = [p for p in range(2, 1000) if all(p % d for d in range(2, int(p**0.5) + 1))]
    return np.sqrt(np.array(primes[:count], dtype=np.float64))


def _status(q: np.ndarray, converged: np.ndarray) -> Status:
    unseen = np.isnan(q[:, 0])
    lost = int((~converged & ~unseen).sum())
    gaps = f"; {int(unseen.sum())} without markers" if unseen.any() else ""
    if lost:
        return Status(False, f"{lost} of {len(q)} frames did not converge{gaps}")
    return Status(True, f"{len(q) - int(unseen.sum())} frames solved{gaps}")
