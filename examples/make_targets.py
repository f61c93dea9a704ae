"""Make examples/targets.csv: hand positions and orientations that the 9-joint arm can take.

Postures are drawn inside the joint limits of the paper's impaired elbow (64.2 to 114 degrees);
the targets are where they bring the hand::

    python examples/make_targets.py
    selfmotion ik examples/targets.csv --limit elbow_flexion=64.2:114
"""

import csv
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from selfmotion.arms import load_arm
from selfmotion.kinematics.forward import forward_kinematics

ELBOW = np.radians([64.2, 114.0])
N_TARGETS = 4


def main() -> None:
    """Write the file beside this one."""
    arm = load_arm("upper_limb").with_limits({"elbow_flexion": (ELBOW[0], ELBOW[1])})
    q = arm.random_postures(N_TARGETS, np.random.default_rng(5))
    T = forward_kinematics(arm.chain, q, arm.tip("hand"))
    turns = Rotation.from_matrix(T[:, :3, :3]).as_quat()
    values = np.concatenate([T[:, :3, 3], turns], axis=1).round(9)
    path = Path(__file__).parent / "targets.csv"
    with open(path, "w", newline="", encoding="utf-8") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow(["id", "x", "y", "z", "qx", "qy", "qz", "qw"])
        out.writerows([i, *row] for i, row in enumerate(values.tolist(), start=1))


if __name__ == "__main__":
    main()
