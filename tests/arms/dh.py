"""The modified Denavit-Hartenberg matrix of [DeBoon] eq. 1, written out for the tests."""

import numpy as np


def craig_row(a: float, twist: float, d: float, angle: float) -> np.ndarray:
    """Rx(twist) Tx(a) Rz(angle) Tz(d)."""
    ct, st, ca, sa = np.cos(angle), np.sin(angle), np.cos(twist), np.sin(twist)
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -sa * d],
            [st * sa, ct * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )
