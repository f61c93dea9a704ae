"""Which clusters see a landmark, and where it is in a movement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.capture.landmarks import Cluster, ClusterPose, Fused, fuse, landmark_covariance

# Joint centre: the clusters on both sides of it.
CENTRES = {
    "shoulder": ("shoulder", "upper_arm"),
    "elbow": ("upper_arm", "forearm"),
    "wrist": ("forearm", "hand"),
}


@dataclass(frozen=True, eq=False)
class View:
    """A landmark as one cluster carries it.

    Attributes:
        cluster: name of the segment.
        local: (3,) its place in the cluster's frame (m).
        covariance: (3, 3) of that place, in the cluster's axes (m²).
    """

    cluster: str
    local: Float[np.ndarray, "3"]
    covariance: Float[np.ndarray, "3 3"]

    @classmethod
    def of(cls, cluster: Cluster, local: np.ndarray, noise: float, soft_tissue: float) -> "View":
        """Build a view with the covariance of :func:`landmark_covariance`."""
        covariance = landmark_covariance(cluster, local, noise=noise, soft_tissue=soft_tissue)
        return cls(cluster.name, local, covariance)


def place_in_cluster(
    path: Float[np.ndarray, "samples 3"], pose: ClusterPose
) -> Float[np.ndarray, "3"]:
    """Give the mean place (m) of a landmark in a cluster's frame, in a static trial.

    Samples count in which both were seen, so that the person may move. Where there are none, the
    landmark's mean place counts, as of a person who keeps still.

    Example:
        >>> still = ClusterPose(np.eye(3)[None], np.zeros((1, 3)), np.zeros(1))
        >>> place_in_cluster(np.array([[0.1, 0.0, 0.2]]), still).tolist()
        [0.1, 0.0, 0.2]
    """
    local = pose.bring_in(path)
    if np.isnan(local).any(axis=1).all():
        local = pose.bring_in(np.tile(np.nanmean(path, axis=0), (len(path), 1)))
    return np.nanmean(local, axis=0)


def see_landmark(views: Sequence[View], poses: Mapping[str, ClusterPose]) -> Fused:
    """Fuse what all clusters say of a landmark, in the axes of the laboratory."""
    paths, covariances = [], []
    for view in views:
        pose = poses[view.cluster]
        paths.append(pose.carry(view.local))
        R = np.where(np.isfinite(pose.rotation), pose.rotation, np.eye(3))
        covariances.append(R @ view.covariance @ R.mT)
    return fuse(paths, covariances)
