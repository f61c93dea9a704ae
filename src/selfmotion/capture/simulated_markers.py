"""Markers as motion capture would record them, on an arm whose angles are known.

A person with the marker set `reaching` sits still for a static trial and then moves. Noise, skin
that slides over the bones with the movement, and gaps come on demand; without them the angles can
be recovered exactly. What the laboratory does not show in a movement is missing here too: the bony
landmarks exist in the static trial only.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from selfmotion.arms import upper_limb_anatomical
from selfmotion.capture.marker_guides import forearm_body, upper_arm_body
from selfmotion.capture.protocol import REACHING, SIDES
from selfmotion.capture.scaling import place_shoulder, scale_arm, with_adult_ranges
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND
from selfmotion.kinematics.forward import body_frames
from selfmotion.kinematics.mirror import mirror
from selfmotion.motion.labels import Frame, Labels
from selfmotion.motion.markers import MarkerSet

RATE = 100.0
LENGTHS = {"upper_arm": 0.29, "forearm": 0.25, "hand": 0.09}
SHOULDER = (0.15, -0.02, -0.03)
# Rest, degrees, in the order of the joints: hands on the table; and where movements go.
REST_DEG = (0.0, 0.0, 10.0, 20.0, -15.0, 85.0, 3.0, -5.0, 100.0)
REACHES_DEG = {
    "forward": (12.0, 6.0, 60.0, 12.0, -25.0, 35.0, 8.0, -15.0, 85.0),
    "cross": (18.0, 4.0, 70.0, -15.0, -20.0, 40.0, -5.0, 10.0, 110.0),
    "drink": (5.0, 10.0, 55.0, 30.0, -40.0, 130.0, 10.0, -25.0, 70.0),
    "comb": (-5.0, 18.0, 95.0, 40.0, 10.0, 120.0, -10.0, 15.0, 60.0),
    "side": (-8.0, 12.0, 30.0, 65.0, 25.0, 60.0, 5.0, -10.0, 40.0),
}


@dataclass(frozen=True)
class MarkerFaults:
    """What is wrong with recorded markers.

    Attributes:
        noise: standard deviation of each coordinate (m).
        skin: how far a cluster slides and how much its markers part, per radian of movement of
            the joints next to it (m/rad).
        gaps: gaps of 50 ms in each movement, each in one marker.
    """

    noise: float = 0.0
    skin: float = 0.0
    gaps: int = 0


@dataclass(frozen=True, eq=False)
class SimulatedCapture:
    """A static trial and movements of a simulated person, with the angles behind them.

    Attributes:
        static: with the bony landmarks.
        movements: without them.
        angles: of each movement, (K, 9) rad.
        arm: the person's arm in the trunk's frame; a left one is mirrored.
        side: right or left.
    """

    static: MarkerSet
    movements: tuple[MarkerSet, ...]
    angles: tuple[Float[np.ndarray, "samples joints"], ...]
    arm: Arm
    side: str


def simulate_markers(
    *,
    side: str = "right",
    faults: MarkerFaults | None = None,
    rng: np.random.Generator,
    repeats: int = 1,
) -> SimulatedCapture:
    """Simulate the capture of a person who reaches forward and across, drinks and combs.

    Args:
        side: the arm that moves.
        faults: noise, skin and gaps; left out: none.
        rng: for the faults and the variation between repeats.
        repeats: of each movement.

    Example:
        >>> seen = simulate_markers(rng=np.random.default_rng(1))
        >>> len(seen.movements), seen.static.n_markers, seen.movements[0].rate
        (5, 27, 100.0)
    """
    arm = simulated_arm(side)

    def movements() -> Iterator[tuple[Labels, np.ndarray]]:
        rest = np.deg2rad(REST_DEG)
        for task, goal in REACHES_DEG.items():
            for trial in range(repeats):
                varied = np.deg2rad(goal) + (0.05 * rng.standard_normal(9) if trial else 0.0)
                q = _there_and_back(rest, np.clip(varied, arm.lower, arm.upper))
                yield Labels("simulated", side, task, None, str(trial + 1)), q

    return capture_of(arm, movements(), side=side, faults=faults, rng=rng)


def simulated_arm(side: str = "right") -> Arm:
    """Give the simulated person's arm in the trunk's frame, with the ranges of adults."""
    arm = with_adult_ranges(scale_arm(upper_limb_anatomical(), LENGTHS))
    arm = place_shoulder(arm, SHOULDER)
    return mirror(arm) if side == "left" else arm


def capture_of(
    arm: Arm,
    movements: Iterable[tuple[Labels, Float[np.ndarray, "samples joints"]]],
    *,
    side: str = "right",
    faults: MarkerFaults | None = None,
    rng: np.random.Generator,
) -> SimulatedCapture:
    """Show known movements of an arm as motion capture would.

    Args:
        arm: from `simulated_arm`.
        movements: labels, and angles at `RATE` (rad).
        side: of the arm.
        faults: noise, skin and gaps; left out: none.
        rng: for the faults.
    """
    wrong = faults or MarkerFaults()
    fixed = _markers_on_bodies(arm, side)
    still = np.tile(np.deg2rad(REST_DEG), (50, 1))
    static = _seen(arm, fixed, still, MarkerFaults(noise=wrong.noise), rng)
    bony = {SIDES[side] + name for name in ("GTH", "LEP", "MEP", "SPR", "SPU")}
    shown, angles = [], []
    for labels, q in movements:
        whole = _seen(arm, fixed, q, wrong, rng)
        kept = whole.select([name for name in whole.names if name not in bony])
        shown.append(replace(kept, labels=labels))
        angles.append(q)
    return SimulatedCapture(static, tuple(shown), tuple(angles), arm, side)


def _there_and_back(rest: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Go by minimum jerk from rest to the goal, joint by joint a little apart, and back."""
    t = np.arange(0.0, 2.4, 1.0 / RATE)[:, None]
    lag = 0.04 * np.arange(len(rest))
    phase = np.clip((t - 0.3 - lag) / 0.8, 0.0, 1.0) - np.clip((t - 1.2 - lag) / 0.8, 0.0, 1.0)
    share = phase**3 * (10.0 - 15.0 * phase + 6.0 * phase**2)
    return rest + share * (goal - rest)


