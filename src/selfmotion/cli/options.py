"""Options that mean the same in every command, as types for a command's parameters.

A command takes those that apply to it: ``json: Json = False, out: Out = None``.
"""

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from selfmotion.errors import RangeError

Json: TypeAlias = Annotated[
    bool, typer.Option("--json", help="Print one JSON document on stdout and nothing else.")
]
Out: TypeAlias = Annotated[
    Path | None, typer.Option("--out", metavar="DIR", help="Write the result files here.")
]
Report: TypeAlias = Annotated[
    Path | None,
    typer.Option("--report", metavar="FILE.html", help="Write a report, self-contained."),
]
Jobs: TypeAlias = Annotated[
    int,
    typer.Option("--jobs", metavar="N", help="Items at once, one thread each; -1: every core."),
]
Scheduler: TypeAlias = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Run on this dask cluster instead."),
]
Resume: TypeAlias = Annotated[
    bool, typer.Option("--resume", help="Keep what an interrupted run has completed.")
]
StudyFile: TypeAlias = Annotated[
    Path | None,
    typer.Option("--study", metavar="FILE.toml", help="Recordings and their labels."),
]
Seed: TypeAlias = Annotated[
    int, typer.Option("--seed", metavar="S", min=0, help="Seed of everything random.")
]
Quiet: TypeAlias = Annotated[bool, typer.Option("--quiet", help="Show no progress.")]


def threads_for(jobs: int) -> int:
    """Give the number of threads that --jobs means.

    Raises:
        RangeError: it is neither -1 nor above 0.
    """
    if jobs < 1 and jobs != -1:
        raise RangeError(f"--jobs {jobs}: allowed is 1 and above, or -1 for every core")
    return jobs if jobs > 0 else os.cpu_count() or 1


def angles_by_name(option: str, texts: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Read ranges typed as ``joint=low:high`` in degrees; give them in radians.

    Args:
        option: how the option is called, for the message.
        texts: one for each time the option was given.

    Returns:
        Joint name to (low, high) in rad.

    Raises:
        RangeError: a text is not of that form, the range is empty, or a joint stands twice.

    Example:
        >>> angles_by_name("--limit", ["elbow_flexion=0:180"])
        {'elbow_flexion': (0.0, 3.141592653589793)}
    """
    ranges: dict[str, tuple[float, float]] = {}
    for text in texts:
        name, equals, span = text.partition("=")
        bounds = [_number(word) for word in span.split(":")]
        if not (name.strip() and equals and len(bounds) == 2 and all(map(math.isfinite, bounds))):
            raise RangeError(
                f"{option} {text!r}: write joint=low:high in degrees, as in elbow_flexion=64.2:114"
            )
        low, high = bounds
        if low > high:
            raise RangeError(f"{option} {text!r}: the low bound {low:g} is above the high {high:g}")
        if name.strip() in ranges:
            raise RangeError(f"{option} {text!r}: joint {name.strip()!r} already has a range")
        ranges[name.strip()] = (math.radians(low), math.radians(high))
    return ranges


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
