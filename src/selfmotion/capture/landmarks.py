"""Virtual landmarks: points of the skeleton carried by rigid clusters of markers.

A landmark that was marked in a static trial only is held in the frame of each cluster that sees
it; in a movement each cluster says where it is, and what they say is fused by their uncertainty,
as in section 4.1 of [DeBoon]: with independent normal errors the most probable point is the
mean weighted by the inverse covariances (Bayes).

The covariance has two parts: marker noise, which grows with the landmark's distance from the
cluster through the error of the fitted rotation, and soft tissue, which moves a cluster as a whole
and cannot be seen in it; its standard deviation is stated by the protocol.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.motion.markers import MarkerSet

# Markers needed for a rotation, and the second singular value (relative) of markers on one line.
LEAST_MARKERS = 3
ON_ONE_LINE = 1e-3


@dataclass(frozen=True, eq=False)
class Cluster:
    """Markers fixed to each other.

    Attributes:
        name: of the segment that carries them.
        markers: their names (M).
        reference: (M, 3) their places in the cluster's frame, whose origin is their mean (m).
    """

    name: str
    markers: tuple[str, ...]
    reference: Float[np.ndarray, "markers 3"]


@dataclass(frozen=True, eq=False)
class ClusterPose:
    """Where a cluster is in each sample; NaN where too few of its markers were seen.

    Attributes:
        rotation: (K, 3, 3) from the cluster's frame to the laboratory's.
        translation: (K, 3) its origin (m).
        residual: (K,) root mean square distance of the markers from the fitted cluster (m).
    """

    rotation: Float[np.ndarray, "samples 3 3"]
    translation: Float[np.ndarray, "samples 3"]
    residual: Float[np.ndarray, " samples"]

    def carry(self, point: ArrayLike) -> Float[np.ndarray, "samples 3"]:
        """Give the path (K, 3) of a point (3,) of the cluster's frame (m)."""
        return self.rotation @ np.asarray(point, dtype=np.float64) + self.translation

    def bring_in(self, path: Float[np.ndarray, "samples 3"]) -> Float[np.ndarray, "samples 3"]:
        """Give a path (K, 3) of the laboratory in the cluster's frame (m)."""
        return np.einsum("kji,kj->ki", self.rotation, path - self.translation)


def cluster_from_static(name: str, static: MarkerSet, markers: Sequence[str]) -> Cluster:
    """Take a cluster's shape from the static trial: the mean place of each marker.

    Raises:
        UnknownNameError: a marker does not exist.
        NotFiniteError: a marker was not seen in the static trial.
        ShapeError: fewer than three markers, or all on one line.
    """
    part = static.select(markers)
    whole = ~part.missing().any(axis=1)
    if not whole.any():
        lost = ", ".join(np.array(part.names)[part.missing().any(axis=0)])
        raise NotFiniteError(f"{static.name}: {lost} of cluster {name} not seen with the others")
    shape = part.positions[whole]
    mean = shape[0] - shape[0].mean(axis=0)
    for _ in range(2):  # the mean shape, apart from how the person swayed
        pose = fit_cluster(Cluster(name, part.names, mean), part.window(0, part.n_samples))
        local = np.stack([pose.bring_in(part.positions[:, i]) for i in range(part.n_markers)], 1)
        mean = np.nanmean(local[whole], axis=0)
    return Cluster(name, part.names, mean - mean.mean(axis=0))


def fit_cluster(cluster: Cluster, markers: MarkerSet) -> ClusterPose:
    """Fit a cluster to the markers seen in each sample: least squares over rotations.

    Raises:
        UnknownNameError: a marker of the cluster does not exist.
        ShapeError: the cluster has fewer than three markers, or they are on one line.

    Example:
        >>> corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])
        >>> turned = corners @ np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).T + [1, 2, 3]
        >>> seen = MarkerSet(np.zeros(1), ("a", "b", "c"), turned[None])
        >>> fit_cluster(Cluster("plate", ("a", "b", "c"), corners), seen).carry([0.2, 0, 0])
        array([[1. , 2.2, 3. ]])
    """
    columns = [markers.index(name) for name in cluster.markers]
    reference = as_float_array("reference", cluster.reference, ndim=2)
    require_shape("reference", reference, (len(columns), 3))
    _check_shape(cluster.name, reference)
    seen = markers.positions[:, columns]
    weight = (~np.isnan(seen[..., 0])).astype(np.float64)
    known = np.where(weight[..., None] > 0.0, seen, 0.0)
    count = weight.sum(axis=1)
    enough = count >= LEAST_MARKERS
    share = weight / np.maximum(count, 1.0)[:, None]
    centre_ref = share @ reference
    centre = np.einsum("km,kmi->ki", share, known)
    apart_ref = (reference[None] - centre_ref[:, None]) * weight[..., None]
    apart = (known - centre[:, None]) * weight[..., None]
    R = _nearest_rotation(np.einsum("kmi,kmj->kij", apart, apart_ref))
    t = centre - np.einsum("kij,kj->ki", R, centre_ref)
    left = apart - apart_ref @ R.mT
    residual = np.sqrt((left**2).sum(axis=(1, 2)) / np.maximum(count, 1.0))
    R, t = R.copy(), t.copy()
    R[~enough], t[~enough], residual[~enough] = np.nan, np.nan, np.nan
    return ClusterPose(R, t, residual)


