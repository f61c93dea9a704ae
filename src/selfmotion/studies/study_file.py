r"""Which file is whose movement: the study file, a small TOML.

Example::

    pattern = '(?P<subject>P\d+)_(?P<condition>reach|drink)_(?P<side>[RL])(?P<trial>\d+)\.csv'
    static = "{subject}_static.csv"        # marker files only; beside the trial
    frame = {up = "z", forward = "y"}      # of the laboratory; else the protocol says

    [names.side]
    R = "right"
    L = "left"

`pattern` is a regular expression that a file's whole name must match; its named groups become the
labels subject, side, condition, target and trial. A study of marker files names the static trial
of each person; without `static` the files hold joint angles or velocities. A static trial is no
movement, even where the pattern fits its name. A table
``[moments.CONDITION]`` says where in a movement its moments are (see :mod:`.moments`)::

    [moments.drink]
    strokes = 4
    grasp = {stroke = 1, at = "end"}
    mid_drink = {between = [2, 3], at = "slowest"}
"""

import os
import re
import string
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

from selfmotion.capture.person import CaptureOptions
from selfmotion.capture.protocol import SIDES
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError, unknown_name
from selfmotion.motion.labels import LABEL_NAMES, UNKNOWN_FRAME, Frame, Labels
from selfmotion.studies.moments import ConditionMoments, read_moments


@dataclass(frozen=True)
class StudyFile:
    """How the files of a study are named and read.

    Attributes:
        pattern: regular expression of a trial's whole file name, with named groups for labels.
        static: name of the static trial beside a trial, with {subject} and so on; empty: the
            files hold joint angles.
        protocol: marker protocol, by name or TOML file.
        frame: axes of the laboratory; left out: those that the marker protocol states.
        names: label to what its values in file names stand for.
        cutoff: low-pass of markers, or of angles before differentiation (Hz); 0: none.
        task: what the movements are for, as in position or pose; empty: the arm's own kind.
        landmark: what is moved there: hand, or wrist, which leaves the wrist's joints out of a
            position task. Files that hold Jacobians bring their own task.
        rest_share: share of peak hand speed that counts as rest before and after the movement; 0:
            whole recordings are used.
        person_ranges: whether joint limits are those of the arm as it is (one person's) and not
            those of adults.
        centres: of the joints: functional (from the movements), or landmarks (middles of those in
            the static trial).
        moments: condition to the moments of its movements.
    """

    pattern: str
    static: str = ""
    protocol: str = "reaching"
    frame: Frame = UNKNOWN_FRAME
    names: Mapping[str, Mapping[str, str]] = field(default_factory=dict, hash=False)
    cutoff: float = 6.0
    task: str = ""
    landmark: str = "hand"
    rest_share: float = 0.05
    person_ranges: bool = False
    centres: str = "functional"
    moments: Mapping[str, ConditionMoments] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        """Check the pattern, the labels and the numbers."""
        try:
            groups = re.compile(self.pattern).groupindex
        except re.error as error:
            raise RangeError(f"pattern {self.pattern!r}: no regular expression ({error})") from None
        for name in (*groups, *self.names):
            if name not in LABEL_NAMES:
                raise unknown_name("label", name, LABEL_NAMES)
        if "subject" not in groups:
            raise RangeError(f"pattern {self.pattern!r}: needs a group (?P<subject>...)")
        _check_static(self.static, tuple(groups))
        if not 0.0 <= self.rest_share < 1.0:
            raise RangeError(f"rest_share = {self.rest_share:g}: allowed is 0 to below 1")
        CaptureOptions(centres=self.centres)  # refuses what it does not know
        if not self.cutoff >= 0.0:
            raise RangeError(f"cutoff = {self.cutoff:g} Hz: allowed is 0 (none) and above")

    @property
    def smoothing(self) -> float | None:
        """The low-pass (Hz), or None."""
        return self.cutoff or None


@dataclass(frozen=True)
class Trial:
    """One file of a study.

    Attributes:
        path: the file.
        key: its path below the study's folder, to name it by.
        labels: read from its name.
        static: the person's static trial; None where the files hold joint angles.
    """

    path: Path
    key: str
    labels: Labels
    static: Path | None


def load_study_file(path: str | Path) -> StudyFile:
    """Read a study file.

    Raises:
        FileFormatError: no file, no TOML, or a value of the wrong kind.
        UnknownNameError: a key or label that does not exist.
        RangeError: a value that is not allowed.

    Example:
        >>> import tempfile
        >>> where = Path(tempfile.mkdtemp(), "study.toml")
        >>> _ = where.write_text("pattern = '(?P<subject>P[0-9]+).csv'")
        >>> load_study_file(where).rest_share
        0.05
    """
    try:
        # Editors on Windows put a mark before the first line.
        table = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be opened ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML ({error})") from None
    known = tuple(f.name for f in fields(StudyFile))
    for key in table:
        if key not in known:
            raise unknown_name(f"key of {path}", key, known)
    if "pattern" not in table:
        raise FileFormatError(f"{path}: no pattern, which says how files are named")
    kinds = {"pattern": str, "static": str, "protocol": str, "frame": dict, "names": dict}
    kinds |= {"moments": dict}
    kinds |= {"task": str, "landmark": str, "centres": str}
    kinds |= {"cutoff": (int, float), "rest_share": (int, float), "person_ranges": bool}
    for key, value in table.items():
        if not isinstance(value, kinds[key]) or (isinstance(value, bool) and key[0] in "cr"):
            raise FileFormatError(f"{path}: {key} = {value!r}: wrong kind of value")
    values = dict(table)
    frame = table.get("frame", {})
    if not {*frame} <= {"up", "forward", "name"}:
        raise FileFormatError(f"{path}: frame takes up, forward and name, not {', '.join(frame)}")
    if frame:
        lacking = [word for word in ("up", "forward") if word not in frame]
        if lacking:
            raise FileFormatError(
                f"{path}: frame says nothing of {' and '.join(lacking)}; as in "
                'frame = {up = "z", forward = "y"}'
            )
        values["frame"] = Frame(**frame)
    else:
        values.pop("frame", None)
    for label, meanings in table.get("names", {}).items():
        if not isinstance(meanings, dict) or not all(map(_is_text, meanings.values())):
            raise FileFormatError(f"{path}: names.{label}: a table of texts is needed")
    try:
        values["moments"] = read_moments(table.get("moments", {}))
    except SelfmotionError as error:
        raise type(error)(f"{path}: {error}") from None
    protocol = values.get("protocol", "")
    if protocol.endswith(".toml"):  # named from where the study file is
        values["protocol"] = str(Path(path).parent / protocol)
    return StudyFile(**values)


