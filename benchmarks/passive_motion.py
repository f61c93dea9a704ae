"""Planning and Donders fits against SciPy's LSODA, in one run on the same movements.

Run `python benchmarks/passive_motion.py` (under a minute). The library plans 10,000 wrist
movements of 100 steps, on all threads that numba may use and on one; LSODA integrates the first
of them, with the same right-hand side compiled by numba and with it in NumPy. The ratio of the
times of the processor is what counts on a busy machine. Accuracy of both is judged by LSODA at
1e-12.
"""

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import platform
import time

import numba
import numpy as np
import scipy
from numba import njit
from scipy.integrate import odeint

from rows import Row, add_rows_option, version_of, write_rows
from selfmotion.arms import srs7, wrist
from selfmotion.methods.donders import fit_elasticity
from selfmotion.methods.elasticity.posture import donders_postures
from selfmotion.methods.passive.kernels import velocity_at
from selfmotion.methods.passive.setup import drive_of, kernel_law, springs
from selfmotion.methods.passive.tasks import kernel_task
from selfmotion.methods.passive.wrist_kernels import wrist_velocity
from selfmotion.methods.passive_motion import JointLaw, PlanSettings, plan
from selfmotion.redundancy.projection import project
from selfmotion.redundancy.task import Pointing, Position

SPRING, TAU, DURATION, N_STEPS = 22.5, 0.08, 0.4, 100
LAW = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
# Tolerance at which LSODA is about as accurate as the library.
TOLERANCE = 1e-7


@njit
def compiled_slope(q, t, joints, goal):
    """The right-hand side of the library's kernel, called by LSODA."""
    growth = 1.0 - np.exp(-t / TAU) * (1.0 + t / TAU)
    pull = (SPRING, 0.0, SPRING, (goal[0], goal[1]))
    v = wrist_velocity((q[0], q[1], q[2]), joints, pull, growth)[0]
    return np.array(v)


def joints_of(law):
    """What the compiled right-hand side wants to know of a law."""
    W = np.linalg.inv(law.damping)
    rows = tuple(tuple(row) for row in W.tolist()), tuple(map(tuple, (W @ law.stiffness).tolist()))
    return (*rows, tuple(law.rest.tolist()), 1.0, 1.0)


def numpy_slope(q, t, task, goal):
    """The same equation as the paper writes it, in NumPy."""
    growth = 1.0 - np.exp(-t / TAU) * (1.0 + t / TAU)
    J = task.jacobian(q)
    p = project(J, LAW.damping)
    xd = J[0] @ np.linalg.solve(LAW.damping, J[0].T @ (SPRING * growth * task.error(q, goal)[0]))
    relaxed = -np.linalg.solve(LAW.damping, LAW.stiffness @ (q - LAW.rest))
    return p.inverse[0] @ xd + p.null[0] @ relaxed


def movements(n):
    """Starts scattered around the rest posture, targets on the circle."""
    rng = np.random.default_rng(0)
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    goals = np.pi / 12 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return LAW.rest + rng.normal(0.0, 0.1, (n, 3)), goals


def best_of(repeats, run, clock=time.process_time):
    """Shortest of some times (s) of the processor, all threads together, and the last answer."""
    times, answer = [], None
    for _ in range(repeats):
        start = clock()
        answer = run()
        times.append(clock() - start)
    return min(times), answer


def lsoda(slope, start, goals, extra, tolerance):
    """Integrate movements one after the other."""
    grid = np.linspace(0.0, DURATION, N_STEPS + 1)
    return np.stack(
        [
            odeint(slope, q, grid, args=(extra, goal), rtol=tolerance, atol=tolerance, mxstep=5000)
            for q, goal in zip(start, goals, strict=True)
        ]
    )


def planning(n):
    task, settings = Pointing(wrist()), PlanSettings(spring=SPRING)
    start, goals = movements(n)
    joints = joints_of(LAW)
    first, _ = best_of(
        1, lambda: plan(task, LAW, start[:2], goals[:2], settings), time.perf_counter
    )
    compiled_slope(start[0], 0.1, joints, goals[0])
    wall = time.perf_counter
    ours, planned = best_of(3, lambda: plan(task, LAW, start, goals, settings), wall)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    single, _ = best_of(3, lambda: plan(task, LAW, start, goals, settings))
    numba.set_num_threads(threads)
    few, fewer = min(n, 300), min(n, 20)
    peer, found = best_of(
        3, lambda: lsoda(compiled_slope, start[:few], goals[:few], joints, TOLERANCE)
    )
    plain, _ = best_of(1, lambda: lsoda(numpy_slope, start[:fewer], goals[:fewer], task, TOLERANCE))
    exact = lsoda(compiled_slope, start[:few], goals[:few], joints, 1e-12)
    print(f"first call (cached code loaded): {first:.2f} s")
    print(f"{n} wrist movements of {N_STEPS} steps: {ours:.3f} s on {threads} threads", end="")
    print(f" by the clock, {single:.3f} s on one by the processor")
    print(f"{'':34}{'µs a movement':>14}{'ratio':>8}{'error (rad)':>13}")
    assert planned is not None
    error = np.abs(planned.q[:few] - exact).max()
    off = np.abs(found - exact).max()
    rows = (
        ("selfmotion, one thread", single / n, error),
        ("LSODA, compiled right-hand side", peer / few, off),
        ("LSODA, NumPy right-hand side", plain / fewer, off),
    )
    for name, seconds, worst in rows:
        print(f"{name:34}{1e6 * seconds:14.1f}{seconds * n / single:8.1f}{worst:13.1e}")
    case = f"{n:,} wrist movements of {N_STEPS} steps, one thread"
    return [row_of(case, name, single / n, error, row) for name, *row in rows[1:]]


