"""Muscles of a compiled MuJoCo model: path lengths, moment arms and force curves.

MuJoCo fills neither coupled joints nor equality constraints by kinematics alone; here the coupling
of the chain sets all joints and carries the moment arms over to the free coordinates, so that
they equal minus the total derivative of length.

The default arm comes from the package myo-sim (declared Apache-2.0; derived from MoBL-ARMS, whose
own terms are non-commercial). Nothing of it is copied here.
"""

import contextlib
import io
import warnings
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from jaxtyping import Float, Int
from numba import njit

from selfmotion.arrays import freeze
from selfmotion.errors import ModelError, unknown_name
from selfmotion.kinematics import kernels
from selfmotion.kinematics.chain import Chain
from selfmotion.muscles import path_kernels
from selfmotion.muscles.hill import ForceCurves, MuscleSet, StiffTendonForces
from selfmotion.muscles.mujoco_paths import path_tables
from selfmotion.muscles.path_kernels import PathTables

_MUSCLE = int(mujoco.mjtGain.mjGAIN_MUSCLE)
_TENDON = int(mujoco.mjtTrn.mjTRN_TENDON)


def load_myo_sim(name: str = "myoarm") -> mujoco.MjModel:
    """Load a model of the package myo-sim, without its message about how it was assembled.

    Raises:
        ModelError: the package has no model of this name.
    """
    import myo_sim

    # MuJoCo prints "Attaching a spec with an empty prefix", which concerns saving only.
    handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        try:
            return myo_sim.load_model(name)
        except (KeyError, ValueError, FileNotFoundError) as error:
            raise ModelError(f"myo-sim has no model {name!r}: {error}") from None
        finally:
            mujoco.set_mju_user_warning(handler)


@dataclass(frozen=True, eq=False)
class MujocoMuscles:
    """Paths of the muscles of a compiled model, over the free coordinates of its chain.

    Not for use by several threads at once: MuJoCo's work space is reused from call to call.

    Attributes:
        model: the compiled model.
        chain: its joints, in any order; joints of the model that are not in it stay at rest.
        joint_ids: (N,) index in the model of each joint of the chain.
        actuators: (M,) index in the model of each muscle.
    """

    model: mujoco.MjModel
    chain: Chain
    joint_ids: Int[np.ndarray, " all_joints"]
    actuators: Int[np.ndarray, " muscles"]

    @cached_property
    def _work(self) -> "_Work":
        return _Work.of(self)

    def length(self, q: Float[np.ndarray, " coords"], muscle: int) -> float:
        """Give the length of one path (m)."""
        return float(self.lengths(q[None])[0, muscle])

    def lengths(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the lengths of all paths (m)."""
        return self.lengths_and_moment_arms(q)[0]

    def moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles coords"]:
        """Give the moment arms on the free coordinates (m)."""
        return self.lengths_and_moment_arms(q)[1]

    def lengths_and_moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> tuple[
        Float[np.ndarray, "samples muscles"],
        Float[np.ndarray, "samples muscles coords"],
    ]:
        """Give both, in one pass."""
        if self._tables is not None:
            return self._compiled(q, self._tables)
        m, w = self.model, self._work
        d = w.data
        joints = self.chain.coupling.value(q)
        lengths = np.empty((len(q), m.ntendon))
        jacobian = np.empty((len(q), d.ten_J.size))
        for k in range(len(q)):
            d.qpos[w.qpos] = joints[k]
            mujoco.mj_kinematics(m, d)
            mujoco.mj_comPos(m, d)
            mujoco.mj_tendon(m, d)
            lengths[k] = d.ten_length
            jacobian[k] = d.ten_J.ravel()
        derivative = self.chain.coupling.derivative(q)
        arms = _project(jacobian, *w.sparsity, w.tendons, w.gear, w.joint_of_dof, derivative)
        return lengths[:, w.tendons] * w.gear, arms

    def rates(
        self,
        q: Float[np.ndarray, "samples coords"],
        velocity: Float[np.ndarray, "samples coords"],
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the rate of change of all lengths (m/s): moment arms are minus their slopes."""
        return -np.einsum("kmn,kn->km", self.moment_arms(q), velocity)

    @cached_property
    def _tables(self) -> PathTables | None:
        return path_tables(self.model, self.chain, self.joint_ids, self.actuators)

    def _compiled(self, q: np.ndarray, tables: PathTables) -> tuple[np.ndarray, np.ndarray]:
        """Run our own kernel, for paths over sites, spheres and cylinders."""
        z, coupling = self.chain.z_frames, self.chain.coupling
        frames = kernels.body_frames(
            z.parent, z.joint_type, z.rotations, z.translations, coupling.value(q)
        )
        lengths = np.empty((len(q), len(self.actuators)))
        arms = np.empty((*lengths.shape, self.chain.n_coordinates))
        path_kernels.lengths_and_moment_arms(tables, *frames, coupling.derivative(q), lengths, arms)
        return lengths, arms

    def paths(self, q: Float[np.ndarray, " coords"]) -> list[Float[np.ndarray, "points 3"]]:
        """Give the points of each muscle's path in the ground (m), for drawing one posture."""
        m, w = self.model, self._work
        w.data.qpos[w.qpos] = self.chain.coupling.value(q[None])[0]
        mujoco.mj_kinematics(m, w.data)
        mujoco.mj_tendon(m, w.data)
        points = w.data.wrap_xpos.reshape(-1, 3)
        first, count = w.data.ten_wrapadr[w.tendons], w.data.ten_wrapnum[w.tendons]
        return [points[a : a + n].copy() for a, n in zip(first, count, strict=True)]


@dataclass(frozen=True, eq=False)
class _Work:
    """MuJoCo's work space, and where in it each joint and each tendon is.

    `sparsity` holds number, first place and columns of the entries of each row of the tendon
    Jacobian, which MuJoCo keeps sparse.
    """

    data: mujoco.MjData
    qpos: np.ndarray
    tendons: np.ndarray
    gear: np.ndarray
    joint_of_dof: np.ndarray
    sparsity: tuple[np.ndarray, np.ndarray, np.ndarray]

    @classmethod
    def of(cls, muscles: "MujocoMuscles") -> "_Work":
        m = muscles.model
        data = mujoco.MjData(m)
        joint_of_dof = np.full(m.nv, -1, dtype=np.int64)
        joint_of_dof[m.jnt_dofadr[muscles.joint_ids]] = np.arange(len(muscles.joint_ids))
        # Until MuJoCo 3.4 the sparsity stood in the data, not in the model.
        holder = m if hasattr(m, "ten_J_rownnz") else data
        sparsity = tuple(
            np.array(getattr(holder, f"ten_J_{part}"), dtype=np.int64).ravel()
            for part in ("rownnz", "rowadr", "colind")
        )
        return cls(
            data,
            m.jnt_qposadr[muscles.joint_ids],
            np.array(m.actuator_trnid[muscles.actuators, 0], dtype=np.int64),
            np.array(m.actuator_gear[muscles.actuators, 0]),
            joint_of_dof,
            sparsity,  # pyright: ignore[reportArgumentType]
        )


def muscles_from_mujoco(
    model: mujoco.MjModel, chain: Chain
) -> tuple[MuscleSet, MujocoMuscles, StiffTendonForces]:
    """Read the muscles of a compiled model whose joints are those of a chain.

    Args:
        model: with muscle actuators on tendons.
        chain: built from the same model; a joint is found by its name, or its name with one of
            the side suffixes ``_r`` and ``_l``.

    Raises:
        ModelError: the model has no muscles, or a muscle does not pull on a tendon.
        UnknownNameError: a joint of the chain is not in the model.
    """
    ids = np.flatnonzero(model.actuator_gaintype == _MUSCLE)
    if len(ids) == 0:
        raise ModelError(f"the model has no muscles among its {model.nu} actuators")
    for i in ids:
        if model.actuator_trntype[i] != _TENDON:
            name = model.actuator(i).name
            raise ModelError(f"muscle {name!r} does not pull on a tendon: its path is not known")
    gain, bias = model.actuator_gainprm[ids], model.actuator_biasprm[ids]
    muscles, relaxed = (_muscle_set(model, ids, prm) for prm in (gain, bias))
    columns = (gain[:, 4], gain[:, 5], gain[:, 6], bias[:, 7], gain[:, 8])
    curves = ForceCurves(*(freeze(np.array(c)) for c in columns))
    joint_ids = np.array([_joint_id(model, name) for name in chain.names], dtype=np.int64)
    geometry = MujocoMuscles(model, chain, joint_ids, ids.astype(np.int64))
    return muscles, geometry, StiffTendonForces(muscles, curves, relaxed)


def _joint_id(model: mujoco.MjModel, name: str) -> int:
    for candidate in (name, f"{name}_r", f"{name}_l"):
        found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, candidate)
        if found >= 0:
            return found
    raise unknown_name("joint", name, tuple(model.joint(i).name for i in range(model.njnt)))


