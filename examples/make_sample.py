"""Write examples/sample: one drinking movement of a simulated person, in every format that is read.

Run from the top folder: python examples/make_sample.py [FOLDER]

Markers, joint angles and the hand's orientation are of the same movement, so each file can be held
against each other one. `examples/sample/README.md` says what is what.
"""

import sys
from dataclasses import replace
from pathlib import Path

import ezc3d
import numpy as np
import scipy.io

from selfmotion.capture.simulated_markers import SimulatedCapture, simulate_markers
from selfmotion.kinematics.forward import forward_kinematics
from selfmotion.motion.files.angles_csv import write_angles_csv
from selfmotion.motion.files.bids_writer import write_bids
from selfmotion.motion.files.npz import write_npz
from selfmotion.motion.files.parquet import write_parquet
from selfmotion.motion.files.storage import write_mot
from selfmotion.motion.files.trc import write_trc
from selfmotion.motion.files.vicon_csv import write_vicon_csv
from selfmotion.motion.labels import Frame, Labels
from selfmotion.motion.markers import MarkerSet
from selfmotion.motion.orientations import Orientations
from selfmotion.motion.recording import Recording

SEED, TASK = 2022, "drink"
STEP = 2  # of 100 Hz: 50 Hz keep the files small
LABELS = Labels("P1", "right", TASK, None, "1")
FRAME = Frame(up="z", forward="y")
STATIC_FRAMES = 5
# A hundredth of a millimetre and a millionth of a radian: short numbers, the same in every file.
MARKER_DIGITS, ANGLE_DIGITS = 5, 6


def main(folder: Path) -> None:
    """Write all files."""
    folder.mkdir(parents=True, exist_ok=True)
    capture = simulate_markers(rng=np.random.default_rng(SEED))
    k = [m.labels.condition for m in capture.movements].index(TASK)
    markers = thinned(capture.movements[k])
    q = capture.angles[k][::STEP].round(ANGLE_DIGITS)
    angles = Recording(markers.time, q=q, joints=capture.arm.joints, labels=LABELS, frame=FRAME)
    write_markers(folder, markers)
    static = replace(thinned(capture.static), labels=replace(LABELS, condition="static"))
    write_trc(folder / "static.trc", static.window(0, STATIC_FRAMES))
    write_angles(folder, angles)
    write_orientations(folder, hand_of(capture, angles))


def thinned(markers: MarkerSet) -> MarkerSet:
    """Take every so many frames, rounded, with what is known of the person."""
    places = markers.positions[::STEP].round(MARKER_DIGITS)
    return MarkerSet(np.arange(len(places)) * STEP / 100.0, markers.names, places, FRAME, LABELS)


def write_markers(folder: Path, markers: MarkerSet) -> None:
    """Write C3D, TRC, the CSV of Vicon Nexus and Motion-BIDS."""
    write_c3d(folder / "drink.c3d", markers)
    write_trc(folder / "drink.trc", markers)
    write_vicon_csv(folder / "drink_vicon.csv", markers)
    write_bids(folder / "bids", markers)


def write_c3d(path: Path, markers: MarkerSet) -> None:
    """Write C3D through ezc3d, as laboratories do: millimetres, 32-bit numbers."""
    made = ezc3d.c3d()
    point = made["parameters"]["POINT"]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = [f"{LABELS.subject}:{name}" for name in markers.names]
    point["RATE"]["value"] = [markers.rate]
    made.add_parameter("POINT", "X_SCREEN", ["+X"])
    made.add_parameter("POINT", "Y_SCREEN", ["+Z"])
    points = np.ones((4, markers.n_markers, markers.n_samples))
    points[:3] = 1e3 * markers.positions.transpose(2, 1, 0)
    made["data"]["points"] = points
    made.write(str(path))


def write_angles(folder: Path, angles: Recording) -> None:
    """Write CSV, MOT, STO, NPZ, MAT, Parquet and Motion-BIDS."""
    write_angles_csv(folder / "drink_angles.csv", [angles])
    write_mot(folder / "drink.mot", angles, unit="deg")
    write_mot(folder / "drink.sto", angles, unit="rad")
    write_npz(folder / "drink.npz", [angles])
    write_mat(folder / "drink.mat", angles)
    write_parquet(folder / "drink.parquet", [angles])
    write_bids(folder / "bids", angles)


def write_mat(path: Path, angles: Recording) -> None:
    """Write a MATLAB file with the fields of the NPZ."""
    names = np.array(angles.joints, dtype=object)
    arrays = {"q": angles.q, "time": angles.time, "joints": names}
    scipy.io.savemat(path, arrays | {"subject": LABELS.subject, "condition": LABELS.condition})


def hand_of(capture: SimulatedCapture, angles: Recording) -> Orientations:
    """Give how the hand is turned against the trunk."""
    T = forward_kinematics(capture.arm.chain, angles.array("q"), capture.arm.tip("hand"))
    return Orientations(angles.time, T[:, :3, :3], "hand", FRAME, LABELS)


def write_orientations(folder: Path, hand: Orientations) -> None:
    """Write quaternions x, y, z, w as CSV and NPZ."""
    turned = hand.quaternions().round(9)
    rows = np.column_stack([hand.time, turned])
    header = "time,hand_qx,hand_qy,hand_qz,hand_qw"
    np.savetxt(
        *(folder / "drink_hand.csv", rows), fmt="%.9g", delimiter=",", header=header, comments=""
    )
    np.savez(folder / "drink_hand.npz", quaternions=turned, time=hand.time)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "sample")
