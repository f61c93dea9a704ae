"""How the levels of a MATLAB file (participant, condition, target, trial) become labels."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.mat_fields import is_motion, part_of
from selfmotion.motion.files.matlab import Tree
from selfmotion.motion.labels import Labels

ORDER = ("condition", "target", "trial")
# Names of lists, by what they count; the number in the list is the label.
LISTS = {
    "condition": re.compile(r"^cond(ition)?s?$"),
    "target": re.compile(r"^(targets?|tgts?|goals?)$"),
    "trial": re.compile(r"^(trials?|reps?|repetitions?|tr)$"),
}
# Names of single entries.
ENTRIES = {
    "condition": re.compile(r"natural|viscous|locked|coupled|assist|^cond(ition)?\d+$"),
    "target": re.compile(r"^(target|tgt|goal|t)(\d+)$"),
    "trial": re.compile(r"^(trial|rep|repetition|tr)(\d+)$"),
}
OWN_NAMES = ("name", "label", "condition", "id", "subject", "participant")


@dataclass(frozen=True, eq=False)
class Node:
    """Something found in the file, with the way to it."""

    path: tuple[str, ...]
    kind: str
    value: Tree


def walk(value: Tree, path: tuple[str, ...] = ()) -> Iterator[Node]:
    """Yield the movements, the authors' weights and the IK_data below a value.

    A path entry is a field's name, or ``#3`` for the third entry of a list.
    """
    if isinstance(value, list):
        for i, item in enumerate(value):
            own = own_name(item)
            yield from walk(item, (*path, own if own and len(value) > 1 else f"#{i + 1}"))
    elif isinstance(value, dict):
        if is_motion(value):
            yield Node(path, "motion", value)
        for name, item in value.items():
            part = part_of(name)
            if part == "ik_data" or (part == "weights" and not isinstance(item, dict | list)):
                yield Node((*path, name), part, item)
            elif part not in ("null", "jacobian"):
                yield from walk(item, (*path, name))
    elif any(part_of(step) == "weights" for step in path):
        yield Node(path, "weights", value)


def own_name(value: Tree) -> str | None:
    """Give the text by which a struct calls itself, if it does."""
    if not isinstance(value, dict):
        return None
    for name, item in value.items():
        if name.lower() in OWN_NAMES and isinstance(item, str) and item.strip():
            return item.strip()
    return None


def labels_of(path: tuple[str, ...], subject: str) -> Labels:
    """Turn the way to a movement into labels.

    Levels that are not named for what they count follow the documented order condition, target,
    trial, if that leaves no choice.

    Raises:
        FileFormatError: more levels than labels, or an unnamed level that could be two of them.
    """
    levels = _levels(path)
    if len(levels) > len(ORDER):
        raise FileFormatError(f"{'/'.join(path)}: {len(levels)} levels; at most 3 are known")
    kinds = [kind for kind, _ in levels]
    known = [kind for kind in kinds if kind is not None]
    if len(set(known)) < len(known):
        raise FileFormatError(f"{'/'.join(path)}: two levels look like {known[0]}")
    free = [kind for kind in ORDER if kind not in known]
    unnamed = kinds.count(None)
    if unnamed and unnamed != len(free):
        # One level alone, unnamed, below a participant is the condition (experiment 2).
        if len(levels) == 1:
            free = ["condition"]
        else:
            raise FileFormatError(
                f"{'/'.join(path)}: cannot tell whether a level counts {' or '.join(free)}"
            )
    labels = Labels(subject=subject)
    for kind, text in levels:
        labels = replace(labels, **{kind or free.pop(0): text})
    return labels


def _levels(path: tuple[str, ...]) -> list[tuple[str | None, str]]:
    """Part a path into levels, each with what it counts (None: not told) and its label."""
    levels: list[tuple[str | None, str]] = []
    awaiting: str | None = None  # the list whose number comes next
    for step in path:
        folded = re.sub(r"[^a-z0-9]", "", step.lower())
        if awaiting is not None:
            levels.append((awaiting, step.lstrip("#").lower()))
            awaiting = None
            continue
        awaiting = next((kind for kind, p in LISTS.items() if p.search(folded)), None)
        if awaiting is not None or folded in ("data", "movements", "recordings"):
            continue
        if part_of(step) in ("weights", "ik_data"):
            continue
        kind = next((k for k, p in ENTRIES.items() if p.search(folded)), None)
        number = re.search(r"(\d+)$", folded)
        text = number[1] if number and kind in ("target", "trial") else step.lstrip("#").lower()
        levels.append((kind, text))
    if awaiting is not None:  # MATLAB makes no list of one struct
        levels.append((awaiting, "1"))
    return levels
