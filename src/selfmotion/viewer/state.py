"""What a studio shows, as a small JSON file that opens again."""

import json
from pathlib import Path

import msgspec
import numpy as np

from selfmotion.errors import FileFormatError, RangeError
from selfmotion.redundancy.refine import check_poses
from selfmotion.writing import whole_file

SCHEMA = "selfmotion.studio"


class StudioState(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a person has set in the studio.

    Attributes:
        schema: what the file is.
        model: musculoskeletal arm, by name or file.
        hand: (4, 4) pose of the hand in the ground (m).
        limits_deg: joint to its range (degrees), where it is not the model's own.
        splint: whether the elbow's splint is on.
        swivel_deg: swivel angle (degrees), or null for that of least effort.
        recording: file that is played, or null.
        time: where in the recording (s).
    """

    schema: str = SCHEMA
    model: str = "myoarm"
    hand: tuple[tuple[float, float, float, float], ...] | None = None
    limits_deg: dict[str, tuple[float, float]] = {}
    splint: bool = False
    swivel_deg: float | None = None
    recording: str | None = None
    time: float = 0.0


def save_state(path: str | Path, state: StudioState) -> Path:
    """Write a state, whole or not at all."""
    text = json.dumps(msgspec.to_builtins(state), indent=2)
    with whole_file(Path(path)) as aside:
        aside.write_text(text + "\n", encoding="utf-8")
    return Path(path)


def load_state(path: str | Path) -> StudioState:
    """Read a state.

    Raises:
        FileFormatError: no such file, no JSON, or not the state of a studio.
    """
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    return read_state(raw, str(path))


def read_state(raw: bytes, name: str) -> StudioState:
    """Read a state from bytes; the name is for messages.

    Raises:
        FileFormatError: no JSON, or not the state of a studio.
    """
    try:
        state = msgspec.json.decode(raw, type=StudioState)
        if state.schema != SCHEMA:
            raise FileFormatError(f"{name}: schema {state.schema!r}; expected {SCHEMA!r}")
        if state.hand is not None:
            check_poses(np.array(state.hand))
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{name}: no state of a studio: {error}") from None
    except (RangeError, ValueError) as error:
        raise FileFormatError(f"{name}: hand: {error}") from None
    return state
