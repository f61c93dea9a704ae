"""The pointing wrist of [Tommasino2017] eq. 6: pronation, flexion and deviation in one point.

doi 10.3389/fnbot.2017.00065. Ground: x forward (the straight hand points there), y left, z up;
right forearm along x with the thumb up. Implements R(q) = exp(-x q_PS) exp(z q_FE) exp(y q_RUD).
"""

import numpy as np

from selfmotion.arms._body import BOONE_AZEN, DEGREE, Body, loads
from selfmotion.arms._serial import Joint, X, Y, Z, at, serial_chain
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Tip


def wrist(*, body: Body | None = None) -> Arm:
    """Build the 3-DoF wrist: coordinates pronation, flexion, deviation (paper: PS, FE, RUD).

    Positive are pronation, flexion and ulnar deviation of a right wrist, so that East on the
    screen is an extension and North a radial deviation. `Pointing(wrist())` with its defaults is
    the paper's task. Elbow and shoulder are fixed in the ground: the elbow at a right angle
    behind the wrist, the shoulder above it. Limits: Boone & Azen 1979.

    Args:
        body: whose hand it is (mass, inertia, distances of landmarks); left out: 70 kg, 1.75 m.

    Example:
        >>> from selfmotion.redundancy.task import Pointing
        >>> (Pointing(wrist()).value([0.0, -0.2618, 0.0]).round(3) + 0.0).tolist()  # no -0.0
        [[0.259, 0.0]]
    """
    person = body or Body()
    upper, fore, hand = (person.length(s) for s in ("upper_arm", "forearm", "hand"))
    ranges = {
        "pronation": ("supination", "pronation"),
        "flexion": ("wrist_extension", "wrist_flexion"),
        "deviation": ("radial_deviation", "ulnar_deviation"),
    }
    limits = {
        name: (-BOONE_AZEN[low] * DEGREE, BOONE_AZEN[high] * DEGREE)
        for name, (low, high) in ranges.items()
    }
    axes = {"pronation": -X, "flexion": Z, "deviation": Y}
    chain = serial_chain([Joint(name, axes[name], limits[name], at()) for name in axes])
    return Arm(
        name="wrist",
        task="pointing",
        chain=chain,
        landmarks={
            "shoulder": Tip(GROUND, at((-fore, 0.0, upper))),
            "elbow": Tip(GROUND, at((-fore, 0.0, 0.0))),
            "wrist": Tip(GROUND),
            "hand": Tip(2, at((hand, 0.0, 0.0))),
        },
        lengths={"upper_arm": upper, "forearm": fore, "hand": hand},
        forward=np.array([1.0, 0.0, 0.0]),
        source="Tommasino & Campolo 2017, eq. 6; limits Boone & Azen 1979; hand of de Leva 1996",
        **loads(3, [(2, person.hand(wrist=np.zeros(3), towards=X))]),
    )
