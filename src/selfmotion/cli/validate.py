"""`selfmotion validate`: what files hold, in which units and axes, and where they have gaps."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from selfmotion.cli.options import Json
from selfmotion.cli.output import Contract, Document, Number, Part, finish
from selfmotion.cli.recordings import (
    NOTHING,
    AngleUnit,
    Forward,
    LengthUnit,
    Rate,
    Stated,
    Up,
    reason,
)
from selfmotion.errors import FileFormatError, SelfmotionError
from selfmotion.provenance import Provenance, hash_file

if TYPE_CHECKING:
    from selfmotion.motion.files.describe import FileContent

OK = "ok"
# What lies beside recordings and says something about them: no recording itself.
BESIDE = ("_motion.json", "_channels.json", "_channels.tsv", ".md", ".toml")


class GapEntry(Part, frozen=True):
    """Samples that are missing of one marker, joint or sensor."""

    name: str
    missing: int
    longest: int


class FrameEntry(Part, frozen=True):
    """The axes; null where the file does not tell them."""

    up: str | None
    forward: str | None


class LabelsEntry(Part, frozen=True):
    """What the file says about one recording."""

    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    trial: str | None


class ContentEntry(Part, frozen=True):
    """What a file holds; gaps in samples, over all its recordings."""

    format: str
    holds: str
    recordings: int
    samples: int
    seconds: Number
    rate_hz: Number
    names: list[str]
    units: dict[str, str]
    frame: FrameEntry
    labels: list[LabelsEntry]
    gaps: list[GapEntry]
    notes: list[str]


class FileEntry(Part, frozen=True):
    """One file; `status` is ok, or why it cannot be read."""

    file: str
    status: str
    content: ContentEntry | None


class ValidateDocument(Document, frozen=True, tag="selfmotion/validate/1", kw_only=True):
    """The files, in the order given."""

    files: list[FileEntry]


CONTRACT = Contract(ValidateDocument, ("validate", "examples/markers.trc", "--json"))


def validate(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE", help="Files, or folders, with all below them."),
    ],
    length_unit: LengthUnit = None,
    angle_unit: AngleUnit = None,
    rate: Rate = None,
    up: Up = None,
    forward: Forward = None,
    json: Json = False,
) -> int:
    """Say what files hold: their units, frame and gaps."""
    stated = Stated(length_unit, angle_unit, rate, up, forward)
    paths = expand(files)
    entries = [entry(path, stated) for path in paths]
    hashes = {e.file: hash_file(p) for e, p in zip(entries, paths, strict=True)}
    document = ValidateDocument(
        provenance=Provenance("validate", inputs=hashes, choices=stated.choices()), files=entries
    )
    text = "\n\n".join(as_text(e) for e in entries)
    return finish(document, text, json=json, failed=sum(e.status != OK for e in entries))


def expand(paths: list[Path]) -> list[Path]:
    """Give the files meant; a folder stands for all files below it, sorted, but for hidden ones.

    Of several files those that only say something about others are left aside: the companions of
    Motion-BIDS, which are read with their recording, README.md and study files (.toml).

    Raises:
        FileFormatError: nothing stands at a path, or a folder is empty.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(p for p in path.rglob("*") if p.is_file() and not _hidden(p, path))
            if not inside:
                raise FileFormatError(f"{path}: no file in this folder")
            found += inside
        elif path.is_file():
            found.append(path)
        else:
            raise FileFormatError(f"{path}: no such file")
    return [path for path in found if not path.name.lower().endswith(BESIDE)] or found


def _hidden(path: Path, folder: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(folder).parts)


def entry(path: Path, stated: Stated = NOTHING) -> FileEntry:
    """Describe one file, or say why it cannot be read."""
    from selfmotion.motion.files.describe import Known, describe

    known = Known(stated.angle_unit, stated.length_unit, stated.rate, stated.frame())
    try:
        content = describe(path, known)
    except SelfmotionError as error:
        return FileEntry(file=str(path), status=reason(error, path), content=None)
    return FileEntry(file=str(path), status=OK, content=as_entry(content))


def as_entry(content: "FileContent") -> ContentEntry:
    """Turn a description into the document's own type."""
    return ContentEntry(
        format=content.format,
        holds=content.holds,
        recordings=content.recordings,
        samples=content.samples,
        seconds=content.seconds,
        rate_hz=content.rate,
        names=list(content.names),
        units=dict(content.units),
        frame=FrameEntry(up=content.frame.up, forward=content.frame.forward),
        labels=[LabelsEntry(**labels.to_dict()) for labels in content.labels],
        gaps=[GapEntry(name=g.name, missing=g.missing, longest=g.longest) for g in content.gaps],
        notes=list(content.notes),
    )


def as_text(item: FileEntry) -> str:
    """Write an entry as a person reads it."""
    content = item.content
    if content is None:
        return f"{item.file}\n  REFUSED: {item.status}"
    up, forward = (axis or "not told" for axis in (content.frame.up, content.frame.forward))
    size = f"{content.samples} samples"
    size += f", {content.seconds:.3f} s" if content.seconds is not None else ", no times"
    size += f", {content.rate_hz:.6g} Hz" if content.rate_hz is not None else ""
    size += f", {content.recordings} recordings" if content.recordings > 1 else ""
    units = ", ".join(f"{what} {unit}" for what, unit in content.units.items())
    lines = [
        item.file,
        f"  {content.format}: {content.holds}; {size}",
        f"  {len(content.names)} names: {shortened(content.names)}",
        f"  units: {units}; frame: up {up}, forward {forward}",
        f"  gaps: {gaps_as_text(content)}",
    ]
    return "\n".join([*lines, *(f"  note: {note}" for note in content.notes)])


def gaps_as_text(content: ContentEntry) -> str:
    """Count the gaps, and name the worst."""
    if not content.gaps:
        return "none"
    worst = max(content.gaps, key=lambda gap: gap.missing)
    return (
        f"{len(content.gaps)} of {len(content.names)} have some; most {worst.name}: "
        f"{worst.missing} samples, the longest gap {worst.longest}"
    )


def shortened(names: list[str], most: int = 12) -> str:
    """Join names, of many only the first."""
    rest = f", ... {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + rest
