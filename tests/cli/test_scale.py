"""Commands at scale: on processes and on a cluster as in one process; after `kill -9`, resumed."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from selfmotion.cli.app import main
from tests.cli.golden import ROOT, difference
from tests.cli.running import Capture, answered
from tests.studies.prediction_cases import planted

EXAMPLES = ROOT / "examples"
STUDY = ("weights", EXAMPLES / "study", "--study", EXAMPLES / "study" / "study.toml")
COMMANDS = {
    "posture": ("posture", EXAMPLES / "poses.csv"),
    "effort": ("effort", EXAMPLES / "postures.csv"),
    "ik": ("ik", EXAMPLES / "targets.csv"),
    "curvature": ("curvature", EXAMPLES / "reach.csv", "--arm", "exoskeleton"),
    "weights": (*STUDY, "--arm", "exoskeleton"),
    "workspace": ("workspace", "--map", "margin", "--map-step", "0.2", "--points", "64"),
}


@pytest.fixture(scope="module")
def scheduler():
    distributed = pytest.importorskip("distributed", reason="extra `scale` is not installed")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=50,
    ) as cluster:
        yield cluster.scheduler_address


QUICK = ("ik", "curvature")
SLOW = [pytest.param(n, marks=pytest.mark.long) for n in COMMANDS if n not in QUICK]


@pytest.mark.parametrize("name", [*QUICK, *SLOW])
def test_a_cluster_gives_what_one_process_gives(name: str, scheduler: str, capsys: Capture) -> None:
    alone = answered(capsys, *COMMANDS[name])
    spread = answered(capsys, *COMMANDS[name], "--scheduler", scheduler)
    assert difference(spread, alone) is None


@pytest.mark.parametrize("name", ["curvature", pytest.param("posture", marks=pytest.mark.long)])
def test_processes_give_what_one_process_gives(name: str, capsys: Capture) -> None:
    alone = answered(capsys, *COMMANDS[name])
    spread = answered(capsys, *COMMANDS[name], "--jobs", "2")
    assert difference(spread, alone) is None


@pytest.mark.long
def test_predict_gives_the_same_on_a_cluster(
    scheduler: str, tmp_path: Path, capsys: Capture
) -> None:
    planted(tmp_path)
    words = ("predict", tmp_path, "--study", tmp_path / "study.toml")
    alone = answered(capsys, *words)
    assert difference(answered(capsys, *words, "--scheduler", scheduler), alone) is None


KILLS_ITSELF = """
import os, signal, sys
from selfmotion.batch.journal import Journal
from selfmotion.cli.app import main
add, left = Journal.add, [{after}]
def add_or_die(self, item, outcome):
    add(self, item, outcome)
    left[0] -= 1
    if not left[0]:
        os.kill(os.getpid(), signal.SIGKILL)
Journal.add = add_or_die
main(sys.argv[1:])
"""


def killed_in_mid_run(words: tuple[object, ...], after: int) -> None:
    """Run a command that is killed (`kill -9`) when so many items are in its journal."""
    code = KILLS_ITSELF.format(after=after)
    ended = subprocess.run([sys.executable, "-c", code, *map(str, words), "--quiet"], check=False)
    assert ended.returncode == -signal.SIGKILL


def whole_files(folder: Path) -> dict[str, Any]:
    """Give the contents of all result files but the journal, without what tells the time."""
    files: dict[str, Any] = {}
    for path in sorted(folder.rglob("*")):
        if path.is_dir() or path.name.endswith(".journal.jsonl"):
            continue
        content: Any = path.read_bytes()
        if path.suffix == ".json":
            content = without_seconds(json.loads(content))
        files[path.relative_to(folder).as_posix()] = content
    return files


def without_seconds(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: without_seconds(v) for k, v in value.items() if k != "seconds"}
    return [without_seconds(v) for v in value] if isinstance(value, list) else value


@pytest.mark.parametrize(
    ("name", "after", "items"),
    [("posture", 2, 3), pytest.param("weights", 5, 24, marks=pytest.mark.long)],
)
def test_after_kill_9_resume_gives_the_same_files(
    name: str, after: int, items: int, tmp_path: Path, capsys: Capture
) -> None:
    words = COMMANDS[name]
    broken, whole = tmp_path / "broken", tmp_path / "whole"
    journal = broken / f"{name}.journal.jsonl"
    killed_in_mid_run((*words, "--out", broken), after)
    assert journal.read_bytes().count(b"\n") == after
    assert main([*map(str, words), "--out", str(broken), "--resume", "--quiet"]) == 0
    assert main([*map(str, words), "--out", str(whole), "--quiet"]) == 0
    capsys.readouterr()
    keys = [json.loads(line)["key"] for line in journal.read_text().splitlines() if line]
    assert len(keys) == len(set(keys)) == items  # nothing was done twice
    assert whole_files(broken) == whole_files(whole)
