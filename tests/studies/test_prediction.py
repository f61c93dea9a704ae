"""Predictions against people: planted studies, generated markers, and recordings at hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.studies.prediction_cases import BIAS, EFFORT_ERROR, planted, record

from selfmotion.batch import Runner
from selfmotion.capture.angles import angles_from_markers
from selfmotion.capture.person import calibrate_person
from selfmotion.capture.simulated_markers import simulate_markers
from selfmotion.errors import FileFormatError, RangeError, UnknownNameError
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.methods.predictors.catalogue import BASELINE, EFFORT, FITTED, START
from selfmotion.methods.predictors.constant import Constant
from selfmotion.methods.predictors.observation import Observation
from selfmotion.motion.labels import Frame, Labels
from selfmotion.report.html import write_report
from selfmotion.report.prediction_figures import sensitivity_figure
from selfmotion.report.prediction_li2022 import people_sections
from selfmotion.report.prediction_page import errors_by_variant
from selfmotion.studies.li2022_people import li2022_on_people, with_people
from selfmotion.studies.people import MovementOfPerson, RecordedPerson, load_person
from selfmotion.studies.prediction import PredictionPlan, left_out, plan_items, predict_people
from selfmotion.studies.prediction_observe import from_record, to_record
from selfmotion.studies.prediction_poses import (
    FittedPerson,
    Moment,
    fit_person,
    moments_of_person,
)
from selfmotion.studies.prediction_summary import summarise
from selfmotion.studies.prediction_tables import tables_of
from selfmotion.studies.study_file import StudyFile, find_trials, load_study_file
from selfmotion.studies.trial_run import person_arm, plan_people

DATA = Path(__file__).parents[3].joinpath("shared", "data", "ue_adl")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("planted")
    study = planted(folder)
    plan = PredictionPlan((folder,), load_study_file(study), out=folder / "out")
    return predict_people(plan, Runner(resume=True))


def test_planted_errors_come_back(run):
    table = summarise(run.predictions, rng=np.random.default_rng(0), draws=200)
    rows = table.set_index("predictor")
    assert rows.loc[EFFORT, "mean_deg"] == pytest.approx(np.rad2deg(EFFORT_ERROR))
    assert rows.loc[START, "mean_deg"] == pytest.approx(np.rad2deg(BIAS))
    assert rows.loc[START, "bias_deg"] == pytest.approx(-np.rad2deg(BIAS))
    assert rows.loc["nearest to start, bias", "mean_deg"] == pytest.approx(0.0, abs=1e-9)
    # People differ by 0.1 rad from one to the next: each is predicted by the mean of the others.
    people = np.array([0.1, 0.2, 0.3, 0.4])
    others = (people.sum() - people) / 3
    expected = np.rad2deg(np.abs(people - others).mean())
    assert rows.loc[BASELINE, "mean_deg"] == pytest.approx(expected, rel=0.02)
    assert rows.loc["nearest to start, bias", "gain_deg"] == pytest.approx(expected, rel=0.02)
    low, mean, high = (table[f"{k}_deg"].to_numpy(float) for k in ("lower", "mean", "upper"))
    assert (low <= mean + 1e-9).all() and (high >= mean - 1e-9).all()


def run_records():
    rng = np.random.default_rng(4)
    return [record(p, task, t, rng) for p in range(1, 5) for task in ("reach", "drink")
            for t in (1, 2)]  # fmt: skip


def test_moments_without_a_swivel_angle_are_left_out_and_kept_in_the_table(run):
    tables = tables_of(run)
    assert len(tables.observations) == 24
    assert tables.observations["counts"].to_numpy(dtype=bool).sum() == 16
    assert set(run.predictions["trial"]) == {"1", "2"}
    assert tables.spread["within_deg"].to_numpy() == pytest.approx(
        np.rad2deg(0.01 / np.sqrt(2.0)) * np.ones(2)
    )
    assert tables.spread["between_deg"].to_numpy() == pytest.approx(
        np.rad2deg(np.std([0.1, 0.2, 0.3, 0.4], ddof=1)) * np.ones(2)
    )


def test_the_papers_figures_hold_the_planted_error(run, tmp_path):
    found = li2022_on_people(tables_of(run))
    assert str(found.numbers.loc[0, "ours"]).startswith("28.6, ")
    assert found.places["error_deg"].to_numpy() == pytest.approx(np.rad2deg(EFFORT_ERROR))
    assert found.coordinates["mean_deg"].to_numpy() == pytest.approx(np.rad2deg(0.1))
    assert list(found.table_iv["study"][:3]) == ["This work"] * 3
    # It stands in the place of the number that had no counterpart, and in the report.
    before = pd.DataFrame({"where": ["Fig 3", "Table IV"], "ours": ["1", ""]})
    assert list(with_people(before, found)["where"]) == ["Fig 3", "Table IV"]
    sections = people_sections(found)
    text = write_report(tmp_path / "r.html", "People", sections).read_text(encoding="utf-8")
    for words in ("As Fig 8", "As Fig 9", "Table IV beside ours", "3.73 ± 3.27", "28.6 ± "):
        assert words in text
    assert text.count("<svg") == 2
    assert all(ax.has_data() for p in sections[0].pictures for ax in p.figure.axes)


def test_nothing_of_whoever_is_predicted_enters_a_fit():
    observations = [from_record(r) for r in run_records()]
    plain = left_out(observations, FITTED)
    first = observations[0].subject
    # Another natural angle of the same person: what others are predicted by changes, not this.
    turned = [
        replace(o, natural=o.natural + 0.7) if o.subject == first else o for o in observations
    ]
    for name, rows in left_out(turned, FITTED).items():
        for o, (angle, *_), (before, *_) in zip(observations, rows, plain[name], strict=True):
            assert (angle == before) == (o.subject == first), name


def test_variants_are_compared_by_the_predictors_that_all_have():
    rows = [
        {"variant": v, "predictor": p, "mean_deg": m, "moved_deg": 1.0, "shift_deg": -1.0,
         "inside": 0.9}
        for v, p, m in (("as recorded", "constant per task", 10.0), ("as recorded", "extra", 5.0),
                        ("as recorded", "mid-range", 30.0), ("wide", "constant per task", 11.0),
                        ("wide", "mid-range", 33.0))
    ]  # fmt: skip
    table = errors_by_variant(pd.DataFrame(rows))
    assert list(table["variant"]) == ["as recorded", "wide"]
    assert list(table["mid-range"]) == [30.0, 33.0] and "extra" not in table
    figure = sensitivity_figure(pd.DataFrame(rows))
    shown = [line.get_label() for line in figure.axes[1].lines]
    assert shown == ["constant per task", "mid-range"]


def test_whoever_is_predicted_is_left_out_with_both_arms():
    rng = np.random.default_rng(0)
    seen: list[set[tuple[str, str]]] = []

    class Spy(Constant):
        def fit(self, training):
            seen.append({(o.subject, o.side) for o in training})
            return self

        def swivel(self, observation):
            assert observation.subject not in {subject for subject, _ in seen[-1]}
            return Constant(means=((observation.kind, 0.0),)).swivel(observation)

    everyone = []
    for p in (1, 2, 3):
        for side in ("right", "left"):
            everyone.append(from_record(record(p, "reach", 1, rng) | {"side": side}))
    left_out(everyone, [Spy()])
    assert [len(s) for s in seen] == [4, 4, 4]


def test_an_observation_survives_its_record():
    given = record(1, "reach", 1, np.random.default_rng(0))
    back = from_record(given)
    again = to_record((back, {}))
    assert {k: given[k] for k in again} == again
    assert isinstance(back, Observation)


def test_studies_that_cannot_be_predicted_are_refused(tmp_path):
    study = planted(tmp_path, n_people=2)
    plan = PredictionPlan((tmp_path,), load_study_file(study), out=tmp_path / "out")
    with pytest.raises(RangeError, match="2 people could be used; .* at least 3"):
        predict_people(plan, Runner(resume=True))
    for text, error, words in (
        ("pattern = '(?P<subject>P).csv'", RangeError, "names no static trial"),
        ("pattern = '(?P<subject>P).csv'\nstatic = 's.csv'", RangeError, "moments: .* names none"),
        (study.read_text().replace("reach]", "comb]").replace("drink]", "eat]"), FileFormatError,
         "no file is of this condition .found: drink, reach"),
    ):  # fmt: skip
        study.write_text(text)
        with pytest.raises(error, match=words):
            plan_items(PredictionPlan((tmp_path,), load_study_file(study)))


def generated(side: str) -> tuple[RecordedPerson, list[float]]:
    """Capture a generated person at the far end of three movements; give true swivel angles."""
    capture = simulate_markers(side=side, rng=np.random.default_rng(1))
    arm = person_arm("upper_limb_anatomical", adult=True)
    person = calibrate_person(arm, capture.static, capture.movements, side=side)
    movements, true = [], []
    for markers, q in list(zip(capture.movements, capture.angles, strict=True))[:3]:
        motion = angles_from_markers(person, markers)
        sample = 115
        labels = Labels("P", side, markers.labels.condition, None, "1")
        moments = {"start": 0, "far": sample, "end": len(q) - 1}
        movements.append(MovementOfPerson(labels, motion, moments, {}))
        points = tip_positions(
            capture.arm.chain,
            q[sample],
            [capture.arm.tip(k) for k in ("shoulder", "elbow", "wrist")],
        )[0]
        S, E, W = points * ([1.0, 1.0, 1.0] if side == "right" else [-1.0, 1.0, 1.0])
        true.append(float(swivel_angle(S, E[None], W[None], down=[0, 0, -1])[0]))
    return RecordedPerson("P", side, person, tuple(movements), ()), true


@pytest.fixture(scope="module")
def fitted() -> tuple[list[Moment], list[float], FittedPerson]:
    person, true = generated("right")
    seen, lost = moments_of_person(person)
    assert not lost
    return seen, true, fit_person(seen, knuckle_radial=0.02)


def test_natural_angles_are_those_of_the_person_behind_the_markers(fitted):
    seen, true, _ = fitted
    natural = [m.natural() for m in seen if m.moment == "far"]
    assert np.rad2deg(natural) == pytest.approx(np.rad2deg(true), abs=0.5)


def test_the_arm_with_muscles_takes_the_persons_posture(fitted):
    seen, _, fit = fitted
    arm = fit.model.arm
    assert fit.error.max() < 0.005
    points = tip_positions(arm.chain, fit.q, [arm.tip(k) for k in ("elbow", "wrist")])
    for m, S, (E, W) in zip(seen, fit.shoulder, points, strict=True):
        if m.moment == "far":
            own = swivel_angle(S, E[None], W[None], down=-arm.up)[0]
            assert np.rad2deg(own) == pytest.approx(np.rad2deg(m.natural()), abs=2.0)


def test_a_left_arm_is_seen_in_the_mirror(fitted):
    left, true = generated("left")
    seen, _ = moments_of_person(left)
    for right, other in zip(fitted[0], seen, strict=True):
        for name in ("elbow", "wrist", "knuckle"):
            assert other.points[name] == pytest.approx(right.points[name], abs=2e-3)
    assert np.rad2deg(true) == pytest.approx(np.rad2deg(fitted[1]), abs=1e-6)


def test_the_least_wrist_offset_brings_all_postures_inside(fitted):
    seen = fitted[0]
    bent = fit_person(seen, knuckle_radial=0.07)  # a wrong knuckle: deviation beyond the limits
    straight = fitted[2]
    assert straight.inside()[[m.moment == "far" for m in seen]].all()
    lower, upper = bent.model.arm.lower[5], bent.model.arm.upper[5]
    assert ((bent.q[:, 5] >= lower) & (bent.q[:, 5] <= upper)).all()
    with pytest.raises(UnknownNameError, match="limits 'none'"):
        fit_person(seen, limits="none")


def test_moving_the_shoulder_moves_all_points_the_other_way(fitted):
    one = fitted[0][0]
    moved = one.with_shoulder((0.01, 0.0, -0.02))
    for name, point in one.points.items():
        assert point - moved.points[name] == pytest.approx([0.01, 0.0, -0.02])


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the reaching recordings are not at {DATA}")
def test_a_recorded_person_is_fitted_within_a_centimetre_and_two_degrees():
    study = StudyFile(
        pattern=r"(?P<subject>ADL005)(?P<condition>[AD])(?P<side>R)(?P<trial>[12])\.csv",
        static="{subject}_static.csv",
        names={"side": {"R": "right"}},
        frame=Frame(),
        moments=load_study_moments(),
    )
    person = load_person(plan_people(find_trials(study, [DATA]))[0], study)
    seen, lost = moments_of_person(person)
    assert not lost
    assert {m.moment for m in seen} == {"start", "end_of_reach", "grasp", "mid_drink"}
    fit = fit_person(seen, knuckle_radial=person.person.protocol.knuckle_radial)
    assert fit.error.max() < 0.01
    assert fit.inside().all()


def load_study_moments():
    from selfmotion.studies.moments import read_moments

    return read_moments(
        {
            "A": {"end_of_reach": {"stroke": 1, "at": "end"}},
            "D": {
                "strokes": 4,
                "grasp": {"stroke": 1, "at": "end"},
                "mid_drink": {"between": [2, 3], "at": "slowest"},
            },
        }
    )
