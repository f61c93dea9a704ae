"""`selfmotion angles`: joint angles of a person from marker trajectories."""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

import typer

from selfmotion.cli.options import Json, Out
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers
from selfmotion.cli.recordings import Forward, LengthUnit, Rate, Stated, Up, load_marker_file
from selfmotion.errors import SelfmotionError
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    from collections.abc import Callable

    from selfmotion.capture.angles import ArmMotion
    from selfmotion.motion.markers import MarkerSet
    from selfmotion.motion.recording import Recording

Found = TypeVar("Found")

# So near to gimbal lock single angles of a sequence say little (degrees).
NEAR_LOCK_DEG = 10.0


class IsbEntry(Part, frozen=True, kw_only=True):
    """Angles after Wu et al. 2005 (degrees): least and largest of each over the movement.

    `shoulder_lock_deg` and `elbow_lock_deg` are the least distances from gimbal lock, where two
    axes of a sequence fall together; `share_near_lock` is the share of frames nearer than 10
    degrees to either, whose single angles say little. `written` is null without --out.
    """

    least_deg: dict[str, Number]
    largest_deg: dict[str, Number]
    shoulder_lock_deg: Number
    elbow_lock_deg: Number
    share_near_lock: Number
    written: str | None


class MovementAngles(Part, frozen=True, kw_only=True):
    """One marker file; lengths of time in frames, errors in mm, median over frames.

    `marker_error_mm` holds each landmark's distance from where it was seen; `share_at_limit` the
    joints that met a limit, with the share of frames. `written` is null without --out, `isb`
    without --isb.
    """

    file: str
    frames: int
    frames_without_markers: int
    frames_not_converged: int
    rms_marker_error_mm: Number
    marker_error_mm: dict[str, Number]
    elbow_disagreement_mm: Number
    share_at_limit: dict[str, float]
    swivel_start_deg: Number
    swivel_end_deg: Number
    written: str | None
    isb: IsbEntry | None
    status: str


class FailedFile(Part, frozen=True, kw_only=True):
    """A marker file that could not be used, and why."""

    file: str
    status: str


class AnglesDocument(Document, frozen=True, tag="selfmotion/angles/1", kw_only=True):
    """Joint angles of one arm of one person, in files; here how good they are.

    `centre_residual_mm`: how far apart two clusters see a joint centre (soft tissue).
    """

    arm: str
    side: str
    joints: list[str]
    lengths_mm: dict[str, float]
    rms_marker_error_mm: Number
    centre_residual_mm: dict[str, float]
    movements: list[MovementAngles]
    failed: list[FailedFile]


CONTRACT = Contract(
    AnglesDocument,
    ("angles", "examples/markers_drink.csv", "--static", "examples/markers_static.csv", "--json"),
)


