"""The arms: by name, from a model file, or built from a person's lengths.

>>> from selfmotion.arms import load_arm
>>> load_arm("exoskeleton").joints
('shoulder_elevation', 'shoulder_rotation', 'shoulder_flexion', 'elbow_flexion')
"""

from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from selfmotion.arms._body import Body
from selfmotion.arms._exoskeleton import exoskeleton
from selfmotion.arms._planar import hip_shoulder_elbow, planar
from selfmotion.arms._srs7 import srs7
from selfmotion.arms._upper_limb import (
    ANATOMICAL,
    Corrections,
    upper_limb,
    upper_limb_anatomical,
    upper_limb_rest,
)
from selfmotion.arms._wrist import wrist
from selfmotion.errors import FileFormatError, unknown_name
from selfmotion.kinematics.arm import Arm

if TYPE_CHECKING:
    from selfmotion.arms._myoarm import myoarm
    from selfmotion.arms.mjcf_urdf import ModelChoices, read_model

__all__ = [
    "ANATOMICAL",
    "Body",
    "Corrections",
    "ModelChoices",
    "arm_names",
    "exoskeleton",
    "hip_shoulder_elbow",
    "load_arm",
    "myoarm",
    "planar",
    "read_model",
    "srs7",
    "upper_limb",
    "upper_limb_anatomical",
    "upper_limb_rest",
    "wrist",
]

# These need MuJoCo, which takes its time to import.
_LAZY = MappingProxyType(
    {
        "myoarm": "selfmotion.arms._myoarm",
        "read_model": "selfmotion.arms.mjcf_urdf",
        "ModelChoices": "selfmotion.arms.mjcf_urdf",
    }
)


def __getattr__(name: str) -> Any:
    """Import what needs MuJoCo when it is first asked for."""
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_LAZY[name]), name)


def _myoarm() -> Arm:
    from selfmotion.arms._myoarm import myoarm

    return myoarm()


_BUILDERS: MappingProxyType[str, Callable[[], Arm]] = MappingProxyType(
    {
        "planar": planar,
        "hip_shoulder_elbow": hip_shoulder_elbow,
        "wrist": wrist,
        "exoskeleton": exoskeleton,
        "upper_limb": upper_limb,
        "upper_limb_anatomical": upper_limb_anatomical,
        "srs7": srs7,
        "myoarm": _myoarm,
    }
)
MODEL_SUFFIXES = (".xml", ".urdf")


def arm_names() -> tuple[str, ...]:
    """Name the arms that `load_arm` builds without a file."""
    return tuple(_BUILDERS)


def load_arm(name_or_path: str | Path) -> Arm:
    """Give an arm by its name, or read one from an MJCF (.xml), URDF (.urdf) or .osim file.

    Args:
        name_or_path: one of `arm_names`, or a path.

    Raises:
        UnknownNameError: there is no arm of this name.
        FileFormatError: the file does not exist or cannot be read.
        ModelError: the model holds a joint that a chain cannot represent.

    Example:
        >>> load_arm("wrist").joints
        ('pronation', 'flexion', 'deviation')
    """
    text = str(name_or_path)
    if text in _BUILDERS:
        return _BUILDERS[text]()
    path = Path(name_or_path)
    if path.suffix.lower() in MODEL_SUFFIXES:
        from selfmotion.arms.mjcf_urdf import read_model

        return read_model(path)
    if path.suffix.lower() == ".osim":
        from selfmotion.muscles.opensim_bridge import read_osim

        return read_osim(path).arm
    if path.suffix or path.exists():
        raise FileFormatError(
            f"{text}: an arm is read from {', '.join(MODEL_SUFFIXES)} or .osim; "
            f"this is {path.suffix!r}"
        )
    raise unknown_name("arm", text, arm_names())
