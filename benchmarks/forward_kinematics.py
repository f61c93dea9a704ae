"""Positions of the hand at many postures: our kernels beside NumPy, MuJoCo, pinocchio and JAX.

    python benchmarks/forward_kinematics.py [--samples 1000000] [--rows FILE]

The 9-DoF arm of [DeBoon]; (samples, joints) in, positions (samples, 3) out, conversion included.
Those that are not installed are left out. Two rates: by the clock on the wall, and by the processor
time of all threads, times the number of threads: what they would do on cores that are otherwise
idle. The last column is the largest difference to frames multiplied in NumPy with the C library's
sine and cosine.
"""

import argparse
import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from rows import Row, add_rows_option, version_of, write_rows
from selfmotion.arms import load_arm
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.fast_position import positions
from selfmotion.kinematics.forward import body_frames, forward_kinematics, frames_and_jacobian

Positions = Callable[[np.ndarray], np.ndarray]
# Postures for which frames and Jacobians are asked at a time.
CHUNK = 20_000


def hardware() -> str:
    """Give the processor's name and the number of cores."""
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = [x for x in info.read_text().splitlines() if x.startswith("model name")]
        name = lines[0].partition(":")[2].strip() if lines else name
    return f"{name}, {os.cpu_count()} cores"


def numpy_positions(arm: Arm) -> Positions:
    offsets, tip = arm.chain.offsets, arm.tip("hand").transform

    def run(q: np.ndarray) -> np.ndarray:
        point = np.tile(tip[:3, 3], (len(q), 1))
        for i in range(arm.n_joints - 1, -1, -1):
            c, s = np.cos(q[:, i]), np.sin(q[:, i])
            x, y = point[:, 0].copy(), point[:, 1].copy()
            point[:, 0], point[:, 1] = c * x - s * y, s * x + c * y
            point = point @ offsets[i, :3, :3].T + offsets[i, :3, 3]
        return point

    return run


def jax_positions(arm: Arm) -> Positions:
    import jax  # pyright: ignore[reportMissingImports]
    import jax.numpy as jnp  # pyright: ignore[reportMissingImports]

    jax.config.update("jax_enable_x64", True)
    offsets, tip = arm.chain.offsets, arm.tip("hand").transform

    # One posture, mapped: written over whole columns, XLA fuses the joints and computes each sine
    # again for every coordinate, which is six times as slow.
    def hand(q):
        p = jnp.array(tip[:3, 3])
        for i in range(arm.n_joints - 1, -1, -1):
            c, s = jnp.cos(q[i]), jnp.sin(q[i])
            turned = jnp.array([c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]])
            p = offsets[i, :3, :3] @ turned + offsets[i, :3, 3]
        return p

    run = jax.jit(jax.vmap(hand))
    return lambda q: np.asarray(run(q))


def pinocchio_positions(arm: Arm) -> Positions:
    import pinocchio  # pyright: ignore[reportMissingImports]

    pin: Any = pinocchio
    model = pin.Model()
    frames = body_frames(arm.chain, np.zeros(arm.n_joints))[0]
    parent = 0
    for i in range(arm.n_joints):
        place = np.linalg.solve(frames[i - 1] if i else np.eye(4), frames[i])
        parent = model.addJoint(
            parent, pin.JointModelRevoluteUnaligned(arm.chain.axes[i]), pin.SE3(place), str(i)
        )
    data, point = model.createData(), arm.tip("hand").transform[:3, 3]

    def run(q: np.ndarray) -> np.ndarray:
        out = np.empty((len(q), 3))
        for k in range(len(q)):
            pin.forwardKinematics(model, data, q[k])
            out[k] = data.oMi[parent].act(point)
        return out

    return run


def mujoco_positions(arm: Arm) -> Positions:
    import mujoco
    from scipy.spatial.transform import Rotation

    spec = mujoco.MjSpec()
    body = spec.worldbody
    for i in range(arm.n_joints):
        T = arm.chain.offsets[i]
        quat = Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)
        body = body.add_body(pos=T[:3, 3], quat=quat, mass=1.0, inertia=[1.0, 1.0, 1.0])
        body.explicitinertial = True
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=arm.chain.axes[i])
    body.add_site(name="hand", pos=arm.tip("hand").transform[:3, 3])
    model = spec.compile()
    data = mujoco.MjData(model)

    def run(q: np.ndarray) -> np.ndarray:
        out = np.empty((len(q), 3))
        for k in range(len(q)):
            data.qpos[:] = q[k]
            mujoco.mj_kinematics(model, data)
            out[k] = data.site_xpos[0]
        return out

    return run


