"""Natural posture: the default search, the published search and a brute-force sweep, in one run.

Run ``python benchmarks/natural_posture.py`` (about a minute; ``--poses 1000 --step 0.05`` for the
full comparison). All three see the same random reachable poses of the default arm; on a busy
machine the processor time and its ratios count. Also times hybrid inverse kinematics.

    certain  continuation of the manifold, effort sampled until its least value is known to 1e-3
    paper    the two-phase search with the paper's parameters (on the first --published poses)
    sweep    effort at every --step degrees of swivel over every feasible interval
"""

import argparse
import os
import platform
import time

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import mujoco
import numba
import numpy as np

from rows import Row, add_rows_option, version_of, write_rows
from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.kinematics.srs import SrsRelative
from selfmotion.methods.hybrid_ik import hybrid_ik
from selfmotion.methods.natural_posture import PostureFinder, SearchOptions
from selfmotion.muscles.static_optimization import muscle_effort
from selfmotion.spatial import log_rotation

HYBRID = 30  # poses for which hybrid inverse kinematics is timed


def timed(work):
    """Give the result, and wall and processor time in milliseconds."""
    wall, processor = time.perf_counter(), time.process_time()
    result = work()
    return result, 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)


def sweep(finder, pose, step_deg):
    """Least effort of a dense sweep over the feasible intervals, and its swivel angle."""
    best, at = np.inf, np.nan
    for interval in finder.manifolds.find(pose).intervals:
        low, high = interval.swivel_range
        count = max(int(np.rad2deg(high - low) / step_deg) + 1, 2)
        q = interval.at(np.linspace(0.0, interval.arc[-1], count))
        found = muscle_effort(finder.model, q)
        effort = np.where([bool(s) for s in found.status], found.effort, np.inf)
        i = int(effort.argmin())
        if effort[i] < best:
            best, at = float(effort[i]), float(interval.swivel_at(q)[i])
    return best, at


def line(name, wall, processor, errors, note=""):
    """Print one row of the table."""
    w, p = np.array(wall), np.array(processor)
    e = np.array(errors) if len(errors) else np.zeros(1)
    print(
        f"{name:8} {np.median(w):9.2f} {np.percentile(w, 95):9.2f} {np.median(p):9.2f} "
        f"{np.median(e):10.1e} {e.max():10.1e} {100 * (e <= 1e-3).mean():7.1f} %  {note}"
    )


