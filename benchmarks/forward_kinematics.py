"""Positions of the hand at many postures: our kernels beside NumPy, MuJoCo, pinocchio and JAX.

    python benchmarks/forward_kinematics.py [--samples 1000000]

The 9-DoF arm of [DeBoon]; (samples, joints) in, positions (samples, 3) out, conversion included.
Those that are not installed are left out.
"""

import argparse
import platform
import time
from collections.abc import Callable

import numpy as np

from selfmotion.arms import load_arm
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.fast_position import positions
from selfmotion.kinematics.forward import body_frames, forward_kinematics, frames_and_jacobian

Positions = Callable[[np.ndarray], np.ndarray]


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

    @jax.jit
    def run(q):
        x, y, z = (jnp.full(q.shape[0], tip[a, 3]) for a in range(3))
        for i in range(arm.n_joints - 1, -1, -1):
            c, s = jnp.cos(q[:, i]), jnp.sin(q[:, i])
            x, y = c * x - s * y, s * x + c * y
            R, t = offsets[i, :3, :3], offsets[i, :3, 3]
            x, y, z = (R[a, 0] * x + R[a, 1] * y + R[a, 2] * z + t[a] for a in range(3))
        return jnp.stack([x, y, z], axis=1)

    return lambda q: np.asarray(run(q))


def pinocchio_positions(arm: Arm) -> Positions:
    import pinocchio as pin  # pyright: ignore[reportMissingImports]

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


def rate(run: Callable[[np.ndarray], object], q: np.ndarray) -> float:
    """Give millions of postures a second: the best of five."""
    run(q)
    best = np.inf
    for _ in range(5):
        begin = time.perf_counter()
        run(q)
        best = min(best, time.perf_counter() - begin)
    return len(q) / best / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1_000_000)
    n = parser.parse_args().samples
    print(platform.processor() or platform.machine(), platform.python_version())
    arm = load_arm("upper_limb")
    chain, tip = arm.chain, arm.tip("hand")
    q = arm.random_postures(n, np.random.default_rng(0))
    few = q[: max(1, n // 50)]
    true = forward_kinematics(chain, few, tip)[:, :3, 3]
    ours = rate(lambda x: positions(chain, x, tip), q)
    rows = {
        "positions, 1 thread": (ours, positions(chain, few, tip)),
        "positions, 2 threads": (
            rate(lambda x: positions(chain, x, tip, threads=2), q),
            positions(chain, few, tip, threads=2),
        ),
        "frames (forward_kinematics)": (
            rate(lambda x: forward_kinematics(chain, x, tip), few),
            true,
        ),
        "frames with 6x9 Jacobian": (rate(lambda x: frames_and_jacobian(chain, x, tip), few), true),
    }
    builders = {
        "NumPy": (numpy_positions, q),
        "JAX": (jax_positions, q),
        "MuJoCo": (mujoco_positions, few),
        "pinocchio": (pinocchio_positions, few),
    }
    for name, (build, samples) in builders.items():
        try:
            run = build(arm)
        except ImportError:
            print(f"  {name} is not installed: left out")
            continue
        rows[name] = (rate(run, samples), run(few))
    for name, (speed, found) in rows.items():
        error = np.abs(found - true).max()
        print(f"  {name:28s} {speed:8.2f} M postures/s  {speed / ours:7.3f} of ours  {error:.1e} m")


if __name__ == "__main__":
    main()
