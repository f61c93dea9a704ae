"""Joint-limited inverse kinematics beside its peers, on the same targets in one process.

    python benchmarks/joint_limited_ik.py [--targets 500]

The 9-DoF arm of [DeBoon], elbow free and splinted; random reachable targets; starts from rest,
mid-range and at random. A target counts as solved at 0.01 mm (and 0.001 rad) with no limit
violated. Peers run with a single start and with 20 random restarts; those that are not installed
are left out. Times are those of the processor. Peers in Python pay for the interpreter: ratios say
what a user would see.
"""

import argparse
import platform
import time
from dataclasses import replace
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from forward_kinematics import hardware
from ik_peers import (
    One,
    mink_solver,
    mujoco_solver,
    optik_solver,
    pink_solver,
    pinocchio_solver,
    scipy_solver,
)
from rows import Row, add_rows_option, version_of, write_rows
from selfmotion.arms import load_arm
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
from selfmotion.methods.reaching.ik_seeds import seed_table
from selfmotion.methods.reaching.ik_tasks import as_hand_rows
from selfmotion.redundancy.task import Pose, Position
from selfmotion.spatial import log_rotation

SPLINT = {"elbow_flexion": (np.deg2rad(64.2), np.deg2rad(114.0))}
REST = np.deg2rad([0, 0, 0, 90, 0, 20, 0, 0, 0.0])
NAMES = ("selfmotion", "numpy", "scipy", "numba", "mujoco", "pin", "pin-pink", "mink", "optik-py")
NEAR, TURNED, WITHIN = 1e-5, 1e-3, 1e-9


def missing(arm: Arm, q: np.ndarray, T: np.ndarray, pose: bool) -> np.ndarray:
    """Tell which targets are missed, measured by one rule for everybody."""
    found = forward_kinematics(arm.chain, q, arm.tip("hand"))
    missed = np.linalg.norm(found[:, :3, 3] - T[:, :3, 3], axis=1) > NEAR
    if pose:
        turn = log_rotation(T[:, :3, :3] @ np.swapaxes(found[:, :3, :3], 1, 2))
        missed |= np.linalg.norm(turn, axis=1) > TURNED
    missed |= ((q < arm.lower - WITHIN) | (q > arm.upper + WITHIN)).any(axis=1)
    return missed


PACKAGES = {
    "scipy": "scipy",
    "mujoco least squares": "mujoco",
    "pin": "pin",
    "pink": "pin-pink",
    "mink": "mink",
    "optik": "optik-py",
}


def peers(arm: Arm, pose: bool, restarts: int) -> dict[str, One]:
    """Give those that are installed; only optik restarts by itself."""
    builders = {
        "scipy": scipy_solver,
        "mujoco least squares": mujoco_solver,
        "pin": pinocchio_solver,
        "pink": pink_solver,
        "mink": mink_solver,
        "optik": partial(optik_solver, restarts=restarts),
    }
    found: dict[str, One] = {}
    for name, build in builders.items():
        try:
            found[name] = build(arm, pose)
        except ImportError:
            continue
    return found


def run_peer(one: One, arm: Arm, T: np.ndarray, starts: np.ndarray, restarts: int, pose: bool):
    """Solve one target after the other; give seconds a target and the share solved."""
    rng, q = np.random.default_rng(0), starts.copy()
    begin = time.process_time()
    for k in range(len(T)):
        for attempt in range(restarts + 1):
            start = starts[k] if attempt == 0 else arm.random_postures(1, rng)[0]
            q[k] = one(T[k], start)
            if not missing(arm, q[k : k + 1], T[k : k + 1], pose)[0]:
                break
    seconds = (time.process_time() - begin) / len(T)
    return seconds, 1.0 - missing(arm, q, T, pose).mean()


