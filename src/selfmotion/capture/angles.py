"""Joint angles from markers: a calibrated person's movement, from landmarks to a recording."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.capture.attach import frame_of
from selfmotion.capture.landmarks import Fused, fit_cluster
from selfmotion.capture.marker_checks import refuse_other_shape
from selfmotion.capture.marker_ik import MarkerIk, MarkerIkOptions, solve_marker_ik
from selfmotion.capture.person import Person, ground_from_trunk, prepare
from selfmotion.capture.views import see_landmark
from selfmotion.kinematics.chain import GROUND
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.motion.markers import MarkerSet
from selfmotion.motion.recording import Recording


@dataclass(frozen=True, eq=False)
class ArmMotion:
    """One movement of a calibrated person.

    Attributes:
        recording: joint angles, timed, with the labels of the markers.
        ik: the same angles with the errors of the inverse kinematics.
        landmarks: landmark to its path in the laboratory (right, forward, up; m), with its
            uncertainty and the disagreement between clusters.
        ground: (K, 3) path of the arm's ground frame (trunk, or shoulder) in the laboratory (m).
        trunk: (K, 3, 3) the trunk's axes right, forward, up as columns, for ISB angles.
        swivel: (K,) swivel angle from the landmarks, rad ([Li2022] eq. 4); for a left arm as its
            mirror image, so that positive is outwards on both sides.
    """

    recording: Recording
    ik: MarkerIk
    landmarks: Mapping[str, Fused]
    ground: Float[np.ndarray, "samples 3"]
    trunk: Float[np.ndarray, "samples 3 3"]
    swivel: Float[np.ndarray, " samples"]

    @property
    def hand_speed(self) -> Float[np.ndarray, " samples"]:
        """Speed of the knuckle in the laboratory (m/s)."""
        from selfmotion.motion.filters import differentiate

        velocity = differentiate(self.landmarks["knuckle"].path, self.recording.time)
        return np.linalg.norm(velocity, axis=1)

    def elbow_disagreement(self) -> float:
        """Give the median distance between the two clusters' views of the elbow (m)."""
        return float(np.nanmedian(self.landmarks["elbow"].disagreement))


def angles_from_markers(
    person: Person, markers: MarkerSet, *, options: MarkerIkOptions | None = None
) -> ArmMotion:
    """Find the joint angles of a calibrated person in a movement.

    Args:
        person: from :func:`selfmotion.capture.person.calibrate_person`.
        markers: of one movement, in metres.
        options: of the inverse kinematics; left out: the calibration's postures are tried first.

    Raises:
        UnknownNameError: a marker of a cluster does not exist.
        NotFiniteError: no landmark could be seen in any frame.
        RangeError: the markers do not have the shape of the person's clusters.

    Example:
        >>> from selfmotion.arms import upper_limb_anatomical
        >>> from selfmotion.capture.person import calibrate_person
        >>> from selfmotion.capture.simulated_markers import simulate_markers
        >>> seen = simulate_markers(rng=np.random.default_rng(1))
        >>> person = calibrate_person(upper_limb_anatomical(), seen.static, seen.movements)
        >>> motion = angles_from_markers(person, seen.movements[0])
        >>> motion.recording.joints[5], bool(np.nanmedian(motion.ik.rms) < 0.005)
        ('elbow_flexion', True)
    """
    moving = prepare(markers, person.protocol, person.options)
    poses = {k: fit_cluster(c, moving) for k, c in person.clusters.items()}
    refuse_other_shape(moving.name, person.clusters, poses)
    landmarks = {k: see_landmark(v, poses) for k, v in person.views.items()}
    trunk = poses["trunk"]
    turn = ground_from_trunk(person.arm)
    local = {
        k: (trunk.bring_in(f.path) - person.trunk[:3, 3]) @ person.trunk[:3, :3] @ turn.T
        for k, f in landmarks.items()
    }
    ground = trunk.carry(person.trunk[:3, 3])
    if person.arm.tip("shoulder").joint == GROUND:  # no girdle: the ground goes with the shoulder
        local = {k: v - local["shoulder"] for k, v in local.items()}
        ground = landmarks["shoulder"].path
    targets = np.stack([local[k] for k in person.model.markers], axis=1)
    chosen = options or MarkerIkOptions(starts=_starts(person))
    ik = solve_marker_ik(person.model, targets, options=chosen)
    recording = Recording(
        moving.time,
        q=ik.q,
        joints=person.arm.joints,
        labels=replace(markers.labels, side=person.side),
        frame=frame_of(person.arm),
        source=markers.source,
    )
    axes = trunk.rotation @ person.trunk[:3, :3]
    return ArmMotion(recording, ik, landmarks, ground, axes, swivel_of(person.side, landmarks))


def swivel_of(side: str, landmarks: Mapping[str, Fused]) -> Float[np.ndarray, " samples"]:
    """Give the swivel angle over time from shoulder, elbow and wrist (rad); NaN in gaps."""
    S, E, W = (landmarks[k].path for k in ("shoulder", "elbow", "wrist"))
    seen = np.isfinite(S + E + W).all(axis=1)
    out = np.full(len(S), np.nan)
    if seen.any():
        flip = np.array([1.0 if side == "right" else -1.0, 1.0, 1.0])
        out[seen] = swivel_angle(
            *(P[seen] * flip for P in (S, E, W)), down=np.array([0.0, 0.0, -1.0])
        )
    return out


def _starts(person: Person) -> Float[np.ndarray, "starts coords"]:
    arm = person.arm
    calm = np.clip(np.median(person.calibration.q, axis=0), arm.lower, arm.upper)
    return np.stack([person.calibration.q[0], calm, arm.middle()])