def angles(
    markers: Annotated[
        list[Path],
        typer.Argument(metavar="MARKERS", help="Marker files (.c3d, .trc, Vicon .csv, BIDS)."),
    ],
    static: Annotated[
        Path, typer.Option("--static", metavar="FILE", help="Trial with all bony landmarks.")
    ],
    arm: Annotated[
        str, typer.Option("--arm", metavar="NAME|FILE", help="The arm that is fitted.")
    ] = "upper_limb_anatomical",
    side: Annotated[
        Literal["right", "left"], typer.Option("--side", help="The arm that moves, one a run.")
    ] = "right",
    protocol: Annotated[
        str, typer.Option("--protocol", metavar="NAME|FILE.toml", help="Which marker is what.")
    ] = "reaching",
    cutoff: Annotated[
        float, typer.Option("--cutoff", metavar="HZ", help="Low-pass of the markers; 0: none.")
    ] = 6.0,
    max_gap: Annotated[
        float, typer.Option("--max-gap", metavar="S", help="Longest gap that is bridged.")
    ] = 0.2,
    ranges: Annotated[
        Literal["adult", "arm"],
        typer.Option("--ranges", help="Joint limits: of adults, where known, or the arm's own."),
    ] = "adult",
    kind: Annotated[
        Literal["mot", "csv", "parquet"], typer.Option("--format", help="Of the files in --out.")
    ] = "mot",
    isb: Annotated[
        bool,
        typer.Option(
            "--isb",
            help="Also the angles of the ISB (Wu 2005), with their distance from gimbal lock.",
        ),
    ] = False,
    length_unit: LengthUnit = None,
    rate: Rate = None,
    up: Up = None,
    forward: Forward = None,
    json: Json = False,
    out: Out = None,
) -> int:
    """Find joint angles from markers: clusters, joint centres, inverse kinematics."""
    from selfmotion.capture.angles import angles_from_markers
    from selfmotion.capture.movement_check import check_movement
    from selfmotion.capture.moving_side import doubt_about_side
    from selfmotion.capture.person import CaptureOptions, calibrate_person
    from selfmotion.capture.protocol import load_protocol
    from selfmotion.provenance import hash_file
    from selfmotion.studies.trial_run import person_arm

    names = load_protocol(protocol)
    stated = Stated(length_unit, None, rate, up, forward)
    still = load_marker_file(static, stated, default=names.frame)
    failed: list[FailedFile] = []

    def read(path: Path) -> "MarkerSet":
        seen = load_marker_file(path, stated, default=names.frame)
        check_movement(still, seen, side=side, protocol=names)
        return seen

    recorded = {path: seen for path in markers if (seen := attempt(read, path, markers, failed))}
    person = calibrate_person(
        person_arm(arm, adult=ranges == "adult"),
        still,
        list(recorded.values()),
        side=side,
        protocol=names,
        options=CaptureOptions(max_gap=max_gap, cutoff=cutoff or None),
    )
    for seen in recorded.values():
        if doubt := doubt_about_side(seen, names, side):
            warnings.warn(doubt, stacklevel=2)
    movements = []
    for path in recorded:
        motion = attempt(lambda p: angles_from_markers(person, recorded[p]), path, markers, failed)
        if motion is None:
            continue
        target = None if out is None else write_angles(out, path, motion.recording, kind)
        table = None if out is None else out / f"{path.stem}_isb.csv"
        entry = isb_entry(motion, side, table) if isb else None
        movements.append(describe(path, motion, target, entry))
    choices = {"arm": arm, "side": side, "protocol": names.name, "cutoff_hz": cutoff or None}
    choices |= {"max_gap_s": max_gap, "ranges": ranges, "centres": person.options.centres}
    choices |= stated.choices()
    document = AnglesDocument(
        provenance=Provenance(
            "angles", inputs={p.name: hash_file(p) for p in [static, *recorded]}, choices=choices
        ),
        arm=person.arm.name,
        side=side,
        joints=list(person.arm.joints),
        lengths_mm={k: 1e3 * v for k, v in person.lengths.items()},
        rms_marker_error_mm=median([m.rms_marker_error_mm for m in movements]),
        centre_residual_mm={k: 1e3 * c.residual for k, c in person.centres.items()},
        movements=movements,
        failed=failed,
    )
    troubled = len(failed) + sum(m.frames_not_converged > 0 for m in movements)
    return finish(document, as_text(document), json=json, failed=troubled)


def attempt(
    work: "Callable[[Path], Found]", path: Path, paths: list[Path], failed: list[FailedFile]
) -> "Found | None":
    """Do something with one of several files; one that fails is put down, and the rest goes on.

    Raises:
        SelfmotionError: it was the last that could have been used.
    """
    try:
        return work(path)
    except SelfmotionError as error:
        if len(failed) + 1 >= len(paths):
            raise
        failed.append(FailedFile(file=str(path), status=str(error)))
        return None


def write_angles(folder: Path, source: Path, recording: "Recording", kind: str) -> Path:
    """Write angles beside each other in a folder, named like the marker files."""
    from selfmotion.motion.files.angles_csv import write_angles_csv
    from selfmotion.motion.files.parquet import write_parquet
    from selfmotion.motion.files.storage import write_mot

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{source.stem}_angles.{kind}"
    if kind == "mot":
        return write_mot(path, recording, unit="deg")
    if kind == "csv":
        return write_angles_csv(path, [recording])
    return write_parquet(path, [recording])


