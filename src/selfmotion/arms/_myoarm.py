"""The right arm of the package myo-sim as a chain of seven free coordinates.

The package is declared Apache-2.0; it derives from MoBL-ARMS, whose own terms are non-commercial.
It is depended on, and nothing of it is copied here. The shoulder girdle follows shoulder_elv and
elv_angle by the model's own joint equalities; fingers are held at their default.
"""

import mujoco
import numpy as np

from selfmotion.arms.mjcf_urdf import arm_from_chain
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.mujoco_chain import chain_from_mujoco
from selfmotion.muscles.mujoco_bridge import load_myo_sim

SIDE = "_r"
# MoBL's hand body sits at the capitate, fixed to the second of the wrist's two axes.
BODIES = {
    "sternoclavicular": "clavicle",
    "shoulder": "humphant",
    "elbow": "ulna",
    "wrist": "lunate",
    "hand": "capitate",
    "middle_knuckle": "3proxph",
}


def myoarm() -> Arm:
    """Give the myo-sim arm, with its shoulder girdle and seven free coordinates.

    Coordinates have MoBL's names without the side. Ground is the model's: z up, the person looks
    along -y, the right arm is at -x. Landmarks: the shoulder is the glenohumeral centre, which
    moves with the girdle; the wrist is the point where its axes cross; the hand is the frame that
    corresponds to the `hand` body of the OpenSim models, 16 mm beyond the wrist and fixed to its
    last axis: x forward, y up, z to the right when the arm hangs at zero.
    Limits, masses and inertias are the model's.

    Example:
        >>> arm = myoarm()
        >>> arm.joints
        ('elv_angle', 'shoulder_elv', 'shoulder_rot', 'elbow_flexion', 'pro_sup', 'deviation',
         'flexion')
    """
    return arm_of_myo_sim(load_myo_sim("myoarm"))


def arm_of_myo_sim(model: mujoco.MjModel) -> Arm:
    """Give the arm of a compiled myo-sim model, as it is or with other segments; see `myoarm`."""
    joints = [model.joint(j).name for j in range(model.njnt)]
    taken = chain_from_mujoco(
        model,
        tip=BODIES["hand"] + SIDE,
        names={name: name.removesuffix(SIDE) for name in joints},
    )
    torso = taken.tip("torso").transform[:3, :3]
    return arm_from_chain(
        taken,
        name="myoarm",
        landmarks={key: taken.tip(body + SIDE) for key, body in BODIES.items()},
        directions=(
            np.array(model.opt.gravity),
            torso[:, 1].round(9) + 0.0,
            torso[:, 0].round(9) + 0.0,
        ),
        source=(
            "myo-sim 0.2 (Apache-2.0; derived from MoBL-ARMS, Saul et al. 2015, non-commercial); "
            "limits, masses and inertias of the model"
        ),
    )
