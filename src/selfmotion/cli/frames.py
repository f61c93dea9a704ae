"""The option --frame: which way the axes of a file's positions and poses point, and from where."""

from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from selfmotion.errors import RangeError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm

MODEL = "model"
OPPOSITE = {"forward": "backward", "up": "down", "right": "left"}
DIRECTIONS = (*OPPOSITE, *OPPOSITE.values())
FrameName: TypeAlias = Annotated[
    str,
    typer.Option(
        "--frame",
        metavar="model|X,Y,Z[@ORIGIN]",
        help="Where the file's axes point, as in forward,up,right, and the landmark at their "
        "origin, as in forward,up,right@shoulder; left out: the model's ground.",
    ),
]


def ground_from_file(frame: str, arm: "Arm") -> "np.ndarray":
    """Give the transform (4, 4) that takes a file's coordinates to the model's ground.

    Args:
        frame: `model`; or three directions of a person, one an axis, and after `@` a landmark,
            taken at the posture of zeros brought inside the joint limits.
        arm: whose ground it is.

    Raises:
        RangeError: the text is something else, or the axes are no right-handed frame.
        UnknownNameError: there is no such landmark.
    """
    import numpy as np

    axes, _, origin = (part.strip() for part in frame.partition("@"))
    T = np.eye(4)
    if axes != MODEL:
        T[:3, :3] = _axes(frame, axes, arm)
    if origin:
        from selfmotion.kinematics.forward import tip_positions

        home = np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)
        T[:3, 3] = tip_positions(arm.chain, home, [arm.tip(origin)])[0, 0]
    return T


def _axes(frame: str, axes: str, arm: "Arm") -> "np.ndarray":
    import numpy as np

    words = [word.strip().lower() for word in axes.split(",")]
    if len(words) != 3 or not set(words) <= set(DIRECTIONS):
        raise RangeError(
            f"--frame {frame!r}: allowed are {MODEL}, or three of {', '.join(DIRECTIONS)}, as in "
            "forward,up,right"
        )
    ways = {"forward": arm.forward, "up": arm.up, "right": np.cross(arm.forward, arm.up)}
    ways |= {OPPOSITE[name]: -way for name, way in ways.items()}
    R = np.stack([ways[word] for word in words], axis=1)
    if not abs(np.linalg.det(R) - 1.0) < 1e-6:
        raise RangeError(f"--frame {frame!r}: these axes are no right-handed frame")
    return R
