"""What the library raises on bad input, and how a method says that it did not succeed.

Bad input raises a :class:`SelfmotionError`. A method that ran but did not reach its goal
returns a :class:`Status` in its result: not converging is data, not an exception.
"""

from dataclasses import dataclass


class SelfmotionError(ValueError):
    """Bad input: the message is one line that names the value and what is allowed."""


class ShapeError(SelfmotionError):
    """An array has the wrong shape or type."""


class NotFiniteError(SelfmotionError):
    """An array holds NaN or infinite values where none are allowed."""


class RangeError(SelfmotionError):
    """A number lies outside the range in which it means anything."""


class UnknownNameError(SelfmotionError):
    """A name (joint, arm, landmark, field) that does not exist; the message lists those that do."""


class FileFormatError(SelfmotionError):
    """A file cannot be read as what it claims to be; the message names file and field."""


class ModelError(SelfmotionError):
    """A model (MJCF, URDF, .osim) holds something that the library cannot represent."""


class MissingExtraError(SelfmotionError):
    """An optional package is needed; the message names the extra that brings it."""


@dataclass(frozen=True)
class Status:
    """Whether a method reached its goal, and a sentence that says what happened."""

    ok: bool
    sentence: str

    def __bool__(self) -> bool:
        """Tell whether the goal was reached."""
        return self.ok

    def __str__(self) -> str:
        """Give the sentence."""
        return self.sentence


def unknown_name(kind: str, name: str, choices: "list[str] | tuple[str, ...]") -> UnknownNameError:
    """Build the error for a name that is not among the choices, with the nearest one if any."""
    import difflib

    near = difflib.get_close_matches(name, choices, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return UnknownNameError(f"unknown {kind} {name!r}{hint} (known: {', '.join(choices)})")
