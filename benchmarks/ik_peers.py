"""Peers of the joint-limited inverse kinematics, each wrapped as one start on one target.

Those from PyPI that install beside this library: SciPy, MuJoCo (its least squares), mink, pin (the
loop of its own example), pink (pin-pink), optik (optik-py). Not wired: PyRoki is not on PyPI; placo
0.10 wants another build of pinocchio's libraries than pin 4 brings; roboticstoolbox-python 1.5
needs packages that it does not declare for its import.

Loops stop at a tenth of the tolerance by which answers are judged, or after `STEPS` steps.
"""

import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import body_frames
from selfmotion.redundancy.task import Pose, Position
from selfmotion.spatial import log_rotation

# One start: target frame (4, 4) and posture to a posture.
One = Callable[[np.ndarray, np.ndarray], np.ndarray]
# Steps of a loop; error that ends it (m, rad); metres that a radian counts as.
STEPS, CLOSE, RADIAN = 100, 1e-6, 0.25


def frames_at_zero(arm: Arm) -> list[np.ndarray]:
    """Give the frame of each body in its parent's, all joints at 0."""
    frames = body_frames(arm.chain, np.zeros(arm.n_joints))[0]
    return [
        np.linalg.solve(before, f)
        for before, f in zip([np.eye(4), *frames[:-1]], frames, strict=True)
    ]


def residuals(arm: Arm, pose: bool, T: np.ndarray) -> tuple[Callable, Callable]:
    """Give task error and Jacobian at a posture, radians weighed as `RADIAN` metres."""
    task = Pose(arm) if pose else Position(arm)
    target = np.concatenate([T[:3, 3], log_rotation(T[None, :3, :3])[0]]) if pose else T[:3, 3]
    scale = np.array([1.0, 1.0, 1.0, RADIAN, RADIAN, RADIAN][: len(target)])
    return (
        lambda q: scale * task.error(q, target)[0],
        lambda q: -scale[:, None] * task.jacobian(q)[0],
    )


def scipy_solver(arm: Arm, pose: bool) -> One:
    """SciPy's bounded least squares (trust region reflective)."""

    def solve(T: np.ndarray, q: np.ndarray) -> np.ndarray:
        error, jacobian = residuals(arm, pose, T)
        return least_squares(
            error,
            np.clip(q, arm.lower + 1e-6, arm.upper - 1e-6),
            jac=jacobian,  # pyright: ignore[reportArgumentType]
            bounds=(arm.lower, arm.upper),
            xtol=1e-12,
            ftol=1e-14,
            max_nfev=STEPS,
        ).x

    return solve


def mujoco_solver(arm: Arm, pose: bool) -> One:
    """MuJoCo's `minimize.least_squares` (box-constrained Gauss-Newton)."""
    from mujoco import minimize

    def solve(T: np.ndarray, q: np.ndarray) -> np.ndarray:
        error, jacobian = residuals(arm, pose, T)
        return minimize.least_squares(
            q[:, None].copy(),
            lambda x: np.stack([error(column) for column in x.T], axis=1),
            bounds=[arm.lower[:, None], arm.upper[:, None]],
            jacobian=lambda x, r: jacobian(x[:, 0]),
            gtol=1e-14,
            xtol=1e-12,
            max_iter=STEPS,
            verbose=0,
        )[0][:, 0]

    return solve


def pinocchio_model(arm: Arm) -> tuple[Any, Any, int]:
    """Build the arm with pinocchio; give the library, the model and the hand's frame."""
    import pinocchio  # pyright: ignore[reportMissingImports]

    pin: Any = pinocchio
    model, parent = pin.Model(), 0
    for i, place in enumerate(frames_at_zero(arm)):
        joint = pin.JointModelRevoluteUnaligned(arm.chain.axes[i])
        parent = model.addJoint(parent, joint, pin.SE3(place), arm.joints[i])
    model.lowerPositionLimit, model.upperPositionLimit = arm.lower.copy(), arm.upper.copy()
    hand = pin.Frame("hand", parent, 0, pin.SE3(arm.tip("hand").transform), pin.OP_FRAME)
    return pin, model, model.addFrame(hand)


def pinocchio_solver(arm: Arm, pose: bool) -> One:
    """Damped least squares clipped to the limits: the loop of pinocchio's own example."""
    pin, model, frame = pinocchio_model(arm)
    data, rows = model.createData(), 6 if pose else 3

    def solve(T: np.ndarray, q: np.ndarray) -> np.ndarray:
        goal, q = pin.SE3(T), q.copy()
        for _ in range(STEPS):
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacement(model, data, frame)
            here = data.oMf[frame]
            if pose:
                e = pin.log6(here.actInv(goal)).vector
                J = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
            else:
                e = goal.translation - here.translation
                J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
            if np.abs(e).max() < CLOSE:
                break
            step = J.T @ np.linalg.solve(J @ J.T + 1e-6 * np.eye(rows), e)
            q = np.clip(q + step, arm.lower, arm.upper)
        return q

    return solve


