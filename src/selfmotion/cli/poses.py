"""Rows of quaternion and position as transforms in the model's ground."""

from typing import TYPE_CHECKING

from selfmotion.cli.tables import QUATERNION, Rows

if TYPE_CHECKING:
    import numpy as np

POSITION = ("x", "y", "z")


def transforms(rows: Rows, T_ground_file: "np.ndarray") -> "np.ndarray":
    """Give poses (K, 4, 4) in the ground; a row with a problem gets the identity.

    Args:
        rows: with the columns qx, qy, qz, qw, x, y, z, quaternions checked.
        T_ground_file: (4, 4) as from the option --frame.
    """
    import numpy as np
    from scipy.spatial.transform import Rotation

    good = rows.good
    T = np.tile(np.eye(4), (len(rows), 1, 1))
    T[good, :3, :3] = Rotation.from_quat(rows.array(QUATERNION)[good]).as_matrix()
    T[good, :3, 3] = rows.array(POSITION)[good]
    T[good] = T_ground_file @ T[good]
    return T
