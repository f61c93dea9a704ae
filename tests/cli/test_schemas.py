import json
from pathlib import Path

import msgspec
import pytest

from selfmotion.cli.app import main
from selfmotion.cli.output import schema
from tests.cli import golden


@pytest.mark.parametrize("name", golden.DOCUMENTS)
def test_schema_file_is_that_of_the_type_written(name: str) -> None:
    written = golden.schema_file(name).read_bytes()
    assert written == schema(golden.contract(name).document), "run `make golden` and look at it"


@pytest.mark.parametrize("name", golden.DOCUMENTS)
def test_example_file_fits_the_schema(name: str) -> None:
    document = golden.contract(name).document
    msgspec.json.decode(golden.example_file(name).read_bytes(), type=document, strict=True)


@pytest.mark.parametrize("name", golden.DOCUMENTS)
def test_command_still_gives_its_example(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(golden.ROOT)
    assert main(golden.contract(name).example) == 0
    found = json.loads(capsys.readouterr().out)
    wanted = json.loads(golden.example_file(name).read_text(encoding="utf-8"))
    assert golden.difference(found, wanted) is None


@pytest.mark.parametrize("name", golden.DOCUMENTS)
def test_document_names_schema_version_and_provenance(name: str) -> None:
    example = json.loads(golden.example_file(name).read_text(encoding="utf-8"))
    assert example["schema"] == f"selfmotion/{name}/1"
    assert example["version"] == example["provenance"]["version"]


def test_no_file_is_left_from_a_command_that_went() -> None:
    wanted = {f"{name}.{kind}.json" for name in golden.DOCUMENTS for kind in ("schema", "example")}
    assert {Path(path).name for path in golden.FOLDER.glob("*.json")} == wanted


def test_difference_names_the_place() -> None:
    wanted = {"a": [1.0, {"b": 2.0}], "version": "1"}
    assert golden.difference({"a": [1.0, {"b": 2.0 + 1e-9}], "version": "2"}, wanted) is None
    assert golden.difference({"a": [1.0, {"b": 3.0}], "version": "1"}, wanted) == (
        "$.a[1].b: 3.0 instead of 2.0"
    )
    assert golden.difference({"a": [1.0, {"b": None}], "version": "1"}, wanted) is not None
