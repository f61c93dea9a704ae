"""Joints, couplers and masses of an OpenSim model as this library's chain.

The package itself is handed in by `opensim_bridge`, the only file that imports it.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.arrays import Transform, freeze
from selfmotion.errors import ModelError, unknown_name
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
from selfmotion.kinematics.inertia import RigidBody, merge_bodies
from selfmotion.muscles.osim_functions import Curve
from selfmotion.spatial import invert, rotation_about, transform

# Bodies whose origin is a joint centre, by their names in the models of the arm.
BODIES: Mapping[str, tuple[str, ...]] = {
    "shoulder": ("humphant", "humerus", "humerus_r", "r_humerus"),
    "elbow": ("ulna", "ulna_r", "r_ulna_radius_hand"),
    "wrist": ("proximal_row", "lunate", "hand", "hand_r", "r_ulna_radius_hand"),
    "hand": ("hand", "hand_r", "capitate", "r_ulna_radius_hand"),
}


def model_coordinates(model: Any) -> list[Any]:
    """Give the coordinates of a model, in its order."""
    coordinates = model.getCoordinateSet()
    return [coordinates.get(i) for i in range(coordinates.getSize())]


class OsimReader:
    """Turns joints, couplers and bodies into a chain."""

    def __init__(self, osim: Any, model: Any, landmarks: dict[str, str]) -> None:
        """Read couplers and lay out the tree."""
        self.osim, self.model = osim, model
        self.joints = [model.getJointSet().get(i) for i in range(model.getJointSet().getSize())]
        self.parent_of = {self._child(j): (self._parent(j), j) for j in self.joints}
        self.landmarks = self._landmark_bodies(landmarks)
        self.leaders = self._leaders()
        moving = self._moving()
        self.free = [
            c.getName()
            for c in model_coordinates(model)
            if c.getName() in moving and self.leaders[c.getName()][0] == c.getName()
        ]
        self.names: list[str] = []
        self.parents: list[int] = []
        self.types: list[int] = []
        self.axes: list[np.ndarray] = []
        self.offsets: list[Transform] = []
        self.rows: list[tuple[str, Curve]] = []
        self.bodies: dict[str, Tip] = {"ground": Tip(GROUND)}
        for child in list(self.parent_of):
            self._place(child)

    def _parent(self, joint: Any) -> str:
        return joint.getParentFrame().findBaseFrame().getName()

    def _child(self, joint: Any) -> str:
        return joint.getChildFrame().findBaseFrame().getName()

    def _landmark_bodies(self, given: dict[str, str]) -> dict[str, str]:
        known = tuple(self.parent_of)
        out: dict[str, str] = {}
        for landmark in LANDMARKS:
            choices = (given[landmark],) if landmark in given else BODIES[landmark]
            found = [name for name in choices if name in known]
            if not found:
                raise unknown_name(f"body for the landmark {landmark}:", choices[0], known)
            out[landmark] = found[0]
        return out

    def _leaders(self) -> dict[str, tuple[str | None, Curve]]:
        """Give, for each coordinate, the free one it follows and how; None: it rests."""
        followers: dict[str, tuple[str, Curve]] = {}
        constraints = self.model.getConstraintSet()
        for i in range(constraints.getSize()):
            c = self.osim.CoordinateCouplerConstraint.safeDownCast(constraints.get(i))
            if c is None or not c.get_isEnforced():
                continue
            names = c.getIndependentCoordinateNames()
            if names.getSize() != 1:
                raise ModelError(f"coupler {c.getName()!r} follows {names.getSize()} coordinates")
            followers[c.getDependentCoordinateName()] = (names.get(0), self._curve(c.getFunction()))
        out: dict[str, tuple[str | None, Curve]] = {}
        coordinates = {c.getName(): c for c in model_coordinates(self.model)}

        def resolve(name: str) -> tuple[str | None, Curve]:
            c = coordinates[name]
            if c.get_locked():
                return None, Curve.line(0.0, c.getDefaultValue())
            if name not in followers:
                return name, Curve.line(1.0, 0.0)
            leader, curve = followers[name]
            root, inner = resolve(leader)
            return root, self._after(curve, inner, name)

        for name in coordinates:
            out[name] = resolve(name)
        return out

    def _after(self, outer: Curve, inner: Curve, name: str) -> Curve:
        curve = outer.after(inner)
        if curve is None:
            raise ModelError(f"{name!r} follows a spline of a spline, which is not represented")
        return curve

    def _moving(self) -> set[str]:
        """Give the free coordinates that move the hand; all others rest."""
        moving: set[str] = set()
        body = self.landmarks["hand"]
        while body in self.parent_of:
            body, joint = self.parent_of[body]
            for i in range(joint.numCoordinates()):
                root = self.leaders[joint.get_coordinates(i).getName()][0]
                moving |= {root} if root else set()
        defaults = {c.getName(): c.getDefaultValue() for c in model_coordinates(self.model)}
        for name, (root, curve) in self.leaders.items():
            if root is not None and root not in moving:
                self.leaders[name] = (None, Curve.line(0.0, curve(defaults[root])[0]))
        return moving

    def _place(self, child: str) -> None:
        """Add the joints that carry a body, its parents first."""
        if child in self.bodies:
            return
        parent, joint = self.parent_of[child]
        self._place(parent)
        carrier = self.bodies[parent]
        T = carrier.transform @ _matrix(joint.getParentFrame().findTransformInBaseFrame())
        at = carrier.joint
        for kind, axis, name, curve in self._steps(joint):
            root, inner = (None, curve) if name is None else self.leaders[name]
            whole = curve if name is None else self._after(curve, inner, name)
            if root is None:
                value = whole(0.0)[0]
                turn = rotation_about(axis, value) if kind == REVOLUTE else None
                T = T @ transform(turn, value * axis if kind == PRISMATIC else None)
                continue
            title = name if name not in self.names else f"{name}_{len(self.names)}"
            self.names.append(str(title))
            self.parents.append(at)
            self.types.append(kind)
            self.axes.append(axis / np.linalg.norm(axis))
            self.offsets.append(T)
            self.rows.append((root, whole))
            at, T = len(self.names) - 1, np.eye(4)
        T = T @ invert(_matrix(joint.getChildFrame().findTransformInBaseFrame()))
        self.bodies[child] = Tip(at, T)

    def _steps(self, joint: Any) -> list[tuple[int, np.ndarray, str | None, Curve]]:
        """Give the motions of a joint in order: kind, axis, coordinate, function of it."""
        x, y, z = np.eye(3)
        same = Curve.line(1.0, 0.0)
        names = [joint.get_coordinates(i).getName() for i in range(joint.numCoordinates())]
        kind = joint.getConcreteClassName()
        simple = {"WeldJoint": [], "PinJoint": [(REVOLUTE, z)], "SliderJoint": [(PRISMATIC, x)]}
        simple["UniversalJoint"] = [(REVOLUTE, x), (REVOLUTE, y)]
        if kind in simple:
            return [
                (t, axis, name, same) for (t, axis), name in zip(simple[kind], names, strict=True)
            ]
        custom = self.osim.CustomJoint.safeDownCast(joint)
        if custom is None:
            raise ModelError(f"joint {joint.getName()!r} is a {kind}, which is not represented")
        motion = custom.getSpatialTransform()
        steps: list[tuple[int, np.ndarray, str | None, Curve]] = []
        for i in (3, 4, 5, 0, 1, 2):  # translations in the parent's axes, then rotations
            axis = motion.getTransformAxis(i)
            driven = axis.getCoordinateNamesInArray()
            if driven.getSize() > 1:
                raise ModelError(f"joint {joint.getName()!r}: an axis follows two coordinates")
            if not axis.hasFunction():
                continue
            name = driven.get(0) if driven.getSize() == 1 else None
            curve = self._curve(axis.getFunction())
            kind_of_axis = PRISMATIC if i > 2 else REVOLUTE
            steps.append((kind_of_axis, axis.getAxis().to_numpy().copy(), name, curve))
        return steps

    def _curve(self, function: Any) -> Curve:
        """Turn an OpenSim function of one variable into a `Curve`."""
        osim, kind = self.osim, function.getConcreteClassName()
        if kind == "Constant":
            return Curve.line(0.0, osim.Constant.safeDownCast(function).getValue())
        if kind == "LinearFunction":
            line = osim.LinearFunction.safeDownCast(function)
            return Curve.line(line.getSlope(), line.getIntercept())
        if kind == "MultiplierFunction":
            product = osim.MultiplierFunction.safeDownCast(function)
            inner, scale = self._curve(product.getFunction()), product.getScale()
            return Curve(inner.knots, scale * inner.values, scale * inner.slopes)
        if kind == "SimmSpline":
            spline = osim.SimmSpline.safeDownCast(function)
            knots = np.array([spline.getX(i) for i in range(spline.getSize())])
            values = np.array([spline.calcValue(osim.Vector(1, float(x))) for x in knots])
            # A plain list: OpenSim's own vector of integers is refused where ezc3d is in use.
            slopes = [spline.calcDerivative([0], osim.Vector(1, float(x))) for x in knots]
            return Curve(knots, values, np.array(slopes))
        raise ModelError(f"a function of kind {kind} is not represented")

    def coupling(self, coordinates: list[Any]) -> Coupling:
        """Give the model's own coordinates from the free ones."""
        return self._coupling([self.leaders[c.getName()] for c in coordinates])

    def _coupling(self, rows: list[tuple[str | None, Curve]]) -> Coupling:
        matrix, offset = np.zeros((len(rows), len(self.free))), np.zeros(len(rows))
        curves: list[CoupledCurve] = []
        for i, (root, curve) in enumerate(rows):
            line = curve.as_line
            if root is None:
                offset[i] = curve(0.0)[0]
            elif line is not None:
                matrix[i, self.free.index(root)], offset[i] = line
            else:
                curves.append(CoupledCurve(i, self.free.index(root), curve.to_ppoly()))
        return Coupling(tuple(self.free), freeze(matrix), freeze(offset), tuple(curves))

    def arm(self, file: Path) -> Arm:
        """Put the arm together."""
        ranges = {
            c.getName(): (c.getRangeMin(), c.getRangeMax()) for c in model_coordinates(self.model)
        }
        limits = np.array([ranges[name] for name in self.free])
        chain = Chain(
            tuple(self.names),
            np.array(self.parents),
            np.array(self.types),
            np.array(self.axes),
            np.array(self.offsets),
            limits[:, 0],
            limits[:, 1],
            self._coupling(list(self.rows)),
        )
        carried = self._carried()
        gravity = self.model.getGravity().to_numpy().copy()
        size = float(np.linalg.norm(gravity))
        return Arm(
            name=file.stem,
            chain=chain,
            landmarks={key: self.bodies[body] for key, body in self.landmarks.items()},
            lengths={},
            mass=np.array([b.mass for b in carried]),
            com=np.array([b.com for b in carried]),
            inertia=np.array([b.inertia for b in carried]),
            gravity=gravity,
            up=-gravity / size if size > 0 else np.array([0.0, 1.0, 0.0]),
            forward=np.array([1.0, 0.0, 0.0]),
            source=f"{file.name}; limits, masses and inertias as in the file",
        )

    def _carried(self) -> list[RigidBody]:
        parts: list[list[RigidBody]] = [[] for _ in self.names]
        for name, tip in self.bodies.items():
            if tip.joint == GROUND:
                continue
            body = self.model.getBodySet().get(name)
            m = body.getInertia().getMoments().to_numpy()
            p = body.getInertia().getProducts().to_numpy()
            inertia = np.array([[m[0], p[0], p[1]], [p[0], m[1], p[2]], [p[1], p[2], m[2]]])
            rigid = RigidBody(body.getMass(), body.getMassCenter().to_numpy().copy(), inertia)
            parts[tip.joint].append(rigid.moved(tip.transform))
        return [merge_bodies(bodies) for bodies in parts]


def _matrix(T: Any) -> Transform:
    out = np.eye(4)
    for i in range(3):
        out[i, 3] = T.p().get(i)
        for j in range(3):
            out[i, j] = T.R().get(i, j)
    return out
