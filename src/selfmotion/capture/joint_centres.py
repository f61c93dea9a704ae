"""Functional joint centres: the point that stays put between two segments that move.

SCoRE, the symmetrical centre of rotation estimation (Ehrig et al. 2006, doi
10.1016/j.jbiomech.2005.10.002): the centre is fixed in both segments, so its places c₁ and c₂ in
their frames solve R₁c₁ + t₁ = R₂c₂ + t₂ in all samples, by least squares. Movements about one axis
leave the centre free along that axis; a prior place, with its standard deviation, holds it there.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.capture.landmarks import ClusterPose
from selfmotion.errors import NotFiniteError, RangeError, ShapeError

# Directions in which the data say less than this part of what they say in the best one.
LOOSE = 0.05


@dataclass(frozen=True, eq=False)
class JointCentre:
    """A joint centre fixed in two segments.

    Attributes:
        proximal: (3,) its place in the proximal cluster's frame (m).
        distal: (3,) in the distal cluster's frame (m).
        residual: root mean square distance between the two views over all samples (m).
        deviation: (3,) standard deviation of the distal place along its principal directions (m),
            largest first: from the residual, as if 0.1 s apart samples were independent.
        condition: ratio of the largest to the smallest singular value of the system.
        n_samples: samples used.
    """

    proximal: Float[np.ndarray, "3"]
    distal: Float[np.ndarray, "3"]
    residual: float
    deviation: Float[np.ndarray, "3"]
    condition: float
    n_samples: int


@dataclass(frozen=True, eq=False)
class Prior:
    """Where a joint centre is thought to be, before the movement is asked.

    Attributes:
        proximal: (3,) its place in the proximal cluster's frame (m).
        distal: (3,) in the distal cluster's frame (m).
        deviation: standard deviation of each coordinate (m).
        noise: standard deviation of the distance between the two views (m): what the prior is
            weighed against, sample by sample.
    """

    proximal: ArrayLike
    distal: ArrayLike
    deviation: float = 0.02
    noise: float = 0.01


def functional_centre(
    proximal: Sequence[ClusterPose], distal: Sequence[ClusterPose], *, prior: Prior | None = None
) -> JointCentre:
    """Find the centre of rotation between two segments (SCoRE).

    Args:
        proximal: poses of the proximal cluster, one of each recording.
        distal: poses of the distal cluster in the same recordings.
        prior: holds the centre where the movements say little; left out: least squares alone.

    Raises:
        ShapeError: not as many recordings of one as of the other, or of other lengths.
        NotFiniteError: fewer than ten samples in which both were seen.
        RangeError: without a prior, movements about fewer than two axes.

    Example:
        >>> from selfmotion.spatial import exp_rotation
        >>> R = exp_rotation(np.random.default_rng(1).normal(size=(50, 3)))
        >>> still = ClusterPose(np.tile(np.eye(3), (50, 1, 1)), np.zeros((50, 3)), np.zeros(50))
        >>> moving = ClusterPose(R, [0.1, 0.2, 0.3] - R @ [0, 0, -0.3], np.zeros(50))
        >>> functional_centre([still], [moving]).proximal.round(6).tolist()
        [0.1, 0.2, 0.3]
    """
    if not proximal or len(proximal) != len(distal):
        raise ShapeError(f"joint centre: {len(proximal)} proximal and {len(distal)} distal poses")
    pairs = [_both_seen(p, d) for p, d in zip(proximal, distal, strict=True)]
    R1, t1, R2, t2 = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    if len(R1) < 10:
        raise NotFiniteError(f"joint centre: {len(R1)} samples with both segments; 10 are needed")
    A = np.concatenate([R1, -R2], axis=2).reshape(-1, 6)
    b = (t2 - t1).reshape(-1)
    sizes = np.linalg.svd(A, compute_uv=False)
    if prior is None and not sizes[-1] > LOOSE / 10.0 * sizes[0]:
        raise RangeError(
            f"joint centre: smallest singular value {sizes[-1] / sizes[0]:.1e} of the largest: "
            "movements about at least two axes, or a prior, are needed"
        )
    normal, right = A.T @ A, A.T @ b
    if prior is not None:
        place = np.concatenate([_place("proximal", prior.proximal), _place("distal", prior.distal)])
        strength = (prior.noise / prior.deviation) ** 2
        normal, right = normal + strength * np.eye(6), right + strength * place
    c = np.linalg.solve(normal, right)
    left = (A @ c - b).reshape(-1, 3)
    residual = float(np.sqrt((left**2).sum(axis=1).mean()))
    covariance = residual**2 / 3.0 * np.linalg.inv(normal) * 10.0
    deviation = np.sqrt(np.linalg.eigvalsh(covariance[3:, 3:])[::-1])
    return JointCentre(
        c[:3], c[3:], residual, deviation, float(sizes[0] / max(sizes[-1], 1e-300)), len(R1)
    )


def _both_seen(first: ClusterPose, second: ClusterPose) -> tuple[np.ndarray, ...]:
    if len(first.translation) != len(second.translation):
        raise ShapeError(
            f"joint centre: poses of {len(first.translation)} and {len(second.translation)} samples"
        )
    seen = ~(np.isnan(first.translation).any(axis=1) | np.isnan(second.translation).any(axis=1))
    return (
        first.rotation[seen],
        first.translation[seen],
        *(
            second.rotation[seen],
            second.translation[seen],
        ),
    )


def _place(name: str, value: ArrayLike) -> np.ndarray:
    place = as_float_array(name, value, ndim=1)
    require_shape(name, place, (3,))
    return place
