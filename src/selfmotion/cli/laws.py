"""Joint laws, springs and postures as they are typed at the command line."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from selfmotion.cli.models import TURN
from selfmotion.errors import FileFormatError, RangeError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.passive.joint_law import JointLaw

FROM_DAMPING = "from-damping"
# The wrist of [Tommasino2017] Fig. 3.
FIG_3_STIFFNESS = (0.5, 1.5, 2.0)
FIG_3_REST_DEG = (5.0, 0.0, 0.0)


def law_of(path: Path | None, arm: "Arm") -> "JointLaw":
    """Read the law, or give that of the paper's wrist.

    Raises:
        SelfmotionError: the file is no law, is for another number of joints, or is needed.
    """
    import numpy as np

    from selfmotion.methods.passive.joint_law import JointLaw, read_law

    if path is None:
        if arm.name != "wrist":
            raise RangeError(
                f"--law: {arm.name} needs a FILE.toml with stiffness (N m/rad) and rest (rad) of "
                f"its {arm.n_joints} joints; only the wrist has one of its own"
            )
        return JointLaw(np.diag(FIG_3_STIFFNESS), np.radians(FIG_3_REST_DEG))
    law = read_law(path)
    if law.n_joints != arm.n_joints:
        raise FileFormatError(
            f"{path}: rest has {law.n_joints} joints, {arm.name} has {arm.n_joints} "
            f"({', '.join(arm.joints)})"
        )
    return law


def typed_spring(text: str) -> float | Literal["from-damping"]:
    """Give the spring constant that --spring means.

    Raises:
        RangeError: it is no number above 0.
    """
    import math

    if text == FROM_DAMPING:
        return FROM_DAMPING
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise RangeError(f"--spring {text!r}: allowed are {FROM_DAMPING} or a number above 0")
    return value


def typed_posture(text: str, arm: "Arm") -> "np.ndarray":
    """Give the posture (n) typed in degrees, in rad.

    Raises:
        RangeError: these are not as many finite numbers as the arm has joints.
    """
    import numpy as np

    try:
        q = np.radians([float(word) for word in text.split(",")])
    except ValueError:
        q = np.empty(0)
    if q.shape != (arm.n_joints,) or not (np.abs(q) <= TURN).all():
        raise RangeError(
            f"--start {text!r}: allowed are {arm.n_joints} angles from -360 to 360 degrees "
            f"({','.join(arm.joints)})"
        )
    return q
