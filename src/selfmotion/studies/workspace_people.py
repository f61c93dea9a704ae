"""Are people's hands where their lengths and the ranges of adults say that they can be?

For each person of a study the arm is scaled to the person's lengths and keeps the ranges of
adults; the hand (the knuckle that was measured) must then always lie inside the workspace. The
measured place of the knuckle is compared, not that of fitted joint angles, which are inside by
construction. Places outside are counted, and explained by what would bring them in:

- ``stretch``: farther from the measured shoulder than the stretched arm is long: lengths, soft
  tissue or the shoulder's centre;
- ``girdle``: not so, and 20 degrees more of the girdle's two joints bring it in: the shoulder went
  where their ranges do not let it go;
- a joint: 20 degrees more of this joint alone bring it in (the first that does, in the arm's
  order);
- ``several``: nothing of that alone.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from jaxtyping import Bool, Float

from selfmotion.capture.person import ground_from_trunk
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.body_shapes import BodyShapes
from selfmotion.kinematics.forward import tip_positions
from selfmotion.methods.reach_clouds import CloudReach, compare_clouds, out_of_reach
from selfmotion.methods.workspace import Workspace, WorkspaceOptions, workspace
from selfmotion.studies.people import MovementOfPerson, RecordedPerson

# Beyond this a place counts as outside (m), and beyond this by more than markers and joint centres
# are uncertain.
TOLERANCE, CERTAIN = 1e-4, 0.005
# How much more range a joint gets on either side (rad).
MORE = np.deg2rad(20.0)
# Samples are so far apart (s).
EVERY = 0.05
GIRDLE = ("scapula_protraction", "scapula_elevation")


@dataclass(frozen=True, eq=False)
class PersonReach:
    """One arm of one person against the workspace predicted for it.

    Attributes:
        subject: name.
        side: right or left.
        arm: scaled to the person; its hand is the knuckle that was measured.
        body: of the person, seated.
        space: the workspace predicted, without what lies inside the body.
        clouds: condition to its places against the workspace.
        causes: condition to the causes of its places outside, with counts.
    """

    subject: str
    side: str
    arm: Arm
    body: BodyShapes
    space: Workspace
    clouds: Mapping[str, CloudReach]
    causes: Mapping[str, Mapping[str, int]]

    def to_frame(self) -> pd.DataFrame:
        """Give a table, one row a condition."""
        rows = []
        for condition, cloud in self.clouds.items():
            outside = cloud.distance > TOLERANCE
            deep = -self.body.distance(cloud.points)
            rows.append(
                {
                    "subject": self.subject,
                    "side": self.side,
                    "condition": condition,
                    "places": len(outside),
                    "outside": int(outside.sum()),
                    "beyond_5_mm": int((cloud.distance > CERTAIN).sum()),
                    "most_mm": 1e3 * max(float(cloud.distance.max()), 0.0),
                    "depth_mm": 1e3 * float(np.median(-cloud.distance[cloud.inside]))
                    if cloud.inside.any()
                    else np.nan,
                    "in_body": int((deep > 0).sum()),
                    "body_mm": 1e3 * max(float(deep.max()), 0.0),
                    "used_percent": 100.0 * cloud.used[0],
                    "causes": ", ".join(f"{k} {n}" for k, n in self.causes[condition].items()),
                }
            )
        return pd.DataFrame(rows)


def workspace_people(
    people: Iterable[RecordedPerson],
    *,
    options: WorkspaceOptions | None = None,
) -> list[PersonReach]:
    """Hold every person's measured hand against the workspace predicted for it.

    Args:
        people: as `load_people` gives them.
        options: how finely workspaces are looked at.
    """
    opts = options or WorkspaceOptions(n_points=2048, shifts=4)
    return [_person(one, opts) for one in people]


def people_frame(people: Iterable[PersonReach]) -> pd.DataFrame:
    """Give one table of all people, a row a condition."""
    return pd.concat([one.to_frame() for one in people], ignore_index=True)


def totals_frame(table: pd.DataFrame) -> pd.DataFrame:
    """Give sums over people by condition, and over all: places, outside, inside the body."""
    how = dict.fromkeys(("places", "outside", "beyond_5_mm", "in_body"), "sum")
    how |= {"most_mm": "max", "body_mm": "max"}
    parts = [
        part.groupby("condition", sort=False).agg(how).reset_index()
        for part in (table, table.assign(condition="all"))
    ]
    sums = pd.concat(parts, ignore_index=True)
    sums["outside_percent"] = 100.0 * sums["outside"] / sums["places"]
    sums["in_body_percent"] = 100.0 * sums["in_body"] / sums["places"]
    return sums


def measured_places(one: RecordedPerson, movement: MovementOfPerson) -> dict[str, np.ndarray]:
    """Give shoulder and knuckle (K, 3) of a movement in the arm's ground (m), gaps left out."""
    motion = movement.motion
    turn = ground_from_trunk(one.person.arm)
    places = {
        name: np.einsum("kji,kj->ki", motion.trunk, motion.landmarks[name].path - motion.ground)
        @ turn.T
        for name in ("shoulder", "knuckle")
    }
    seen = np.isfinite(np.hstack(list(places.values()))).all(axis=1)
    step = max(1, round(EVERY / float(np.median(np.diff(motion.recording.time)))))
    return {name: path[seen][::step] for name, path in places.items()}


