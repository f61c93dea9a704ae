"""Run all benchmarks, one after the other, and write docs/benchmarks.md.

    python benchmarks/run_all.py [--full] [--only NAME] [--out FILE.md] [--keep DIR]

Sizes are those of the table `RUNS` below: some ten minutes in all on two idle cores; ``--full``
takes those named in each benchmark's own help, an hour. `make benchmarks` does the same in the
environment of the Makefile, with the peers of `peers.txt` that can be installed there. A benchmark
or a peer that is not installed is left out, and the page says so. ``--keep DIR`` keeps the rows of
each benchmark as JSON and takes those that are there already, so that a run that was interrupted
goes on.
"""

import argparse
import datetime
import importlib.util
import os
import platform
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from forward_kinematics import hardware
from rows import Row, read_rows, version_of

HERE = Path(__file__).parent
ROOT = HERE.parent
PEOPLE = "examples/people"


@dataclass(frozen=True)
class Run:
    """How one benchmark is called.

    Attributes:
        name: of its file.
        quick: its options in the usual run.
        full: its options in the long run.
        needs: a package without which it cannot run.
    """

    name: str
    quick: tuple[str, ...]
    full: tuple[str, ...]
    needs: str = ""

    def command(self, full: bool) -> list[str]:
        """Give what a person would type."""
        return ["python", f"benchmarks/{self.name}.py", *(self.full if full else self.quick)]


IK_ON_PEOPLE = (PEOPLE, "--study", f"{PEOPLE}/study.toml", "--accuracy")
RUNS = (
    Run("forward_kinematics", ("--samples", "200000"), ("--samples", "1000000")),
    Run("identification", ("--quick",), ()),
    Run("passive_motion", ("--movements", "1000"), ("--movements", "10000")),
    Run("marker_ik", (*IK_ON_PEOPLE, "1e-5"), (*IK_ON_PEOPLE, "1e-5"), needs="opensim"),
    Run(
        "joint_limited_ik",
        ("--targets", "500", "--peer-targets", "8"),
        ("--targets", "2000", "--peer-targets", "200"),
    ),
    Run("workspace_volume", (), ("--seeds", "16", "--sample", "1000")),
    Run(
        "natural_posture",
        ("--poses", "15", "--published", "2", "--step", "0.2"),
        ("--poses", "1000", "--step", "0.05"),
    ),
)


@dataclass(frozen=True)
class Found:
    """What came of one benchmark: rows, peers that are not installed, or why there is nothing."""

    run: Run
    rows: list[Row]
    absent: list[str]
    problem: str = ""


def run_one(run: Run, *, full: bool, folder: Path) -> Found:
    """Run a benchmark in a process of its own, or take the rows of an earlier run."""
    kept = folder / f"{run.name}.json"
    if run.needs and importlib.util.find_spec(run.needs) is None:
        return Found(run, [], [], f"{run.needs} is not installed")
    if not kept.exists():
        command = [sys.executable, *run.command(full)[1:], "--rows", str(kept)]
        print("$", *run.command(full), flush=True)
        ended = subprocess.run(command, cwd=ROOT, check=False, stderr=subprocess.PIPE, text=True)
        if ended.returncode != 0:
            last = ended.stderr.strip().splitlines()[-1:] or [f"exit code {ended.returncode}"]
            return Found(run, [], [], f"failed: {last[0]}")
    return Found(run, *read_rows(kept))


def number(value: float) -> str:
    """Write three significant digits without an exponent."""
    if abs(value) < 1:
        return f"{value:.3g}"
    return f"{value:,.{max(0, 3 - len(str(int(abs(value)))))}f}"


def factor(ratio: float) -> str:
    """Write how many times as fast we are."""
    return f"{ratio:,.0f}" if ratio >= 10 else f"{ratio:.2g}"


def table(rows: list[Row]) -> list[str]:
    """Write the rows of one benchmark as Markdown."""
    lines = ["| case | beside | ours | theirs | unit | times as fast | and |"]
    lines.append("| --- | --- | ---: | ---: | --- | ---: | --- |")
    for row in rows:
        peer = row.peer + (f" ({row.peer_version})" if row.peer_version else "")
        numbers = f"{number(row.ours)} | {number(row.theirs)} | {row.unit} | {factor(row.ratio)}"
        lines.append(f"| {row.case} | {peer} | {numbers} | {row.note} |")
    return lines


HEAD = """# Benchmarks

`make benchmarks` runs everything in `benchmarks/` and writes this page; by hand
`python benchmarks/run_all.py`. Each benchmark runs ours and its peers in one run, on the same
inputs.

**Read the ratios, not the times.** The machine may be shared with others, so a time says little
about yours, while both sides of a ratio suffer alike. Times are those of the processor, of one
thread. Above 1, this library is faster. A peer written in Python pays for the interpreter at each
call, as its users do; libraries that solve a wider problem than ours are not slow for that reason
alone.
"""


def load_now() -> str:
    """Say how busy the machine is; nothing where the system does not tell."""
    return f", load {os.getloadavg()[0]:.1f} before it" if hasattr(os, "getloadavg") else ""


def page(found: list[Found], *, full: bool, load: str = "") -> str:
    """Write the whole page; `load` is that of the machine before the run."""
    today = datetime.date.today().isoformat()
    ours = ", ".join(version_of(name) for name in ("selfmotion", "numpy", "scipy", "numba"))
    lines = [HEAD, f"Run on {today}; {hardware()}{load}; {platform.system()}, Python "]
    lines[-1] += f"{platform.python_version()}; {ours}.\n"
    for one in found:
        title = one.rows[0].benchmark if one.rows else one.run.name.replace("_", " ").capitalize()
        lines += [f"## {title}\n", f"`{' '.join(one.run.command(full))}`\n"]
        lines += [*table(one.rows), ""] if one.rows else []
        if one.problem:
            lines += [f"Not run: {one.problem}.\n"]
        if one.absent:
            lines += [f"Left out, since not installed: {', '.join(one.absent)}.\n"]
    return "\n".join(lines).rstrip() + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--full", action="store_true", help="the sizes of each benchmark's help")
    parser.add_argument("--only", action="append", choices=[run.name for run in RUNS])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "benchmarks.md")
    parser.add_argument("--keep", type=Path, help="folder that keeps the rows")
    args = parser.parse_args()
    load = load_now()  # our own run is no part of it
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        chosen = [run for run in RUNS if not args.only or run.name in args.only]
        found = [run_one(run, full=args.full, folder=folder.resolve()) for run in chosen]
    args.out.write_text(page(found, full=args.full, load=load), encoding="utf-8")
    print(f"wrote {args.out}")


if __name__ == "__main__":
    main()
