"""`selfmotion segment`: where movements begin and end, their strokes, and which stand apart."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from selfmotion.cli.options import Json, Out
from selfmotion.cli.output import Contract, Document, Part, finish
from selfmotion.cli.recordings import (
    AngleUnit,
    ArmName,
    Cutoff,
    Forward,
    LengthUnit,
    Rate,
    Stated,
    TaskName,
    Up,
)
from selfmotion.errors import RangeError, SelfmotionError
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from selfmotion.motion.recording import Recording
    from selfmotion.motion.strokes import StrokeRules


# Low-pass of markers where none is asked for (Hz).
MARKER_CUTOFF = 6.0


class StrokePart(Part, frozen=True, kw_only=True):
    """One stroke: seconds in the recording, metres along the path, m/s."""

    onset_s: float
    peak_s: float
    offset_s: float
    length_m: float
    peak_speed: float


class SegmentedMovement(Part, frozen=True, kw_only=True):
    """One recording: from the first to the last motion, and its strokes.

    `stands_apart`: path length or duration is more than two interquartile ranges from the median
    of all recordings. A recording that could not be used has a status that says why.
    """

    name: str
    onset_s: float | None
    offset_s: float | None
    duration_s: float | None
    length_m: float | None
    strokes: list[StrokePart]
    stands_apart: bool
    failed: bool
    status: str


class SegmentDocument(Document, frozen=True, tag="selfmotion/segment/1", kw_only=True):
    """The movements of all recordings."""

    movements: list[SegmentedMovement]


CONTRACT = Contract(
    SegmentDocument,
    ("segment", "examples/markers_drink.csv", "--marker", "RFB", "--json"),
)


def segment(
    inputs: Annotated[
        list[Path],
        typer.Argument(metavar="INPUT", help="Recordings, or marker files, or folders."),
    ],
    marker: Annotated[
        str | None,
        typer.Option("--marker", metavar="NAME", help="Of marker files: whose speed counts."),
    ] = None,
    arm: ArmName = None,
    task: TaskName = None,
    cutoff: Cutoff = None,
    length_unit: LengthUnit = None,
    angle_unit: AngleUnit = None,
    rate: Rate = None,
    up: Up = None,
    forward: Forward = None,
    share: Annotated[
        float,
        typer.Option("--share", metavar="SHARE", help="Share of peak speed that counts as rest."),
    ] = 0.05,
    valley: Annotated[
        float,
        typer.Option(
            "--valley", metavar="SHARE", help="Speed between strokes, as a share of the lower peak."
        ),
    ] = 0.5,
    points: Annotated[
        int,
        typer.Option(
            "--points", metavar="N", help="Of each movement and stroke in normalised.*, 0-100 %."
        ),
    ] = 101,
    form: Annotated[
        Literal["csv", "parquet"], typer.Option("--format", help="Of the tables in --out.")
    ] = "csv",
    json: Json = False,
    out: Out = None,
) -> int:
    """Find where movements begin and end, and their strokes."""
    from selfmotion.motion.segment import stands_apart
    from selfmotion.motion.strokes import StrokeRules
    from selfmotion.provenance import hash_file

    rules = StrokeRules(share=share, valley=valley)
    if points < 2:
        raise RangeError(f"--points {points}: at least 2")
    stated = Stated(length_unit, angle_unit, rate, up, forward)
    found: list[SegmentedMovement] = []
    curves: list[pd.DataFrame] = []
    keep = _Keep(rules, points if out is not None else 0, curves)
    if marker is None:
        from selfmotion.cli.recordings import read_study

        study, unread = read_study(inputs, arm=arm, task=task, cutoff=cutoff, stated=stated)
        found += [_failed(bad.file, bad.status) for bad in unread]
        for recording in study:
            found.append(_attempt(recording.name, lambda r=recording: _of_recording(r, keep)))
    else:
        from selfmotion.cli.recordings import find_files

        inputs = find_files(inputs, markers=True)
        for path in inputs:
            found.append(
                _attempt(str(path), lambda p=path: _of_marker(p, marker, cutoff, (stated, keep)))
            )
    good = [i for i, m in enumerate(found) if not m.failed]
    apart = stands_apart([found[i].length_m or 0.0 for i in good])
    apart = apart | stands_apart([found[i].duration_s or 0.0 for i in good])
    from msgspec.structs import replace

    for i, far in zip(good, apart.tolist(), strict=True):
        found[i] = replace(found[i], stands_apart=far)
    hashes = {p.name: hash_file(p) for p in inputs if p.is_file()}
    choices = {"share": share, "valley": valley, "marker": marker, "arm": arm, "cutoff_hz": cutoff}
    choices |= stated.choices()
    document = SegmentDocument(
        provenance=Provenance("segment", inputs=hashes, choices=choices), movements=found
    )
    text = as_text(document)
    if out is not None:
        text += "".join(f"\nwrote {path}" for path in write_tables(document, curves, out, form))
    return finish(document, text, json=json, failed=len(found) - len(good))


@dataclass(frozen=True, eq=False)
class _Keep:
    """How recordings are measured, and what is kept of them for the table of curves.

    Attributes:
        rules: what counts as a stroke.
        points: of each part over 0 to 100 %; 0: nothing is kept.
        curves: to which each recording adds its table.
    """

    rules: "StrokeRules"
    points: int
    curves: "list[pd.DataFrame]"


def _attempt(name: str, measure: Callable[[], SegmentedMovement]) -> SegmentedMovement:
    """Measure one recording; one that fails says why, and the rest goes on."""
    try:
        return measure()
    except SelfmotionError as error:
        return _failed(name, str(error))


def _failed(name: str, status: str) -> SegmentedMovement:
    return SegmentedMovement(
        name=name,
        onset_s=None,
        offset_s=None,
        duration_s=None,
        length_m=None,
        strokes=[],
        stands_apart=False,
        failed=True,
        status=status,
    )


def _of_recording(recording: "Recording", keep: "_Keep") -> SegmentedMovement:
    import numpy as np

    from selfmotion.motion.filters import with_velocities

    if recording.rate is None:
        raise RangeError(f"{recording.name}: has no time in seconds")
    moving = with_velocities(recording)
    speed = np.linalg.norm(moving.array("xd")[:, :3], axis=1)
    columns = {"speed_m_s": speed}
    if moving.q is not None:
        columns |= {f"{name}_rad": moving.q[:, i] for i, name in enumerate(moving.joints)}
    if moving.x is not None:
        columns |= {f"hand_{name}": moving.x[:, i] for i, name in enumerate(moving.rows)}
    return _measured(recording.name, recording.time, columns, keep)


def _of_marker(
    path: Path, marker: str, cutoff: float | None, how: "tuple[Stated, _Keep]"
) -> SegmentedMovement:
    import numpy as np

    from selfmotion.cli.recordings import load_marker_file
    from selfmotion.motion.checks import require_even_steps
    from selfmotion.motion.filters import differentiate, fill_gaps, low_pass

    stated, keep = how
    seen = load_marker_file(path, stated)
    points, _ = fill_gaps(seen.point(marker), seen.time, max_gap=0.2)
    if seen.rate is not None:  # raw markers: noise at the ends would look like motion
        require_even_steps(seen.name, seen.time)
        points = low_pass(points, seen.rate, MARKER_CUTOFF if cutoff is None else cutoff)
    speed = np.linalg.norm(differentiate(points, seen.time, points=3), axis=1)
    columns = {"speed_m_s": speed}
    columns |= {f"{marker}_{axis}_m": points[:, i] for i, axis in enumerate("xyz")}
    return _measured(str(path), seen.time, columns, keep)


def _measured(
    name: str, time: "np.ndarray", columns: "dict[str, np.ndarray]", keep: "_Keep"
) -> SegmentedMovement:
    """Measure a recording; `columns` begins with the speed, the rest is kept over 0 to 100 %."""
    from selfmotion.motion.segment import normalised_parts
    from selfmotion.motion.strokes import find_strokes, movement_span

    speed = next(iter(columns.values()))
    strokes = find_strokes(speed, time, rules=keep.rules)
    first, last = movement_span(speed, share=keep.rules.share)
    if keep.points:
        parts = [("movement", first, last)]
        parts += [(f"stroke {i + 1}", s.onset, s.offset) for i, s in enumerate(strokes)]
        table = normalised_parts(time, columns, parts, n_samples=keep.points)
        table.insert(0, "recording", name)
        keep.curves.append(table)
    return SegmentedMovement(
        name=name,
        onset_s=float(time[first]),
        offset_s=float(time[last]),
        duration_s=float(time[last] - time[first]),
        length_m=float(sum(s.length for s in strokes)),
        strokes=[
            StrokePart(
                onset_s=float(time[s.onset]),
                peak_s=float(time[s.peak]),
                offset_s=float(time[s.offset]),
                length_m=s.length,
                peak_speed=s.peak_speed,
            )
            for s in strokes
        ],
        stands_apart=False,
        failed=False,
        status=f"{len(strokes)} strokes",
    )


def write_tables(
    document: SegmentDocument,
    curves: "list[pd.DataFrame]",
    folder: Path,
    form: Literal["csv", "parquet"],
) -> list[Path]:
    """Write strokes, one row a stroke, and normalised, one row a part and percent."""
    import pandas as pd
    from msgspec.structs import asdict

    folder.mkdir(parents=True, exist_ok=True)
    rows = [
        {"recording": m.name, "stroke": i + 1, **asdict(s), "stands_apart": m.stands_apart}
        for m in document.movements
        for i, s in enumerate(m.strokes)
    ]
    tables = {"strokes": pd.DataFrame(rows)}
    if curves:
        tables["normalised"] = pd.concat(curves, ignore_index=True)
    written = []
    for name, table in tables.items():
        path = folder / f"{name}.{form}"
        if form == "csv":
            written.append(write_whole(path, table.to_csv(index=False)))
        else:
            from selfmotion.motion.files.parquet import write_parquet_table

            written.append(write_parquet_table(path, table))
    return written


def as_text(document: SegmentDocument) -> str:
    """Write the movements as a person reads them."""
    lines = []
    for m in document.movements:
        if m.failed:
            lines.append(f"{m.name}: {m.status.removeprefix(f'{m.name}: ')}")
            continue
        apart = "; stands apart from the others" if m.stands_apart else ""
        lines.append(f"{m.name}: {m.onset_s:.2f} to {m.offset_s:.2f} s, {m.status}{apart}")
        lines += [
            f"  {s.onset_s:.2f} to {s.offset_s:.2f} s: {s.length_m:.3f} m, "
            f"peak {s.peak_speed:.2f} m/s"
            for s in m.strokes
        ]
    return "\n".join(lines)