def _person(one: RecordedPerson, options: WorkspaceOptions) -> PersonReach:
    tips = one.person.model.tips
    arm = one.person.arm
    arm = replace(arm, landmarks={**arm.landmarks, "hand": tips["knuckle"]})
    body = BodyShapes.of(arm, "seated")
    space = workspace(arm, blocked=body.inside, options=options)
    clouds, causes = {}, {}
    for condition in dict.fromkeys(m.labels.condition or "" for m in one.movements):
        parts = [
            measured_places(one, m)
            for m in one.movements
            if (m.labels.condition or "") == condition
        ]
        hand = np.concatenate([part["knuckle"] for part in parts])
        shoulder = np.concatenate([part["shoulder"] for part in parts])
        (cloud,) = compare_clouds(space, {condition: hand})
        outside = cloud.distance > TOLERANCE
        clouds[condition] = cloud
        causes[condition] = explain(arm, hand[outside], shoulder[outside])
    return PersonReach(one.subject, one.side, arm, body, space, clouds, causes)


def explain(
    arm: Arm, hand: Float[np.ndarray, "places 3"], shoulder: Float[np.ndarray, "places 3"]
) -> dict[str, int]:
    """Count what would bring places of the hand in that are outside; see the module."""
    found: dict[str, int] = {}
    open_ = np.ones(len(hand), dtype=np.bool_)

    def settle(cause: str, cured: Bool[np.ndarray, " places"]) -> None:
        count = int((open_ & cured).sum())
        if count:
            found[cause] = count
        open_[cured] = False

    if not len(hand):
        return found
    away = np.linalg.norm(hand - shoulder, axis=1)
    settle("stretch", away > arm_length(arm) + TOLERANCE)
    wide = {name: MORE for name in GIRDLE if name in arm.joints}
    if wide:
        settle("girdle", _cured(arm, hand, wide))
    for joint in arm.joints:
        if joint not in GIRDLE:
            settle(joint, _cured(arm, hand, {joint: MORE}))
    settle("several", np.ones(len(hand), dtype=np.bool_))
    return found


def arm_length(arm: Arm) -> float:
    """Give the distance from shoulder to hand with the arm stretched as far as its ranges let it.

    By the segments' lengths: upper arm, forearm, and from the wrist to the hand.
    """
    tips = [arm.tip(name) for name in ("shoulder", "elbow", "wrist", "hand")]
    marks = tip_positions(arm.chain, arm.middle()[None], tips)[0]
    return float(np.linalg.norm(np.diff(marks, axis=0), axis=1).sum())


def _cured(arm: Arm, hand: np.ndarray, more: Mapping[str, float]) -> np.ndarray:
    """Tell which places are reached where joints have more range on both sides."""
    limits = {}
    for joint, extra in more.items():
        j = arm.joints.index(joint)
        limits[joint] = (float(arm.lower[j] - extra), float(arm.upper[j] + extra))
    return out_of_reach(arm.with_limits(limits), hand) <= TOLERANCE
