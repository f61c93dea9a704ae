import numpy as np
import pytest

from selfmotion.errors import RangeError
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.settings import PlanSettings
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.studies.center_out import (
    NAMES,
    CenterOut,
    MotorNoise,
    predicted,
    simulate,
    simulated_law,
    target_places,
)
from selfmotion.studies.tommasino2017 import (
    MOVEMENTS,
    compare,
    hysteresis,
    measure,
    measure_planned,
)
from selfmotion.studies.tommasino2017_numbers import (
    diagonal_ratio,
    figure_3_law,
    fit_person,
    population_prior,
    reproduce_tommasino2017,
)

STEADY = MotorNoise(0.0, 0.0, 0.0, 0.0)
PAPER = CenterOut(settings=PlanSettings(spring=22.5))


@pytest.fixture(scope="module")
def figure_3():
    return measure_planned(predicted(figure_3_law(), PAPER))


def test_diagonal_movements_curve_about_six_times_more(figure_3):
    assert 5.0 < diagonal_ratio(figure_3) < 7.0


def test_outbound_and_inbound_veer_to_the_same_side(figure_3):
    for name in ("NE", "NW", "SW", "SE"):
        out, back = (figure_3.net[figure_3.of(name, d)][0] for d in ("outbound", "inbound"))
        assert out * back > 0.0
        assert abs(hysteresis(figure_3, name)[0]) > 3.0 * abs(hysteresis(figure_3, "E")[0])


def test_opposite_targets_have_the_same_curvature(figure_3):
    # A turn by half a circle keeps left and right: A_net is equal, the paths are mirrored.
    out = figure_3.net[:8]
    np.testing.assert_allclose(out[:4], out[4:], atol=1e-9)


def test_equal_damping_in_all_joints_gives_straighter_paths():
    even = JointLaw(np.eye(3) * 4.0 / 3.0, np.zeros(3))
    isotropic = measure_planned(predicted(even, PAPER))
    uneven = measure_planned(predicted(figure_3_law(), PAPER))
    assert np.abs(isotropic.net).max() < 0.2 * np.abs(uneven.net).max()


def test_the_simulated_protocol_is_the_paper_s():
    study = simulate(figure_3_law(), np.random.default_rng(0), protocol=CenterOut(n_trials=3))
    assert len(study) == 48
    for trial in ("1", "2", "3"):
        done = [r.labels for r in study.select(trial=trial)]
        assert [label.condition for label in done] == ["outbound", "inbound"] * 8
        assert sorted(str(label.target) for label in done[::2]) == sorted(NAMES)
        assert all(a.target == b.target for a, b in zip(done[::2], done[1::2], strict=True))
    orders = {tuple(r.labels.target for r in study.select(trial=t))[::2] for t in ("1", "2", "3")}
    assert len(orders) == 3
    assert abs((study[0].rate or 0.0) - 120.0) < 15.0


def test_without_noise_a_person_moves_as_predicted():
    law = figure_3_law()
    protocol = CenterOut(n_trials=2, settings=PlanSettings(spring=22.5), rate=500.0)
    study = simulate(law, np.random.default_rng(0), protocol=protocol, noise=STEADY)
    found = measure(study)
    model = measure_planned(predicted(law, protocol))
    # Movements begin in slightly different postures: the null space has not relaxed in 0.4 s.
    for i, movement in enumerate(MOVEMENTS):
        np.testing.assert_allclose(found.net[found.of(*movement)], model.net[i], atol=2e-3)


def test_the_true_law_is_not_told_from_the_data():
    rng = np.random.default_rng(1)
    law = simulated_law(rng)
    result = compare(simulate(law, rng), law)
    # 16 tests at 5 %: two or three false alarms at the worst, nearly none after correction.
    assert result.captured >= 0.75
    assert result.captured_corrected >= 0.9
    other = JointLaw(np.diag([0.5, 2.6, 0.9]), law.rest)
    assert compare(simulate(law, rng), other).captured < 0.7
    frame = result.to_frame()
    assert len(frame) == 3 * 16 + 8
    assert frame.loc[frame["test"] == "A_sum", "note"].str.contains("says nothing").all()


def test_outliers_are_left_out():
    rng = np.random.default_rng(2)
    study = simulate(figure_3_law(), rng, protocol=CenterOut(n_trials=3))
    slow = study[5]
    dawdled = Recording(3.0 * slow.time, q=slow.q, x=slow.x, labels=slow.labels)
    found = measure(Study((*study.recordings[:5], dawdled, *study.recordings[6:])))
    assert not found.kept[5]
    assert found.kept.mean() > 0.8
    assert len(found.to_frame()) == 48


def test_recordings_without_a_target_are_refused():
    study = simulate(figure_3_law(), np.random.default_rng(3), protocol=CenterOut(n_trials=2))
    bad = Recording(study[0].time, q=study[0].q, x=study[0].x, labels=Labels(target="up"))
    with pytest.raises(RangeError, match="target must be one of E, NE"):
        measure(Study((bad,)))
    with pytest.raises(RangeError, match="at least 2"):
        CenterOut(n_trials=1)


def test_the_prior_makes_the_fit_within_15_degrees_usable():
    rng = np.random.default_rng(4)
    law = simulated_law(rng)
    study = simulate(law, rng)
    fit = fit_person(study, prior=population_prior())
    assert fit.status.ok
    assert (np.abs(fit.stiffness - law.stiffness) < 4.0 * fit.stiffness_stderr).all()
    assert fit.stiffness_stderr[0, 0] <= 0.12
    alone = fit_person(study)
    assert any("cannot tell the stiffness of pronation" in s for s in alone.sentences)


def test_the_table_of_published_numbers():
    found = reproduce_tommasino2017(0, n_people=1, protocol=CenterOut(n_trials=4))
    rows = found.table.to_dict("records")
    # eq. 10 at the centre: b_max = 2 τ₀, so that k = 2 where Fig 3 prints 22.5.
    (spring,) = (row for row in rows if row["quantity"].startswith("constant k"))
    assert (spring["published"], spring["ours"]) == ("22.5", "2")
    same = [row for row in rows if row["comparable"] and row is not spring]
    assert len(same) == 3 and all(row["ours"] == row["published"] for row in same)
    assert all(row["ours"] and row["note"] for row in rows)
    assert len(found.people) == 1
    np.testing.assert_allclose(np.linalg.norm(target_places(), axis=1), np.pi / 12)
