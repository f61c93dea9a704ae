"""Run commands in tests: what they print, and the one line of what they refuse."""

import json
from pathlib import Path
from typing import Any

import pytest

from selfmotion.cli.app import main

Capture = pytest.CaptureFixture[str]


def answered(capsys: Capture, *words: object, code: int = 0) -> dict[str, Any]:
    """Run a command with --json and give its document."""
    got = main([*map(str, words), "--json"])
    captured = capsys.readouterr()
    assert (got, captured.err) == (code, "")
    return json.loads(captured.out)


def refused(capsys: Capture, *words: object) -> str:
    """Run a command that must be refused, and give its one line."""
    assert main([str(word) for word in words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("selfmotion: ")
    assert captured.err.count("\n") == 1
    return captured.err


def written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path
