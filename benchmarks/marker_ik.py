"""Marker inverse kinematics beside OpenSim's, on the same frames and the same arm, on one core.

    python benchmarks/marker_ik.py FOLDER --study study.toml [--people 8] [--trials 4]
        [--accuracy 1e-5]

FOLDER and study file as for ``selfmotion weights FOLDER --study`` with marker files. Each person is
calibrated by selfmotion; the person's arm is then written as an OpenSim model (pin joints, the same
places and weights of the markers, clamped coordinates with the same ranges), and the landmarks of
each trial as a TRC file. OpenSim runs as its InverseKinematicsTool (files in, file out) and as its
InverseKinematicsSolver alone (the tracking loop). Errors of all are measured by one rule, with
selfmotion's forward kinematics. Times are CPU times of this process, which runs one thread.
"""

import argparse
import contextlib
import os
import platform
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np
import opensim as osim  # pyright: ignore[reportMissingImports]

from rows import Row, add_rows_option, write_rows
from selfmotion.capture.angles import ArmMotion
from selfmotion.capture.marker_ik import (
    MarkerIkOptions,
    MarkerModel,
    marker_arrays,
    solve_marker_ik,
)
from selfmotion.capture.person import Person, ground_from_trunk
from selfmotion.kinematics.chain import GROUND
from selfmotion.motion.files.storage import read_storage
from selfmotion.motion.files.trc import write_trc
from selfmotion.motion.labels import Frame
from selfmotion.motion.markers import MarkerSet
from selfmotion.studies.people import load_people
from selfmotion.studies.study_file import load_study_file

ACCURACY = 1e-5  # OpenSim's default


@dataclass(frozen=True)
class Frames:
    """The frames of one trial as OpenSim reads them.

    Attributes:
        trc: file of the markers.
        count: number of frames.
        rate: Hz.
        accuracy: asked of OpenSim.
    """

    trc: Path
    count: int
    rate: float
    accuracy: float


@dataclass(frozen=True, eq=False)
class Answer:
    """Angles (K, n) of one solver and the CPU seconds it took."""

    q: np.ndarray
    seconds: float


def landmarks_in_ground(person: Person, motion: ArmMotion) -> np.ndarray:
    """Give the landmarks (K, M, 3) in the arm's ground frame (m), frames that are whole."""
    turn = ground_from_trunk(person.arm)
    paths = [motion.landmarks[name].path for name in person.model.markers]
    local = [np.einsum("kji,kj->ki", motion.trunk, path - motion.ground) @ turn.T for path in paths]
    targets = np.stack(local, axis=1)
    return targets[np.isfinite(targets).all(axis=(1, 2))]


