"""The chain from the ground to a body or site of a compiled MuJoCo model.

Hinges and slides on the way become the chain's joints, with their anchors and with several joints
a body; fixed bodies, and branches such as fingers, are merged into the body that carries them, in
the posture `held`. Joint equality constraints become the coupling (MuJoCo applies them by forces
only: its kinematics alone do not move coupled joints). Not represented, as a chain has no place
for them: tendon equalities, and followers that are not on the way.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float, Int
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, freeze
from selfmotion.errors import ModelError, unknown_name
from selfmotion.kinematics.chain import (
    GROUND,
    PRISMATIC,
    REVOLUTE,
    Chain,
    CoupledCurve,
    Coupling,
    Tip,
)
from selfmotion.kinematics.inertia import RigidBody, merge_bodies
from selfmotion.spatial import rotation_about, transform

# Limits of joints for which the model gives none: a full turn (rad) or a metre either way.
UNLIMITED_TURN, UNLIMITED_SLIDE = 2 * np.pi, 1.0

_HINGE, _SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
_EQUAL_JOINT = int(mujoco.mjtEq.mjEQ_JOINT)
_LOOPS = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))
_JOINT, _BODY, _SITE = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_SITE


@dataclass(frozen=True, eq=False)
class MujocoChain:
    """A chain taken from a compiled model, and the way back to the model's arrays.

    Attributes:
        model: the compiled model.
        chain: the joints from the ground to the tip.
        joint_ids: (N,) index in the model of each joint of the chain.
        bodies: for each body of the model, the joint that carries it and its frame there.
        segments: for each joint, all that it carries up to the next one, as one rigid body.
        rest: (nq,) qpos in which joints outside the chain are held.
    """

    model: mujoco.MjModel
    chain: Chain
    joint_ids: Int[np.ndarray, " all_joints"]
    bodies: tuple[Tip, ...]
    segments: tuple[RigidBody, ...]
    rest: Float[np.ndarray, " positions"]

    def tip(self, name: str) -> Tip:
        """Give a body's or site's frame by its name in the model.

        Raises:
            UnknownNameError: the model has neither a body nor a site of this name.
        """
        body, T = _find(self.model, name)
        carrier = self.bodies[body]
        return Tip(carrier.joint, carrier.transform @ T)

    def qpos(self, q: ArrayLike) -> Float[np.ndarray, "samples positions"]:
        """Give the model's qpos (K, nq) for samples of the free coordinates, (n,) or (K, n)."""
        values = self.chain.joint_values(q)
        out = np.repeat(self.rest[None], len(values), axis=0)
        out[:, self.model.jnt_qposadr[self.joint_ids]] = values
        return out

    def velocity_map(self, q: ArrayLike) -> Float[np.ndarray, "samples velocities coords"]:
        """Give the derivative (K, nv, n) of the model's qvel with respect to coordinate speeds.

        A generalised force f (nv,) of the model is ``velocity_map.T @ f`` on the coordinates.
        """
        samples = self.chain.as_samples(q)
        out = np.zeros((len(samples), self.model.nv, self.chain.n_coordinates))
        out[:, self.model.jnt_dofadr[self.joint_ids]] = self.chain.coupling.derivative(samples)
        return out


def chain_from_mujoco(
    model: mujoco.MjModel,
    *,
    tip: str | None = None,
    held: Mapping[str, float] | None = None,
    names: Mapping[str, str] | None = None,
) -> MujocoChain:
    """Take the chain from the ground to a body or site.

    Args:
        model: the compiled model.
        tip: name of the body or site where the chain ends; left out: the last site, or the last
            body of a model without sites.
        held: joints that do not move, with their values (rad or m); joints that are not on the
            way are held at the model's default.
        names: joint names of the model to the names wanted; others keep theirs.

    Returns:
        The chain. Coordinates count as in the model; a joint without limits gets a full turn (a
        metre) either way.

    Raises:
        UnknownNameError: there is no such tip or held joint.
        ModelError: a joint on the way is a ball or free joint, or the way holds a closed loop,
            or couplings contradict each other, or no joint is on the way.
    """
    joints = {name: i for i, name in enumerate(_names(model, _JOINT, model.njnt, "joint"))}
    fixed = dict(held or {})
    for name in fixed:
        if name not in joints:
            raise unknown_name("joint", name, tuple(joints))
    way = _joints_on_the_way(model, _default_tip(model) if tip is None else tip)
    rest = np.array(model.qpos0)
    for name, value in fixed.items():
        rest[model.jnt_qposadr[joints[name]]] = value
    curves = _couplings(model, [j for j in way if _joint_name(model, j) not in fixed], rest)
    moving = [j for j in way if j in curves]
    if not moving:
        raise ModelError(
            f"no joint moves {tip or _default_tip(model)!r}: a chain needs at least one"
        )
    bodies, offsets, parents = _walk(model, moving, rest)
    _refuse_loops(model, bodies)
    titles = [(names or {}).get(n, n) for n in (_joint_name(model, j) for j in moving)]
    chain = _chain(model, (moving, titles), curves, (offsets, parents))
    return MujocoChain(
        model,
        chain,
        freeze(np.array(moving, dtype=np.int64)),
        tuple(bodies),
        tuple(_segments(model, bodies, len(moving))),
        freeze(rest),
    )