def find_trials(study: StudyFile, folders: Sequence[Path]) -> tuple[Trial, ...]:
    """List the trials in folders and below, ordered by subject, side and name.

    A file that is somebody's static trial is none.

    Raises:
        FileFormatError: a folder does not exist, or nothing in it is named as the pattern says.
        RangeError: a side is neither right nor left, or two trials have the same place.
    """
    found: list[Trial] = []
    for folder in folders:
        if not folder.is_dir():
            raise FileFormatError(f"{folder}: no such folder; a study is a folder of recordings")
        # A link to nothing counts: it is reported as a file that cannot be read.
        files = sorted(p for p in folder.rglob("*") if not p.is_dir())
        found += [trial for path in files if (trial := _trial(study, folder, path)) is not None]
    where = ", ".join(map(str, folders))
    if not found:
        raise FileFormatError(f"{where}: no file is named as the pattern {study.pattern!r} says")
    still = {os.path.abspath(trial.static) for trial in found if trial.static is not None}
    moving = [trial for trial in found if os.path.abspath(trial.path) not in still]
    if not moving:
        raise FileFormatError(
            f"{where}: every file that the pattern {study.pattern!r} fits is a static trial "
            f"(static = {study.static!r})"
        )
    _refuse_same_place(moving)
    order = [(str(t.labels.subject), str(t.labels.side), t.key) for t in moving]
    return tuple(trial for _, trial in sorted(zip(order, moving, strict=True), key=lambda p: p[0]))


def unused_moments(study: StudyFile, trials: Sequence[Trial]) -> tuple[str, ...]:
    """Say of which conditions moments are named that no trial has: misspelt, or not recorded.

    Example:
        >>> rules = {"Drink": ConditionMoments()}
        >>> study = StudyFile("(?P<subject>P1)_(?P<condition>drink).csv", moments=rules)
        >>> trial = Trial(Path("P1_drink.csv"), "P1_drink.csv", Labels("P1", None, "drink"), None)
        >>> unused_moments(study, [trial])
        ('moments.Drink: no file has this condition (there are: drink)',)
    """
    there = sorted({trial.labels.condition or "none" for trial in trials})
    return tuple(
        f"moments.{name}: no file has this condition (there are: {', '.join(there)})"
        for name in study.moments
        if name not in there
    )


def _trial(study: StudyFile, folder: Path, path: Path) -> Trial | None:
    """Read a file's labels from its name; None where the pattern does not fit."""
    match = re.fullmatch(study.pattern, path.name)
    if match is None:
        return None
    given = {k: v for k, v in match.groupdict().items() if v is not None}
    named = {k: study.names.get(k, {}).get(v, v) for k, v in given.items()}
    if named.get("side", "right") not in SIDES:
        raise RangeError(
            f"{path}: side {named['side']!r}; allowed are right, left (the study file's "
            "[names.side] says what letters stand for)"
        )
    static = None
    if study.static:
        # A group that took no part in the match stands for nothing.
        parts = {name: given.get(name, "") for name in match.groupdict()}
        static = path.parent / study.static.format_map(parts)
    return Trial(path, path.relative_to(folder).as_posix(), Labels(**named), static)


def _refuse_same_place(trials: Sequence[Trial]) -> None:
    """Refuse trials of several folders that have one name: their results would be one file."""
    seen: dict[str, Path] = {}
    for trial in trials:
        if trial.key in seen:
            raise RangeError(
                f"{trial.path} and {seen[trial.key]} are both {trial.key} in their folders; give "
                "the folder above, or one folder once"
            )
        seen[trial.key] = trial.path


def _check_static(static: str, groups: tuple[str, ...]) -> None:
    """Check that the name of the static trial takes nothing but the pattern's groups.

    Raises:
        RangeError: it cannot be filled in.
    """
    example = 'as in "{subject}_static.csv"'
    try:
        parts = list(string.Formatter().parse(static))
    except ValueError as error:
        raise RangeError(f"static = {static!r}: {error}; {example}") from None
    for _, name, form, conversion in parts:
        if name is not None and (name not in groups or form or conversion):
            raise RangeError(
                f"static = {static!r}: {{{name}}} is no group of the pattern (there are: "
                f"{', '.join(groups)}); {example}"
            )
    if not static.isprintable() or Path(static).is_absolute():
        raise RangeError(f"static = {static!r}: a file beside the trial, {example}")


def _is_text(value: object) -> bool:
    return isinstance(value, str)
