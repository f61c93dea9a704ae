import numpy as np
import pandas as pd

from selfmotion.report.study_tables import groups_frame, swivel_frame
from selfmotion.studies.study_statistics import comparison_lines

SPREAD = {f"{k}{end}_deg": 1.0 for k in ("within", "between") for end in ("", "_lower", "_upper")}


def spread(selection: str, movements: int, **other: float) -> dict[str, object]:
    head = {"side": "right", "condition": "drink", "moment": "mid_drink", "selection": selection}
    numbers = {**SPREAD, "mean_deg": 40.0, "within_median_deg": 1.0, **other}
    return {**head, "people": 2, "movements": movements, **numbers}


def test_a_selection_that_leaves_nothing_out_is_told_once() -> None:
    same = [spread("all", 10), spread("elbow off the line", 10)]
    assert swivel_frame(pd.DataFrame(same))["which"].tolist() == ["all"]
    fewer = [spread("all", 10), spread("elbow off the line", 9, between_deg=np.nan)]
    found = swivel_frame(pd.DataFrame(fewer))
    assert found["which"].tolist() == ["all", "elbow off the line"]
    assert found["between"].tolist() == ["1.0\u00a0(1.0\u00a0to\u00a01.0)", "–"]
    assert found["moment"].tolist() == ["mid drink"] * 2


def test_groups_without_an_estimate_have_a_dash() -> None:
    row = {"subject": "P1", "side": "right", "condition": "drink", "trials": 5, "synergy": 0.1}
    row |= {"task_share": 0.5, "task_share_identity": 0.4, "task_share_others": 0.4}
    row |= {"status": "a long sentence", "unexplained": 0.2}
    found = groups_frame(pd.DataFrame([row]), {})
    assert found["joints with weights"].tolist() == ["–"]
    assert not {"status", "unexplained"} & set(found.columns)


def test_comparisons_without_a_test_share_their_reason() -> None:
    rows = [
        {"comparison": "right: a against b", "level": "joints", "sentence": "T²", "t2": 3.0},
        {"comparison": "left: a against b", "level": "joints", "sentence": "no test", "t2": np.nan},
        {"comparison": "left: a against c", "level": "joints", "sentence": "no test", "t2": np.nan},
    ]
    assert comparison_lines(pd.DataFrame(rows)) == [
        "right: a against b (joints): T²",
        "no test. So in: left: a against b (joints); left: a against c (joints)",
    ]
    assert comparison_lines(pd.DataFrame()) == []
