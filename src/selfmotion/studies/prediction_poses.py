"""From a recorded moment to what predictors see: hand pose, natural angle, feasible postures.

As in [Li2022] section IV-B the arm with muscles is scaled to the person and fitted to the recorded
landmarks; its hand pose is the one that is predicted for, and swivel angles turn about its
shoulder centre in the fitted posture. The natural angle itself comes from the landmarks. Stated
choices:

- the model's upright stands for the laboratory's, its forward for the trunk's, level; left arms
  are seen in the mirror;
- the hand is fitted by wrist, styloids and knuckle; what the model's wrist cannot do within its
  limits is taken up by one offset of deviation and one of flexion for each person, the least that
  brings all of that person's postures inside (FIT_MARGIN), since nobody marked the wrist's zero;
- the mouth carries no marker: it is assumed at `MOUTH` from the sternoclavicular joint.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from selfmotion.arms.person_with_muscles import PersonSize, myoarm_of_person
from selfmotion.capture.marker_guides import guide_model
from selfmotion.capture.marker_ik import MarkerIkOptions, MarkerModel, solve_marker_ik
from selfmotion.capture.person import ground_from_trunk
from selfmotion.capture.scaling import ADULT_RANGES_DEG
from selfmotion.errors import unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import Tip
from selfmotion.kinematics.forward import body_frames, forward_kinematics, tip_positions
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.spatial import transform
from selfmotion.studies.people import MovementOfPerson, RecordedPerson

# From the sternoclavicular joint: outwards, forward, up (m). A guess from body measures: the
# midline, and the height of the mouth above the notch of the sternum.
MOUTH = (-0.02, 0.08, 0.16)
# How far inside the limits the wrist's offsets bring natural postures (rad).
FIT_MARGIN = np.deg2rad(1.0)
# Weights of the fit: the swivel angle rests on elbow and wrist.
WEIGHTS = {"elbow": 30.0, "wrist": 30.0, "knuckle": 1.0, "radial_styloid": 0.3}
WEIGHTS |= {"ulnar_styloid": 0.3}
# The shoulder moves with the girdle, which follows the posture: the fit is repeated.
FITS = 4

LIMITS = ("adult", "model", "wide")
_ADULT = {
    "elbow_flexion": (0.0, ADULT_RANGES_DEG["elbow_flexion"][1]),
    "deviation": ADULT_RANGES_DEG["wrist_deviation"],
    "flexion": ADULT_RANGES_DEG["wrist_flexion"],
}
_WIDE = {
    "elv_angle": (-150.0, 150.0),
    "shoulder_rot": (-150.0, 150.0),
    "elbow_flexion": (0.0, 160.0),
    "pro_sup": (-120.0, 120.0),
    "deviation": (-70.0, 70.0),
    "flexion": (-100.0, 100.0),
}
_RANGES: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {"adult": _ADULT, "model": {}, "wide": _WIDE}
)


@dataclass(frozen=True, eq=False)
class Moment:
    """One moment of one movement, in axes right, forward, up from the shoulder; left mirrored.

    Attributes:
        task: the movement's condition.
        moment: its name; "start" is one.
        trial: the repetition.
        points: landmarks and the mouth, (3,) each (m).
    """

    task: str
    moment: str
    trial: str
    points: Mapping[str, Float[np.ndarray, "3"]]

    def natural(self) -> float:
        """Give the swivel angle from the landmarks (rad), [Li2022] eq. 4."""
        E, W = self.points["elbow"], self.points["wrist"]
        return float(swivel_angle(np.zeros(3), E[None], W[None], down=[0.0, 0.0, -1.0])[0])

    def elbow_radius(self) -> float:
        """Give the elbow's distance from the line through shoulder and wrist (m)."""
        E, W = self.points["elbow"], self.points["wrist"]
        return float(np.linalg.norm(np.cross(E, W)) / np.linalg.norm(W))

    def with_shoulder(self, shift: Sequence[float]) -> "Moment":
        """Give the same with the shoulder centre elsewhere: outwards, forward, up (m)."""
        move = np.array(shift, dtype=np.float64)
        return replace(self, points={k: v - move for k, v in self.points.items()})


@dataclass(frozen=True, eq=False)
class FittedPerson:
    """The model arm at a person's size, fitted to all moments.

    Attributes:
        model: with the limits that hold.
        q: (K, 7) fitted postures, wrist offsets included (rad).
        shoulder: (K, 3) the model's shoulder centre in them (m).
        offset: (2,) what was added to deviation and flexion (rad).
        error: (K,) root mean square distance of elbow and wrist from where they were seen (m).
    """

    model: MusculoskeletalArm
    q: Float[np.ndarray, "samples 7"]
    shoulder: Float[np.ndarray, "samples 3"]
    offset: Float[np.ndarray, "2"]
    error: Float[np.ndarray, " samples"]

    def hand_poses(self) -> Float[np.ndarray, "samples 4 4"]:
        """Give the hand poses in the model's ground (m)."""
        arm = self.model.arm
        return forward_kinematics(arm.chain, self.q, arm.tip("hand"))

    def inside(self) -> np.ndarray:
        """Tell which postures the limits allow, (K,)."""
        arm = self.model.arm
        within = (self.q >= arm.lower - 1e-6) & (self.q <= arm.upper + 1e-6)
        return np.asarray(within.all(axis=1))


