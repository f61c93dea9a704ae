"""Scenes: the feasible postures of a person's arm, sampled along the self-motion manifold."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from selfmotion.kinematics.forward import forward_kinematics, tip_positions
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.methods.predictors.observation import Scene, Stretch
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.redundancy.feasible import FeasibleInterval, unwrapped
from selfmotion.redundancy.manifold import ManifoldFinder

# Greatest distance between samples along the manifold (rad, norm over coordinates); a degree of
# swivel angle is about 0.04.
SPACING = 0.02


def make_scene(
    model: MusculoskeletalArm,
    T_hand: ArrayLike,
    *,
    shoulder: ArrayLike,
    mouth: ArrayLike,
    start: ArrayLike,
    finder: ManifoldFinder | None = None,
) -> Scene:
    """Find the feasible postures for a hand pose and sample them.

    Args:
        model: the person's arm with muscles.
        T_hand: (4, 4) hand pose in its ground (m).
        shoulder: (3,) the centre that swivel angles turn about (m).
        mouth: (3,) (m).
        start: (7,) posture at the start of the movement (rad).
        finder: of the same arm, where there are many poses.

    Raises:
        RangeError: T_hand is not a rigid transform.
        ModelError: the arm has not seven free coordinates.
    """
    places = (np.array(v, dtype=np.float64) for v in (T_hand, shoulder, mouth, start))
    bare = Scene(model, *places, stretches=())
    manifold = (finder or ManifoldFinder.of(model.arm)).find(bare.T_hand)
    stretches = tuple(_sampled(bare, interval) for interval in manifold.intervals)
    return replace(bare, stretches=stretches, manifold=manifold)


def swivel_about(scene: Scene, q: Float[np.ndarray, "samples 7"]) -> Float[np.ndarray, " samples"]:
    """Give the swivel angle (rad) of postures about the scene's shoulder; left arms mirrored."""
    E, W = elbow_and_wrist(scene, q)
    return swivel_angle(scene.shoulder, E, W, down=-scene.model.arm.up)


def elbow_and_wrist(
    scene: Scene, q: Float[np.ndarray, "samples 7"]
) -> tuple[Float[np.ndarray, "samples 3"], Float[np.ndarray, "samples 3"]]:
    """Give the places of elbow and wrist (m)."""
    arm = scene.model.arm
    points = tip_positions(arm.chain, q, [arm.tip("elbow"), arm.tip("wrist")])
    return points[:, 0], points[:, 1]


def wrist_of_hand(scene: Scene) -> Float[np.ndarray, "3"]:
    """Give the place of the wrist (m), which the hand pose determines, in reach or not."""
    arm = scene.model.arm
    T = forward_kinematics(arm.chain, scene.start, arm.tip("hand"))[0]
    W = elbow_and_wrist(scene, scene.start[None])[1][0]
    return scene.T_hand[:3, :3] @ (T[:3, :3].T @ (W - T[:3, 3])) + scene.T_hand[:3, 3]


def _sampled(scene: Scene, interval: FeasibleInterval) -> Stretch:
    n = max(3, int(np.ceil(interval.length / SPACING)) + 1)
    q = interval.at(np.linspace(interval.arc[0], interval.arc[-1], n))
    return Stretch(q, unwrapped(swivel_about(scene, q)))
