"""A file of joint angles and the arm whose joints it holds."""

from pathlib import Path

from selfmotion.arms import arm_names, load_arm
from selfmotion.errors import FileFormatError
from selfmotion.kinematics.arm import Arm
from selfmotion.motion.files import load
from selfmotion.motion.recording import Recording


def open_recording(path: Path) -> tuple[Recording, Arm]:
    """Read the first recording of a file and find the arm that has its joints.

    Of several arms the one with the most joints is taken, of these the one for recordings
    (`upper_limb_anatomical`).

    Raises:
        FileFormatError: no arm of the library has these joints.
        SelfmotionError: the file cannot be read.
    """
    recording = load(path)[0]
    held = set(recording.joints)
    arms = [load_arm(name) for name in arm_names()]
    fitting = [arm for arm in arms if set(arm.joints) <= held and recording.q is not None]
    if not fitting:
        known = "; ".join(f"{arm.name}: {', '.join(arm.joints)}" for arm in arms)
        raise FileFormatError(
            f"{path}: its columns ({', '.join(recording.joints)}) are the joints of no arm: {known}"
        )
    best = max(fitting, key=lambda arm: (arm.n_joints, arm.name == "upper_limb_anatomical"))
    return recording, best
