"""Where landmarks belong on an arm of the library: guides for placing a person's markers.

Before joint angles are known, the guides put shoulder, elbow, wrist and knuckle on the arm's own
landmarks, the epicondyles on the elbow's axis and the styloids across the forearm; once angles are
found with them, landmarks are fixed to their bodies where they are on average.
"""

from collections.abc import Mapping

import numpy as np

from selfmotion.arrays import JointSamples, Transform
from selfmotion.capture.marker_ik import MarkerModel
from selfmotion.errors import ModelError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import GROUND, Tip
from selfmotion.kinematics.forward import body_frames, tip_positions
from selfmotion.spatial import transform

# Names of the forearm's joint, and its value in full supination, a quarter turn from thumb up,
# where radius and ulna are parallel and the styloids lie along the elbow's axis (rad).
PRONATION = ("wrist_pronation", "pro_sup")
PALM_FORWARD_AT_ZERO = ("upper_limb_anatomical",)
QUARTER = np.pi / 2
# Weights of the guides: the joint centres, then what lies across a segment.
CENTRE_WEIGHT, ACROSS_WEIGHT = 1.0, 0.3
BODY_OF = {
    "shoulder": "shoulder",
    "elbow": "elbow",
    "wrist": "wrist",
    "knuckle": "hand",
}


def guide_model(
    arm: Arm, side: str, seen: Mapping[str, np.ndarray], knuckle_radial: float = 0.0
) -> MarkerModel:
    """Put the guides on an arm.

    Args:
        arm: of the person's size, of this side.
        side: right or left.
        seen: landmarks' paths (K, 3), m, for the widths of elbow and wrist.
        knuckle_radial: how far the knuckle lies to the radial side of the hand's axis (m).
    """
    tips = {mark: arm.tip(name) for mark, name in BODY_OF.items()}
    if arm.tip("hand").joint == arm.tip("wrist").joint and np.allclose(
        arm.tip("hand").transform, arm.tip("wrist").transform
    ):
        tips["knuckle"] = arm.tip("palm")
    tips["knuckle"] = _beside(arm, side, tips["knuckle"], knuckle_radial)
    tips |= _epicondyles(arm, side, seen) | _styloids(arm, side, seen)
    weights = {k: CENTRE_WEIGHT if k in BODY_OF else ACROSS_WEIGHT for k in tips}
    return MarkerModel(arm, tips, weights)


def attach_to_bodies(arm: Arm, q: JointSamples, seen: Mapping[str, np.ndarray]) -> dict[str, Tip]:
    """Fix landmarks to the bodies that carry them, at their mean place over known postures.

    Args:
        arm: of the person's size.
        q: postures (K, n), rad.
        seen: landmarks in the arm's ground frame, (K, 3) each, m.

    Returns:
        Epicondyles, styloids and knuckle.
    """
    frames = body_frames(arm.chain, q)
    bodies = {
        "lateral_epicondyle": upper_arm_body(arm),
        "medial_epicondyle": upper_arm_body(arm),
        "radial_styloid": forearm_body(arm),
        "ulnar_styloid": forearm_body(arm),
        "knuckle": arm.tip("hand").joint,
    }
    tips = {}
    for mark, body in bodies.items():
        T = frames[:, body]
        local = np.einsum("kji,kj->ki", T[:, :3, :3], seen[mark] - T[:, :3, 3])
        tips[mark] = Tip(body, transform(None, local.mean(axis=0)))
    return tips


def upper_arm_body(arm: Arm) -> int:
    """Give the body above the elbow's flexion."""
    body = int(arm.chain.parent[_elbow_joint(arm)])
    if body == GROUND:
        raise ModelError(f"arm {arm.name}: nothing moves above its elbow")
    return body


def forearm_body(arm: Arm) -> int:
    """Give the body that pronates, or the forearm where the arm has no pronation."""
    for name in PRONATION:
        if name in arm.chain.names:
            return arm.chain.names.index(name)
    return _elbow_joint(arm)


def _elbow_joint(arm: Arm) -> int:
    if "elbow_flexion" in arm.chain.names:
        return arm.chain.names.index("elbow_flexion")
    return arm.tip("elbow").joint


def _outwards(arm: Arm, side: str, q: np.ndarray) -> np.ndarray:
    """Give the direction from the medial to the lateral epicondyle: the axis of flexion."""
    joint = _elbow_joint(arm)
    frame = body_frames(arm.chain, q)[0, joint]
    axis = frame[:3, :3] @ arm.chain.axes[joint]
    # Positive flexion of a hanging arm turns about the axis that points to the person's right.
    return axis if side == "right" else -axis


def _epicondyles(arm: Arm, side: str, seen: Mapping[str, np.ndarray]) -> dict[str, Tip]:
    q = np.zeros(arm.n_joints)
    width = _width(seen["lateral_epicondyle"], seen["medial_epicondyle"])
    centre = tip_positions(arm.chain, q, [arm.tip("elbow")])[0, 0]
    across = 0.5 * width * _outwards(arm, side, q)
    body = upper_arm_body(arm)
    frame = body_frames(arm.chain, q)[0, body]
    return {
        "lateral_epicondyle": Tip(body, _point(frame, centre + across)),
        "medial_epicondyle": Tip(body, _point(frame, centre - across)),
    }


def _styloids(arm: Arm, side: str, seen: Mapping[str, np.ndarray]) -> dict[str, Tip]:
    body = forearm_body(arm)
    q = _supinated(arm)
    width = _width(seen["radial_styloid"], seen["ulnar_styloid"])
    centre = tip_positions(arm.chain, q, [arm.tip("wrist")])[0, 0]
    across = 0.5 * width * _outwards(arm, side, q)
    frame = body_frames(arm.chain, q)[0, body]
    return {
        "radial_styloid": Tip(body, _point(frame, centre + across)),
        "ulnar_styloid": Tip(body, _point(frame, centre - across)),
    }


def _beside(arm: Arm, side: str, tip: Tip, radial: float) -> Tip:
    """Move a point of the hand to the radial side."""
    q = _supinated(arm)
    frame = body_frames(arm.chain, q)[0, tip.joint]
    place = tip_positions(arm.chain, q, [tip])[0, 0]
    return Tip(tip.joint, _point(frame, place + radial * _outwards(arm, side, q)))


def _supinated(arm: Arm) -> np.ndarray:
    """Give the hanging posture with the palm forward: the thumb points outwards."""
    q = np.zeros(arm.n_joints)
    body = forearm_body(arm)
    if arm.chain.names[body] in PRONATION:
        name = arm.name.removesuffix(" (mirrored)")
        supinated = 0.0 if name in PALM_FORWARD_AT_ZERO else -QUARTER
        q[arm.chain.index(arm.chain.names[body])] = supinated
    return q


def _width(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.median(np.linalg.norm(first - second, axis=1)))


def _point(frame: Transform, place: np.ndarray) -> Transform:
    return transform(None, frame[:3, :3].T @ (place - frame[:3, 3]))
