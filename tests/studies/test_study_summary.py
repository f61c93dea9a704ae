"""Tables over people, on numbers whose answers are known."""

import numpy as np
import pandas as pd
import pytest

from selfmotion.studies.study_summary import (
    joint_levels,
    means_over_people,
    quality,
    swivel_spread,
)


def trials(angles: dict[str, list[float]], off: float = 100.0) -> pd.DataFrame:
    rows = [
        {
            "subject": subject,
            "side": "right",
            "condition": "reach",
            "swivel_grasp_deg": angle,
            "elbow_off_grasp_mm": off,
        }
        for subject, values in angles.items()
        for angle in values
    ]
    return pd.DataFrame(rows)


def test_spread_within_and_between_by_hand():
    """Two people: variances 1 and 4 over three repeats each, means 10 and 20."""
    table = trials({"P1": [9.0, 10.0, 11.0], "P2": [18.0, 20.0, 22.0]})
    row = swivel_spread(table, ["grasp"]).iloc[0]
    assert row["mean_deg"] == pytest.approx(15.0)
    assert row["within_deg"] == pytest.approx(np.sqrt(2.5))
    assert row["within_median_deg"] == pytest.approx(np.sqrt(2.5))
    assert row["between_deg"] == pytest.approx(np.sqrt(50.0))
    # χ² with 4 degrees of freedom: quantiles 0.4844 and 11.1433 (any table).
    assert row["within_lower_deg"] == pytest.approx(np.sqrt(2.5 * 4 / 11.1433), rel=1e-4)
    assert row["within_upper_deg"] == pytest.approx(np.sqrt(2.5 * 4 / 0.484419), rel=1e-4)


def test_intervals_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(3)
    held = []
    for _ in range(150):
        centres = rng.normal(40.0, 9.0, 8)
        table = trials(
            {str(i): (c + 3.0 * rng.standard_normal(5)).tolist() for i, c in enumerate(centres)}
        )
        row = swivel_spread(table, ["grasp"]).iloc[0]
        held.append(row["within_lower_deg"] < 3.0 < row["within_upper_deg"])
    assert 0.91 < np.mean(held) < 0.985


def test_angles_about_180_degrees_do_not_part():
    near = swivel_spread(trials({"P1": [179.0, -179.0], "P2": [178.0, 180.0]}), ["grasp"]).iloc[0]
    assert near["within_deg"] == pytest.approx(np.sqrt(2.0))
    assert abs(abs(near["mean_deg"]) - 179.5) < 0.01


def test_a_straight_elbow_counts_in_all_only():
    table = pd.concat([trials({"P1": [30.0, 31.0]}), trials({"P2": [-60.0, 80.0]}, off=10.0)])
    found = swivel_spread(table, ["grasp"]).set_index("selection")
    assert found["people"].to_dict() == {"all": 2, "elbow off the line": 1}
    assert found.loc["elbow off the line", "within_deg"] == pytest.approx(np.sqrt(0.5))


def test_means_have_t_intervals_and_missing_people_do_not_count():
    table = pd.DataFrame({"side": "right", "condition": "drink", "task_share": [0.5, 0.7, np.nan]})
    for name in ("task_share_identity", "task_share_others", "synergy"):
        table[name] = np.nan
    (row,) = means_over_people(table).to_dict("records")
    assert (row["what"], row["people"]) == ("task_share", 2)
    assert row["mean"] == pytest.approx(0.6)
    # t with 1 degree of freedom: 12.7062; a share is between 0 and 1, and so is its mean.
    assert (row["lower"], row["upper"]) == (0.0, 1.0)
    table["synergy"] = [0.5, 0.7, np.nan]
    row = means_over_people(table).to_dict("records")[-1]
    assert row["what"] == "synergy"
    assert row["upper"] - row["mean"] == pytest.approx(12.7062 * 0.1, rel=1e-4)
    assert row["lower"] < 0.0


def test_joint_levels_are_found_with_holes():
    rng = np.random.default_rng(1)
    level = np.array([0.0, -1.0, -3.0, 2.0])
    logs = level + rng.standard_normal((6, 1))
    logs[0, 1] = logs[1, [0, 3]] = logs[4, 2] = np.nan
    np.testing.assert_allclose(joint_levels(logs), level - level.mean(), atol=1e-12)
    apart = np.array([[0.0, 1.0, np.nan, np.nan], [np.nan, np.nan, 0.0, 1.0]])
    assert np.isnan(joint_levels(apart)).all()


def test_quality_gives_percentiles_of_what_is_there():
    table = quality(pd.DataFrame({"rms_landmark_mm": [1.0, 2.0, 3.0, None]}))
    assert table.to_dict("records")[0]["median"] == 2.0 and len(table) == 1
    assert table["trials"].tolist() == [3]
