import io
import json
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from selfmotion.cli import output
from selfmotion.provenance import Provenance


class Sample(output.Document, frozen=True, tag="selfmotion/sample/1", kw_only=True):
    share: output.Number
    weights: output.Vector
    extra: dict[str, Any]


def document(share: float | None, weights: list[float | None], **extra: Any) -> Sample:
    return Sample(provenance=Provenance("sample"), share=share, weights=weights, extra=extra)


def test_unknown_numbers_become_null() -> None:
    made = document(float("nan"), output.numbers([1.0, np.inf, -np.inf, np.nan]))
    read = json.loads(output.encode(made))
    assert read["share"] is None
    assert read["weights"] == [1.0, None, None, None]


def test_numbers_keep_the_shape_of_any_array() -> None:
    assert output.numbers(np.full((2, 0), np.nan)) == [[], []]
    assert output.numbers(np.array([[[1, 2]]])) == [[[1.0, 2.0]]]
    assert output.numbers(np.nan) is None


def test_document_takes_what_numpy_and_paths_give() -> None:
    made = document(0.5, [], array=np.array([1.0, np.nan]), n=np.int64(3), at=Path("a/b"))
    assert json.loads(output.encode(made))["extra"] == {"array": [1.0, None], "n": 3, "at": "a/b"}


def test_document_refuses_what_json_cannot_hold() -> None:
    with pytest.raises(TypeError, match="object"):
        output.encode(document(0.5, [], thing=object()))


def test_what_is_written_can_be_read_by_its_type() -> None:
    made = document(0.25, [0.5, None], note="µ")
    for indent in (0, 2):
        assert msgspec.json.decode(output.encode(made, indent=indent), type=Sample) == made


def test_schema_names_its_keys_and_forbids_others() -> None:
    root = json.loads(output.schema(Sample))["$defs"]["Sample"]
    assert set(root["required"]) == {
        *("schema", "version", "provenance", "share", "weights", "extra")
    }
    assert root["properties"]["schema"]["enum"] == ["selfmotion/sample/1"]
    assert root["additionalProperties"] is False


def test_finish_prints_for_a_person_or_for_a_program(capsys: pytest.CaptureFixture[str]) -> None:
    made = document(0.25, [])
    assert output.finish(made, "a quarter", json=False) == 0
    assert capsys.readouterr().out == "a quarter\n"
    assert output.finish(made, "a quarter", json=True, failed=2) == 1
    assert json.loads(capsys.readouterr().out)["share"] == 0.25


def test_document_on_a_terminal_is_indented(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = io.TextIOWrapper(io.BytesIO())
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr("sys.stdout", terminal)
    output.finish(document(0.25, []), "", json=True)
    terminal.seek(0)
    assert '\n  "share": 0.25' in terminal.read()


def test_save_writes_the_document_whole(tmp_path: Path) -> None:
    path = output.save(document(0.25, []), tmp_path / "new", "sample")
    assert json.loads(path.read_text())["share"] == 0.25
    assert [file.name for file in path.parent.iterdir()] == ["sample.json"]
