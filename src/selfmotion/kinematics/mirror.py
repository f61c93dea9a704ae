"""The other side's arm: a mirror image across the sagittal plane, with the same coordinates."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import REVOLUTE, Tip
from selfmotion.spatial import unit


def mirror(arm: Arm) -> Arm:
    """Give the left arm for a right one, and the other way round.

    The mirror is the plane through the ground's origin that holds up and forward. Coordinates
    keep their meaning (abduction stays positive sideways, pronation stays pronation) and their
    limits: a posture q puts every landmark at the mirror image of where the given arm has it.
    A frame's axis across the plane points the other way, so that frames stay right-handed.

    Example:
        >>> from selfmotion.arms import upper_limb_anatomical
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> left = mirror(upper_limb_anatomical())
        >>> T = forward_kinematics(left.chain, [0.0] * 9, left.tip("shoulder"))
        >>> T[0, :3, 3].round(3).tolist()
        [-0.188, 0.0, 0.0]
    """
    across = unit("up x forward", np.cross(arm.up, arm.forward))
    S = np.eye(4)
    S[:3, :3] -= 2.0 * np.outer(across, across)
    S3 = S[:3, :3]
    # A reflection turns a rotation vector the other way round: S exp(a) S = exp(-S a).
    sign = np.where(arm.chain.joint_type == REVOLUTE, -1.0, 1.0)
    chain = replace(
        arm.chain, axes=sign[:, None] * (arm.chain.axes @ S3), offsets=S @ arm.chain.offsets @ S
    )
    return replace(
        arm,
        name=_other_side(arm.name),
        chain=chain,
        landmarks={key: _mirrored(tip, S) for key, tip in arm.landmarks.items()},
        com=arm.com @ S3,
        inertia=S3 @ arm.inertia @ S3,
        gravity=S3 @ arm.gravity,
    )


def _mirrored(tip: Tip, S: Float[np.ndarray, "4 4"]) -> Tip:
    return Tip(tip.joint, S @ tip.transform @ S)


def _other_side(name: str) -> str:
    suffix = " (mirrored)"
    return name.removesuffix(suffix) if name.endswith(suffix) else name + suffix