def run_ours(arm: Arm, T: np.ndarray, starts: np.ndarray, options: IkOptions, pose: bool):
    """Solve all targets in one call, on one thread; give seconds a target and the share solved."""
    task = Pose(arm) if pose else Position(arm)
    target = T if pose else T[:, :3, 3]
    seeds = seed_table(as_hand_rows(task))
    solve_ik(task, target, start=starts, seeds=seeds, options=options)  # compiled before
    seconds, q = np.inf, starts
    for _ in range(3):
        begin = time.process_time()
        q = solve_ik(task, target, start=starts, seeds=seeds, options=options).q
        seconds = min(seconds, (time.process_time() - begin) / len(T))
    return seconds, 1.0 - missing(arm, q, T, pose).mean()


def compared(case: str, ours: tuple[float, float], found: dict[str, tuple[float, float]]):
    """Give the rows of the peers with restarts, which solve about as many as we do."""
    rows = []
    for label, (seconds, solved) in found.items():
        name, _, kind = label.partition(", ")
        if kind != "20 restarts":
            continue
        note = f"solved: ours {100 * ours[1]:.1f} %, theirs {100 * solved:.1f} %"
        times = 1e6 * ours[0], 1e6 * seconds
        peer = f"{name}, 20 restarts"
        title, release = "Joint-limited inverse kinematics", version_of(PACKAGES[name])
        rows.append(Row(title, case, peer, release, *times, "µs", note))
    return rows


def scenario(
    arm: Arm, pose: bool, n_targets: int, n_peer: int, rng: np.random.Generator
) -> dict[str, list[Row]]:
    T = forward_kinematics(arm.chain, arm.random_postures(n_targets, rng), arm.tip("hand"))
    rest = np.clip(REST, arm.lower, arm.upper)
    kinds = {
        "rest": np.tile(rest, (n_targets, 1)),
        "mid-range": np.tile(arm.middle(), (n_targets, 1)),
        "random": arm.random_postures(n_targets, rng),
    }
    comparisons = {}
    published = IkOptions(scheme="published", max_iterations=500, position_tolerance=5e-6)
    for kind, starts in kinds.items():
        ours = run_ours(arm, T, starts, IkOptions(), pose)
        rows = {
            "selfmotion": ours,
            "selfmotion, one start": run_ours(arm, T, starts, IkOptions(restarts=0), pose),
            "published scheme": run_ours(arm, T, starts, published, pose),
        }
        for restarts in (0, 20):
            few, begin = T[:n_peer], starts[:n_peer]
            for name, one in peers(arm, pose, restarts).items():
                label = f"{name}, {'one start' if restarts == 0 else '20 restarts'}"
                again = 0 if name == "optik" else restarts
                rows[label] = run_peer(one, arm, few, begin, again, pose)
        print(f"\n{'pose' if pose else 'position'}, from {kind}")
        for name, (seconds, solved) in rows.items():
            print(
                f"  {name:28s} solved {100 * solved:6.2f} %  {1e6 * seconds:9.1f} us a target"
                f"  {seconds / ours[0]:7.1f} times ours"
            )
        comparisons[kind] = compared(f"a {'pose' if pose else 'position'}, from {kind}", ours, rows)
    return comparisons


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--targets", type=int, default=2000)
    parser.add_argument("--peer-targets", type=int, default=200)
    add_rows_option(parser)
    args = parser.parse_args()
    found, absent = [], []
    print(hardware(), platform.python_version())
    for name in NAMES:
        try:
            print(f"  {name} {version(name)}")
        except PackageNotFoundError:
            print(f"  {name} is not installed")
            absent.append(name)
    rng = np.random.default_rng(0)
    free = load_arm("upper_limb")
    for label, arm in (("elbow free", free), ("elbow splinted", free.with_limits(SPLINT))):
        print(f"\n== {label}")
        for pose in (False, True):
            made = scenario(arm, pose, args.targets, args.peer_targets, rng)
            found += [replace(row, case=f"{row.case}, {label}") for row in made["mid-range"]]
    write_rows(args.rows, found, absent)


if __name__ == "__main__":
    main()