def moments_of_person(person: RecordedPerson) -> tuple[list[Moment], list[tuple[str, str]]]:
    """Take the moments out of a person's movements, with (where, why) of those not to be had."""
    found: list[Moment] = []
    lost: list[tuple[str, str]] = []
    for movement in person.movements:
        name = movement.motion.recording.source or str(movement.labels)
        lost += [(f"{name}, {moment}", why) for moment, why in movement.missing.items()]
        wanted = [m for m in movement.moments if m != "end"]
        if wanted == ["start"]:
            continue
        for moment in wanted:
            points = _points(person, movement, movement.moments[moment])
            if not np.isfinite(np.stack(list(points.values()))).all():
                lost.append((f"{name}, {moment}", "a landmark was not seen"))
                continue
            labels = movement.labels
            found.append(Moment(str(labels.condition), moment, str(labels.trial or name), points))
    return found, lost


def _points(
    person: RecordedPerson, movement: MovementOfPerson, sample: int
) -> dict[str, np.ndarray]:
    motion = movement.motion
    trunk = motion.trunk[sample]
    out = 1.0 if person.side == "right" else -1.0
    places = {k: f.path[sample] for k, f in motion.landmarks.items()}
    places["mouth"] = motion.ground[sample] + trunk @ (np.array(MOUTH) * [out, 1.0, 1.0])
    forward = trunk[:, 1] * [1.0, 1.0, 0.0]
    forward = forward / np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0])
    axes = np.stack([out * np.cross(forward, up), forward, up])
    return {k: axes @ (place - places["shoulder"]) for k, place in places.items()}


def fit_person(
    moments: Sequence[Moment], *, knuckle_radial: float = 0.0, limits: str = "adult"
) -> FittedPerson:
    """Scale the arm with muscles to a person and fit it to the landmarks of all moments.

    Args:
        moments: of one arm of one person, starts among them.
        knuckle_radial: how far the knuckle's marker lies to the thumb's side of the hand (m).
        limits: adult: wrist and elbow as adults have them (Boone & Azen 1979), the rest the
            model's; model: the model's; wide: hardly any.

    Raises:
        UnknownNameError: there are no such limits.
        RangeError: a segment's length is not one that an arm may have.
    """
    if limits not in LIMITS:
        raise unknown_name("limits", limits, LIMITS)
    marks = ("shoulder", "elbow", "wrist", "knuckle")
    seen = np.stack([[m.points[k] for k in marks] for m in moments])
    lengths = np.median(np.linalg.norm(np.diff(seen, axis=1), axis=2), axis=0)
    hand = float(np.sqrt(max(lengths[2] ** 2 - knuckle_radial**2, 1e-4)))
    size = {"upper_arm": float(lengths[0]), "forearm": float(lengths[1]), "hand": hand}
    model = myoarm_of_person(PersonSize(size))
    free = model.arm.with_limits(_radians("wide"))
    markers = _markers(free, moments, knuckle_radial)
    q, shoulder, error = _fit(free, markers, moments)
    arm = model.arm.with_limits(_radians(limits))
    offset = np.array([_offset(q[:, i], arm.lower[i], arm.upper[i]) for i in (5, 6)])
    q[:, 5:] += offset
    return FittedPerson(replace(model, arm=arm), q, shoulder, offset, error)


def _radians(limits: str) -> dict[str, tuple[float, float]]:
    return {k: (np.deg2rad(v[0]), np.deg2rad(v[1])) for k, v in _RANGES[limits].items()}


def _markers(arm: Arm, moments: Sequence[Moment], knuckle_radial: float) -> MarkerModel:
    """Put elbow, wrist, styloids and knuckle on the arm."""
    names = ("lateral_epicondyle", "medial_epicondyle", "radial_styloid", "ulnar_styloid")
    seen = {k: np.stack([m.points[k] for m in moments]) for k in names}
    guides = guide_model(arm, "right", seen).tips
    # At zero the arm hangs with the thumb forward.
    hand = arm.tip("hand").joint
    zero = np.zeros(7)
    knuckle = tip_positions(arm.chain, zero, [arm.tip("middle_knuckle")])[0, 0]
    frame = body_frames(arm.chain, zero)[0, hand]
    local = frame[:3, :3].T @ (knuckle + knuckle_radial * arm.forward - frame[:3, 3])
    tips = {k: guides[k] for k in WEIGHTS if k != "knuckle"}
    tips["knuckle"] = Tip(hand, transform(None, local))
    return MarkerModel(arm, tips, WEIGHTS)


def _fit(
    arm: Arm, markers: MarkerModel, moments: Sequence[Moment]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    turn = ground_from_trunk(arm)
    seen = np.stack([[turn @ m.points[k] for k in markers.markers] for m in moments])
    raised = np.zeros(7)
    raised[1] = np.pi / 4
    shoulder = np.repeat(tip_positions(arm.chain, raised, [arm.tip("shoulder")])[0], len(seen), 0)
    q = np.empty((len(seen), 7))
    error = np.empty(len(seen))
    options = MarkerIkOptions(pull=1e-9)
    for _ in range(FITS):
        for i in range(len(seen)):
            found = solve_marker_ik(markers, seen[i : i + 1] + shoulder[i], options=options)
            q[i] = found.q[0]
            joints = [found.markers.index(k) for k in ("elbow", "wrist")]
            error[i] = np.sqrt((found.error[0, joints] ** 2).mean())
        shoulder = tip_positions(arm.chain, q, [arm.tip("shoulder")])[:, 0]
    return q, shoulder, error


def _offset(values: np.ndarray, lower: float, upper: float) -> float:
    """Give the least constant that brings values inside; if they span too much, to the middle."""
    low, high = float(values.min()) - FIT_MARGIN, float(values.max()) + FIT_MARGIN
    if high - low > upper - lower:
        return 0.5 * (lower + upper) - 0.5 * (low + high)
    return max(lower - low, 0.0) + min(upper - high, 0.0)