def landmark_covariance(
    cluster: Cluster, point: ArrayLike, *, noise: float, soft_tissue: float = 0.0
) -> Float[np.ndarray, "3 3"]:
    """Give the covariance of a landmark as a cluster sees it, in the cluster's frame (m²).

    Args:
        cluster: that carries the landmark.
        point: (3,) the landmark in its frame (m).
        noise: standard deviation of a marker's coordinate within the cluster (m).
        soft_tissue: standard deviation of each coordinate from the cluster's motion against the
            bone (m).

    Example:
        >>> square = np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]) * 0.05
        >>> plate = Cluster("plate", ("a", "b", "c", "d"), square)
        >>> near = landmark_covariance(plate, [0, 0, 0], noise=1e-3)
        >>> far = landmark_covariance(plate, [0, 0, 0.3], noise=1e-3)
        >>> [round(float(1e3 * np.sqrt(C[0, 0])), 2) for C in (near, far)]
        [0.5, 3.04]
    """
    if not (noise >= 0.0 and soft_tissue >= 0.0):
        raise RangeError(f"noise = {noise:g}, soft_tissue = {soft_tissue:g} m: neither may be < 0")
    local = cluster.reference - cluster.reference.mean(axis=0)
    d = as_float_array("point", point, ndim=1) - cluster.reference.mean(axis=0)
    spread = (local**2).sum() * np.eye(3) - local.T @ local
    lever = np.array([[0.0, d[2], -d[1]], [-d[2], 0.0, d[0]], [d[1], -d[0], 0.0]])
    turned = lever @ np.linalg.solve(spread, lever.T)
    return noise**2 * (np.eye(3) / len(local) + turned) + soft_tissue**2 * np.eye(3)


@dataclass(frozen=True, eq=False)
class Fused:
    """One landmark as several clusters see it together.

    Attributes:
        path: (K, 3) the most probable place (m); NaN where no cluster sees it.
        deviation: (K,) its standard deviation, root mean square over the axes (m).
        disagreement: (K,) largest distance between two clusters' views (m); NaN with one.
    """

    path: Float[np.ndarray, "samples 3"]
    deviation: Float[np.ndarray, " samples"]
    disagreement: Float[np.ndarray, " samples"]


def fuse(paths: Sequence[ArrayLike], covariances: Sequence[np.ndarray]) -> Fused:
    """Fuse what several clusters say of one landmark.

    Args:
        paths: of each cluster, (K, 3) m; NaN where it does not see the landmark.
        covariances: of each, (3, 3) or (K, 3, 3), m², in the axes of the paths.

    Raises:
        ShapeError: nothing to fuse, or sizes that do not agree.

    Example:
        >>> near, far = np.zeros((1, 3)), np.array([[0.01, 0, 0]])
        >>> both = fuse([near, far], [np.eye(3) * 1e-6, np.eye(3) * 4e-6])
        >>> (1e3 * both.path[0]).round(6).tolist(), float(both.disagreement[0])
        ([2.0, 0.0, 0.0], 0.01)
    """
    if not paths or len(paths) != len(covariances):
        raise ShapeError(f"fuse: {len(paths)} paths and {len(covariances)} covariances")
    views = np.stack([as_float_array("path", path, ndim=2) for path in paths])
    precision = np.stack(
        [np.broadcast_to(np.linalg.inv(C), (views.shape[1], 3, 3)) for C in covariances]
    )
    seen = np.asarray(~np.isnan(views).any(axis=2))
    known = np.where(seen[..., None], views, 0.0)
    weight = np.where(seen[..., None, None], precision, 0.0)
    weight = np.nan_to_num(weight)
    total = weight.sum(axis=0)
    any_seen = np.asarray(seen.any(axis=0))
    total[~any_seen] = np.eye(3)
    right = np.einsum("ckij,ckj->ki", weight, known)
    path = np.linalg.solve(total, right[..., None])[..., 0]
    covariance = np.linalg.inv(total)
    deviation = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 3.0)
    path[~any_seen], deviation[~any_seen] = np.nan, np.nan
    return Fused(path, deviation, _disagreement(views, seen))


def _disagreement(views: np.ndarray, seen: np.ndarray) -> np.ndarray:
    largest = np.full(views.shape[1], np.nan)
    for i in range(len(views)):
        for j in range(i):
            both = seen[i] & seen[j]
            distance = np.linalg.norm(views[i] - views[j], axis=1)
            largest[both] = np.fmax(largest[both], distance[both])
    return largest


def _check_shape(name: str, reference: np.ndarray) -> None:
    if len(reference) < LEAST_MARKERS:
        raise ShapeError(f"cluster {name}: {len(reference)} markers; at least 3 are needed")
    sizes = np.linalg.svd(reference - reference.mean(axis=0), compute_uv=False)
    if not sizes[1] > ON_ONE_LINE * sizes[0]:
        raise ShapeError(f"cluster {name}: its markers are on one line, which has no rotation")


def _nearest_rotation(H: Float[np.ndarray, "samples 3 3"]) -> Float[np.ndarray, "samples 3 3"]:
    """Give the rotations R that maximise trace(RᵀH) (Kabsch)."""
    U, _, Vt = np.linalg.svd(H)
    U[..., 2] *= np.linalg.det(U @ Vt)[:, None]
    return U @ Vt
