"""How the cost grows with poses, muscles and people, and what a batch costs beside its work.

    python benchmarks/scale.py [--largest N] [--cluster]

Prints the numbers of docs/scale.md. Times are those of the processor (one thread), so that they
hold on a machine that others use too; only items a second are by the clock. ``--largest`` (default
80) is the largest number of poses, ``--cluster`` also runs a local dask cluster.
"""

import argparse
import json
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np

from forward_kinematics import hardware
from rows import version_of
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.batch import Item, Runner, iterate_batch
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import solve_ik
from selfmotion.methods.natural_posture import PostureFinder
from selfmotion.methods.reaching.ik_seeds import seed_table
from selfmotion.methods.reaching.ik_tasks import as_hand_rows
from selfmotion.muscles.static_optimization import EffortOptions, MuscleProblem, muscle_problem
from selfmotion.redundancy.task import Pose
from selfmotion.studies.people import load_people
from selfmotion.studies.study_file import load_study_file
from selfmotion.studies.study_run import StudyPlan, run_study

EXAMPLES = Path(__file__).parents[1] / "examples"
SPLITS = (1, 2, 4, 8)
PEOPLE = (1, 2, 4, 8)
ITEMS = 100_000
PAGE = 4096
LOCAL: dict[str, Any] = {
    "n_workers": 2,
    "threads_per_worker": 1,
    "dashboard_address": None,
    "silence_logs": logging.CRITICAL,
}


def seconds_of(work: Callable[[], object]) -> float:
    """Give processor time."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def growth(sizes: list[int], seconds: list[float]) -> float:
    """Give the exponent p of seconds ~ size**p, by least squares of the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def print_table(what: str, sizes: list[int], seconds: list[float]) -> None:
    for size, spent in zip(sizes, seconds, strict=True):
        print(f"  {size:>8,} {what:10} {spent:9.3f} s  {1e3 * spent / size:9.3f} ms each")
    print(f"  grows as {what}^{growth(sizes, seconds):.2f}")


