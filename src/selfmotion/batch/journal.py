"""The outcomes of a batch in a file, so that a run that was interrupted goes on where it was."""

import json
import os
import time
from pathlib import Path
from typing import Any

from selfmotion.batch.item import Item, Outcome
from selfmotion.errors import Status

# Seconds between two syncs of the journal to the disk: what a power cut can cost.
SYNC_EVERY = 1.0


class Journal:
    """File of outcomes, a line each; outcomes stay in the file, the memory holds where."""

    def __init__(self, path: Path | None, *, resume: bool) -> None:
        """Name the file; None keeps nothing. Without `resume` an old one is written over."""
        self._path, self._resume = path, resume
        self._places: dict[str, tuple[str, int]] = {}
        self._stream, self._reader = None, None
        self._synced = 0.0

    def __enter__(self) -> "Journal":
        """Open the file, and note what an earlier run has left in it."""
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            if self._resume and self._path.exists():
                self._reader = open(self._path, "rb")
                self._find_places()
            self._stream = open(self._path, "a" if self._resume else "w", encoding="utf-8")
            if self._stream.tell() > 0:
                self._stream.write("\n")  # a line that was cut off must not swallow the next
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the file."""
        if self._stream is not None:
            self._stream.close()
        if self._reader is not None:
            self._reader.close()

    def _find_places(self) -> None:
        """Note where each completed item stands; a last line that was cut off does not count."""
        assert self._reader is not None
        place = 0
        for line in self._reader:
            entry = _entry(line)
            if entry is not None and entry["ok"]:
                self._places[entry["key"]] = (entry["fingerprint"], place)
            place += len(line)

    def has(self, item: Item) -> bool:
        """Tell whether an earlier run has completed this very item."""
        return item.key in self._places and self._places[item.key][0] == item.fingerprint

    def outcome(self, item: Item) -> Outcome:
        """Give what the earlier run made of it."""
        assert self._reader is not None
        self._reader.seek(self._places[item.key][1])
        entry = _entry(self._reader.readline())
        assert entry is not None
        return Outcome(item.key, entry["result"], Status(True, entry["status"]))

    def add(self, item: Item, outcome: Outcome) -> None:
        """Write an outcome down."""
        if self._stream is None:
            return
        entry = {
            "key": item.key,
            "fingerprint": item.fingerprint,
            "ok": outcome.status.ok,
            "status": outcome.status.sentence,
            "result": outcome.result,
        }
        self._stream.write(json.dumps(entry) + "\n")
        self._stream.flush()
        if time.monotonic() - self._synced > SYNC_EVERY:
            os.fsync(self._stream.fileno())
            self._synced = time.monotonic()


def _entry(line: bytes) -> dict[str, Any] | None:
    """Read a line of the journal; None where a crash has cut it off."""
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    return entry if isinstance(entry, dict) else None
