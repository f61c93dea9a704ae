from pathlib import Path

import pytest

from tests.cli.running import Capture, refused

FOLDER = Path(__file__).parents[2] / "examples" / "people"
STUDY = str(FOLDER / "study.toml")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((str(FOLDER),), "--study is missing"),
        ((str(FOLDER), "--study", STUDY, "--subject", "P9"), "P9: no such arm"),
        ((str(FOLDER), "--study", STUDY, "--side", "left"), "left: no such arm"),
        ((str(FOLDER), "--study", STUDY, "--report", "r.html"), "choose with --subject"),
        (("nowhere", "--study", STUDY), "no such folder"),
    ],
)
def test_bad_input_is_one_line(capsys: Capture, words: tuple[str, ...], told: str) -> None:
    assert told in refused(capsys, "person", *words)
