"""The option --body: the person's body, which cuts out of the workspace and keeps the arm out."""

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

if TYPE_CHECKING:
    from selfmotion.kinematics.arm import Arm
    from selfmotion.kinematics.body_shapes import BodyShapes

NO_BODY = "none"
BodyName: TypeAlias = Annotated[
    Literal["none", "seated", "standing"],
    typer.Option(
        "--body", help="Keep out of the body of an adult, sized by the arm's lengths; none: do not."
    ),
]
# The same where a file may say it: left out, the file counts.
BodyChoice: TypeAlias = Annotated[
    Literal["none", "seated", "standing"] | None,
    typer.Option(
        "--body",
        help="Keep the hand out of the body of an adult, sized by the arm's lengths; left out: "
        "the subject's, or none.",
    ),
]


def body_of(name: str, arm: "Arm") -> "BodyShapes | None":
    """Give the body around an arm, or None for `none`.

    Raises:
        UnknownNameError: there is no such posture of the body.
        RangeError: the arm's lengths are not those of a person.
    """
    if name == NO_BODY:
        return None
    from selfmotion.errors import unknown_name
    from selfmotion.kinematics.body_shapes import POSTURES, BodyShapes

    for posture in POSTURES:
        if posture == name:
            return BodyShapes.of(arm, posture)
    raise unknown_name("body", name, (NO_BODY, *POSTURES))


def body_choice(name: str) -> dict[str, str]:
    """Give what provenance says of the body: nothing where there is none."""
    return {} if name == NO_BODY else {"body": name}
