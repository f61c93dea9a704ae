"""Estimates kept on disk as soon as they are there, so that an interrupted study goes on with them.

A file of JSON lines: a fingerprint of all that an estimate depends on, and the estimate. Lines that
are damaged, or that another version wrote, do not count.
"""

import json
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.errors import Status
from selfmotion.methods.weights.estimate import WeightEstimate
from selfmotion.provenance import Provenance

ARRAYS = (
    "weights",
    "contribution",
    "contribution_eq26",
    "full_weights",
    "stderr_log",
    "log_covariance",
    "history",
    "error_history",
    "feedback_gains",
)


@dataclass(frozen=True, eq=False)
class KeptEstimates:
    """Estimates by fingerprint.

    Attributes:
        path: the file; None: nothing is kept.
        known: what an interrupted run left.
    """

    path: Path | None = None
    known: dict[str, dict[str, Any]] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path | None, *, resume: bool) -> "KeptEstimates":
        """Begin a file, or go on with the one that is there."""
        if path is None:
            return cls()
        path.parent.mkdir(parents=True, exist_ok=True)
        known: dict[str, dict[str, Any]] = {}
        if resume and path.is_file():
            for line in path.read_text(encoding="utf-8").splitlines():
                try:
                    entry = json.loads(line)
                    known[entry["fingerprint"]] = entry["estimate"]
                except (json.JSONDecodeError, KeyError, TypeError):
                    continue
        else:
            path.write_text("", encoding="utf-8")
        return cls(path, known)

    def recall(self, fingerprint: str) -> WeightEstimate | None:
        """Give the estimate of an earlier run; None where there is none."""
        entry = self.known.get(fingerprint)
        return None if entry is None else from_plain(entry)

    def keep(self, fingerprint: str, estimate: WeightEstimate) -> None:
        """Write an estimate to the file."""
        if self.path is None:
            return
        line = json.dumps({"fingerprint": fingerprint, "estimate": to_plain(estimate)})
        with open(self.path, "a", encoding="utf-8") as stream:
            stream.write(f"\n{line}")  # a line that was cut off must not swallow the next


def to_plain(estimate: WeightEstimate) -> dict[str, Any]:
    """Give what JSON can hold, arrays with their shapes; every digit stays."""
    plain: dict[str, Any] = {}
    for f in fields(estimate):
        value = getattr(estimate, f.name)
        if f.name in ARRAYS:
            array = np.asarray(value, dtype=np.float64)
            value = {"shape": array.shape, "values": array.ravel().tolist()}
        elif f.name == "status":
            value = {"ok": value.ok, "sentence": value.sentence}
        elif f.name == "provenance":
            value = value.to_dict()
        elif f.name == "unidentifiable":
            value = dict(value)
        plain[f.name] = value
    return plain


def from_plain(plain: dict[str, Any]) -> WeightEstimate | None:
    """Give the estimate back; None where the record is not whole."""
    try:
        values = {f.name: plain[f.name] for f in fields(WeightEstimate)}
        for name in ARRAYS:
            numbers = np.array(values[name]["values"], dtype=np.float64)
            values[name] = numbers.reshape(values[name]["shape"])
        for name in ("groups", "structural_groups"):
            values[name] = tuple(tuple(group) for group in values[name])
        for name in ("joints", "feedback_terms"):
            values[name] = tuple(values[name])
        values["status"] = Status(**values["status"])
        values["provenance"] = Provenance(**values["provenance"])
        return WeightEstimate(**values)
    except (KeyError, TypeError, ValueError):
        return None