def poses(largest: int) -> None:
    """Natural postures, and inverse kinematics of the same hand poses."""
    model = load_musculoskeletal_arm()
    arm, finder = model.arm, PostureFinder.of(model)
    q = arm.random_postures(100 * largest, np.random.default_rng(0))
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    finder.find(T[0])  # compiled before
    sizes = [max(1, largest // k) for k in (8, 4, 2, 1)]
    print("natural posture")
    ends = np.cumsum([0, *sizes])  # each size has poses of its own
    times = [
        seconds_of(lambda a=a, b=b: [finder.find(pose) for pose in T[a:b]])
        for a, b in zip(ends[:-1], ends[1:], strict=True)
    ]
    print_table("poses", sizes, times)
    task = Pose(arm)
    seeds = seed_table(as_hand_rows(task))
    solve_ik(task, T[:2], seeds=seeds)
    many = [100 * size for size in sizes]
    print("inverse kinematics, all in one call")
    print_table(
        "poses", many, [seconds_of(lambda k=k: solve_ik(task, T[:k], seeds=seeds)) for k in many]
    )


def split(problem: MuscleProblem, k: int) -> MuscleProblem:
    """Part each muscle into k strands, each with a k-th of its strength."""
    return MuscleProblem(
        np.repeat(problem.lengths, k, axis=1),
        np.repeat(problem.arms, k, axis=1),
        np.repeat(problem.strength, k, axis=1) / k,
        problem.torque,
    )


def muscles() -> None:
    """Lengths and moment arms, and the effort for them, of postures."""
    model, options = load_musculoskeletal_arm(), EffortOptions.of("plain")
    q = model.arm.random_postures(2000, np.random.default_rng(1))
    geometry = seconds_of(lambda: model.geometry.lengths_and_moment_arms(q))
    count = len(model.muscles.names)
    print(f"lengths and moment arms of {count} muscles: {1e3 * geometry / len(q):.3f} ms a posture")
    problem = muscle_problem(model, q, options)
    problem.solve(options)
    sizes = [k * count for k in SPLITS]
    parted = [split(problem, k) for k in SPLITS]
    times = [seconds_of(lambda p=p: p.solve(options)) for p in parted]
    print(f"effort of {len(q)} postures, muscles parted into strands")
    for size, spent in zip(sizes, times, strict=True):
        print(f"  {size:>8,} muscles    {1e6 * spent / len(q):9.0f} µs a posture")
    print(f"  grows as muscles^{growth(sizes, times):.2f}")


def copies(source: Path, folder: Path, count: int) -> None:
    """Copy the files of people under new names until there are so many people."""
    folder.mkdir()
    names = sorted({path.name.partition("_")[0] for path in source.glob("P*.csv")})
    for k in range(count):
        name = names[k % len(names)]
        for path in source.glob(f"{name}_*.csv"):
            rest = path.name.partition("_")[2]
            shutil.copy(path, folder / f"P{k + 1:0{len(name) - 1}d}_{rest}")


def people() -> None:
    """Markers to joint angles, and weights with their statistics, of studies that grow."""
    markers, angles = EXAMPLES / "people", EXAMPLES / "study"
    file_of = {source: load_study_file(source / "study.toml") for source in (markers, angles)}

    def work(source: Path, folder: Path) -> None:
        if source == markers:
            list(load_people([folder], file_of[source]))
        else:
            run_study(StudyPlan((folder,), file_of[source], "exoskeleton"))

    with tempfile.TemporaryDirectory() as scratch:
        for source, what in (
            (markers, "markers to angles, a static trial and two movements a person"),
            (angles, "weights with statistics, twelve movements a person"),
        ):
            times = []
            sizes = [n for n in PEOPLE if source == markers or n > 1]
            for n in [sizes[0], *sizes]:  # the first run compiles
                folder = Path(scratch, f"{source.name}{n}{len(times)}")
                copies(source, folder, n)
                times.append(seconds_of(lambda s=source, f=folder: work(s, f)))
            print(what)
            print_table("people", sizes, times[1:])


def tiny(payload: float) -> dict[str, list[float]]:
    """Do next to nothing."""
    return {"x": [payload] * 10}


def resident() -> float:
    """Give the memory that this process holds, MB; NaN where the system does not tell."""
    file = Path("/proc/self/statm")
    return int(file.read_text().split()[1]) * PAGE / 1e6 if file.exists() else float("nan")


def batches(with_cluster: bool) -> None:
    """What an item costs beside its work."""
    with tempfile.TemporaryDirectory() as scratch:
        runners = {"this process": Runner(), "2 processes": Runner(jobs=2)}
        print(f"a batch of {ITEMS:,} items that do nothing, with a journal")
        for name, runner in runners.items():
            overhead(name, runner, Path(scratch))
        if with_cluster:
            from distributed import LocalCluster  # pyright: ignore[reportMissingImports]

            cluster: Any = LocalCluster(**LOCAL)
            with cluster:
                runner = Runner(scheduler=cluster.scheduler_address)
                overhead("local cluster", runner, Path(scratch))


def overhead(name: str, runner: Runner, scratch: Path) -> None:
    def items() -> Iterator[Item]:
        for k in range(ITEMS):
            yield Item(str(k), float(k))

    journal = scratch / f"{name}.jsonl"
    chosen = Runner(runner.jobs, runner.scheduler, journal)
    next(iterate_batch(tiny, [Item("first", 0.0)], chosen))  # workers started
    before, begin = resident(), time.perf_counter()
    for _ in iterate_batch(tiny, items(), chosen):
        pass
    spent = time.perf_counter() - begin
    size = journal.stat().st_size
    print(
        f"  {name:14} {ITEMS / spent:9,.0f} items/s, {resident() - before:5.1f} MB more memory, "
        f"journal {size / ITEMS:.0f} bytes an item"
    )


def pose_bytes() -> None:
    """Size of what a pose leaves in the journal and in the document."""
    document = json.loads((EXAMPLES.parent / "docs/cli/posture.example.json").read_text())
    found = [len(json.dumps(pose)) for pose in document["poses"]]
    print(f"a pose takes {np.mean(found):,.0f} bytes in posture.json")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--largest", type=int, default=80)
    parser.add_argument("--cluster", action="store_true")
    args = parser.parse_args()
    packages = ("selfmotion", "numpy", "numba", "mujoco")
    print(f"{hardware()}, load {os.getloadavg()[0]:.1f};", ", ".join(map(version_of, packages)))
    poses(args.largest)
    pose_bytes()
    muscles()
    people()
    batches(args.cluster)


if __name__ == "__main__":
    main()
