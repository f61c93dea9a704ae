"""A piece of work, and what came of it."""

from dataclasses import dataclass
from typing import Any

from selfmotion.errors import Status

DONE = Status(True, "done")


@dataclass(frozen=True)
class Item:
    """One piece of work.

    Attributes:
        key: its name, once in a batch.
        payload: what the function takes; picklable.
        fingerprint: hash of everything that the result depends on; a journalled outcome counts
            only if it has the same.
    """

    key: str
    payload: Any
    fingerprint: str = ""


@dataclass(frozen=True)
class Outcome:
    """What came of an item: the function's dictionary, or None and the reason why."""

    key: str
    result: dict[str, Any] | None
    status: Status = DONE
