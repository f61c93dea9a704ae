"""A recording made ready to be played: lines, and the velocities of task and null space.

The hand's velocity is the task's: J#Jq̇ moves it, Nq̇ does not. What the null space does shows at
the elbow, so its arrow stands there. Beside a recording, λ0-PMP plays the movement that it plans
from the same start to the same end ([Tommasino2017]).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.capture.attach import attach_arm
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import geometric_jacobian
from selfmotion.methods.passive_motion import JointLaw, PlanSettings, plan
from selfmotion.methods.velocity_split import VelocitySplit, split
from selfmotion.motion.recording import Recording
from selfmotion.redundancy.task import task_for
from selfmotion.viewer.scene import landmark_line

# The law of a person about whom nothing is known: the same stiffness at every joint (N m/rad).
PLAIN_STIFFNESS = 1.0


@dataclass(frozen=True, eq=False)
class Playback:
    """A movement as it is drawn.

    Attributes:
        name: of the recording.
        time: (K,) from 0 (s).
        line: (K, 4, 3) shoulder, elbow, wrist, hand (m).
        hand_velocity: (K, 3) of the hand (m/s).
        elbow_null_velocity: (K, 3) of the elbow by the null space alone (m/s).
        task_speed: (K,) norm of J#Jq̇ (rad/s).
        null_speed: (K,) norm of Nq̇ (rad/s).
        parted: the split it comes from.
    """

    name: str
    time: Float[np.ndarray, " samples"]
    line: Float[np.ndarray, "samples 4 3"]
    hand_velocity: Float[np.ndarray, "samples 3"]
    elbow_null_velocity: Float[np.ndarray, "samples 3"]
    task_speed: Float[np.ndarray, " samples"]
    null_speed: Float[np.ndarray, " samples"]
    parted: VelocitySplit


def make_playback(
    recording: Recording, arm: Arm, *, weights: Float[np.ndarray, " coords"] | None = None
) -> Playback:
    """Prepare a recording of joint angles.

    Args:
        recording: with q (rad) and time.
        arm: whose joints they are.
        weights: (n,) inverse-kinematics weights; left out: all alike.

    Raises:
        ShapeError: the recording holds no angles.
        UnknownNameError: a joint of the arm is missing.
        RangeError: it is not timed.
    """
    moving = attach_arm(recording, arm)
    q = moving.array("q")
    known = np.isfinite(q).all(axis=1) & np.isfinite(moving.array("qd")).all(axis=1)
    first, last = np.flatnonzero(known)[[0, -1]]
    moving = moving.window(int(first), int(last) + 1)
    if not np.isfinite(moving.array("q")).all():
        raise RangeError(f"{recording.name}: joint angles have gaps; fill them before playing")
    q, qd = moving.array("q"), moving.array("qd")
    parted = split(moving, weights=weights)
    elbow = geometric_jacobian(arm.chain, q, arm.tip("elbow"))[:, :3]
    hand = geometric_jacobian(arm.chain, q, arm.tip("hand"))[:, :3]
    return Playback(
        name=recording.name,
        time=moving.time - moving.time[0],
        line=landmark_line(arm, q),
        hand_velocity=np.einsum("kin,kn->ki", hand, qd),
        elbow_null_velocity=np.einsum("kin,kn->ki", elbow, parted.null),
        task_speed=np.linalg.norm(parted.task, axis=1),
        null_speed=np.linalg.norm(parted.null, axis=1),
        parted=parted,
    )


def plain_law(rest: Float[np.ndarray, " coords"], duration: float) -> JointLaw:
    """Give the law of a person about whom nothing is known.

    Args:
        rest: (n,) posture without elastic torque (rad).
        duration: of the movement (s); the paper's times are a fifth of its movements.
    """
    stiffness = PLAIN_STIFFNESS * np.eye(len(rest))
    return JointLaw(stiffness, rest, damping_time=duration / 5, spring_time=duration / 5)


@dataclass(frozen=True, eq=False)
class PlannedBeside:
    """What λ0-PMP plans for a recording's start and end.

    Attributes:
        time: (S,) from 0 (s).
        line: (S, 4, 3) shoulder, elbow, wrist, hand (m).
        status: whether the plan reaches the target.
    """

    time: Float[np.ndarray, " samples"]
    line: Float[np.ndarray, "samples 4 3"]
    status: Status


def plan_beside(
    recording: Recording,
    arm: Arm,
    *,
    law: JointLaw | None = None,
    weights: Float[np.ndarray, " coords"] | None = None,
) -> PlannedBeside:
    """Plan from a recording's first posture to where its hand ends.

    Args:
        recording: with q (rad) and time.
        arm: whose joints they are.
        law: elasticity; left out: the same stiffness everywhere, at rest where the recording
            starts.
        weights: (n,) used as damping, scaled to the law's; left out: the law's own.

    Raises:
        ShapeError: the law is of another number of joints.
    """
    moving = attach_arm(recording, arm)
    q = moving.array("q")
    whole = np.flatnonzero(np.isfinite(q).all(axis=1))
    start, stop = int(whole[0]), int(whole[-1])
    task = task_for(arm)
    duration = float(moving.time[stop] - moving.time[start])
    if law is None:
        law = plain_law(q[start], duration)
    if law.n_joints != arm.n_joints:
        raise ShapeError(f"law: {law.n_joints} joints, and the arm has {arm.n_joints}")
    damping = None if weights is None else law.damping.trace() * weights / weights.sum()
    settings = PlanSettings(duration=duration, damping=damping)
    motion = plan(task, law, q[start], task.value(q[[stop]])[0], settings)
    return PlannedBeside(motion.time, landmark_line(arm, motion.q[0]), motion.status)