def opensim_model(model: MarkerModel) -> osim.Model:
    """Write an arm with markers as an OpenSim model: a pin joint for each of ours."""
    chain, arrays = model.arm.chain, marker_arrays(model)
    made = osim.Model()
    made.setName("arm")
    bodies = {GROUND: made.getGround()}
    for i, name in enumerate(chain.names):
        body = osim.Body(f"body_{name}", 1.0, osim.Vec3(0), osim.Inertia(0.01, 0.01, 0.01))
        matrix = osim.Mat33(*arrays.rotations[i].ravel().tolist())
        turn = osim.Rotation(matrix).convertRotationToBodyFixedXYZ()
        place = osim.Vec3(*arrays.translations[i].tolist())
        ends = (bodies[int(chain.parent[i])], place, turn, body, osim.Vec3(0), osim.Vec3(0))
        joint = osim.PinJoint(f"joint_{name}", *ends)
        coordinate = joint.updCoordinate()
        k = model.arm.joints.index(name)
        coordinate.setName(name)
        coordinate.setRangeMin(float(model.arm.lower[k]))
        coordinate.setRangeMax(float(model.arm.upper[k]))
        coordinate.setDefaultClamped(True)
        coordinate.setDefaultValue(float(np.clip(0.0, model.arm.lower[k], model.arm.upper[k])))
        made.addBody(body)
        made.addJoint(joint)
        bodies[i] = body
    for m, name in enumerate(model.markers):
        place = osim.Vec3(*arrays.local[m].tolist())
        made.addMarker(osim.Marker(name, bodies[int(arrays.body[m])], place))
    made.finalizeConnections()
    return made


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Keep what the tool prints about its model off the screen."""
    screen = os.dup(1)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(screen, 1)
            os.close(screen)


def run_tool(model: MarkerModel, frames: Frames) -> Answer:
    """Run the InverseKinematicsTool: model and TRC in, MOT out."""
    made, folder = opensim_model(model), frames.trc.parent
    tool = osim.InverseKinematicsTool()
    tool.setModel(made)
    tool.setMarkerDataFileName(str(frames.trc))
    tool.setOutputMotionFileName(str(folder / "ik.mot"))
    tool.setResultsDir(str(folder))
    tool.set_report_errors(False)
    tool.setStartTime(0.0)
    tool.setEndTime((frames.count - 1) / frames.rate)
    tool.set_accuracy(frames.accuracy)
    tasks = tool.getIKTaskSet()
    for name in model.markers:
        task = osim.IKMarkerTask()
        task.setName(name)
        task.setApply(True)
        task.setWeight(float(model.weights.get(name, 1.0)))
        tasks.cloneAndAppend(task)
    with silenced():
        begin = time.process_time()
        tool.run()
        seconds = time.process_time() - begin
    table = read_storage(folder / "ik.mot")
    columns = [table.columns.index(name) for name in model.arm.joints]
    return Answer(np.deg2rad(table.values[:, columns]), seconds)


def run_solver(model: MarkerModel, frames: Frames) -> Answer:
    """Run the InverseKinematicsSolver frame by frame; nothing is written."""
    made = opensim_model(model)
    state = made.initSystem()
    weights = osim.SetMarkerWeights()
    for name in model.markers:
        weights.cloneAndAppend(osim.MarkerWeight(name, float(model.weights.get(name, 1.0))))
    reference = osim.MarkersReference(str(frames.trc), weights)
    solver = osim.InverseKinematicsSolver(made, reference, osim.SimTKArrayCoordinateReference())
    solver.setAccuracy(frames.accuracy)
    coordinates = [made.getCoordinateSet().get(name) for name in model.arm.joints]
    q = np.empty((frames.count, len(coordinates)))
    begin = time.process_time()
    for k in range(frames.count):
        state.setTime(k / frames.rate)
        if k == 0:
            solver.assemble(state)
        else:
            solver.track(state)
        q[k] = [c.getValue(state) for c in coordinates]
    return Answer(q, time.process_time() - begin)


def run_ours(model: MarkerModel, targets: np.ndarray, options: MarkerIkOptions) -> Answer:
    begin = time.process_time()
    q = solve_marker_ik(model, targets, options=options).q
    return Answer(q, time.process_time() - begin)


def trial(
    person: Person, motion: ArmMotion, rate: float, accuracy: float
) -> tuple[np.ndarray, dict[str, Answer]]:
    """Solve one trial by all; give its targets and their answers."""
    targets, model = landmarks_in_ground(person, motion), person.model
    calm = np.clip(np.median(person.calibration.q, axis=0), model.arm.lower, model.arm.upper)
    starts = np.stack([person.calibration.q[0], calm, model.arm.middle()])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        times = np.arange(len(targets)) / rate
        frames = Frames(folder / "m.trc", len(targets), rate, accuracy)
        write_trc(frames.trc, MarkerSet(times, model.markers, targets, Frame()))
        return targets, {
            "selfmotion": run_ours(model, targets, MarkerIkOptions(starts=starts)),
            "OpenSim solver": run_solver(model, frames),
            "OpenSim tool": run_tool(model, frames),
        }


def errors(model: MarkerModel, q: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give rms landmark error (m) and weighted sum of squares (m²) of each frame."""
    square = ((model.positions(q) - targets) ** 2).sum(axis=2)
    weights = np.array([float(model.weights.get(name, 1.0)) for name in model.markers])
    return np.sqrt(square.mean(axis=1)), square @ weights


