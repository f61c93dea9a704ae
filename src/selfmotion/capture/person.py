"""A person ready to be measured: an arm of the right size with markers on it.

A static trial with the bony landmarks and movements of the same person give the clusters, the
functional joint centres, the trunk's frame, the segment lengths and the marker model.

The trunk's axes and the girdle's zero are those of rest, the first moments of the movements: in a
static trial arms are often raised, and the shoulders with them. Without movements the static trial
counts as rest. (Bones of the girdle carry no markers from which an anatomical zero could be taken.)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import Transform
from selfmotion.capture.joint_centres import JointCentre, Prior, functional_centre
from selfmotion.capture.landmarks import Cluster, ClusterPose, cluster_from_static, fit_cluster
from selfmotion.capture.marker_checks import refuse_lengths, refuse_other_shape
from selfmotion.capture.marker_guides import attach_to_bodies, guide_model
from selfmotion.capture.marker_ik import MarkerIk, MarkerModel, solve_marker_ik
from selfmotion.capture.protocol import REACHING, Protocol
from selfmotion.capture.scaling import SEGMENTS, place_shoulder, scale_arm, segment_lengths
from selfmotion.capture.trunk import trunk_frame
from selfmotion.capture.views import CENTRES, View, place_in_cluster, see_landmark
from selfmotion.errors import NotFiniteError, RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND
from selfmotion.kinematics.mirror import mirror
from selfmotion.motion.checks import require_even_steps
from selfmotion.motion.filters import fill_gaps, low_pass
from selfmotion.motion.labels import Frame
from selfmotion.motion.markers import MarkerSet

# Landmarks that lie across a segment, and the clusters that carry what is no joint centre.
ACROSS = ("lateral_epicondyle", "medial_epicondyle", "radial_styloid", "ulnar_styloid")
CARRIED_BY = dict.fromkeys(ACROSS[:2], "upper_arm") | dict.fromkeys(ACROSS[2:], "forearm")
CARRIED_BY |= {"knuckle": "hand"}
# What skin turns about a segment's axis counts less than a joint centre (weight 1).
SKIN_WEIGHT = 0.3
# Standard deviation of a landmark from its cluster's motion against the bone, where no movement
# tells (m).
UNKNOWN_SKIN = 0.01
# Two views of a joint centre differ by about 10 mm, alike over half a second, so that 50 samples
# count as one against the prior (m).
VIEW_NOISE = 0.07
# How often the landmarks are placed on the bodies, and in how many samples of the movements.
PLACEMENTS, PLACEMENT_SAMPLES = 3, 200
# Rest: the first of so many equal parts of a movement.
REST_PART = 20


@dataclass(frozen=True)
class CaptureOptions:
    """How markers are made ready, and what the person's arm may do.

    Attributes:
        max_gap: longest gap that is bridged (s).
        cutoff: of the zero-phase low-pass of all markers (Hz); None: none.
        centres: ``"functional"`` (SCoRE), or ``"landmarks"``: middles between bony landmarks, and
            the place below the acromion that the protocol states.
    """

    max_gap: float = 0.2
    cutoff: float | None = 6.0
    centres: str = "functional"

    def __post_init__(self) -> None:
        """Check the choice of centres."""
        if self.centres not in ("functional", "landmarks"):
            raise RangeError(f"centres = {self.centres!r}: allowed are functional, landmarks")


@dataclass(frozen=True, eq=False)
class Person:
    """One arm of one person, calibrated.

    Attributes:
        side: ``"right"`` or ``"left"``.
        arm: the library's arm at this person's size; a left one is mirrored.
        model: the arm with its markers, for the inverse kinematics.
        clusters: segment to cluster.
        views: landmark to the clusters that see it.
        trunk: the trunk's frame in the trunk cluster's, (4, 4) m: right, forward, up at rest, the
            origin at the sternoclavicular joint of this side.
        centres: joint centre to how it was found; empty with ``centres="landmarks"``.
        lengths: segment to length (m).
        calibration: angles and errors in the samples with which landmarks were placed.
        protocol: filled in for the side.
        options: how markers are made ready.
    """

    side: str
    arm: Arm
    model: MarkerModel
    clusters: Mapping[str, Cluster]
    views: Mapping[str, tuple[View, ...]]
    trunk: Transform
    centres: Mapping[str, JointCentre]
    lengths: Mapping[str, float]
    calibration: MarkerIk
    protocol: Protocol
    options: CaptureOptions = field(default_factory=CaptureOptions)


def calibrate_person(
    arm: Arm,
    static: MarkerSet,
    movements: Sequence[MarkerSet],
    *,
    side: str = "right",
    protocol: Protocol = REACHING,
    options: CaptureOptions | None = None,
) -> Person:
    """Fit an arm to a person from a static trial and movements.

    Args:
        arm: a right arm of the library, as `upper_limb_anatomical` or `srs7`, with the joint
            limits that shall hold.
        static: in which all landmarks were seen.
        movements: of the same person, for the functional centres and the segment lengths.
        side: which arm was recorded; for the left one `arm` is mirrored.
        protocol: which marker is what.
        options: gap filling, filter, kind of joint centres.

    Raises:
        UnknownNameError: a marker or the side does not exist.
        NotFiniteError: a landmark was not seen in the static trial, or too little of a movement.
        RangeError: markers are not what they are taken for (see :mod:`.marker_checks`).

    Example:
        >>> from selfmotion.arms import upper_limb_anatomical
        >>> from selfmotion.capture.simulated_markers import simulate_markers
        >>> seen = simulate_markers(rng=np.random.default_rng(1))
        >>> person = calibrate_person(upper_limb_anatomical(), seen.static, seen.movements)
        >>> round(person.lengths["upper_arm"], 2), round(person.lengths["forearm"], 2)
        (0.29, 0.25)
    """
    chosen = options or CaptureOptions()
    names = protocol.for_side(side)
    still = prepare(static, names, replace(chosen, cutoff=None))
    moving = [prepare(m, names, chosen) for m in movements]
    at_rest = [m.window(0, max(1, m.n_samples // REST_PART)) for m in moving] or [still]
    clusters = {
        k: cluster_from_static(k, at_rest[0] if k == "trunk" else still, v)
        for k, v in names.clusters.items()
    }
    scene = _Scene(
        names,
        clusters,
        still,
        {k: fit_cluster(c, still) for k, c in clusters.items()},
        tuple({k: fit_cluster(c, m) for k, c in clusters.items()} for m in moving),
    )
    for movement, poses in zip(moving, scene.moving, strict=True):
        refuse_other_shape(movement.name, clusters, poses)
    trunk = trunk_frame(clusters["trunk"], at_rest, names, side)
    priors = _priors(scene, trunk)
    centres: dict[str, JointCentre] = {}
    if chosen.centres == "functional" and moving:
        centres = {k: _centre(k, priors[k], scene.moving) for k in CENTRES}
    views = _views(scene, centres, priors)
    lengths = _lengths(views, scene)
    refuse_lengths(still.name, lengths)
    seen = _landmarks_in_trunk(views, scene, trunk)
    own, model, ik = _fit_arm(arm, side, lengths, seen, names.knuckle_radial)
    return Person(side, own, model, clusters, views, trunk, centres, lengths, ik, names, chosen)


@dataclass(frozen=True, eq=False)
class _Scene:
    """All trials of a person, with the clusters fitted to them.

    Attributes:
        names: the protocol, filled in for the side.
        clusters: segment to cluster.
        static: the static trial.
        rest: segment to its poses in the static trial.
        moving: the same for each movement.
    """

    names: Protocol
    clusters: Mapping[str, Cluster]
    static: MarkerSet
    rest: Mapping[str, ClusterPose]
    moving: tuple[Mapping[str, ClusterPose], ...]


def prepare(markers: MarkerSet, protocol: Protocol, options: CaptureOptions) -> MarkerSet:
    """Bridge short gaps, smooth, and turn into the axes right, forward, up.

    Markers that the protocol does not name are left out.
    """
    part = protocol.select(markers).in_frame(Frame())
    positions = part.positions
    if part.n_samples > 1:
        flat = positions.reshape(part.n_samples, -1)
        if np.isnan(flat).any():
            flat, _ = fill_gaps(flat, part.time, max_gap=options.max_gap)
        rate = part.rate
        if options.cutoff is not None and rate is not None:
            require_even_steps(part.name, part.time)
            flat = low_pass(flat, rate, options.cutoff)
        positions = flat.reshape(positions.shape)
    return replace(part, positions=positions)


def _priors(scene: _Scene, trunk: Transform) -> dict[str, Prior]:
    """Say where the joint centres are thought to be from the bony landmarks."""
    names = scene.names
    mark = {k: _static_path(scene.static, v) for k, v in names.landmarks.items()}
    axes = scene.rest["trunk"].rotation @ trunk[:3, :3]
    right, rest = axes[:, :, 0], axes[:, :, 1:]
    out, forward, up = names.shoulder
    across = np.einsum("ki,ki->k", mark["acromion"] - mark["sternum"], right)
    outwards = right * np.sign(np.nanmedian(across))
    thought = {
        "shoulder": mark["acromion"] + out * outwards + rest @ [forward, up],
        "elbow": 0.5 * (mark["lateral_epicondyle"] + mark["medial_epicondyle"]),
        "wrist": 0.5 * (mark["radial_styloid"] + mark["ulnar_styloid"]),
    }
    priors = {}
    for joint, pair in CENTRES.items():
        first, second = (place_in_cluster(thought[joint], scene.rest[k]) for k in pair)
        deviation = names.shoulder_deviation if joint == "shoulder" else names.limb_deviation
        priors[joint] = Prior(first, second, deviation, noise=VIEW_NOISE)
    return priors


def _centre(joint: str, prior: Prior, poses: Sequence[Mapping[str, ClusterPose]]) -> JointCentre:
    upper, lower = CENTRES[joint]
    return functional_centre([p[upper] for p in poses], [p[lower] for p in poses], prior=prior)


def _views(
    scene: _Scene, centres: Mapping[str, JointCentre], priors: Mapping[str, Prior]
) -> dict[str, tuple[View, ...]]:
    """Say which cluster carries which landmark where, and how sure it is."""
    noise = {k: _noise(k, [scene.rest, *scene.moving]) for k in scene.clusters}
    views: dict[str, tuple[View, ...]] = {}
    for joint, pair in CENTRES.items():
        found = centres.get(joint) or priors[joint]
        # Two clusters cannot tell which of them moved against the bones: they share it alike.
        soft = found.residual / np.sqrt(6.0) if isinstance(found, JointCentre) else UNKNOWN_SKIN
        places = (found.proximal, found.distal)
        views[joint] = tuple(
            View.of(scene.clusters[k], np.asarray(place, dtype=np.float64), noise[k], soft)
            for k, place in zip(pair, places, strict=True)
        )
    for landmark, k in CARRIED_BY.items():
        path = _static_path(scene.static, scene.names.landmarks[landmark])
        local = place_in_cluster(path, scene.rest[k])
        views[landmark] = (View.of(scene.clusters[k], local, noise[k], 0.0),)
    return views


def _noise(segment: str, poses: Sequence[Mapping[str, ClusterPose]]) -> float:
    """Give the standard deviation of a marker's coordinate within its cluster (m)."""
    residuals = np.concatenate([p[segment].residual for p in poses])
    known = residuals[np.isfinite(residuals)]
    return max(float(np.sqrt((known**2).mean() / 3.0)), 1e-4) if known.size else 1e-3


