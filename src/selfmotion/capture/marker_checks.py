"""What tells that markers are not what they are taken for.

Wrong units, another person's static trial, swapped labels or a wrong up axis leave numbers that
look like angles; the shape of the clusters and the sides of the body tell.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from selfmotion.capture.landmarks import Cluster, ClusterPose
from selfmotion.errors import RangeError

# Markers of a cluster may differ from its shape by this share of its size (root mean square
# distance from its middle). Skin markers stay below a quarter, swapped ones are near one half.
MISFIT = 0.3
# Cosine of the angle between the line from left to right and the frame's right beyond which the
# person faces away from the stated forward.
FACES_AWAY = -0.5
# Lengths between joint centres that people have, infants and giants included (m).
LEAST_LENGTH, LARGEST_LENGTH = 0.02, 0.8


def refuse_other_shape(
    name: str, clusters: Mapping[str, Cluster], poses: Mapping[str, ClusterPose]
) -> None:
    """Refuse markers that do not have the shape of their clusters.

    Args:
        name: of the recording, for the sentence.
        clusters: segment to cluster.
        poses: segment to the cluster's poses in the recording.

    Raises:
        RangeError: a cluster is misfit by more than `MISFIT` of its size (median over samples).

    Example:
        >>> from selfmotion.capture.landmarks import fit_cluster
        >>> from selfmotion.motion.markers import MarkerSet
        >>> plate = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])
        >>> cluster = Cluster("hand", ("a", "b", "c"), plate - plate.mean(axis=0))
        >>> seen = MarkerSet(np.zeros(1), ("a", "b", "c"), 1e-3 * plate[None])
        >>> refuse_other_shape("reach", {"hand": cluster}, {"hand": fit_cluster(cluster, seen)})
        Traceback (most recent call last):
        ...
        selfmotion.errors.RangeError: reach: a, b, c (cluster hand, 66.7 mm) are 66.6 mm off \
their shape at calibration, at most 20 mm are allowed; are units, static trial and labels right?
    """
    for segment, cluster in clusters.items():
        known = poses[segment].residual[np.isfinite(poses[segment].residual)]
        local = cluster.reference - cluster.reference.mean(axis=0)
        size = float(np.sqrt((local**2).sum(axis=1).mean()))
        off = float(np.median(known)) if known.size else 0.0
        if off > MISFIT * size:
            raise RangeError(
                f"{name}: {', '.join(cluster.markers)} (cluster {segment}, {1e3 * size:.3g} mm) "
                f"are {1e3 * off:.3g} mm off their shape at calibration, at most "
                f"{1e3 * MISFIT * size:.3g} mm are allowed; are units, static trial and labels "
                "right?"
            )


def refuse_swapped_sides(
    names: Sequence[str], lateral: Sequence[str], right: Float[np.ndarray, " recordings"]
) -> None:
    """Refuse a person whose left is right, or who faces away from the stated forward.

    Args:
        names: of the recordings.
        lateral: the left and the right marker.
        right: cosine between the line from the left to the right marker and the frame's right.

    Raises:
        RangeError: it is below `FACES_AWAY` in a recording.

    Example:
        >>> refuse_swapped_sides(["reach"], ["LSHO3", "RSHO3"], np.array([-1.0]))
        Traceback (most recent call last):
        ...
        selfmotion.errors.RangeError: reach: LSHO3 is to the right of RSHO3; are the up and \
forward axes and the labels of the sides right?
    """
    for name, cosine in zip(names, right, strict=True):
        if cosine < FACES_AWAY:
            raise RangeError(
                f"{name}: {lateral[0]} is to the right of {lateral[1]}; are the up and forward "
                "axes and the labels of the sides right?"
            )


def refuse_lengths(name: str, lengths: Mapping[str, float]) -> None:
    """Refuse segments that nobody has.

    Raises:
        RangeError: a length is outside `LEAST_LENGTH` to `LARGEST_LENGTH`.

    Example:
        >>> refuse_lengths("P1", {"upper_arm": 290.0})
        Traceback (most recent call last):
        ...
        selfmotion.errors.RangeError: P1: upper_arm is 2.9e+05 mm long; allowed are 20 to 800 mm: \
are the units right?
    """
    for segment, length in lengths.items():
        if not LEAST_LENGTH <= length <= LARGEST_LENGTH:
            raise RangeError(
                f"{name}: {segment} is {1e3 * length:.3g} mm long; allowed are "
                f"{1e3 * LEAST_LENGTH:g} to {1e3 * LARGEST_LENGTH:g} mm: are the units right?"
            )
