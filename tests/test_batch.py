"""Batches: order, failures, interruption and resumption, dead workers, a real dask cluster."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from selfmotion.batch import Item, Outcome, Runner, iterate_batch, run_batch
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


@pytest.fixture(scope="module")
def scheduler():
    """A cluster of two processes that gives an item up with the second worker it has killed."""
    distributed = pytest.importorskip("distributed", reason="extra `scale` is not installed")
    import dask.config

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            silence_logs=50,
        ) as cluster,
    ):
        yield cluster.scheduler_address


@pytest.fixture(params=["processes", "cluster"])
def runner(request):
    if request.param == "processes":
        return Runner(jobs=2)
    return Runner(scheduler=request.getfixturevalue("scheduler"))


def slow_square(payload):
    time.sleep(0.02)
    return {"square": payload**2, "pid": os.getpid()}


def deadly(payload):
    if payload == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": payload**2}


def test_dask_cluster_gives_the_same(scheduler):
    outcomes = run_batch(root, items(4, 9), Runner(scheduler=scheduler))
    assert [o.result for o in outcomes] == [{"root": 2.0}, {"root": 3.0}]


def test_a_killed_worker_costs_nothing(runner, tmp_path):
    told: list[Outcome] = []
    killed: list[int] = []

    def kill_once(outcome):
        told.append(outcome)
        if len(told) == 6:
            killed.append(outcome.result["pid"])
            os.kill(killed[0], signal.SIGKILL)

    journal = tmp_path / "journal.jsonl"
    chosen = replace(runner, journal=journal, on_done=kill_once)
    outcomes = run_batch(slow_square, items(*range(80)), chosen)
    assert [o.result["square"] if o.result else o.status for o in outcomes] == [
        k**2 for k in range(80)
    ]
    assert len(told) == 80  # each exactly once
    assert len({json.loads(line)["key"] for line in journal.read_text().splitlines()}) == 80
    after = {o.result["pid"] for o in told[20:] if o.result}
    assert killed and killed[0] not in after


def test_an_item_that_kills_its_worker_is_the_only_one_that_fails(runner):
    outcomes = run_batch(deadly, items(*range(8)), runner)
    assert [o.result for o in outcomes if o.key != "n3"] == [
        {"square": k**2} for k in range(8) if k != 3
    ]
    assert not outcomes[3].status and "worker process died" in outcomes[3].status.sentence


def test_items_are_taken_when_there_is_a_free_worker(runner):
    taken: list[int] = []

    def numbers():
        for k in range(10_000):
            taken.append(k)
            yield Item(str(k), float(k))

    stream = iterate_batch(slow_square, numbers(), runner)
    first = next(stream)
    assert first.result is not None and len(taken) < 20
    stream.close()


def test_a_scheduler_that_does_not_answer_is_one_line():
    pytest.importorskip("distributed", reason="extra `scale` is not installed")
    with pytest.raises(RangeError, match="'nowhere': no answer"):
        run_batch(root, items(4), Runner(scheduler="nowhere"))


def dask_process(*words: str) -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
    return subprocess.Popen(command, stderr=subprocess.DEVNULL)


@pytest.mark.long
def test_a_scheduler_that_is_lost_is_one_line_and_the_journal_stays(tmp_path, capfd):
    pytest.importorskip("distributed", reason="extra `scale` is not installed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    scheduler = dask_process("scheduler", "--port", address.rpartition(":")[2])
    worker = dask_process("worker", address, "--no-nanny", "--nthreads", "1")
    told: list[Outcome] = []

    def kill_once(outcome):
        told.append(outcome)
        if len(told) == 6:
            scheduler.kill()

    try:
        wait_for_workers(address)
        runner = Runner(scheduler=address, journal=tmp_path / "j.jsonl", on_done=kill_once)
        with pytest.raises(RangeError, match="lost in mid-run"):
            run_batch(slow_square, items(*range(1000)), runner)
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()
    kept = [json.loads(line)["key"] for line in (tmp_path / "j.jsonl").read_text().splitlines()]
    assert kept == [outcome.key for outcome in told] and len(kept) >= 6
    assert "Traceback" not in capfd.readouterr().err


def wait_for_workers(address):
    from distributed import Client

    with Client(address, timeout="60s", set_as_default=False) as client:
        client.wait_for_workers(1, timeout=60)


MEMORY = """
import sys
from pathlib import Path
from selfmotion.batch import Item, Runner, iterate_batch
jobs, journal, resume = int(sys.argv[1]), Path(sys.argv[2]), sys.argv[3] == "resume"
def tiny(x):
    return {"x": [x] * 40}
def resident():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6
numbers = (Item(str(k), k) for k in range(100_000))
runner = Runner(jobs=jobs, journal=journal, resume=resume)
for count, outcome in enumerate(iterate_batch(tiny, numbers, runner), start=1):
    if count in (10_000, 100_000):
        print(count, resident())
"""


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
@pytest.mark.parametrize("jobs", [1, 2])
def test_memory_stays_flat_over_a_hundred_thousand_items(jobs, tmp_path):
    """To hold the results, 40 numbers each, takes 80 MB; the keys take 10 MB."""
    for resume in ("anew", "resume"):
        command = [sys.executable, "-c", MEMORY, str(jobs), str(tmp_path / "j.jsonl"), resume]
        lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        few, many = float(lines[1]), float(lines[3])
        assert (lines[0], lines[2]) == ("10000", "100000")
        assert many - few < 25.0  # MB


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_memory_stays_flat_with_a_real_method(tmp_path):
    code = REAL.format(journal=str(tmp_path / "j.jsonl"))
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    few, many = map(float, run.stdout.split())
    assert many - few < 25.0  # MB


REAL = """
from pathlib import Path
import numpy as np
from selfmotion.arms import load_arm
from selfmotion.batch import Item, Runner, iterate_batch
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.reaching.ik_seeds import seed_table
from selfmotion.methods.reaching.ik_tasks import as_hand_rows
from selfmotion.redundancy.task import Position
arm = load_arm("upper_limb")
task, rng = Position(arm), np.random.default_rng(0)
seeds = seed_table(as_hand_rows(task))
def solve(target):
    return {{"q": solve_ik(task, np.array(target)[None], seeds=seeds).q[0].tolist()}}
def goals():
    for k in range(20):
        T = forward_kinematics(arm.chain, arm.random_postures(100, rng), arm.tip("hand"))
        yield from (Item(str(100 * k + i), x.tolist()) for i, x in enumerate(T[:, :3, 3]))
for count, outcome in enumerate(iterate_batch(solve, goals(), Runner(journal=Path({journal!r})))):
    assert outcome.status, outcome
    if count + 1 in (500, 2000):
        print(int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6)
"""
