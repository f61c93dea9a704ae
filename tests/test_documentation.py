"""What README and documentation say must exist: commands, options, files that links name."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from selfmotion.cli.app import COMMANDS, load

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# Pages that `make docs` writes.
WRITTEN = ("_generated/commands.md", "_generated/api.md", "_generated/gallery/index.md")


def _command_lines(text: str) -> list[list[str]]:
    """Give the words of every `selfmotion ...` line in blocks of code."""
    blocks = re.findall(r"^```(?:sh|bash|console)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    blocks += re.findall(r"(?:^    .*\n)+", text, re.MULTILINE)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    return [shlex.split(line, comments=True) for line in lines if _is_call(line)]


def _is_call(line: str) -> bool:
    return line.strip().startswith("selfmotion ") and "COMMAND" not in line


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_commands_and_options_exist(page: Path) -> None:
    for _, command, *words in _command_lines(page.read_text(encoding="utf-8")):
        assert command in COMMANDS, f"{page.name}: selfmotion {command}"
        known = {name for p in load(command).params for name in p.opts}
        unknown = {w.split("=")[0] for w in words if w.startswith("--")} - known
        assert not unknown, f"{page.name}: selfmotion {command} {unknown}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_to_files(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8")):
        if "://" not in target and target not in WRITTEN:
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_tour_runs_in_python() -> None:
    tour = (ROOT / "docs" / "tour.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^```python\n(.*?)^```", tour, re.MULTILINE | re.DOTALL)
    scope: dict[str, Any] = {}
    exec(compile(block.replace("examples/", f"{ROOT}/examples/"), "tour.md", "exec"), scope)
    assert scope["weights"].status.ok
