"""Predictors of the swivel angle: planted laws are recovered, criteria give what they name."""

from dataclasses import replace

import numpy as np
import pytest

from selfmotion.arms.with_muscles import load_musculoskeletal_arm
from selfmotion.errors import ShapeError, UnknownNameError
from selfmotion.kinematics.dynamics import gravity_torque
from selfmotion.kinematics.forward import forward_kinematics, tip_positions
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.methods.natural_posture import natural_posture
from selfmotion.methods.predictors.biased import Biased
from selfmotion.methods.predictors.catalogue import CRITERIA, FITTED, Computed
from selfmotion.methods.predictors.combination import Combination
from selfmotion.methods.predictors.constant import Constant
from selfmotion.methods.predictors.coplanar import Coplanar
from selfmotion.methods.predictors.gravity_torque import GravityTorque
from selfmotion.methods.predictors.least_displacement import LeastDisplacement
from selfmotion.methods.predictors.manipulability import Manipulability, longest_axis
from selfmotion.methods.predictors.mid_range import MidRange
from selfmotion.methods.predictors.muscle_effort import MuscleEffort
from selfmotion.methods.predictors.observation import (
    Observation,
    Prediction,
    Scene,
    angle_between,
    mean_angle,
)
from selfmotion.methods.predictors.pose_regression import PoseRegression, pose_features
from selfmotion.methods.predictors.scenes import make_scene, swivel_about, wrist_of_hand
from selfmotion.methods.predictors.start_angle import StartAngle
from selfmotion.redundancy.manifold import self_motion_manifold
from selfmotion.spatial import rotation_about

HELD = np.array([0.7, 0.9, -0.2, 1.3, 0.2, 0.05, 0.1])


def people(n_people=6, n_each=8, seed=0):
    """Draw people whose natural angle is their criterion "c" and nothing else."""
    rng = np.random.default_rng(seed)
    out = []
    for p in range(n_people):
        for k in range(n_each):
            angle = float(rng.normal(0.5, 0.2))
            axis = rng.standard_normal(3)
            out.append(
                Observation(
                    f"P{p}",
                    "right",
                    ("reach", "drink")[k % 2],
                    "end",
                    str(k),
                    natural=angle,
                    start=float(rng.normal(0.2, 0.1)),
                    wrist=rng.normal([0.1, 0.5, 0.0], 0.2),
                    hand=rotation_about(axis / np.linalg.norm(axis), float(rng.uniform(0, 1))),
                    criteria={"c": Prediction(angle)},
                )
            )
    return out


@pytest.fixture(scope="module")
def scene() -> Scene:
    model = load_musculoskeletal_arm()
    T = forward_kinematics(model.arm.chain, HELD, model.arm.tip("hand"))[0]
    S = tip_positions(model.arm.chain, HELD, [model.arm.tip("shoulder")])[0, 0]
    mouth = S + [0.17, -0.1, 0.2]
    return make_scene(model, T, shoulder=S, mouth=mouth, start=HELD)


@pytest.fixture
def seen(scene):
    return replace(people(1, 1)[0], scene=scene)


def test_the_constant_is_exact_on_constant_people():
    everyone = [replace(o, natural=0.3 if o.task == "reach" else 0.8) for o in people()]
    fitted = Constant().fit(everyone)
    for o in everyone:
        assert fitted.swivel(o).angle == pytest.approx(o.natural, abs=1e-12)
    overall = Constant(by_kind=False).fit(everyone)
    assert overall.swivel(everyone[0]).angle == pytest.approx(0.55)


def test_each_person_counts_once_however_many_their_repeats():
    base = people(1, 1)[0]
    a = [replace(base, subject="A", natural=0.0) for _ in range(9)]
    b = [replace(base, subject="B", natural=0.4)]
    assert Constant().fit([*a, *b]).swivel(base).angle == pytest.approx(0.2)