def _names(model: mujoco.MjModel, kind: mujoco.mjtObj, count: int, word: str) -> list[str]:
    return [mujoco.mj_id2name(model, kind, i) or f"{word}_{i}" for i in range(count)]


def _joint_name(model: mujoco.MjModel, joint: int) -> str:
    return mujoco.mj_id2name(model, _JOINT, joint) or f"joint_{joint}"


def _default_tip(model: mujoco.MjModel) -> str:
    if model.nsite:
        return _names(model, _SITE, model.nsite, "site")[-1]
    return _names(model, _BODY, model.nbody, "body")[-1]


def _find(model: mujoco.MjModel, name: str) -> tuple[int, Transform]:
    """Give the body that carries a named body or site, and the frame in it."""
    bodies = _names(model, _BODY, model.nbody, "body")
    if name in bodies:
        return bodies.index(name), np.eye(4)
    sites = _names(model, _SITE, model.nsite, "site")
    if name not in sites:
        raise unknown_name("body or site", name, tuple(bodies[1:] + sites))
    i = sites.index(name)
    return int(model.site_bodyid[i]), _frame(model.site_pos[i], model.site_quat[i])


def _frame(position: np.ndarray, quaternion: np.ndarray) -> Transform:
    """Give a transform from MuJoCo's position and (w, x, y, z)."""
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, quaternion)
    return transform(R.reshape(3, 3), position)


def _joints_on_the_way(model: mujoco.MjModel, tip: str) -> list[int]:
    """Give the joints from the ground to the tip; refuse those that are not hinge or slide."""
    body = _find(model, tip)[0]
    way: list[int] = []
    while body != 0:
        first = int(model.body_jntadr[body])
        way = list(range(first, first + int(model.body_jntnum[body]))) + way
        body = int(model.body_parentid[body])
    for j in way:
        if model.jnt_type[j] not in (_HINGE, _SLIDE):
            kind = mujoco.mjtJoint(int(model.jnt_type[j])).name.removeprefix("mjJNT_").lower()
            raise ModelError(
                f"joint {_joint_name(model, j)!r} is a {kind} joint: an arm has hinge and slide "
                "joints only; replace it by hinges, or fix its body"
            )
    return way


def _couplings(
    model: mujoco.MjModel, candidates: list[int], rest: np.ndarray
) -> dict[int, tuple[int, Polynomial]]:
    """Give, for each joint that moves, its free coordinate and its value as a polynomial of it.

    A follower of a joint that does not move does not move either: its value goes into `rest`.
    """
    equalities: dict[int, tuple[int, np.ndarray]] = {}
    for e in range(model.neq):
        if int(model.eq_type[e]) != _EQUAL_JOINT or not model.eq_active0[e]:
            continue
        follower, leader = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if follower in equalities:
            name = _joint_name(model, follower)
            raise ModelError(f"joint {name!r} follows two others: a joint may follow one")
        equalities[follower] = (leader, np.array(model.eq_data[e, :5]))

    def resolve(joint: int, seen: tuple[int, ...]) -> tuple[int, Polynomial]:
        if joint in seen:
            raise ModelError(f"joint {_joint_name(model, joint)!r} follows itself")
        if joint not in equalities:
            value = rest[model.jnt_qposadr[joint]]
            free = joint in candidates
            return (joint, Polynomial([0.0, 1.0])) if free else (GROUND, Polynomial([value]))
        leader, coefficients = equalities[joint]
        start = model.qpos0[model.jnt_qposadr[joint]]
        if leader < 0:
            return GROUND, Polynomial([start + coefficients[0]])
        root, value = resolve(leader, (*seen, joint))
        shifted = value - model.qpos0[model.jnt_qposadr[leader]]
        return root, start + Polynomial(coefficients)(shifted)

    moving: dict[int, tuple[int, Polynomial]] = {}
    for joint in candidates:
        root, curve = resolve(joint, ())
        if root == GROUND:
            rest[model.jnt_qposadr[joint]] = curve(0.0)
        else:
            moving[joint] = (root, curve.trim())
    return moving


