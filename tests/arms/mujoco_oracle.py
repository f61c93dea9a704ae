"""Any `Arm` written as a MuJoCo model, which then says where things are and what they weigh."""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.interpolate import PPoly
from scipy.spatial.transform import Rotation

from selfmotion.arms import load_arm, planar
from selfmotion.kinematics.arm import LANDMARKS, Arm
from selfmotion.kinematics.chain import (
    GROUND,
    PRISMATIC,
    REVOLUTE,
    Chain,
    CoupledCurve,
    Coupling,
    Tip,
)
from selfmotion.spatial import transform

# MuJoCo wants every moving body to weigh something; this is below what the tests can see.
NOTHING = 2e-15

NAMES = (
    "planar",
    "hip_shoulder_elbow",
    "wrist",
    "exoskeleton",
    "upper_limb",
    "upper_limb_anatomical",
    "srs7",
    "myoarm",
    "upright",
    "tree",
    "coupled_tree",
)


def arm_called(name: str) -> Arm:
    """Give one of the library's arms, or one made for these tests."""
    if name == "upright":
        return planar([0.4, 0.3], gravity=(0.0, -9.81, 0.0))
    if name == "tree":
        return _tree(Coupling.identity(tuple("abcde")))
    if name == "coupled_tree":
        matrix = np.zeros((5, 3))
        matrix[[0, 2, 3, 3], [0, 1, 2, 0]] = [1.0, 1.0, 1.0, -0.5]
        curve = PPoly(np.array([[0.3, -1.0], [0.0, 0.0], [1.0, 0.5], [0.1, 0.2]]), [-1.0, 0.0, 1.0])
        coupling = Coupling(
            ("p", "q", "r"),
            matrix,
            np.array([0.0, 0.0, 0.2, 0.1, 0.3]),
            (CoupledCurve(1, 2, curve),),
        )
        return _tree(coupling)
    return load_arm(name)


def _tree(coupling: Coupling) -> Arm:
    """Five joints, one of them a slide, that branch twice, with skew axes and bodies."""
    rng = np.random.default_rng(5)
    axes = rng.normal(size=(5, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    turns = Rotation.random(5, rng=rng).as_matrix()
    offsets = np.array([transform(R, rng.normal(size=3) * 0.2) for R in turns])
    n = len(coupling.coordinates)
    chain = Chain(
        tuple("abcde"),
        np.array([GROUND, 0, 1, 1, 3]),
        np.array([REVOLUTE, REVOLUTE, PRISMATIC, REVOLUTE, REVOLUTE]),
        axes,
        offsets,
        -np.ones(n),
        np.ones(n),
        coupling,
    )
    A = rng.normal(size=(5, 3, 3)) * 0.1
    Q = A @ np.swapaxes(A, 1, 2)
    inertia = np.trace(Q, axis1=1, axis2=2)[:, None, None] * np.eye(3) - Q
    tips = {key: Tip(j, offsets[j]) for key, j in zip(LANDMARKS, (0, 2, 3, 4), strict=True)}
    com = rng.normal(size=(5, 3)) * 0.1
    return Arm("tree", chain, tips, {}, rng.uniform(0.1, 2.0, 5), com, inertia)


@dataclass
class Oracle:
    """The same chain in MuJoCo, all joints free; coupling is applied to what it returns."""

    arm: Arm
    model: mujoco.MjModel
    data: mujoco.MjData

    @classmethod
    def of(cls, arm: Arm) -> "Oracle":
        chain, spec = arm.chain, mujoco.MjSpec()
        spec.option.gravity = arm.gravity
        bodies: list[mujoco.MjsBody] = []
        for i, name in enumerate(chain.names):
            parent = spec.worldbody if chain.parent[i] == GROUND else bodies[chain.parent[i]]
            T = chain.offsets[i]
            body = parent.add_body(name=f"body_{i}", pos=T[:3, 3], quat=_quaternion(T[:3, :3]))
            moments, axes = np.linalg.eigh(arm.inertia[i])
            axes[:, 2] *= np.linalg.det(axes)
            body.mass = max(arm.mass[i], NOTHING)
            body.ipos, body.iquat = arm.com[i], _quaternion(axes)
            # A triangle inequality that rounding breaks is mended by the same tiny amount.
            body.inertia = np.maximum(moments, 0.0) + NOTHING
            body.explicitinertial = True
            slide = chain.joint_type[i] == PRISMATIC
            kind = mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE
            body.add_joint(name=name, type=kind, axis=chain.axes[i])
            bodies.append(body)
        model = spec.compile()
        return cls(arm, model, mujoco.MjData(model))

    def set(self, q: np.ndarray) -> None:
        """Put the model into a posture, at rest."""
        self.data.qpos[:] = self.arm.chain.joint_values(q)[0]
        self.data.qvel[:] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def coupling(self, q: np.ndarray) -> np.ndarray:
        return self.arm.chain.coupling.derivative(q[None])[0]

    def frame(self, tip: Tip) -> np.ndarray:
        body = tip.joint + 1
        R, p = self.data.xmat[body].reshape(3, 3), self.data.xpos[body]
        return transform(R, p) @ tip.transform

    def jacobian(self, tip: Tip, q: np.ndarray) -> np.ndarray:
        n_joints = len(self.arm.chain.names)
        J = np.zeros((6, n_joints))
        point = self.frame(tip)[:3, 3]
        mujoco.mj_jac(self.model, self.data, J[:3], J[3:], point, tip.joint + 1)
        return J @ self.coupling(q)

    def gravity(self, q: np.ndarray) -> np.ndarray:
        return self.coupling(q).T @ self.data.qfrc_bias

    def inertia(self, q: np.ndarray) -> np.ndarray:
        n_joints = len(self.arm.chain.names)
        M = np.zeros((n_joints, n_joints))
        for row, unit in zip(M, np.eye(n_joints), strict=True):
            mujoco.mj_mulM(self.model, self.data, row, unit)
        C = self.coupling(q)
        return C.T @ M @ C


def _quaternion(R: np.ndarray) -> np.ndarray:
    return np.roll(Rotation.from_matrix(R).as_quat(), 1)
