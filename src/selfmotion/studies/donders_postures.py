"""Postures of recorded people, as Donders' law sees them: shoulder, forearm and wrist.

Each movement gives postures equally spaced in time from its first to its last motion, and one for
each moment that the study file names. Stated choices: the orientations are those of the fitted arm
(`upper_limb_anatomical` at the person's size), the thorax is its ground; for the law the arm is cut
at the wrist centre and the girdle is held at its median, so that four joints remain (three of the
shoulder, the elbow) for the three coordinates of the wrist, and one freedom: the swivel angle.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.errors import NotFiniteError, RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import body_frames, tip_positions
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.methods.passive.held_joints import hold_joints
from selfmotion.motion.strokes import movement_span
from selfmotion.redundancy.task import Position
from selfmotion.spatial import unit
from selfmotion.studies.people import MovementOfPerson, RecordedPerson

# Postures of one movement: neighbours at 100 Hz tell little more.
N_SAMPLES = 15
SEGMENTS = ("shoulder", "forearm", "wrist")
# Joints of the law; all others are held.
LAW_JOINTS = ("shoulder_flexion", "shoulder_adduction", "shoulder_rotation", "elbow_flexion")
NEEDED = (*LAW_JOINTS, "wrist_pronation", "wrist_flexion")
ON_PATH = ""


@dataclass(frozen=True, eq=False)
class PersonPostures:
    """Postures of one arm of one person.

    Attributes:
        subject: name.
        side: right or left.
        arm: from shoulder to wrist, at the person's size, four joints.
        q: (K, 4) its postures (rad).
        rotations: segment to its orientations (K, 3, 3): upper arm in the thorax (shoulder),
            forearm in the thorax, hand in the forearm before pronation (wrist).
        axes: segment to its long axis in its own frame.
        condition: (K,) task.
        trial: (K,) repeat.
        phase: (K,) number of the sample in its movement, -1 for moments.
        moment: (K,) name; "" for samples on the path.
    """

    subject: str
    side: str
    arm: Arm
    q: Float[np.ndarray, "samples joints"]
    rotations: Mapping[str, Float[np.ndarray, "samples 3 3"]]
    axes: Mapping[str, Float[np.ndarray, "3"]]
    condition: np.ndarray
    trial: np.ndarray
    phase: np.ndarray
    moment: np.ndarray

    @property
    def task(self) -> Position:
        """The task of the law: the place of the wrist centre."""
        return Position(self.arm, "wrist")

    @property
    def on_path(self) -> Bool[np.ndarray, " samples"]:
        """Which postures are on the path (the others are moments)."""
        return self.moment == ON_PATH

    @property
    def movement(self) -> np.ndarray:
        """Name of each posture's movement, (K,)."""
        return np.array([f"{c} {t}" for c, t in zip(self.condition, self.trial, strict=True)])

    def points(self, q: Float[np.ndarray, "samples joints"]) -> Float[np.ndarray, "samples 3 3"]:
        """Give shoulder, elbow and wrist (m) of postures."""
        arm = self.arm
        return tip_positions(arm.chain, q, [arm.tip(k) for k in ("shoulder", "elbow", "wrist")])

    def swivel(self, q: Float[np.ndarray, "samples joints"]) -> Float[np.ndarray, " samples"]:
        """Give the swivel angle of postures (rad) about the shoulder, as the thorax sees it."""
        S, E, W = np.swapaxes(self.points(q), 0, 1)
        return swivel_angle(S, E, W, down=-self.arm.up)


def postures_of(person: RecordedPerson, *, n_samples: int = N_SAMPLES) -> PersonPostures:
    """Take the postures out of a person's movements.

    Raises:
        RangeError: the arm is not `upper_limb_anatomical`, or there are fewer than two movements.
        NotFiniteError: no posture could be seen.
    """
    arm = person.person.arm
    for joint in NEEDED:
        if joint not in arm.joints:
            raise RangeError(f"arm {arm.name!r}: no joint {joint!r}; take upper_limb_anatomical")
    if len(person.movements) < 2:
        raise RangeError(
            f"{person.subject}: {len(person.movements)} movement(s); at least 2 needed"
        )
    q, labels = [], []
    for movement in person.movements:
        for sample, phase, moment in _wanted(movement, n_samples):
            posture = movement.motion.recording.array("q")[sample]
            if np.isfinite(posture).all():
                q.append(posture)
                given = movement.labels
                labels.append((str(given.condition), str(given.trial), phase, moment))
    if not q:
        raise NotFiniteError(f"{person.subject}: no posture was seen in any movement")
    whole = np.array(q)
    condition, trial, phase, moment = (np.array(column) for column in zip(*labels, strict=True))
    rotations, axes = _segments(arm, whole)
    shown = [arm.joints.index(joint) for joint in LAW_JOINTS]
    return PersonPostures(
        person.subject,
        person.side,
        law_arm(arm, whole),
        np.ascontiguousarray(whole[:, shown]),
        rotations,
        axes,
        condition,
        trial,
        phase,
        moment,
    )


def law_arm(arm: Arm, q: Float[np.ndarray, "samples joints"]) -> Arm:
    """Give the arm from shoulder to wrist: all but the law's joints held at their median."""
    middle = np.median(q, axis=0)
    held = {j: float(m) for j, m in zip(arm.joints, middle, strict=True) if j not in LAW_JOINTS}
    return hold_joints(arm, held)


def _wanted(movement: MovementOfPerson, n_samples: int) -> list[tuple[int, int, str]]:
    """List sample, phase and moment of the postures of a movement."""
    first, last = movement_span(movement.motion.hand_speed)
    spaced = np.linspace(first, last, n_samples).round().astype(int)
    path = [(int(sample), phase, ON_PATH) for phase, sample in enumerate(spaced)]
    named = [(s, -1, name) for name, s in movement.moments.items() if name not in ("start", "end")]
    return path + named


def _segments(arm: Arm, q: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Give orientations and long axes of the segments."""
    chain = arm.chain
    frames = body_frames(chain, q)[:, :, :3, :3]
    upper, ulna, radius = (
        chain.names.index(n) for n in ("shoulder_rotation", "elbow_flexion", "wrist_pronation")
    )
    hand = arm.tip("hand")
    rotations = {
        "shoulder": frames[:, upper],
        "forearm": frames[:, radius],
        "wrist": frames[:, ulna].mT @ frames[:, hand.joint],
    }
    axes = {
        "shoulder": chain.axes[upper],
        "forearm": chain.axes[radius],
        "wrist": unit("hand", hand.transform[:3, 3]),
    }
    return {k: np.ascontiguousarray(R) for k, R in rotations.items()}, axes
