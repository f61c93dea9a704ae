"""Whether a movement can serve to calibrate a person."""

from selfmotion.capture.landmarks import cluster_from_static, fit_cluster
from selfmotion.capture.marker_checks import refuse_other_shape
from selfmotion.capture.person import REST_PART, CaptureOptions, prepare
from selfmotion.capture.protocol import REACHING, Protocol
from selfmotion.capture.trunk import trunk_frame
from selfmotion.motion.markers import MarkerSet


def check_movement(
    static: MarkerSet,
    movement: MarkerSet,
    *,
    side: str = "right",
    protocol: Protocol = REACHING,
) -> None:
    """Refuse a movement that cannot calibrate a person together with the static trial.

    Raises:
        SelfmotionError: a marker lacks, or markers are not what they are taken for.

    Example:
        >>> import numpy as np
        >>> from selfmotion.capture.simulated_markers import simulate_markers
        >>> seen = simulate_markers(rng=np.random.default_rng(1))
        >>> check_movement(seen.static, seen.movements[0])
    """
    names = protocol.for_side(side)
    raw = CaptureOptions(max_gap=0.0, cutoff=None)
    still, moving = prepare(static, names, raw), prepare(movement, names, raw)
    rest = moving.window(0, max(1, moving.n_samples // REST_PART))
    shapes = {
        k: cluster_from_static(k, rest if k == "trunk" else still, v)
        for k, v in names.clusters.items()
    }
    refuse_other_shape(
        moving.name, shapes, {k: fit_cluster(shape, moving) for k, shape in shapes.items()}
    )
    trunk_frame(shapes["trunk"], [rest], names, side)
