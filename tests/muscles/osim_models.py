"""Small OpenSim models that the tests build, and OpenSim's own static optimisation."""

from pathlib import Path

import numpy as np


def small_arm(osim, file: Path) -> None:
    """Write a planar arm: shoulder, elbow, and a wrist that follows the elbow along a spline."""
    model = osim.Model()
    model.setName("small")
    model.setGravity(osim.Vec3(0, -9.81, 0))
    parent, place = model.getGround(), osim.Vec3(0, 0, 0)
    zero = osim.Vec3(0, 0, 0)
    for name, length, joint, coordinate in (
        ("humerus", 0.3, "shoulder", "shoulder_angle"),
        ("ulna", 0.25, "elbow", "elbow_angle"),
        ("hand", 0.08, "wrist", "wrist_angle"),
    ):
        inertia = osim.Inertia(0.01, 0.001, 0.01, 0, 0, 0)
        body = osim.Body(name, 1.5 * length / 0.3, osim.Vec3(0.01, -length / 2, 0), inertia)
        model.addBody(body)
        pin = osim.PinJoint(joint, parent, place, osim.Vec3(0, 0, 0.1), body, zero, zero)
        c = pin.updCoordinate()
        c.setName(coordinate)
        c.setRangeMin(-0.2)
        c.setRangeMax(2.4)
        model.addJoint(pin)
        parent, place = body, osim.Vec3(0, -length, 0)
    spline = osim.SimmSpline()
    for x, y in ((-0.5, -0.1), (0.3, 0.0), (1.0, 0.2), (2.5, 0.3)):
        spline.addPoint(x, y)
    names = osim.ArrayStr()
    names.append("elbow_angle")
    coupler = osim.CoordinateCouplerConstraint()
    coupler.setName("wrist_follows")
    coupler.setIndependentCoordinateNames(names)
    coupler.setDependentCoordinateName("wrist_angle")
    coupler.setFunction(spline)
    model.addConstraint(coupler)
    _add_muscles(osim, model)
    limit = osim.CoordinateLimitForce("elbow_angle", 60.0, 0.5, 20.0, 0.3, 0.0, 15.0)
    limit.setName("elbow_limit")
    model.addForce(limit)
    model.finalizeConnections()
    model.printToXML(str(file))


def _add_muscles(osim, model) -> None:
    ground = model.getGround()
    body = {name: model.getBodySet().get(name) for name in ("humerus", "ulna", "hand")}
    paths = {
        "front": ((ground, 0.05, 0.03), (body["humerus"], 0.03, -0.12)),
        "back": ((ground, -0.05, 0.03), (body["humerus"], -0.03, -0.12)),
        "biceps": ((ground, 0.03, 0.02), (body["ulna"], 0.02, -0.05)),
        "brachialis": ((body["humerus"], 0.02, -0.15), (body["ulna"], 0.02, -0.04)),
        "triceps": ((body["humerus"], -0.03, -0.1), (body["ulna"], -0.02, 0.02)),
        "wrist_flexor": ((body["humerus"], 0.02, -0.28), (body["hand"], 0.015, -0.03)),
    }
    for name, points in paths.items():
        muscle = osim.Millard2012EquilibriumMuscle(name, 4000.0, 0.12, 0.05, 0.2)
        for i, (frame, x, y) in enumerate(points):
            muscle.addNewPathPoint(f"{name}_{i}", frame, osim.Vec3(x, y, 0))
        model.addForce(muscle)


TIME = np.linspace(0.0, 1.0, 101)  # of a motion that OpenSim analyses
MIDDLE = 50


def static_optimization(osim, file: Path, values: dict[str, np.ndarray], folder: Path) -> dict:
    """Give activations by OpenSim's own analysis amid a motion over `TIME`, tolerance 1e-8."""
    motion = folder / "posture.mot"
    table = np.column_stack([TIME, *values.values()])
    rows = ["\t".join(f"{v:.15g}" for v in row) for row in table]
    head = ["posture", "version=1", f"nRows={len(rows)}", f"nColumns={len(values) + 1}"]
    lines = [*head, "inDegrees=no", "endheader", "time\t" + "\t".join(values), *rows, ""]
    motion.write_text("\n".join(lines))
    model = osim.Model(str(file))
    model.initSystem()
    analysis = osim.StaticOptimization()
    analysis.setStartTime(TIME[MIDDLE])
    analysis.setEndTime(TIME[MIDDLE + 1])
    analysis.setConvergenceCriterion(1e-8)
    analysis.setMaxIterations(3000)
    model.addAnalysis(analysis)
    tool = osim.AnalyzeTool(model)
    tool.setName("oracle")
    tool.setCoordinatesFileName(str(motion))
    tool.setInitialTime(TIME[MIDDLE])
    tool.setFinalTime(TIME[MIDDLE + 1])
    tool.setResultsDir(str(folder))
    tool.setLowpassCutoffFrequency(-1.0)
    tool.setLoadModelAndInput(True)
    tool.run()
    table = osim.TimeSeriesTable(str(next(folder.glob("*activation*"))))
    row = np.array(table.getRowAtIndex(0).to_numpy())
    return dict(zip(table.getColumnLabels(), row, strict=True))


def one_muscle(osim, kind: str, pennation: float):
    """Give a model of one muscle along a slide: 1000 N, fibre 0.1 m, tendon 0.2 m."""
    model = osim.Model()
    ground, zero = model.getGround(), osim.Vec3(0, 0, 0)
    body = osim.Body("slide", 1.0, zero, osim.Inertia(1))
    model.addBody(body)
    joint = osim.SliderJoint("joint", ground, zero, zero, body, zero, zero)
    joint.updCoordinate().setName("x")
    model.addJoint(joint)
    muscle = getattr(osim, kind)()
    muscle.setName("m")
    muscle.setMaxIsometricForce(1000.0)
    muscle.setOptimalFiberLength(0.1)
    muscle.setTendonSlackLength(0.2)
    muscle.setPennationAngleAtOptimalFiberLength(pennation)
    muscle.addNewPathPoint("a", ground, zero)
    muscle.addNewPathPoint("b", body, zero)
    model.addForce(muscle)
    model.finalizeConnections()
    return model
