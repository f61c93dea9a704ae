"""The paper's numbers come out, and the table says what may be compared."""

import numpy as np
import pytest

from selfmotion.motion.files.mat import PublishedDataset
from selfmotion.motion.labels import Labels
from selfmotion.report.khoramshahi2022_page import khoramshahi2022_page
from selfmotion.studies.khoramshahi2022 import Size, against_authors, reproduce
from selfmotion.studies.numerical_examples import example_1, example_2, gamma_sweep, noise_sweep
from selfmotion.studies.paper_figures import FIGURES
from selfmotion.studies.published import KHORAMSHAHI2022, as_text
from selfmotion.studies.results import Convergence
from selfmotion.studies.simulated_people import ReachingProtocol
from selfmotion.studies.simulated_screen import short_protocol

SMALL = Size(
    repeats=2,
    sweep_repeats=1,
    iterations=(60, 60),
    generated_iterations=10,
    recorded_iterations=10,
    reaching=ReachingProtocol(n_people=3, n_trials=3),
    screen=short_protocol(n_people=1, n_targets=5),
)


def test_example_1_gives_the_printed_error():
    run = example_1(rng=np.random.default_rng(1), repeats=8)
    assert run.final_error == pytest.approx(0.07, abs=0.01)


def test_example_1_starts_with_equal_weights():
    run = example_1(rng=np.random.default_rng(1), repeats=1)
    np.testing.assert_array_equal(run.weights[0, 0], np.ones(5))


def test_larger_gamma_is_slower_and_one_never_moves():
    sweep = gamma_sweep(
        rng=np.random.default_rng(2), repeats=1, gammas=(0.0, 0.6, 0.9, 1.0), iterations=200
    )
    steps = [run.iterations_to(0.01)[0] for run in sweep.runs]
    assert steps[0] < steps[1] < steps[2]
    assert np.ptp(sweep.run(1.0).weights, axis=1).max() == 0.0


def test_example_2_turns_round_without_gamma_and_settles_with_a_large_one():
    sweep = example_2(gammas=(0.0, 0.2, 0.8), iterations=150)
    np.testing.assert_allclose(sweep.run(0.0).weights[0, -1], [0.0, 1.0], atol=0.03)
    np.testing.assert_allclose(sweep.run(0.8).weights[0, -1], [1.0, 0.01], atol=0.02)
    swing = {g: np.ptp(sweep.run(g).weights[0, -50:], axis=0).max() for g in (0.2, 0.8)}
    assert swing[0.2] > 0.05 and swing[0.8] < 0.01
    printed = sweep.runs[-1].weights[0]
    assert printed[-1, 1] > 0.1  # the printed schedule freezes on the way


def test_projected_noise_harms_algorithm_1_more():
    table = noise_sweep(rng=np.random.default_rng(3), sigmas=(0.5,), repeats=2).table
    error = {
        (row["sigma"], row["method"]): row["error"]
        for row in table.to_dict("records")
        if row["noise"] == "projected"
    }
    assert error[0.5, "ml"] < 0.5 * error[0.5, "paper"]


def test_iterations_are_counted_to_the_last_departure():
    path = np.array([1.0, 0.5, 0.0, 0.5, 0.005, 0.0])[None, :, None]
    run = Convergence("by hand", path, np.zeros(1))
    assert run.iterations_to(0.01).tolist() == [4.0]


@pytest.fixture(scope="module")
def small():
    return reproduce(seed=5, size=SMALL)


def test_every_published_number_has_a_row(small):
    assert list(small.table["quantity"]) == [p.quantity for p in KHORAMSHAHI2022]
    assert (small.table["ours"] != "").all()
    assert (small.table["note"] != "").all()


def test_the_split_velocity_of_eqs_13_and_14_is_exact(small):
    table = small.table.set_index("where")
    for where, null in (("eq. 13", "-0.5, 0.5"), ("eq. 14", "-0.1, 0.1")):
        assert table.at[where, "ours"] == table.at[where, "published"]
        assert null in table.at[where, "note"]


def test_generated_people_are_never_called_comparable(small):
    examples = ["eq. 13", "eq. 14", "Fig 1", "Fig 2", "Fig 3", "S1 File"]
    experiments = ~small.table["where"].isin(examples)
    assert not small.table.loc[experiments, "comparable"].any()
    assert small.table.loc[~experiments, "comparable"].all()


def test_the_report_holds_every_figure(small):
    page = khoramshahi2022_page(small)
    places = {one.section for one in FIGURES["khoramshahi2022"]} - {""}
    assert places <= {section.heading for section in page.sections}
    captions = [picture.caption for section in page.sections for picture in section.pictures]
    for name in ("Fig 1", "Fig 2", "Fig 3", "Fig 5", "Fig 6", "Fig 7", "Fig 9", "Table 1", "S1"):
        assert any(f"As {name}" in c or f"As the paper's {name}" in c for c in captions), name


def test_locked_elbow_leaves_nothing_to_identify(small):
    table = small.screen.weights
    locked = table[(table["condition"] == "Locked") & (table["method"] == "ml")]
    assert not locked["identified"].any()
    natural = table[(table["condition"] == "Natural") & (table["method"] == "ml")]
    assert natural["identified"].all()


def test_recorded_data_take_the_place_of_generated_people(small):
    weights = {Labels(subject="P01", condition="Natural"): np.array([1.0, 0.2, 0.1, 1.0])}
    data = PublishedDataset(small.reaching.study, "experiment 1", (), authors_weights=weights)
    made = reproduce(seed=5, size=SMALL, data=data)
    assert made.reaching.recovery is None and not made.reaching.generated
    assert made.table.loc[made.table["where"] == "Fig 6", "comparable"].all()
    # The other parts have streams of their own: the same numbers as before.
    examples = made.table["where"].isin(["Fig 1", "Fig 2", "Fig 3", "Table 1"])
    assert made.table[examples].equals(small.table[examples])
    assert made.authors is not None
    assert made.authors["authors"].tolist() == [1.0, 0.2, 0.1, 1.0]
    assert set(made.authors.columns) >= {"algorithm_1", "maximum_likelihood"}


def test_flat_data_are_refused(small):
    data = PublishedDataset(small.reaching.study, "flat", ())
    with pytest.raises(ValueError, match="layout 'flat'"):
        reproduce(size=SMALL, data=data)


def test_authors_weights_of_single_trials_are_left_out(small):
    single = {Labels(subject="P01", condition="Natural", trial="3"): np.ones(4)}
    assert against_authors(small.reaching.weights, single).empty


def test_numbers_as_text():
    assert as_text((0.07, float("nan"), 1.5e-9, 225.3)) == "0.07, –, 1.5e-09, 225"