def _markers_on_bodies(arm: Arm, side: str) -> dict[str, tuple[int, np.ndarray]]:
    """Give each marker's body and place on it, from places on the hanging arm, palm forward."""
    letter, other = SIDES[side], SIDES["left" if side == "right" else "right"]
    out = 1.0 if side == "right" else -1.0
    shoulder = np.array([out * SHOULDER[0], *SHOULDER[1:]])
    elbow = shoulder - [0.0, 0.0, LENGTHS["upper_arm"]]
    wrist = elbow - [0.0, 0.0, LENGTHS["forearm"]]
    knuckle = wrist - [0.0, 0.0, LENGTHS["hand"]]
    x = np.array([out, 0.0, 0.0])
    upper, fore, hand = upper_arm_body(arm), forearm_body(arm), arm.tip("hand").joint
    girdle = int(arm.chain.parent[arm.tip("shoulder").joint])
    notch = -np.array([out, 1.0, 1.0]) * REACHING.sternoclavicular
    acromion = shoulder + [-out * 0.03, -0.05, 0.06]
    opposite = np.array([2.0 * notch[0] - acromion[0], *acromion[1:]])
    places = {
        "STRN": (GROUND, notch),
        letter + "GTH": (girdle, shoulder + [out * 0.035, 0.01, 0.055]),
        letter + "LEP": (upper, elbow + 0.04 * x),
        letter + "MEP": (upper, elbow - 0.04 * x),
        letter + "SPR": (fore, wrist + 0.028 * x),
        letter + "SPU": (fore, wrist - 0.028 * x),
        letter + "FB": (hand, knuckle + REACHING.knuckle_radial * x),
    }
    plates = {
        letter + "SHO": (girdle, acromion, 2),
        other + "SHO": (GROUND, opposite, 2),
        letter + "UAR": (upper, 0.5 * (shoulder + elbow) + 0.05 * x, 0),
        letter + "LAR": (fore, 0.4 * elbow + 0.6 * wrist + 0.04 * x, 0),
        letter + "HAN": (hand, 0.5 * (wrist + knuckle) - [0.0, 0.02, 0.0], 1),
    }
    for stem, (body, centre, normal) in plates.items():
        a, b = np.delete(np.eye(3), normal, axis=0)
        for i, (u, v) in enumerate(((-1, -1), (-1, 1), (1, 1.2), (1, -1))):
            outwards = 1.0 if stem[0] == "R" else -1.0
            spread = 0.03 * (u * a + v * b) * [outwards, 1.0, 1.0]
            places[f"{stem}{i + 1}"] = (body, centre + spread)
    zero = body_frames(arm.chain, np.zeros(arm.n_joints))[0]
    fixed = {}
    for name, (body, place) in places.items():
        T = np.eye(4) if body == GROUND else zero[body]
        fixed[name] = (body, T[:3, :3].T @ (np.asarray(place) - T[:3, 3]))
    return fixed


def _seen(
    arm: Arm,
    fixed: dict[str, tuple[int, np.ndarray]],
    q: np.ndarray,
    faults: MarkerFaults,
    rng: np.random.Generator,
) -> MarkerSet:
    """Place the markers, let skin slide with the movement, add noise and cut gaps."""
    frames = body_frames(arm.chain, q)
    time = np.arange(len(q)) / RATE
    sway = 0.01 * np.sin(2.0 * np.pi * 0.3 * time)[:, None] * [0.3, 1.0, 0.0]
    travelled = np.linalg.norm(q - q[0], axis=1)[:, None]
    positions = np.empty((len(q), len(fixed), 3))
    slides: dict[str, np.ndarray] = {}
    for m, (name, (body, local)) in enumerate(fixed.items()):
        if body == GROUND:
            path = np.tile(local, (len(q), 1))
        else:
            stem = name.rstrip("1234")
            slide = slides.setdefault(stem, rng.standard_normal(3))
            moved = local + faults.skin * travelled * (slide + 0.2 * rng.standard_normal(3))
            T = frames[:, body]
            path = np.einsum("kij,kj->ki", T[:, :3, :3], moved) + T[:, :3, 3]
        positions[:, m] = path + sway
    positions += faults.noise * rng.standard_normal(positions.shape)
    for _ in range(faults.gaps):
        m, start = rng.integers(len(fixed)), rng.integers(10, len(q) - 20)
        positions[start : start + 5, m] = np.nan
    return MarkerSet(time, tuple(fixed), positions, Frame(), Labels("simulated"))
