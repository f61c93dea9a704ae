"""Make examples/poses.csv and examples/postures.csv: hand poses that an arm can take.

Postures are drawn inside the joint limits of the default musculoskeletal arm, in front of the
body; the poses are where they bring the hand::

    python examples/make_poses.py
    selfmotion posture examples/poses.csv
    selfmotion effort examples/postures.csv
"""

import csv
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from selfmotion.arms import load_arm
from selfmotion.kinematics.forward import forward_kinematics

# Degrees: elv_angle, shoulder_elv, shoulder_rot, elbow_flexion, pro_sup, deviation, flexion.
LOW = (20.0, 20.0, -40.0, 50.0, -30.0, -2.0, -10.0)
HIGH = (80.0, 70.0, 20.0, 110.0, 30.0, 10.0, 15.0)
N_POSES = 3


def main() -> None:
    """Write both files beside this one."""
    arm = load_arm("myoarm")
    rng = np.random.default_rng(4)
    q = np.radians(rng.uniform(LOW, HIGH, (N_POSES, 7)))
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    turns = Rotation.from_matrix(T[:, :3, :3]).as_quat()
    folder = Path(__file__).parent
    names = ["id", "qx", "qy", "qz", "qw", "x", "y", "z"]
    poses = np.concatenate([turns, T[:, :3, 3]], axis=1).round(9)
    write(folder / "poses.csv", names, poses)
    write(folder / "postures.csv", ["id", *arm.joints], q.round(6))


def write(path: Path, names: list[str], values: np.ndarray) -> None:
    """Write rows with their number from 1."""
    with open(path, "w", newline="", encoding="utf-8") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow(names)
        out.writerows([i, *row] for i, row in enumerate(values.tolist(), start=1))


if __name__ == "__main__":
    main()
