"""A user's own .osim as an arm with muscles: the only file that imports OpenSim.

Chain, couplers and masses are read once and become this library's arrays; path lengths and moment
arms are asked of OpenSim for each posture. Moment arms are the generalised forces of a unit path
tension, which is what OpenSim's own static optimisation uses; where moving path points or
approximate wraps are involved they differ from minus the derivative of length by millimetres.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from selfmotion.errors import FileFormatError, MissingExtraError, ModelError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import Coupling
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.hill import MuscleSet
from selfmotion.muscles.opensim_curves import read_curves
from selfmotion.muscles.opensim_forces import LimitForces, OpensimForces
from selfmotion.muscles.osim_reader import OsimReader, model_coordinates

_DEGREE = np.pi / 180.0
_ROTATIONAL = 1  # Coordinate::MotionType


def _opensim() -> Any:
    try:
        import opensim  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise MissingExtraError(
            'an .osim model needs OpenSim: install the extra with pip install "selfmotion[opensim]"'
        ) from None
    opensim.Logger.removeFileSink()  # or it writes opensim.log where the user happens to be
    opensim.Logger.setLevelString("Off")
    return opensim


def read_osim(
    path: str | Path,
    *,
    convention: str = "opensim",
    landmarks: Mapping[str, str] | None = None,
) -> MusculoskeletalArm:
    """Read an arm with muscles from an .osim file.

    Coordinates that do not move the hand, and locked ones, rest at their defaults. Couplers that
    are splines are kept as they are; those on a straight line become linear.

    Args:
        path: the file.
        convention: opensim or plain (see `muscles.static_optimization`).
        landmarks: landmark (shoulder, elbow, wrist, hand) to the body whose origin it is; left
            out: by the names usual in models of the arm.

    Raises:
        MissingExtraError: OpenSim is not installed.
        FileFormatError: the file does not exist or OpenSim cannot read it.
        ModelError: a joint, function or muscle is of a kind that is not represented, or there
            are no muscles.
        UnknownNameError: a landmark's body is not in the model.
    """
    osim = _opensim()
    file = Path(path)
    if not file.is_file():
        raise FileFormatError(f"{file}: there is no such file")
    try:
        model = osim.Model(str(file))
        state = model.initSystem()
    except RuntimeError as error:
        raise FileFormatError(f"{file}: {' '.join(str(error).split())[:300]}") from None
    if model.getMuscles().getSize() == 0:
        raise ModelError(f"{file}: the model has no muscles")
    reader = OsimReader(osim, model, dict(landmarks or {}))
    arm = _with_what_is_left_out(osim, model, reader.arm(file))
    geometry = OpensimMuscles(osim, model, state, reader.coupling(model_coordinates(model)))
    muscles = _muscle_set(model)
    forces = _forces(osim, model, muscles, convention)
    limits = _limit_forces(osim, model, arm.joints)
    return MusculoskeletalArm(arm, muscles, geometry, forces, convention, limits)


@dataclass(frozen=True, eq=False)
class OpensimMuscles:
    """Paths of the muscles of an OpenSim model, over the free coordinates of its chain.

    Attributes:
        osim: the package.
        model: the model.
        state: its state, used as work space: not for several threads at once.
        coordinates: the model's coordinates from the free ones.
    """

    osim: Any
    model: Any
    state: Any
    coordinates: Coupling

    @cached_property
    def _paths(self) -> list[Any]:
        muscles = self.model.getMuscles()
        return [muscles.get(i).getGeometryPath() for i in range(muscles.getSize())]

    @cached_property
    def _slots(self) -> np.ndarray:
        """Place of each coordinate in the state's vector of q (and of u)."""
        state, slots = self.osim.State(self.state), []
        for c in model_coordinates(self.model):
            c.setLocked(state, False)
            before = state.getQ().to_numpy().copy()
            c.setValue(state, c.getValue(state) + 0.125, False)
            changed = np.flatnonzero(np.abs(state.getQ().to_numpy() - before) > 0.1)
            if len(changed) != 1:
                raise ModelError(f"coordinate {c.getName()!r} is not one entry of the state")
            slots.append(int(changed[0]))
        return np.array(slots)

    def pose(self, values: np.ndarray, speeds: np.ndarray | None = None) -> None:
        """Set all coordinates of the model (no assembly: the coupling has done it), and speeds."""
        q = self.state.getQ().to_numpy().copy()
        q[self._slots] = values
        self.state.setQ(self.osim.Vector.createFromMat(q))
        u = np.zeros(self.state.getNU())
        u[self._slots] = 0.0 if speeds is None else speeds
        self.state.setU(self.osim.Vector.createFromMat(u))
        self.model.realizeVelocity(self.state)

    def length(self, q: Float[np.ndarray, " coords"], muscle: int) -> float:
        """Give the length of one path (m): OpenSim takes nearly all its time over the wraps."""
        self.pose(self.coordinates.value(q[None])[0])
        return float(self._paths[muscle].getLength(self.state))

    def lengths(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give the lengths of all paths (m)."""
        out = np.empty((len(q), len(self._paths)))
        for k, values in enumerate(self.coordinates.value(q)):
            self.pose(values)
            out[k] = [path.getLength(self.state) for path in self._paths]
        return out

    def moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> Float[np.ndarray, "samples muscles coords"]:
        """Give the generalised forces of unit tensions (m)."""
        return self.lengths_and_moment_arms(q)[1]

    def lengths_and_moment_arms(
        self, q: Float[np.ndarray, "samples coords"]
    ) -> tuple[
        Float[np.ndarray, "samples muscles"],
        Float[np.ndarray, "samples muscles coords"],
    ]:
        """Give both, in one pass."""
        osim, state, matter = self.osim, self.state, self.model.getMatterSubsystem()
        n_slots = state.getNU()
        n_bodies = self.model.getBodySet().getSize() + 1
        lengths = np.empty((len(q), len(self._paths)))
        arms = np.empty((*lengths.shape, q.shape[1]))
        forces = osim.Vector(n_slots, 0.0)
        zero = osim.SpatialVec(osim.Vec3(0), osim.Vec3(0))
        derivative = self.coordinates.derivative(q)
        for k, values in enumerate(self.coordinates.value(q)):
            self.pose(values)
            for i, path in enumerate(self._paths):
                lengths[k, i] = path.getLength(state)
                bodies = osim.VectorOfSpatialVec(n_bodies, zero)
                mobility = osim.Vector(n_slots, 0.0)
                path.addInEquivalentForces(state, 1.0, bodies, mobility)
                matter.multiplyBySystemJacobianTranspose(state, bodies, forces)
                total = forces.to_numpy() + mobility.to_numpy()
                arms[k, i] = total[self._slots] @ derivative[k]
        return lengths, arms

    def rates(
        self,
        q: Float[np.ndarray, "samples coords"],
        velocity: Float[np.ndarray, "samples coords"],
    ) -> Float[np.ndarray, "samples muscles"]:
        """Give OpenSim's own lengthening speeds (m/s).

        They are not the moment arms times velocity where path points move or wraps are ellipsoids.
        """
        out = np.empty((len(q), len(self._paths)))
        speeds = np.einsum("kij,kj->ki", self.coordinates.derivative(q), velocity)
        for k, values in enumerate(self.coordinates.value(q)):
            self.pose(values, speeds[k])
            out[k] = [path.getLengtheningSpeed(self.state) for path in self._paths]
        return out

    def paths(self, q: Float[np.ndarray, " coords"]) -> list[Float[np.ndarray, "points 3"]]:
        """Give the points of each muscle's path in the ground (m), for drawing one posture."""
        self.pose(self.coordinates.value(q[None])[0])
        out = []
        for path in self._paths:
            points = path.getCurrentPath(self.state)
            out.append(
                np.array(
                    [
                        points.get(i).getLocationInGround(self.state).to_numpy().copy()
                        for i in range(points.getSize())
                    ]
                )
            )
        return out


def _with_what_is_left_out(osim: Any, model: Any, arm: Arm) -> Arm:
    """Name in the arm's source the forces of the model that are not represented."""
    found = [model.getForceSet().get(i) for i in range(model.getForceSet().getSize())]
    names = [
        f"{force.getName()} ({force.getConcreteClassName()})"
        for force in found
        if force.get_appliesForce()
        and force.getConcreteClassName() != "CoordinateLimitForce"
        and osim.Muscle.safeDownCast(force) is None
    ]
    return replace(arm, source=f"{arm.source}; left out: {', '.join(names)}") if names else arm


def _muscle_set(model: Any) -> MuscleSet:
    muscles = [model.getMuscles().get(i) for i in range(model.getMuscles().getSize())]
    return MuscleSet(
        tuple(m.getName() for m in muscles),
        np.array([m.getMaxIsometricForce() for m in muscles]),
        np.array([m.getOptimalFiberLength() for m in muscles]),
        np.array([m.getTendonSlackLength() for m in muscles]),
        np.array([m.getPennationAngleAtOptimalFiberLength() for m in muscles]),
    )


def _forces(osim: Any, model: Any, muscles: MuscleSet, convention: str) -> OpensimForces:
    found = [model.getMuscles().get(i) for i in range(len(muscles.names))]
    fastest = np.array([m.getMaxContractionVelocity() for m in found])
    curves = tuple(read_curves(osim, m) for m in found)
    return OpensimForces(muscles, curves, fastest, convention)


def _limit_forces(osim: Any, model: Any, names: tuple[str, ...]) -> LimitForces:
    """Read coordinate-limit forces; OpenSim states them in degrees for rotational coordinates."""
    rows = []
    coordinates = {c.getName(): c for c in model_coordinates(model)}
    forces = model.getForceSet()
    for i in range(forces.getSize()):
        force = forces.get(i)
        if force.getConcreteClassName() != "CoordinateLimitForce" or not force.get_appliesForce():
            continue
        value = {key: _number(osim, force, key) for key in _LIMIT_KEYS}
        name = force.getPropertyByName("coordinate").toString()
        if name not in names:
            continue
        unit = _DEGREE if coordinates[name].getMotionType() == _ROTATIONAL else 1.0
        rows.append(
            (
                names.index(name),
                value["upper_limit"] * unit,
                value["lower_limit"] * unit,
                value["upper_stiffness"] / unit,
                value["lower_stiffness"] / unit,
                value["transition"] * unit,
                value["damping"] / unit,
            )
        )
    table = np.array(rows).reshape(-1, 7).T  # without any: no torque
    return LimitForces(table[0].astype(int), *table[1:])


_LIMIT_KEYS = (
    "upper_stiffness",
    "upper_limit",
    "lower_stiffness",
    "lower_limit",
    "transition",
    "damping",
)


def _number(osim: Any, thing: Any, name: str) -> float:
    return float(osim.PropertyHelper.getValueDouble(thing.getPropertyByName(name)))