@dataclass(frozen=True)
class Rates:
    """Millions of postures a second: by the clock, and by processor time."""

    wall: float
    processor: float


def rates(run: Callable[[np.ndarray], object], q: np.ndarray, threads: int = 1) -> Rates:
    """Give the best of seven."""
    run(q)
    wall = processor = np.inf
    for _ in range(7):
        begin, spent = time.perf_counter(), time.process_time()
        run(q)
        wall = min(wall, time.perf_counter() - begin)
        processor = min(processor, time.process_time() - spent)
    return Rates(len(q) / wall / 1e6, threads * len(q) / processor / 1e6)


def ours(arm: Arm, n_samples: int) -> dict[str, tuple[Callable[[np.ndarray], np.ndarray], int]]:
    """Give our own functions by name, each with its threads; all give positions."""
    chain, tip = arm.chain, arm.tip("hand")
    out = np.empty((n_samples, 3))

    def into(q: np.ndarray, threads: int) -> np.ndarray:
        return positions(chain, q, tip, threads=threads, out=out[: len(q)])

    frames, columns = np.empty((CHUNK, 4, 4)), np.empty((CHUNK, 6, arm.n_joints))

    def jacobians(q: np.ndarray, threads: int, again: bool) -> np.ndarray:
        places = []
        for k in range(0, len(q), CHUNK):
            part = q[k : k + CHUNK]
            filled = (frames[: len(part)], columns[: len(part)]) if again else None
            T, _ = frames_and_jacobian(chain, part, tip, threads=threads, out=filled)
            places.append(T[:, :3, 3].copy())
        return np.concatenate(places)

    made = {}
    for t in (1, 2):
        made[f"positions, {t} thread(s)"] = (partial(positions, chain, tip=tip, threads=t), t)
        made[f"positions into out=, {t}"] = (partial(into, threads=t), t)
        made[f"frames and Jacobian, {t}"] = (partial(jacobians, threads=t, again=False), t)
        made[f"frames and Jacobian, out=, {t}"] = (partial(jacobians, threads=t, again=True), t)
    made["frames"] = (lambda q: forward_kinematics(chain, q, tip)[:, :3, 3], 1)
    return made


def versions() -> str:
    """Give the versions of everything that takes part."""
    found = []
    for name in ("selfmotion", "numpy", "numba", "jax", "mujoco", "pin"):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} absent")
    return ", ".join(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1_000_000)
    add_rows_option(parser)
    args = parser.parse_args()
    n = args.samples
    print(hardware(), platform.python_version(), versions(), sep="\n")
    arm = load_arm("upper_limb")
    q = arm.random_postures(n, np.random.default_rng(0))
    few = q[: max(1, n // 50)]
    true = numpy_positions(arm)(few)
    rows = {}
    for name, (run, threads) in ours(arm, n).items():
        samples = q if name.startswith("positions") else q[: n // 5]
        rows[name] = (rates(run, samples, threads), run(few).copy())
    builders = {
        "NumPy": (numpy_positions, q),
        "JAX": (jax_positions, q),
        "MuJoCo": (mujoco_positions, few),
        "pinocchio": (pinocchio_positions, few),
    }
    absent = []
    for name, (build, samples) in builders.items():
        try:
            run = build(arm)
        except ImportError:
            print(f"  {name} is not installed: left out")
            absent.append(name)
            continue
        rows[name] = (rates(run, samples, 2 if name == "JAX" else 1), run(few))
    best = rows["positions into out=, 2"][0]
    print(f"{'million postures a second':30s} {'wall':>8s} {'processor':>9s}  wall, of ours  error")
    for name, (rate, found) in rows.items():
        print(
            f"{name:30s} {rate.wall:8.2f} {rate.processor:9.2f}  {rate.wall / best.wall:13.3f}"
            f"  {np.abs(found - true).max():.1e} m"
        )
    ours_rate = rows["positions into out=, 1"][0].processor
    packages = {"NumPy": "numpy", "JAX": "jax", "MuJoCo": "mujoco", "pinocchio": "pin"}
    compared = [
        Row(
            "Forward kinematics",
            f"hand of the 9-DoF arm, {n:,} postures, a core",
            name,
            version_of(packages[name]),
            ours_rate,
            rows[name][0].processor,
            "million postures/s",
        )
        for name in packages
        if name in rows
    ]
    write_rows(args.rows, compared, absent)


if __name__ == "__main__":
    main()