def report(name: str, parts: list[dict[str, float]], base: float) -> None:
    frames = sum(p["frames"] for p in parts)
    seconds = sum(p["seconds"] for p in parts)
    rms = np.median([p["rms"] for p in parts])
    outside = np.rad2deg(max(p["outside"] for p in parts))
    apart = np.rad2deg(np.median([p["apart"] for p in parts]))
    worst = max(p["worse"] for p in parts)
    print(
        f"  {name:16s} {frames / seconds:9.0f} frames/s ({seconds / frames / base:6.1f} times ours)"
        f"  rms {1e3 * rms:5.2f} mm, objective above ours at most {1e6 * worst:8.3f} mm^2"
        f"  beyond limits {outside:.4f} deg, angles from ours {apart:.3f} deg (median rms)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--study", type=Path, required=True)
    parser.add_argument("--people", type=int, default=8)
    parser.add_argument("--trials", type=int, default=4, help="of each person, spread over theirs")
    parser.add_argument("--accuracy", type=float, default=ACCURACY, help="asked of OpenSim")
    add_rows_option(parser)
    args = parser.parse_args()
    osim.Logger.setLevelString("off")
    print(platform.processor() or platform.machine(), platform.python_version())
    print(
        f"  selfmotion {version('selfmotion')}, OpenSim {osim.GetVersion()}, "
        f"numba {version('numba')}, numpy {np.__version__}; accuracy of OpenSim {args.accuracy:g}"
    )
    found: dict[str, list[dict[str, float]]] = {}
    people = load_people([args.folder], load_study_file(args.study))
    arms = 0
    for recorded in people:
        if recorded.side != "right" or arms == args.people:
            continue
        arms += 1
        step = max(1, len(recorded.movements) // args.trials)
        for movement in recorded.movements[::step][: args.trials]:
            model, rate = recorded.person.model, movement.motion.recording.rate or 100.0
            targets, answers = trial(recorded.person, movement.motion, rate, args.accuracy)
            ours = answers["selfmotion"].q
            _, best = errors(model, ours, targets)
            for name, answer in answers.items():
                rms, objective = errors(model, answer.q, targets)
                low, high = model.arm.lower - answer.q, answer.q - model.arm.upper
                found.setdefault(name, []).append(
                    {
                        "frames": len(targets),
                        "seconds": answer.seconds,
                        "rms": float(np.median(rms)),
                        "worse": float((objective - best).max()),
                        "outside": float(max(low.max(), high.max(), 0.0)),
                        "apart": float(np.sqrt(((answer.q - ours) ** 2).mean())),
                    }
                )
    first = found["selfmotion"]
    base = sum(p["seconds"] for p in first) / sum(p["frames"] for p in first)
    print(f"{arms} right arms, {len(first)} trials, {sum(p['frames'] for p in first):.0f} frames")
    for name, parts in found.items():
        report(name, parts, base)
    write_rows(args.rows, compared(found, args.accuracy))


def compared(found: dict[str, list[dict[str, float]]], accuracy: float) -> list[Row]:
    """Give a row for each way to run OpenSim."""
    speed = {
        name: sum(p["frames"] for p in parts) / sum(p["seconds"] for p in parts)
        for name, parts in found.items()
    }
    frames = sum(p["frames"] for p in found["selfmotion"])
    rms = {name: 1e3 * np.median([p["rms"] for p in parts]) for name, parts in found.items()}
    return [
        Row(
            "Marker inverse kinematics",
            f"9-DoF arm, {frames:.0f} frames, accuracy of OpenSim {accuracy:g}",
            name,
            f"opensim {osim.GetVersion().split('-')[0]}",
            speed["selfmotion"],
            speed[name],
            "frames/s",
            f"landmark error (rms): ours {rms['selfmotion']:.2f} mm, theirs {rms[name]:.2f} mm",
        )
        for name in found
        if name != "selfmotion"
    ]


if __name__ == "__main__":
    main()