def _walk(
    model: mujoco.MjModel, moving: list[int], rest: np.ndarray
) -> tuple[list[Tip], list[Transform], list[int]]:
    """Place every body on the joint that carries it; give offsets and parents of the joints.

    A joint turns about its anchor: ``Trans(anchor) motion(value - default) Trans(-anchor)``, in
    the frame that the body's joints before it have made.
    """
    bodies = [Tip(GROUND)]
    offsets: list[Transform] = []
    parents: list[int] = []
    for body in range(1, model.nbody):
        parent = bodies[int(model.body_parentid[body])]
        carrier = parent.joint
        T = parent.transform @ _frame(model.body_pos[body], model.body_quat[body])
        first = int(model.body_jntadr[body])
        for j in range(first, first + int(model.body_jntnum[body])):
            anchor = transform(translation=model.jnt_pos[j])
            back = transform(translation=-model.jnt_pos[j])
            default = model.qpos0[model.jnt_qposadr[j]]
            if j in moving:
                offsets.append(T @ anchor @ _motion(model, j, -default))
                parents.append(carrier)
                carrier, T = len(offsets) - 1, back
            elif model.jnt_type[j] in (_HINGE, _SLIDE):
                value = rest[model.jnt_qposadr[j]]
                T = T @ anchor @ _motion(model, j, value - default) @ back
        bodies.append(Tip(carrier, T))
    return bodies, offsets, parents


def _motion(model: mujoco.MjModel, joint: int, value: float) -> Transform:
    axis = model.jnt_axis[joint]
    if model.jnt_type[joint] == _HINGE:
        return transform(rotation_about(axis, float(value)))
    return transform(translation=value * axis)


def _refuse_loops(model: mujoco.MjModel, bodies: list[Tip]) -> None:
    for e in range(model.neq):
        if int(model.eq_type[e]) not in _LOOPS:
            continue
        ids = [int(model.eq_obj1id[e]), int(model.eq_obj2id[e])]
        if int(model.eq_objtype[e]) == int(_SITE):
            ids = [int(model.site_bodyid[i]) for i in ids]
        carriers = {bodies[i].joint for i in ids}
        if model.eq_active0[e] and len(carriers) > 1:
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, e) or e
            raise ModelError(f"equality {name!r} closes a loop: an arm is an open chain")


def _chain(
    model: mujoco.MjModel,
    joints: tuple[list[int], list[str]],
    curves: dict[int, tuple[int, Polynomial]],
    placed: tuple[list[Transform], list[int]],
) -> Chain:
    from scipy.interpolate import PPoly

    moving, titles = joints
    free = [j for j in moving if curves[j][0] == j]
    coordinates = tuple(titles[moving.index(j)] for j in free)
    matrix, offset = np.zeros((len(moving), len(free))), np.zeros(len(moving))
    bent: list[CoupledCurve] = []
    for i, j in enumerate(moving):
        root, curve = curves[j]
        column = free.index(root)
        if curve.degree() <= 1:
            offset[i], matrix[i, column] = (*curve.coef, 0.0)[:2]
        else:  # one piece from knot 0, extended both ways: the polynomial itself
            pieces = PPoly(curve.coef[::-1, None], np.array([0.0, 1.0]), extrapolate=True)
            bent.append(CoupledCurve(i, column, pieces))
    limits = np.array([_limits(model, j) for j in free])
    return Chain(
        tuple(titles),
        np.array(placed[1]),
        np.array([REVOLUTE if model.jnt_type[j] == _HINGE else PRISMATIC for j in moving]),
        np.array([model.jnt_axis[j] for j in moving]),
        np.array(placed[0]),
        limits[:, 0],
        limits[:, 1],
        Coupling(coordinates, freeze(matrix), freeze(offset), tuple(bent)),
    )


def _limits(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    if model.jnt_limited[joint]:
        low, high = model.jnt_range[joint]
        return float(low), float(high)
    wide = UNLIMITED_TURN if model.jnt_type[joint] == _HINGE else UNLIMITED_SLIDE
    return -wide, wide


def _segments(model: mujoco.MjModel, bodies: list[Tip], n_joints: int) -> list[RigidBody]:
    carried: list[list[RigidBody]] = [[] for _ in range(n_joints)]
    for body, tip in enumerate(bodies):
        if tip.joint == GROUND:
            continue
        R = _frame(np.zeros(3), model.body_iquat[body])[:3, :3]
        inertia = R * model.body_inertia[body] @ R.T
        rigid = RigidBody(float(model.body_mass[body]), np.array(model.body_ipos[body]), inertia)
        carried[tip.joint].append(rigid.moved(tip.transform))
    return [merge_bodies(parts) for parts in carried]