def test_a_kind_that_nobody_else_did_has_no_constant():
    everyone = people()
    found = Constant().fit(everyone).swivel(replace(everyone[0], task="comb"))
    assert np.isnan(found.angle)
    assert found.status.sentence == "nobody else did comb, end"


def test_a_bias_is_taken_out_across_the_half_turn():
    everyone = [replace(o, natural=o.criteria["c"].angle + 2.9) for o in people()]
    for by_kind in (False, True):
        fitted = Biased("b", "c", by_kind).fit(everyone)
        for o in everyone:
            assert abs(angle_between(fitted.swivel(o).angle, o.natural)) < 1e-12


def test_regression_recovers_a_planted_law_on_a_new_person():
    everyone = people(8, 30)
    slopes = np.random.default_rng(5).normal(0, 0.3, 15)
    everyone = [replace(o, natural=float(pose_features([o])[0] @ slopes)) for o in everyone]
    fitted = PoseRegression().fit([o for o in everyone if o.subject != "P7"])
    for o in everyone:
        if o.subject == "P7":
            assert fitted.swivel(o).angle == pytest.approx(o.natural, abs=0.02)


def test_combination_recovers_a_criterion_with_a_constant_for_each_task():
    everyone = [
        replace(o, natural=0.8 * o.criteria["c"].angle + (0.3 if o.task == "drink" else 0.0))
        for o in people(8, 30)
    ]
    fitted = Combination(criteria=("c",)).fit([o for o in everyone if o.subject != "P7"])
    for o in everyone:
        if o.subject == "P7":
            assert fitted.swivel(o).angle == pytest.approx(o.natural, abs=0.02)


@pytest.mark.parametrize("predictor", FITTED, ids=lambda p: p.name)
def test_no_prediction_depends_on_the_natural_angle_of_the_one_predicted(predictor):
    names = [c.name for c in CRITERIA]
    everyone = [replace(o, criteria={k: o.criteria["c"] for k in names}) for o in people()]
    fitted = predictor.fit(everyone[8:])
    angles = [fitted.swivel(o).angle for o in everyone[:8]]
    turned = [replace(o, natural=o.natural + 1.0) for o in everyone[:8]]
    assert angles == [fitted.swivel(o).angle for o in turned]
    assert np.isfinite(angles).all()


def test_effort_gives_the_answer_of_natural_posture(scene, seen):
    found = MuscleEffort().swivel(seen)
    q = natural_posture(scene.model, scene.T_hand).q
    E, W = tip_positions(
        scene.model.arm.chain, q, [scene.model.arm.tip(k) for k in ("elbow", "wrist")]
    )[0]
    expected = swivel_angle(scene.shoulder, E, W, down=-scene.model.arm.up)[0]
    assert found.angle == pytest.approx(expected, abs=1e-12)
    assert found.status.ok


def test_the_start_is_nearest_to_the_start_where_it_holds_the_pose(scene, seen):
    own = swivel_about(scene, HELD[None])[0]
    for measure in ("rotation", "coordinates"):
        found = LeastDisplacement(from_start=True, measure=measure).swivel(seen)
        assert found.angle == pytest.approx(own, abs=np.deg2rad(0.05))


def test_mid_range_is_the_middle_of_the_widest_interval(scene, seen):
    manifold = self_motion_manifold(scene.model.arm, scene.T_hand)
    widest = max(manifold.intervals, key=lambda i: np.ptp(i.swivel))
    ends = swivel_about(scene, widest.at([widest.arc[0], widest.arc[-1]]))
    assert MidRange().swivel(seen).angle == pytest.approx(ends.mean(), abs=np.deg2rad(0.5))


def test_no_sampled_posture_has_less_gravity_torque(scene, seen):
    angle = GravityTorque().swivel(seen).angle
    q = np.concatenate([s.q for s in scene.stretches])
    cost = (gravity_torque(scene.model.arm, q) ** 2).sum(axis=1)
    best = np.concatenate([s.swivel for s in scene.stretches])[np.argmin(cost)]
    assert angle == pytest.approx(best, abs=np.deg2rad(0.6))


