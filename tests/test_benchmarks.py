"""The page of benchmarks: what a ratio means, what is left out, and that no benchmark is forgotten.

Nothing is timed here.
"""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
# Not benchmarks beside a peer: parts of them, the page's own script, and how cost grows.
OTHERS = {"rows", "run_all", "ik_peers", "scale"}


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module


def row(module, **changes):
    fields = {"benchmark": "Planning", "case": "10 movements", "peer": "SciPy"}
    fields |= {"peer_version": "scipy 1", "ours": 2.0, "theirs": 8.0, "unit": "ms", **changes}
    return module("rows").Row(**fields)


def test_a_ratio_says_how_many_times_as_fast_we_are(module) -> None:
    assert row(module).ratio == 4.0
    assert row(module, unit="million postures/s").ratio == 0.25


def test_rows_come_back_as_they_were_written(module, tmp_path: Path) -> None:
    rows, file = module("rows"), tmp_path / "r.json"
    rows.write_rows(file, [row(module, note="same answers")], ["JAX"])
    assert rows.read_rows(file) == ([row(module, note="same answers")], ["JAX"])


def test_every_benchmark_is_in_the_run(module) -> None:
    names = {path.stem for path in BENCHMARKS.glob("*.py")}
    assert {run.name for run in module("run_all").RUNS} == names - OTHERS


def test_every_benchmark_hands_on_rows() -> None:
    for path in BENCHMARKS.glob("*.py"):
        if path.stem not in OTHERS:
            text = path.read_text(encoding="utf-8")
            assert "add_rows_option(parser)" in text and "write_rows(" in text, path.name


def test_what_could_not_run_stands_on_the_page(module, tmp_path: Path) -> None:
    run_all = module("run_all")
    run = run_all.Run("nothing", (), (), needs="no_such_package")
    missing = run_all.run_one(run, full=False, folder=tmp_path)
    found = run_all.Found(run_all.RUNS[0], [row(module)], ["JAX"])
    text = run_all.page([found, missing], full=False)
    assert "| 10 movements | SciPy (scipy 1) | 2.00 | 8.00 | ms | 4 |" in text
    assert "Left out, since not installed: JAX." in text
    assert "Not run: no_such_package is not installed." in text


def test_help_says_how_to_run(tmp_path: Path) -> None:
    command = [sys.executable, str(BENCHMARKS / "run_all.py"), "--help"]
    said = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path).stdout
    assert "--full" in said and "--keep" in said