def isb_entry(motion: "ArmMotion", side: str, path: Path | None) -> IsbEntry:
    """Give the ranges of the ISB's angles and of their locks; write them over time if asked to."""
    import numpy as np

    from selfmotion.capture.isb import isb_angles
    from selfmotion.writing import write_whole

    found = isb_angles({k: f.path for k, f in motion.landmarks.items()}, motion.trunk, side=side)
    table = found.to_frame()
    table.insert(0, "time", motion.recording.time)
    if path is not None:
        write_whole(path, table.to_csv(index=False))
    known = table.drop(columns="time").dropna()
    values, names = known.to_numpy(), list(known.columns)
    empty = not len(values)
    low, high = (
        [np.nan] * len(names) if empty else pick(values, axis=0) for pick in (np.min, np.max)
    )
    least, largest = (dict(zip(names, numbers(ends), strict=True)) for ends in (low, high))
    locks = [least.pop("shoulder_lock_deg"), least.pop("elbow_lock_deg")]
    near = (values[:, -2:] < NEAR_LOCK_DEG).any(axis=1)
    return IsbEntry(
        least_deg=least,
        largest_deg={name: largest[name] for name in least},
        shoulder_lock_deg=locks[0],
        elbow_lock_deg=locks[1],
        share_near_lock=None if empty else float(near.mean()),
        written=None if path is None else str(path),
    )


def describe(
    path: Path, motion: "ArmMotion", target: Path | None, isb: IsbEntry | None
) -> MovementAngles:
    """Say how good the angles of one movement are."""
    import numpy as np

    ik = motion.ik
    unseen = np.isnan(ik.q[:, 0])
    at_limit = ik.at_limit.mean(axis=0)
    swivel = np.rad2deg(motion.swivel[np.isfinite(motion.swivel)])
    errors = numbers(1e3 * np.nanmedian(ik.error[~unseen], axis=0))
    return MovementAngles(
        file=str(path),
        frames=len(ik.q),
        frames_without_markers=int(unseen.sum()),
        frames_not_converged=int((~ik.converged & ~unseen).sum()),
        rms_marker_error_mm=float(1e3 * np.nanmedian(ik.rms)),
        marker_error_mm=dict(zip(ik.markers, errors, strict=True)),
        elbow_disagreement_mm=1e3 * motion.elbow_disagreement(),
        share_at_limit={j: float(s) for j, s in zip(ik.joints, at_limit, strict=True) if s > 0.0},
        swivel_start_deg=float(swivel[0]) if swivel.size else None,
        swivel_end_deg=float(swivel[-1]) if swivel.size else None,
        written=None if target is None else str(target),
        isb=isb,
        status=ik.status.sentence,
    )


def median(values: list[float | None]) -> float | None:
    """Give the median of the numbers that are there."""
    from statistics import median as middle

    known = [v for v in values if v is not None]
    return middle(known) if known else None


def as_text(document: AnglesDocument) -> str:
    """Write the quality as a person reads it."""
    lengths = ", ".join(f"{k} {v:.0f}" for k, v in document.lengths_mm.items())
    lines = [f"{document.arm}, {document.side} arm; lengths (mm): {lengths}"]
    for joint, residual in document.centre_residual_mm.items():
        lines.append(f"  {joint} centre: {residual:.1f} mm between its two clusters")
    for m in document.movements:
        lines.append(f"{m.file}: {m.rms_marker_error_mm:.1f} mm (rms landmark error); {m.status}")
        for joint, share in m.share_at_limit.items():
            lines.append(f"  {joint} at its limit in {100 * share:.0f} % of the frames")
        if m.isb and m.isb.share_near_lock is not None:
            lines.append(
                f"  ISB angles: {m.isb.shoulder_lock_deg:.0f} deg (shoulder) and "
                f"{m.isb.elbow_lock_deg:.0f} deg (elbow) from gimbal lock at the nearest; nearer "
                f"than {NEAR_LOCK_DEG:g} deg in {100 * m.isb.share_near_lock:.0f} % of the frames"
            )
        if m.isb and m.isb.written:
            lines.append(f"  wrote {m.isb.written}")
        if m.written:
            lines.append(f"  wrote {m.written}")
    lines += [f"not used: {one.file}: {one.status}" for one in document.failed]
    return "\n".join(lines)
