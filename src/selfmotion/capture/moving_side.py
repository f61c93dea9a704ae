"""Which arm moves in a recording: a guard against angles of the arm that rests."""

import numpy as np

from selfmotion.capture.protocol import SIDES, Protocol
from selfmotion.errors import SelfmotionError
from selfmotion.motion.markers import MarkerSet

# The other hand travels so far, and so many times as far, where the side is doubted (m).
FAR, TIMES = 0.1, 3.0


def hand_travel(markers: MarkerSet, protocol: Protocol) -> dict[str, float]:
    """Give for each side the size of the box in which the hand's markers move (m).

    A side whose hand carries no markers, or was never seen, is left out.

    Args:
        markers: of one movement.
        protocol: which marker is what, for both sides.

    Example:
        >>> from selfmotion.capture.protocol import REACHING
        >>> from selfmotion.capture.simulated_markers import simulate_markers
        >>> seen = simulate_markers(rng=np.random.default_rng(1))
        >>> hand_travel(seen.movements[0], REACHING)["right"] > 0.1
        True
    """
    found = {}
    for side in SIDES:
        try:
            names = protocol.for_side(side)
            part = names.select(markers).select(names.clusters["hand"])
        except SelfmotionError:
            continue
        seen = part.positions[np.isfinite(part.positions).all(axis=(1, 2))].mean(axis=1)
        if len(seen):
            found[side] = float(np.linalg.norm(np.ptp(seen, axis=0)))
    return found


def doubt_about_side(markers: MarkerSet, protocol: Protocol, side: str) -> str:
    """Say that the other arm is the one that moves; empty where there is no doubt.

    Args:
        markers: of one movement.
        protocol: for both sides.
        side: whose angles are asked for.
    """
    travel = hand_travel(markers, protocol)
    other = "left" if side == "right" else "right"
    own, far = travel.get(side, 0.0), travel.get(other, 0.0)
    if side not in travel or far < FAR or far < TIMES * own:
        return ""
    return (
        f"{markers.name}: the {other} hand moves by {1e3 * far:.0f} mm, the {side} one by "
        f"{1e3 * own:.0f} mm; these are angles of the {side} arm (--side {other}?)"
    )