def _lengths(views: Mapping[str, tuple[View, ...]], scene: _Scene) -> dict[str, float]:
    """Give the median distances over all movements, or over the static trial without any."""
    marks = ("shoulder", "elbow", "wrist", "knuckle")
    paths = [
        [see_landmark(views[k], pose).path for k in marks] for pose in scene.moving or [scene.rest]
    ]
    points = np.stack([np.concatenate(path) for path in zip(*paths, strict=True)])
    apart = np.linalg.norm(np.diff(points, axis=0), axis=2)
    for segment, distance in zip(SEGMENTS, apart, strict=True):
        if not np.isfinite(distance).any():
            raise NotFiniteError(f"length of {segment}: its ends were never seen together")
    return dict(zip(SEGMENTS, np.nanmedian(apart, axis=1).tolist(), strict=True))


def _landmarks_in_trunk(
    views: Mapping[str, tuple[View, ...]], scene: _Scene, trunk: Transform
) -> list[dict[str, np.ndarray]]:
    """Give the landmarks' paths in the trunk's frame, one entry a trial."""
    return [
        {
            k: (pose["trunk"].bring_in(see_landmark(v, pose).path) - trunk[:3, 3]) @ trunk[:3, :3]
            for k, v in views.items()
        }
        for pose in scene.moving or [scene.rest]
    ]


