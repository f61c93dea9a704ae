"""Make examples/wrist_postures.csv: a generated person who points to 80 places, with noise.

The person has the stiffness and rest posture of Tommasino and Campolo's Fig. 3 (2017); half a
degree of noise in every joint makes it a measurement::

    python examples/make_wrist_postures.py
    selfmotion donders examples/wrist_postures.csv
"""

import csv
from pathlib import Path

import numpy as np

from selfmotion.arms import wrist
from selfmotion.methods.elasticity.posture import donders_postures
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.redundancy.task import Pointing

STIFFNESS = (0.5, 1.5, 2.0)
REST_DEG = (5.0, 0.0, 0.0)
NOISE_DEG = 0.5


def main() -> None:
    """Write the file beside this one."""
    law = JointLaw(np.diag(STIFFNESS), np.radians(REST_DEG))
    arm = wrist()
    angles = np.linspace(0.0, 2.0 * np.pi, 20, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    targets = np.concatenate([np.sin(np.radians(r)) * circle for r in (8.0, 15.0, 22.0, 30.0)])
    q = np.degrees(donders_postures(Pointing(arm), law, targets).q)
    q += np.random.default_rng(3).normal(0.0, NOISE_DEG, q.shape)
    path = Path(__file__).parent / "wrist_postures.csv"
    with open(path, "w", newline="", encoding="utf-8") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow([f"{joint}_deg" for joint in arm.joints])
        out.writerows(q.round(3).tolist())
    print(path, "true stiffness:", STIFFNESS, "rest (deg):", REST_DEG)


if __name__ == "__main__":
    main()
