"""What `selfmotion ik` prints and writes: its document, its table, its text and its report."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from selfmotion.cli.ik_path import PathPart
from selfmotion.cli.output import Document, Number, Part
from selfmotion.cli.tables import Name, Rows
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.batch import Outcome

# What a batch gives for each target.
KEYS = ("time", "q", "error_mm", "error_deg", "iterations", "restarts", "status", "failed")


class TargetItem(Part, frozen=True, kw_only=True):
    """The posture for one target: q in joint order (rad), as near as it comes if not solved.

    Null where the row holds no target, and what does not apply: the time of a target that is on no
    path, the steps tried along a path. An error is 0 where nothing of its kind is held.
    """

    id: Name
    time: Number
    q: list[Number] | None
    error_mm: Number
    error_deg: Number
    iterations: int | None
    restarts: int | None
    status: str
    failed: bool


class IkDocument(Document, frozen=True, tag="selfmotion/ik/1", kw_only=True):
    """Postures for targets; limits in radians."""

    arm: str
    joints: list[str]
    lower: list[Number]
    upper: list[Number]
    rows: list[str]
    path: PathPart | None
    targets: list[TargetItem]


def n_failed(document: IkDocument) -> int:
    """Count the targets that were missed; a jump on the way counts as one."""
    jumped = document.path is not None and not document.path.ok
    return max(sum(t.failed for t in document.targets), int(jumped))


def records(rows: Rows, outcomes: "list[Outcome]") -> list[TargetItem]:
    """Give a record for every row, in the file's order."""
    found: dict[int, dict[str, Any]] = {}
    for outcome in outcomes:
        result = outcome.result or {"place": []}
        keys = [key for key in KEYS if key in result]
        for k, i in enumerate(result["place"]):
            found[i] = {key: result[key][k] for key in keys}
    reason = next((o.status.sentence for o in outcomes if o.result is None), "not computed")
    unknown = dict.fromkeys(KEYS)
    return [
        TargetItem(
            id=name,
            **{**unknown, **found.get(i, {"status": problem or reason, "failed": True})},
        )
        for i, (name, problem) in enumerate(zip(rows.ids, rows.problems, strict=True))
    ]


def save_table(document: IkDocument, folder: Path) -> Path:
    """Write ik.csv: one row a target, joints in radians."""
    import pandas as pd

    empty = [None] * len(document.joints)
    table = pd.DataFrame(
        {
            "id": t.id,
            **({} if document.path is None else {"time": t.time}),
            **dict(zip(document.joints, t.q or empty, strict=True)),
            "error_mm": t.error_mm,
            "error_deg": t.error_deg,
            "iterations": t.iterations,
            "status": t.status,
        }
        for t in document.targets
    )
    return write_whole(folder / "ik.csv", table.to_csv(index=False))


def write_report_of(path: Path, document: IkDocument) -> Path:
    """Write the report; give its path."""
    import numpy as np

    from selfmotion.report.ik_page import IkResults, write_ik_report

    missing = [None] * len(document.joints)
    results = IkResults(
        document.arm,
        tuple(document.joints),
        np.array([document.lower, document.upper], dtype=float),
        tuple(document.rows),
        tuple(t.id for t in document.targets),
        np.array([t.q or missing for t in document.targets], dtype=float),
        np.array([[t.error_mm, t.error_deg] for t in document.targets], dtype=float),
        tuple(t.status for t in document.targets),
        None if document.path is None else np.array([t.time for t in document.targets]),
        "" if document.path is None else document.path.status,
        document.provenance,
    )
    return write_ik_report(path, results)


def as_text(document: IkDocument) -> str:
    """Write postures as a person reads them, in degrees."""
    from math import degrees

    solved = sum(not t.failed for t in document.targets)
    lines = [
        f"arm {document.arm}, held: {', '.join(document.rows)}; "
        f"{solved} of {len(document.targets)} targets solved",
        *([] if document.path is None else [f"path: {document.path.status}"]),
        "degrees, in order: " + ", ".join(document.joints),
    ]
    for t in document.targets:
        angles = " ".join(f"{degrees(v):7.1f}" for v in t.q or [] if v is not None)
        lines.append(f"target {t.id}: {angles}  {t.status}".replace(":   ", ": "))
    return "\n".join(lines)