def _fit_arm(
    arm: Arm,
    side: str,
    lengths: Mapping[str, float],
    seen: Sequence[Mapping[str, np.ndarray]],
    knuckle_radial: float,
) -> tuple[Arm, MarkerModel, MarkerIk]:
    """Scale the arm and fix the landmarks to its bodies where they are on average.

    At first the guides say where they belong; angles found with them place the landmarks on the
    bodies anew, and so on. Joint centres and the knuckle, which sets the wrist's zero, stay.
    """
    has = segment_lengths(arm)
    along = float(np.sqrt(max(lengths["hand"] ** 2 - knuckle_radial**2, 1e-4)))
    sizes = {**lengths, "hand": along}
    own = scale_arm(arm, {k: v for k, v in sizes.items() if has[k] > 0.0})
    if side == "left":
        own = mirror(own)
    turn = ground_from_trunk(own)
    if own.tip("shoulder").joint == GROUND:  # no girdle: the ground goes with the shoulder
        own = place_shoulder(own, np.zeros(3))
        seen = [{k: v - paths["shoulder"] for k, v in paths.items()} for paths in seen]
    else:
        own = place_shoulder(own, turn @ _at_rest([paths["shoulder"] for paths in seen]))
    sample = _sample({k: np.concatenate([paths[k] for paths in seen]) @ turn.T for k in seen[0]})
    model = guide_model(own, side, sample, knuckle_radial)
    for _ in range(PLACEMENTS):
        found = solve_marker_ik(model, np.stack([sample[k] for k in model.markers], axis=1))
        placed = attach_to_bodies(own, found.q, sample)
        tips = {**model.tips, **{k: placed[k] for k in ACROSS}}
        model = MarkerModel(own, tips, {k: SKIN_WEIGHT for k in ACROSS})
    return own, model, solve_marker_ik(model, np.stack([sample[k] for k in model.markers], axis=1))