def row_of(case, peer, ours, error, theirs):
    """Give the ratio to LSODA."""
    note = f"largest error: ours {error:.0e} rad, theirs {theirs[1]:.0e} rad"
    times = 1e6 * ours, 1e6 * theirs[0]
    return Row("Planned movements", case, peer, version_of("scipy"), *times, "µs", note)


@njit
def compiled_chain_slope(q, t, served):
    """The right-hand side of the library's kernel for serial chains, called by LSODA."""
    task, law, drive, movement = served
    return velocity_at(task, law, drive, movement, t, q)


def serial_chain(n):
    task = Position(srs7())
    middle = task.arm.middle()
    law = JointLaw(np.diag(np.linspace(2.0, 0.5, 7)), middle)
    rng = np.random.default_rng(1)
    start = middle + rng.normal(0.0, 0.1, (n, 7))
    goals = task.value(start + rng.normal(0.0, 0.1, (n, 7)))
    settings = PlanSettings(spring=30.0)
    plan(task, law, start[:2], goals[:2], settings)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    ours, planned = best_of(3, lambda: plan(task, law, start, goals, settings))
    numba.set_num_threads(threads)
    assert planned is not None
    free = np.arange(7)
    kernel = kernel_law(law, settings, free)
    drive = drive_of(task, settings, start, goals, springs(task, law, settings, start, free))
    served, given = kernel_task(task), drive.for_kernels()
    grid = np.linspace(0.0, settings.duration, settings.n_steps + 1)

    def peer_of(tolerance, few):
        tight = {"rtol": tolerance, "atol": tolerance, "mxstep": 5000}
        inputs = [(served, kernel, given, i) for i in range(few)]
        return np.stack(
            [odeint(compiled_chain_slope, start[i[3]], grid, args=(i,), **tight) for i in inputs]
        )

    peer_of(TOLERANCE, 1)
    few = min(n, 100)
    peer, found = best_of(3, lambda: peer_of(TOLERANCE, few))
    exact = peer_of(1e-12, few)
    off, worst = np.abs(found - exact).max(), np.abs(planned.q[:few] - exact).max()
    print(f"{n} movements of the 7-DoF arm: {ours:.3f} s")
    print(f"{'selfmotion':34}{1e6 * ours / n:14.1f}{1.0:8.1f}{worst:13.1e}")
    ratio = peer / few * n / ours
    name = "LSODA, compiled right-hand side"
    print(f"{name:34}{1e6 * peer / few:14.1f}{ratio:8.1f}{off:13.1e}")
    case = f"{n:,} movements of a 7-DoF arm, one thread"
    return [row_of(case, name, ours / n, worst, (peer / few, off))]


def donders(n):
    task = Pointing(wrist())
    rng = np.random.default_rng(2)
    r, a = np.sin(np.radians(30.0)) * np.sqrt(rng.uniform(size=n)), rng.uniform(0, 2 * np.pi, n)
    law = JointLaw(
        np.array([[0.6, 0.1, -0.05], [0.1, 1.5, 0.1], [-0.05, 0.1, 1.9]]), np.radians([5, -3, 4])
    )
    found = donders_postures(task, law, np.stack([r * np.cos(a), r * np.sin(a)], axis=1))
    q = found.q[found.least]
    q = q + rng.normal(0.0, np.radians(0.5), q.shape)
    seconds, fit = best_of(3, lambda: fit_elasticity(q))
    assert fit is not None
    worst = np.abs((fit.stiffness - law.stiffness) / fit.stiffness_stderr).max()
    print(f"Donders fit of {len(q)} postures: {seconds:.3f} s, ", end="")
    print(f"largest error of the stiffness {worst:.1f} standard errors")


def main():
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--movements", type=int, default=10_000)
    add_rows_option(parser)
    chosen = parser.parse_args()
    print(f"numpy {np.__version__}, scipy {scipy.__version__}, numba {numba.__version__}, ", end="")
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    rows = planning(chosen.movements) + serial_chain(1000)
    donders(2000)
    write_rows(chosen.rows, rows)


if __name__ == "__main__":
    main()