def test_longest_axis_is_that_of_a_jacobian_by_differences():
    S, E, W = np.array([0.1, 0.0, 0.2]), np.array([0.2, 0.25, 0.1]), np.array([0.0, 0.45, 0.25])
    normal = np.cross(E - S, W - E)
    normal = normal / np.linalg.norm(normal)
    columns = []
    for axis in np.eye(3):
        turned = [S + rotation_about(axis, h) @ (W - S) for h in (1e-6, -1e-6)]
        columns.append((turned[0] - turned[1]) / 2e-6)
    turned = [E + rotation_about(normal, h) @ (W - E) for h in (1e-6, -1e-6)]
    columns.append((turned[0] - turned[1]) / 2e-6)
    U, sizes, _ = np.linalg.svd(np.array(columns).T)
    assert sizes[0] > sizes[1]
    assert abs(U[:, 0] @ longest_axis(S, E[None], W[None])[0]) == pytest.approx(1.0, abs=1e-9)


def test_the_plane_of_the_arm_meets_the_mouth(scene, seen):
    angle = Coplanar().swivel(seen).angle
    W, S = wrist_of_hand(scene), scene.shoulder
    q = scene.stretches[0].q
    assert np.allclose(
        tip_positions(scene.model.arm.chain, q, [scene.model.arm.tip("wrist")])[:, 0], W, atol=1e-6
    )
    # Turn an elbow to that angle: it lies in the plane, away from the mouth.
    along = (W - S) / np.linalg.norm(W - S)
    down = -scene.model.arm.up - (-scene.model.arm.up @ along) * along
    elbow = rotation_about(along, angle) @ down
    if abs(swivel_angle(S, S + along * 0.1 + elbow, W, down=-scene.model.arm.up)[0] - angle) > 1e-6:
        elbow = rotation_about(along, -angle) @ down
    side = scene.mouth - S - ((scene.mouth - S) @ along) * along
    assert np.linalg.norm(np.cross(elbow, side)) < 1e-9
    assert elbow @ side < 0


def test_manipulability_without_limits_lies_in_the_plane_of_the_mouth(scene, seen):
    apart = angle_between(Manipulability().swivel(seen).angle, Coplanar().swivel(seen).angle)
    ends = [s.swivel for s in scene.stretches]
    plane = Coplanar().swivel(seen).angle
    if any(s.min() < plane < s.max() for s in ends):
        assert abs(apart) < np.deg2rad(0.5) or abs(abs(apart) - np.pi) < np.deg2rad(0.5)


def test_a_pose_out_of_reach_has_no_answer_but_a_reason(scene, seen):
    far = scene.T_hand.copy()
    far[:3, 3] += [0.0, -1.0, 0.0]
    empty = make_scene(
        scene.model, far, shoulder=scene.shoulder, mouth=scene.mouth, start=scene.start
    )
    lost = replace(seen, scene=empty)
    for predictor in (MidRange(), GravityTorque(), MuscleEffort(), LeastDisplacement()):
        found = predictor.swivel(lost)
        assert np.isnan(found.angle)
        assert not found.status.ok and found.status.sentence


def test_what_is_known_already_is_looked_up(seen):
    assert Computed("c").fit([]).swivel(seen) is seen.criteria["c"]
    assert StartAngle().fit([]).swivel(seen).angle == seen.start


def test_criteria_refuse_an_observation_without_an_arm():
    with pytest.raises(ShapeError, match="P0, reach, end: the observation holds no arm"):
        MidRange().swivel(people(1, 1)[0])
    with pytest.raises(UnknownNameError, match="measure 'angles'"):
        LeastDisplacement(measure="angles")


def test_names_are_unique_and_the_mean_of_no_angle_is_unknown():
    names = [p.name for p in (*CRITERIA, *FITTED)]
    assert len(set(names)) == len(names)
    assert np.isnan(mean_angle([]))
