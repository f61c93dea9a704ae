"""What all benchmarks can hand on: rows of a table of ratios, as a JSON file.

Every benchmark takes ``--rows FILE`` beside its own options and writes there what it also prints;
``run_all.py`` makes the page of them.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


@dataclass(frozen=True)
class Row:
    """One comparison.

    Attributes:
        benchmark: its title.
        case: what was done, with its size.
        peer: beside whom.
        peer_version: package and version; empty where the peer is written out in the benchmark.
        ours, theirs: the two numbers.
        unit: of both; a rate ends in "/s", all else is a time.
        note: what belongs to the comparison: accuracy, share solved.
    """

    benchmark: str
    case: str
    peer: str
    peer_version: str
    ours: float
    theirs: float
    unit: str
    note: str = ""

    @property
    def ratio(self) -> float:
        """How many times as fast we are."""
        return self.ours / self.theirs if self.unit.endswith("/s") else self.theirs / self.ours


def version_of(package: str) -> str:
    """Give package and version, or say that it is absent."""
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"{package} absent"


def add_rows_option(parser: argparse.ArgumentParser) -> None:
    """Let a benchmark take ``--rows FILE``."""
    parser.add_argument("--rows", type=Path, help="write the ratios here too, as JSON")


def write_rows(path: Path | None, rows: Sequence[Row], absent: Sequence[str] = ()) -> None:
    """Write rows, and the peers that were left out; without a path, nothing."""
    if path is None:
        return
    listed = [{**asdict(row), "ratio": row.ratio} for row in rows]
    path.write_text(json.dumps({"rows": listed, "absent": list(absent)}, indent=1) + "\n")


def read_rows(path: Path) -> tuple[list[Row], list[str]]:
    """Read what a benchmark has written: rows, and the peers that were left out."""
    document = json.loads(path.read_text())
    fields = Row.__dataclass_fields__
    rows = [Row(**{k: v for k, v in row.items() if k in fields}) for row in document["rows"]]
    return rows, document["absent"]
