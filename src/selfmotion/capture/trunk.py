"""The trunk's axes in the frame of its markers, from samples in which nothing moves."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import Transform
from selfmotion.capture.landmarks import Cluster, fit_cluster
from selfmotion.capture.marker_checks import refuse_swapped_sides
from selfmotion.capture.protocol import Protocol
from selfmotion.errors import NotFiniteError, RangeError
from selfmotion.motion.markers import MarkerSet

# Distance between two trunk axes' markers below which they give no direction (m).
LEAST_WIDTH = 0.05


def trunk_frame(
    cluster: Cluster, at_rest: Sequence[MarkerSet], names: Protocol, side: str
) -> Transform:
    """Give the trunk's frame in its cluster's from samples in which nothing moves.

    Up is that of the laboratory; right is the level part of the line through the lateral markers.
    """
    out, forward, up = names.sternoclavicular
    turns, origins, cosines = [], [], []
    for still in at_rest:
        pose = fit_cluster(cluster, still)
        left, right, sternum = (
            still.point(name) for name in (*names.lateral, names.landmarks["sternum"])
        )
        across = (right - left) * [1.0, 1.0, 0.0]
        width = np.linalg.norm(across, axis=1, keepdims=True)
        seen = np.isfinite(width[:, 0] + pose.residual + sternum[:, 0])
        if seen.any() and np.nanmedian(width) < LEAST_WIDTH:
            raise RangeError(
                f"{still.name}: {' and '.join(names.lateral)} are {1e3 * np.nanmedian(width):.0f} "
                f"mm apart, seen from above; at least {1e3 * LEAST_WIDTH:.0f} mm are needed to "
                "tell right from left"
            )
        x = across[seen] / width[seen]
        cosines.append(float(np.median(x[:, 0])) if len(x) else 1.0)
        z = np.tile([0.0, 0.0, 1.0], (len(x), 1))
        axes = np.stack([x, np.cross(z, x), z], axis=2)
        turns.append(pose.rotation[seen].mT @ axes)
        origin = sternum[seen] + axes @ [out if side == "right" else -out, forward, up]
        origins.append(
            np.einsum("kji,kj->ki", pose.rotation[seen], origin - pose.translation[seen])
        )
    if not sum(map(len, origins)):
        raise NotFiniteError(
            f"trunk: {', '.join(cluster.markers)} and {', '.join(names.lateral)} were never seen "
            "together at rest"
        )
    refuse_swapped_sides([m.name for m in at_rest], names.lateral, np.array(cosines))
    T = np.eye(4)
    T[:3, :3] = _mean_rotation(np.concatenate(turns))
    T[:3, 3] = np.concatenate(origins).mean(axis=0)
    return T


def _mean_rotation(rotations: Float[np.ndarray, "samples 3 3"]) -> Float[np.ndarray, "3 3"]:
    U, _, Vt = np.linalg.svd(rotations.mean(axis=0))
    U[:, 2] *= np.linalg.det(U @ Vt)
    return U @ Vt
