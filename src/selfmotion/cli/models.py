"""The arm that a command works on: by name or file, with the limits typed at the command line."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from selfmotion.cli.options import angles_by_name
from selfmotion.errors import ModelError, RangeError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.muscles.geometry import MusculoskeletalArm

# One turn (rad): no joint of an arm has a limit beyond it.
TURN = 6.283185307179586 * (1.0 + 1e-12)
Limits: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="JOINT=LOW:HIGH",
        help="Range of a joint in degrees, as in elbow_flexion=64.2:114; repeatable.",
    ),
]
WeightsText: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--weights",
        metavar="W,W,...|FILE.json",
        help="Cost of each joint: numbers in joint order, or a weights.json.",
    ),
]


def load_any_arm(name: str) -> "Arm":
    """Load an arm by name, or from an .osim, .xml or .urdf.

    Raises:
        SelfmotionError: there is none, or the file cannot be read as one.
    """
    if Path(name).suffix.lower() == ".osim":
        return load_muscles(name, None).arm
    from selfmotion.arms import load_arm

    return load_arm(name)


def load_muscles(name: str, convention: str | None) -> "MusculoskeletalArm":
    """Load an arm with muscles.

    Raises:
        SelfmotionError: names the file and what is wrong with it.
    """
    from selfmotion.arms.with_muscles import load_musculoskeletal_arm

    try:
        return load_musculoskeletal_arm(name, convention=convention)
    except ModelError as error:
        if name in str(error):
            raise
        raise ModelError(f"{name}: {error}") from None


def with_typed_limits(arm: "Arm", texts: list[str] | None) -> "Arm":
    """Give the arm with the ranges of --limit.

    Raises:
        RangeError: a range is empty, or beyond one turn.
        UnknownNameError: there is no such joint.
    """
    ranges = angles_by_name("--limit", texts or [])
    for text, bounds in zip(texts or [], ranges.values(), strict=True):
        if max(map(abs, bounds)) > TURN:
            raise RangeError(f"--limit {text!r}: allowed are angles from -360 to 360 degrees")
    return arm.with_limits(ranges)


def typed_weights(text: str | None, arm: "Arm") -> "np.ndarray | None":
    """Give the weights (n) that --weights means.

    Raises:
        SelfmotionError: the text is no file or numbers that give positive weights.
    """
    if text is None:
        return None
    if text.lower().endswith(".json"):
        from selfmotion.cli.split import weights_of_file

        return weights_of_file(Path(text), arm.joints)
    from selfmotion.methods.velocity_split import weight_vector

    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        raise RangeError(
            f"--weights {text!r}: allowed are {arm.n_joints} numbers with commas between, or a "
            ".json file of `selfmotion weights`"
        ) from None
    return weight_vector(values, arm.joints)
