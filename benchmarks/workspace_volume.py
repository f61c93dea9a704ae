"""Volume of a workspace: how fast, how certain, and beside what else one might do.

    python benchmarks/workspace_volume.py [--points 8192] [--seeds 4] [--rows FILE]

The 9-DoF arm of [DeBoon], free and with the elbow splinted, in one call. Points are decided once
more by SciPy's bounded least squares from three random starts; the last columns say how often the
two disagree and by how much. The hull of random postures, the usual estimate, is given as many of
them as its time allows.
"""

import argparse
import platform
import time
from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial import ConvexHull

from forward_kinematics import hardware
from rows import Row, add_rows_option, version_of, write_rows
from selfmotion.arms import load_arm
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.fast_position import positions
from selfmotion.methods.workspace import Workspace, WorkspaceOptions, workspace
from selfmotion.redundancy.task import Position

SPLINT = {"elbow_flexion": (np.deg2rad(64.2), np.deg2rad(114.0))}
STARTS, NEAR = 3, 1e-5


def timed(
    arm: Arm, limited: Arm, options: WorkspaceOptions, seed: int
) -> tuple[Workspace, float, float]:
    """Give a workspace, seconds by the clock, and processor seconds."""
    begin, spent = time.perf_counter(), time.process_time()
    found = workspace(arm, limited=limited, options=options, rng=np.random.default_rng(seed))
    return found, time.perf_counter() - begin, time.process_time() - spent


def by_scipy(arm: Arm, points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Give how near SciPy comes to points (m), and processor seconds for one of them."""
    task, begin = Position(arm), time.process_time()
    near = np.full(len(points), np.inf)
    for i, point in enumerate(points):
        for start in arm.random_postures(STARTS, rng):
            fit = least_squares(
                lambda q, x=point: task.error(q, x)[0],
                start,
                jac=lambda q: -task.jacobian(q)[0],  # pyright: ignore[reportArgumentType]
                bounds=(arm.lower, arm.upper),
            )
            near[i] = min(near[i], float(np.linalg.norm(fit.fun)))
            if near[i] < NEAR:
                break
    return near, (time.process_time() - begin) / len(points)


def spread(found: Sequence[Workspace], name: str) -> str:
    """Say volume, stated error and scatter over seeds."""
    volumes = np.array([w.regions[name].volume for w in found])
    stated = np.array([w.regions[name].standard_error for w in found])
    mean = volumes.mean()
    scatter = volumes.std(ddof=1) if len(found) > 1 else np.nan
    rms = np.sqrt((stated**2).mean())
    return (
        f"{name:8s} {1e3 * mean:8.2f} litres, standard error {100 * rms / mean:.3f} %, at most "
        f"{100 * stated.max() / mean:.3f} %, scatter over seeds {100 * scatter / mean:.3f} %"
    )


def hull_of_random(arm: Arm, seconds: float, rng: np.random.Generator) -> tuple[int, float]:
    """Give the hull of as many random postures as fit into the time."""
    n, begin, volume = 1024, time.process_time(), 0.0
    while time.process_time() - begin < seconds:
        n *= 4
        q = arm.random_postures(n, rng)
        volume = ConvexHull(positions(arm.chain, q, arm.tip("hand"))).volume
    return n, float(volume)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=8192, help="of one of eight shifts")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--sample", type=int, default=100, help="points that SciPy decides, too")
    add_rows_option(parser)
    args = parser.parse_args()
    print(hardware(), platform.python_version(), version_of("scipy"), sep="\n")
    arm, rng = load_arm("upper_limb"), np.random.default_rng(0)
    splinted = arm.with_limits(SPLINT)
    options = WorkspaceOptions(n_points=args.points, threads=2)
    workspace(arm, limited=splinted, options=WorkspaceOptions(n_points=256))  # compiled before
    runs = [timed(arm, splinted, options, seed) for seed in range(args.seeds)]
    found, walls, spent = zip(*runs, strict=True)
    wall, processor = min(walls), min(spent)
    print(f"free and limited, two threads: {wall:.2f} s by the clock, {processor:.2f} s processor")
    for name in ("free", "limited", "lost"):
        print(spread(found, name))
    regions = found[0].regions
    assert not (regions["limited"].inside & ~regions["free"].inside).any()

    limited = regions["limited"]
    some = rng.choice(len(limited.points), args.sample, replace=False)
    near, each = by_scipy(splinted, limited.points[some], rng)
    reached = limited.inside[some]
    only_scipy, only_ours = ~reached & (near < NEAR), reached & (near >= NEAR)
    print(f"SciPy, {STARTS} starts: {1e3 * each:.1f} ms a point; reached by SciPy alone ", end="")
    print(f"{only_scipy.sum()}, by ours alone {only_ours.sum()} of {len(some)}")
    n, volume = hull_of_random(splinted, processor, rng)
    off = 100 * (volume / limited.volume - 1)
    print(f"hull of {n:,} random postures: {off:+.1f} % off the splinted volume")
    ours = 1e6 * processor / (2 * len(limited.points))
    note = f"reached by theirs alone {only_scipy.sum()}, by ours alone {only_ours.sum()}"
    row = Row(
        "Volume of a workspace",
        f"a point decided, {len(limited.points):,} points, free and splinted",
        f"SciPy bounded least squares, {STARTS} starts",
        version_of("scipy"),
        ours,
        1e6 * each,
        "µs",
        f"{note}, of {len(some)}",
    )
    write_rows(args.rows, [row])


if __name__ == "__main__":
    main()