def pink_solver(arm: Arm, pose: bool) -> One:
    """Pink's differential inverse kinematics (a quadratic program a step, solved by daqp)."""
    import pink  # pyright: ignore[reportMissingImports]

    pin, model, _ = pinocchio_model(arm)
    model.velocityLimit = np.full(arm.n_joints, 1e3)
    limits = [pink.limits.ConfigurationLimit(model)]
    task = pink.tasks.FrameTask("hand", 1.0, RADIAN if pose else 0.0, lm_damping=1e-3)

    def solve(T: np.ndarray, q: np.ndarray) -> np.ndarray:
        configuration = pink.Configuration(model, model.createData(), q.copy())
        task.set_target(pin.SE3(T))
        for _ in range(STEPS):
            if np.abs(task.compute_error(configuration)[: 6 if pose else 3]).max() < CLOSE:
                break
            v = pink.solve_ik(configuration, [task], 1.0, "daqp", limits=limits, safety_break=False)
            configuration.integrate_inplace(v, 1.0)
        return np.asarray(configuration.q)

    return solve


def mink_solver(arm: Arm, pose: bool) -> One:
    """Mink's differential inverse kinematics (a quadratic program a step, solved by daqp)."""
    import mink  # pyright: ignore[reportMissingImports]
    import mujoco
    from scipy.spatial.transform import Rotation

    spec: Any = mujoco.MjSpec()
    spec.compiler.degree = False
    body = spec.worldbody
    for i, place in enumerate(frames_at_zero(arm)):
        quat = Rotation.from_matrix(place[:3, :3]).as_quat(scalar_first=True)
        body = body.add_body(pos=place[:3, 3], quat=quat, mass=1.0, inertia=[1.0, 1.0, 1.0])
        body.explicitinertial = True
        span = [arm.lower[i], arm.upper[i]]
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=arm.chain.axes[i], range=span)
    tip = arm.tip("hand").transform
    quat = Rotation.from_matrix(tip[:3, :3]).as_quat(scalar_first=True)
    body.add_site(name="hand", pos=tip[:3, 3], quat=quat)
    model = spec.compile()
    limits = [mink.ConfigurationLimit(model)]
    task = mink.FrameTask("hand", "site", 1.0, RADIAN if pose else 0.0, lm_damping=1e-3)

    def solve(T: np.ndarray, q: np.ndarray) -> np.ndarray:
        configuration = mink.Configuration(model, q=q.copy())
        task.set_target(mink.SE3.from_matrix(T))
        for _ in range(STEPS):
            if np.abs(task.compute_error(configuration)[: 6 if pose else 3]).max() < CLOSE:
                break
            v = mink.solve_ik(configuration, [task], 1.0, "daqp", limits=limits)
            configuration.integrate_inplace(v, 1.0)
        return np.clip(configuration.q, arm.lower, arm.upper)  # its limits give by 1e-8 rad

    return solve


def urdf(arm: Arm) -> str:
    """Write the arm as URDF."""
    from scipy.spatial.transform import Rotation

    def origin(T: np.ndarray) -> str:
        with warnings.catch_warnings(action="ignore"):  # gimbal lock: any pair of angles serves
            turn = Rotation.from_matrix(T[:3, :3]).as_euler("xyz")
        texts = [" ".join(f"{v:.17g}" for v in values) for values in (T[:3, 3], turn)]
        return f'<origin xyz="{texts[0]}" rpy="{texts[1]}"/>'

    lines = ['<robot name="arm">', '<link name="b0"/>']
    for i, place in enumerate(frames_at_zero(arm)):
        axis = " ".join(f"{v:.17g}" for v in arm.chain.axes[i])
        lines += [
            f'<link name="b{i + 1}"/><joint name="j{i}" type="revolute">{origin(place)}',
            f'<parent link="b{i}"/><child link="b{i + 1}"/><axis xyz="{axis}"/>',
            f'<limit lower="{arm.lower[i]:.17g}" upper="{arm.upper[i]:.17g}" effort="1" '
            'velocity="1"/></joint>',
        ]
    lines += [
        f'<link name="hand"/><joint name="tip" type="fixed">{origin(arm.tip("hand").transform)}',
        f'<parent link="b{arm.n_joints}"/><child link="hand"/></joint></robot>',
    ]
    return "\n".join(lines)


def optik_solver(arm: Arm, pose: bool, restarts: int) -> One:
    """Optik (SLSQP in Rust), with restarts of its own; on one thread."""
    import optik  # pyright: ignore[reportMissingImports]

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.urdf"
        file.write_text(urdf(arm))
        robot = optik.Robot.from_urdf_file(str(file), "b0", "hand")
    robot.set_parallelism(1)
    config = optik.SolverConfig(
        "speed",
        max_time=0.0,
        max_restarts=restarts + 1,
        tol_f=1e-12,
        linear_weight=[1.0] * 3,
        angular_weight=[RADIAN if pose else 0.0] * 3,
    )

    def solve(T: np.ndarray, q: np.ndarray) -> np.ndarray:
        inside = np.clip(q, arm.lower, arm.upper)
        found = robot.ik(config, T.tolist(), inside.tolist())
        return inside if found is None else np.array(found[0])

    return solve