def _muscle_set(model: mujoco.MjModel, ids: np.ndarray, prm: np.ndarray) -> MuscleSet:
    """Turn MuJoCo's parameters into fibre, tendon and force.

    MuJoCo spreads a range of normalised lengths over the range of path lengths: one fibre length
    is the ratio of the two, and what remains of the path is tendon.
    """
    spread = model.actuator_lengthrange[ids]
    names = tuple(model.actuator(i).name for i in ids)
    if not (spread[:, 1] > spread[:, 0]).all():
        i = int(np.argmin(spread[:, 1] - spread[:, 0]))
        raise ModelError(f"muscle {names[i]!r}: the model does not hold its range of lengths")
    fibre = (spread[:, 1] - spread[:, 0]) / (prm[:, 1] - prm[:, 0])
    tendon = spread[:, 0] - prm[:, 0] * fibre
    scaled = prm[:, 3] / np.maximum(model.actuator_acc0[ids], mujoco.mjMINVAL)
    force = np.where(prm[:, 2] < 0, scaled, prm[:, 2])
    return MuscleSet(names, force, fibre, tendon, np.zeros(len(ids)))


@njit(cache=True)
def _project(values, count, first, column, tendons, gear, joint_of_dof, coupling):
    """Give moment arms (K,M,n): minus tendon Jacobian times coupling (K,N,n)."""
    n_samples, _, n = coupling.shape
    out = np.zeros((n_samples, tendons.shape[0], n))
    for k in range(n_samples):
        for i in range(tendons.shape[0]):
            row = tendons[i]
            for e in range(first[row], first[row] + count[row]):
                joint = joint_of_dof[column[e]]
                if joint >= 0:
                    v = -gear[i] * values[k, e]
                    for c in range(n):
                        out[k, i, c] += v * coupling[k, joint, c]
    return out
