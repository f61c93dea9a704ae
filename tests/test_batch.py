"""Batches: order, failures, processes, interruption and resumption, a real dask cluster."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from selfmotion.batch import Item, Runner, run_batch
from selfmotion.errors import RangeError


def root(payload):
    if payload < 0:
        raise RangeError(f"payload = {payload}: allowed is 0 and above")
    return {"root": payload**0.5}


def defect(payload):
    return {"x": 1 / payload}


def items(*numbers):
    return [Item(f"n{n}", n, fingerprint=str(n)) for n in numbers]


@pytest.mark.parametrize("jobs", [1, 2])
def test_outcomes_keep_the_order_and_failures_stay_alone(jobs):
    seen = []
    outcomes = run_batch(root, items(4, -1, 9), Runner(jobs=jobs, on_done=seen.append))
    assert [o.key for o in outcomes] == ["n4", "n-1", "n9"]
    assert [o.result for o in outcomes] == [{"root": 2.0}, None, {"root": 3.0}]
    assert outcomes[1].status.sentence == "payload = -1: allowed is 0 and above"
    assert len(seen) == 3


def test_a_defect_is_reported_not_raised():
    (outcome,) = run_batch(defect, items(0), Runner())
    assert outcome.status.sentence.startswith("internal error: ZeroDivisionError")


def test_double_keys_are_refused():
    with pytest.raises(RangeError, match="'n1' stands twice"):
        run_batch(root, items(1, 1), Runner())


def test_wrong_number_of_jobs_is_refused():
    with pytest.raises(RangeError, match="jobs = 0"):
        Runner(jobs=0)


def test_resume_takes_what_is_there_and_does_the_rest(tmp_path):
    journal = tmp_path / "journal.jsonl"
    run_batch(root, items(4, -1), Runner(journal=journal))
    text = journal.read_text()
    journal.write_text(text + '{"key": "n9", "fing')  # cut off by a crash
    again = run_batch(defect, items(4, 16), Runner(journal=journal, resume=True))
    assert again[0].result == {"root": 2.0}  # from the journal: `defect` was not asked
    assert again[1].result == {"x": 1 / 16}
    whole = run_batch(defect, items(4, 16), Runner(journal=journal, resume=True))
    assert [o.result for o in whole] == [o.result for o in again]


def test_resume_does_not_take_what_was_made_from_other_input(tmp_path):
    journal = tmp_path / "journal.jsonl"
    run_batch(root, [Item("a", 4.0, "old")], Runner(journal=journal))
    (outcome,) = run_batch(root, [Item("a", 9.0, "new")], Runner(journal=journal, resume=True))
    assert outcome.result == {"root": 3.0}


KILLED = """
import sys, time
sys.path.insert(0, {here!r})
from pathlib import Path
from selfmotion.batch import Item, Runner, run_batch
def slow(x):
    time.sleep(0.05)
    return {{"x": x}}
run_batch(slow, [Item(str(i), i) for i in range(200)], Runner(journal=Path({journal!r})))
"""


def test_killed_run_loses_nothing_that_was_complete(tmp_path):
    journal = tmp_path / "journal.jsonl"
    code = KILLED.format(here=str(Path(__file__).parent), journal=str(journal))
    process = subprocess.Popen([sys.executable, "-c", code])
    while not journal.exists() or journal.read_text().count("\n") < 3:
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    complete = [json.loads(line)["key"] for line in journal.read_text().splitlines()]
    resumed = run_batch(
        lambda x: {"x": x},
        [Item(str(i), i) for i in range(200)],
        Runner(journal=journal, resume=True),
    )
    assert complete == [str(i) for i in range(len(complete))]
    assert [o.result for o in resumed] == [{"x": i} for i in range(200)]


def test_dask_cluster_gives_the_same(tmp_path):
    distributed = pytest.importorskip("distributed", reason="extra `scale` is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        runner = Runner(scheduler=cluster.scheduler_address)
        assert [o.result for o in run_batch(root, items(4, 9), runner)] == [
            {"root": 2.0},
            {"root": 3.0},
        ]
