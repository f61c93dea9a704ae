"""The muscle paths of a compiled MuJoCo model, written out for `path_kernels`.

Every body of the model stands still relative to one joint of the chain, since joints outside it
are at rest: where, is read off one posture.
"""

import mujoco
import numpy as np
from jaxtyping import Float, Int

from selfmotion.kinematics import kernels
from selfmotion.kinematics.chain import GROUND, PRISMATIC, Chain
from selfmotion.muscles import path_kernels
from selfmotion.muscles.path_kernels import PathTables

_SITE = int(mujoco.mjtWrap.mjWRAP_SITE)
_KINDS = {
    _SITE: path_kernels.SITE,
    int(mujoco.mjtWrap.mjWRAP_SPHERE): path_kernels.SPHERE,
    int(mujoco.mjtWrap.mjWRAP_CYLINDER): path_kernels.CYLINDER,
}


def path_tables(
    model: mujoco.MjModel,
    chain: Chain,
    joint_ids: Int[np.ndarray, " all_joints"],
    actuators: Int[np.ndarray, " muscles"],
) -> PathTables | None:
    """Write the paths of muscles out; None if they hold more than sites, spheres and cylinders.

    Args:
        model: the compiled model.
        chain: its joints; those that are not in it are at rest.
        joint_ids: index in the model of each joint of the chain.
        actuators: index in the model of each muscle; each pulls on a tendon.
    """
    tendons = model.actuator_trnid[actuators, 0]
    starts, counts = model.tendon_adr[tendons], model.tendon_num[tendons]
    spans = [np.arange(a, a + n) for a, n in zip(starts, counts, strict=True)]
    for span in spans:
        kinds = model.wrap_type[span]
        known = np.isin(kinds, list(_KINDS)).all()
        if not known or kinds[0] != _SITE or kinds[-1] != _SITE:
            return None
    elements = np.concatenate(spans)
    carriers = _carriers(model, joint_ids)
    bodies = _frames_on_carriers(model, chain, joint_ids, carriers)
    return PathTables(
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.array([_KINDS[int(kind)] for kind in model.wrap_type[elements]]),
        *_elements(model, elements, carriers, bodies),
        *_side_sites(model, elements, carriers, bodies),
        np.array(model.actuator_gear[actuators, 0]),
        chain.parent,
        chain.joint_type == PRISMATIC,
    )


def _elements(
    model: mujoco.MjModel, elements: np.ndarray, carriers: np.ndarray, bodies: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Give carrier (E), place (E, 3), axes (E, 3, 3) and radius (E) of each element."""
    count = len(elements)
    carrier, radius = np.empty(count, dtype=np.int64), np.zeros(count)
    place, turn = np.empty((count, 3)), np.tile(np.eye(3), (count, 1, 1))
    for i, e in enumerate(elements):
        item = int(model.wrap_objid[e])
        if model.wrap_type[e] == _SITE:
            body, point = int(model.site_bodyid[item]), model.site_pos[item]
        else:
            body, point = int(model.geom_bodyid[item]), model.geom_pos[item]
            R = np.empty(9)
            mujoco.mju_quat2Mat(R, model.geom_quat[item])
            turn[i] = bodies[body, :3, :3] @ R.reshape(3, 3)
            radius[i] = model.geom_size[item, 0]
        carrier[i] = carriers[body]
        place[i] = bodies[body, :3, :3] @ point + bodies[body, :3, 3]
    return carrier, place, turn, radius


def _side_sites(
    model: mujoco.MjModel, elements: np.ndarray, carriers: np.ndarray, bodies: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Give carrier (E) and place (E, 3) of the site beside each surface, if it has one."""
    carrier = np.full(len(elements), path_kernels.NO_SIDE, dtype=np.int64)
    place = np.zeros((len(elements), 3))
    for i, e in enumerate(elements):
        site = int(np.round(model.wrap_prm[e]))
        if model.wrap_type[e] != _SITE and site >= 0:
            body = int(model.site_bodyid[site])
            carrier[i] = carriers[body]
            place[i] = bodies[body, :3, :3] @ model.site_pos[site] + bodies[body, :3, 3]
    return carrier, place


def _carriers(model: mujoco.MjModel, joint_ids: np.ndarray) -> np.ndarray:
    """Give, for each body of the model, the joint of the chain that carries it, or GROUND."""
    out = np.full(model.nbody, GROUND, dtype=np.int64)
    for body in range(1, model.nbody):
        out[body] = out[model.body_parentid[body]]
        on_body = np.flatnonzero(model.jnt_bodyid[joint_ids] == body)
        if len(on_body):
            out[body] = on_body.max()
    return out


def _frames_on_carriers(
    model: mujoco.MjModel, chain: Chain, joint_ids: np.ndarray, carriers: np.ndarray
) -> Float[np.ndarray, "bodies 4 4"]:
    """Give the frame of each body of the model in the z-frame of the joint that carries it."""
    data, z = mujoco.MjData(model), chain.z_frames
    values = chain.coupling.value(
        np.clip(np.zeros((1, len(chain.lower))), chain.lower, chain.upper)
    )
    data.qpos[model.jnt_qposadr[joint_ids]] = values[0]
    mujoco.mj_kinematics(model, data)
    R, p = kernels.body_frames(z.parent, z.joint_type, z.rotations, z.translations, values)
    out = np.tile(np.eye(4), (model.nbody, 1, 1))
    for body, carrier in enumerate(carriers):
        turn, origin = data.xmat[body].reshape(3, 3), data.xpos[body]
        if carrier != GROUND:
            turn = R[0, carrier].T @ turn
            origin = R[0, carrier].T @ (origin - p[0, carrier])
        out[body, :3, :3], out[body, :3, 3] = turn, origin
    return out