def _at_rest(paths: Sequence[np.ndarray]) -> np.ndarray:
    first = np.concatenate([path[: max(1, len(path) // REST_PART)] for path in paths])
    found = np.nanmedian(first, axis=0)
    if not np.isfinite(found).all():
        raise NotFiniteError("shoulder: never seen with the trunk at the start of a movement")
    return found


def _sample(paths: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Take samples in which all landmarks are seen, evenly, at most `PLACEMENT_SAMPLES`."""
    whole = np.flatnonzero(np.isfinite(np.stack(list(paths.values()))).all(axis=(0, 2)))
    if not whole.size:
        raise NotFiniteError(f"{', '.join(paths)}: never seen all together")
    step = max(1, -(-len(whole) // PLACEMENT_SAMPLES))
    return {k: path[whole[::step]] for k, path in paths.items()}


def ground_from_trunk(arm: Arm) -> Float[np.ndarray, "3 3"]:
    """Give the rotation from right, forward, up to the axes of the arm's ground frame."""
    return np.stack([np.cross(arm.forward, arm.up), arm.forward, arm.up], axis=1)


def _static_path(static: MarkerSet, name: str) -> Float[np.ndarray, "samples 3"]:
    path = static.point(name)
    if np.isnan(path).all():
        raise NotFiniteError(f"{static.name}: marker {name} was not seen in the static trial")
    return path
