"""Rewrite a task for the compiled kernels, where they can serve it."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise

import numba
import numpy as np
from jaxtyping import Int

from selfmotion.errors import RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND
from selfmotion.methods.passive import kernels as passive_motion_kernels
from selfmotion.methods.passive import wrist_kernels
from selfmotion.methods.passive.arrays import (
    POINTING,
    POSITION,
    WRIST,
    KernelLaw,
    KernelOut,
    KernelTask,
)
from selfmotion.methods.passive.slopes import Drive
from selfmotion.redundancy.task import Planar, Pointing, Pose, Position, RowMask, Task

# Fewer movements than this are not worth a thread.
MOVEMENTS_PER_THREAD = 50
# Postures at which a chain is compared with the closed form of the wrist (rad).
_PROBES = np.array([[0.0, 0.0, 0.0], [0.4, -0.3, 0.2], [-0.7, 0.5, -0.6], [1.1, 0.9, 0.8]])


def whole_task(task: Task) -> Task:
    """Give the task of which a mask keeps some rows (or the task itself): targets are its."""
    while isinstance(task, RowMask):
        task = task.task
    return task


def kept_rows(task: Task) -> Int[np.ndarray, " rows"]:
    """Give the rows of the whole task that the task keeps."""
    if not isinstance(task, RowMask):
        return np.arange(len(task.units))
    return kept_rows(task.task)[list(task.rows)]


def arm_of(task: Task) -> Arm:
    """Give the arm that a task stands on.

    Raises:
        RangeError: the task does not say.
    """
    arm = getattr(whole_task(task), "arm", None)
    if not isinstance(arm, Arm):
        raise RangeError(f"task {type(task).__name__}: it must have an attribute `arm`")
    return arm


def has_rotation_vectors(task: Task) -> bool:
    """Tell whether the difference of two values of the task is not its error (pose rows)."""
    return isinstance(whole_task(task), Pose) and bool((kept_rows(task) >= 3).any())


def kernel_task(task: Task) -> KernelTask | None:
    """Give a task in the kernels' form, or None where they do not serve it.

    They serve pointing and position (all rows or some) on arms whose joints follow their free
    coordinates linearly; the wrist of [Tommasino2017] has its closed form.
    """
    kept, task = kept_rows(task), whole_task(task)
    found = _parts(task)
    if found is None:
        return None
    kind, rows, vector = found
    arm = arm_of(task)
    assert isinstance(task, Position | Planar | Pointing)
    tip, chain = arm.tip(task.landmark), arm.chain
    if chain.coupling.curves or tip.joint == GROUND:
        return None
    path = []
    joint = tip.joint
    while joint != GROUND:
        path.append(joint)
        joint = int(chain.parent[joint])
    path.reverse()
    z = chain.z_frames
    in_body = tip.transform[:3, 3] if kind == POSITION else tip.transform[:3, :3] @ vector
    served = KernelTask(
        kind,
        np.ascontiguousarray(chain.joint_type[path]),
        np.ascontiguousarray(z.rotations[path]),
        np.ascontiguousarray(z.translations[path]),
        np.ascontiguousarray(z.to_body[tip.joint] @ in_body),
        np.ascontiguousarray(rows[kept]),
        np.ascontiguousarray(chain.coupling.matrix[path]),
        np.ascontiguousarray(chain.coupling.offset[path]),
    )
    return served._replace(kind=WRIST) if _is_wrist(task, kept) else served


def run_kernels(task: KernelTask, law: KernelLaw, drive: Drive) -> KernelOut:
    """Integrate all movements, shared among as many threads as numba may use."""
    n_movements, n = drive.start.shape
    m, n_samples = len(task.rows), len(drive.time)
    out = KernelOut(
        np.empty((n_movements, n_samples, n)),
        np.empty((n_movements, n_samples, n)),
        np.empty((n_movements, n_samples, m)),
        np.empty((n_movements, n_samples, m)),
        np.empty(n_movements, dtype=np.int64),
        np.empty(n_movements),
    )
    given = drive.for_kernels()
    n_threads = min(numba.get_num_threads(), n_movements // MOVEMENTS_PER_THREAD)
    if task.kind == WRIST and given.points.shape[1] == 1:
        integrate = partial(wrist_kernels.integrate, law, given, out)
    else:
        integrate = partial(passive_motion_kernels.integrate, task, law, given, out)
    if n_threads < 2:
        integrate(0, n_movements)
        return out
    edges = np.linspace(0, n_movements, 4 * n_threads + 1).astype(int)
    with ThreadPoolExecutor(n_threads) as pool:
        runs = [pool.submit(integrate, int(a), int(b)) for a, b in pairwise(edges)]
        for run in runs:
            run.result()
    return out


def _parts(task: Task) -> tuple[int, np.ndarray, np.ndarray] | None:
    """Give kind, rows and direction of a task on one tip."""
    if isinstance(task, Position):
        return POSITION, np.eye(3), np.zeros(3)
    if isinstance(task, Planar):
        return POSITION, np.eye(3)[list(task.axes)], np.zeros(3)
    if isinstance(task, Pointing):
        return POINTING, np.asarray(task.screen), task.distance * task.direction
    return None


def _is_wrist(task: Task, kept: np.ndarray) -> bool:
    """Tell whether the closed form of eq. 6 gives the task's values and Jacobians."""
    if not isinstance(task, Pointing) or kept.tolist() != [0, 1]:
        return False
    if arm_of(task).n_joints != 3:
        return False
    closed = [wrist_kernels.wrist_rows(tuple(q)) for q in _PROBES.tolist()]
    x = np.array([rows[0] for rows in closed])
    jac = np.array([rows[1:] for rows in closed])
    same = np.allclose(task.value(_PROBES), x, rtol=0.0, atol=1e-12)
    return same and np.allclose(task.jacobian(_PROBES), jac, rtol=0.0, atol=1e-12)