def turn(angle):
    """Bring an angle into half a turn either way."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def hybrid_line(arm, poses):
    """Time hybrid inverse kinematics, the whole turn of swivel by 2 degrees for each pose."""
    relative, tip = SrsRelative.of(arm), arm.tip("hand")
    each, all_wall, all_processor, count, off = [], 0.0, 0.0, 0, np.zeros(2)
    for pose in poses:
        found, wall, processor = timed(lambda pose=pose: hybrid_ik(arm, pose, relative=relative))
        if len(found.q) == 0:
            continue
        T = forward_kinematics(arm.chain, found.q, tip)
        turn = log_rotation(np.swapaxes(T[:, :3, :3], 1, 2) @ pose[:3, :3])
        errors = np.linalg.norm(T[:, :3, 3] - pose[:3, 3], axis=1), np.linalg.norm(turn, axis=1)
        off = np.maximum(off, [e.max() for e in errors])
        each.append(1e3 * processor / len(found.q))
        all_wall, all_processor = all_wall + wall, all_processor + processor
        count += len(found.q)
    print(
        f"hybrid inverse kinematics, {len(each)} poses, {count} postures: a posture takes "
        f"{1e3 * all_wall / count:.0f} us ({1e3 * all_processor / count:.0f} us processor; median "
        f"over poses {np.median(each):.0f} us), within {off[0]:.0e} m and {off[1]:.0e} rad"
    )


def row_of(name, rows, step):
    """Give the ratio of one of the slower ways."""
    peer = {"paper": "the published search", "sweep": f"a sweep of {step:g} deg"}[name]
    worst = max(rows[name][2]), max(rows["certain"][2])
    return Row(
        "Natural posture",
        f"myoarm, {len(rows[name][0])} random poses",
        f"{peer}, in this library",
        version_of("mujoco"),
        float(np.median(rows["certain"][1])),
        float(np.median(rows[name][1])),
        "ms",
        f"largest relative error of the effort: ours {worst[1]:.0e}, theirs {worst[0]:.0e}",
    )


def main():
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poses", type=int, default=30)
    parser.add_argument("--published", type=int, default=3)
    parser.add_argument("--step", type=float, default=0.1, help="degrees of swivel")
    parser.add_argument("--seed", type=int, default=2022)
    add_rows_option(parser)
    options = parser.parse_args()
    compared = []
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, load", end=" ")
    print(f"{os.getloadavg()[0]:.1f}; Python {platform.python_version()}", end=", ")
    print(f"numpy {np.__version__}, numba {numba.__version__}, mujoco {mujoco.__version__}")
    model = load_musculoskeletal_arm()
    arm = model.arm
    q = arm.random_postures(options.poses, np.random.default_rng(options.seed))
    poses = forward_kinematics(arm.chain, q, arm.tip("hand"))
    finder = PostureFinder.of(model)
    published = PostureFinder.of(model, search=SearchOptions(search="paper"))
    finder.find(poses[0])  # compile
    hybrid_ik(arm, poses[0], [0.0])
    rows = {name: ([], [], []) for name in ("certain", "paper", "sweep")}
    swivel, undetermined, drift, missed = [], 0, [], 0
    for k, pose in enumerate(poses):
        (best, at), wall, processor = timed(lambda pose=pose: sweep(finder, pose, options.step))
        found, w, p = timed(lambda pose=pose: finder.find(pose))
        if not (found.status and np.isfinite(best)):
            missed += 1
            continue
        for name, values in (("sweep", (wall, processor, 0.0)), ("certain", (w, p, 0.0))):
            rows[name][0].append(values[0])
            rows[name][1].append(values[1])
        rows["sweep"][2].append(0.0)
        rows["certain"][2].append(max(found.effort / best - 1.0, 0.0))
        least = found.minima[0]
        if least.flat or sum(m.tied for m in found.minima) > 1:
            undetermined += 1
        else:
            swivel.append(np.rad2deg(abs(turn(at - found.swivel))))
        if k < options.published:
            theirs, w, p = timed(lambda pose=pose: published.find(pose))
            if theirs.status:
                rows["paper"][0].append(w)
                rows["paper"][1].append(p)
                rows["paper"][2].append(abs(theirs.effort / best - 1.0))
                drift.append(theirs.drift[0])
    print(f"\n{'':8} {'median':>9} {'95 %':>9} {'median':>9} {'median':>10} {'greatest':>10}")
    print(f"{'':8} {'wall ms':>9} {'wall ms':>9} {'cpu ms':>9} {'rel. err.':>10} {'rel. err.':>10}")
    for name, (w, p, e) in rows.items():
        note = f"hand {1e3 * max(drift):.1f} mm off at most" if name == "paper" and drift else ""
        if w:
            line(name, w, p, e, note)
    for name in ("paper", "sweep"):
        if rows[name][0]:
            ratio = np.median(rows[name][1]) / np.median(rows["certain"][1])
            print(f"certain takes 1/{ratio:.1f} of the processor time of {name}")
            compared.append(row_of(name, rows, options.step))
    print(
        f"swivel angle off by {np.median(swivel):.3f} deg (median), {max(swivel):.3f} (greatest); "
        f"within 0.2 deg: {100 * np.mean(np.array(swivel) <= 0.2):.1f} %; effort does not "
        f"determine it: {undetermined}; not found: {missed} of {options.poses}"
    )
    hybrid_line(arm, poses[:HYBRID])
    write_rows(options.rows, compared)


if __name__ == "__main__":
    main()
