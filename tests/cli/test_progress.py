import os
import subprocess
import sys

import pytest

from selfmotion.cli.progress import progress

SHOW = """
from selfmotion.cli.progress import progress
with progress(3, "fitting", quiet={quiet}) as done:
    for _ in range(3): done("outcome")
"""


def on_a_terminal(code: str) -> str:
    """Run code with stderr on a pseudo-terminal, and give what that shows."""
    pty = pytest.importorskip("pty", reason="pseudo-terminals are POSIX only")
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    subprocess.run([sys.executable, "-c", code], stderr=theirs, env=environment, check=True)
    os.write(theirs, b"\n")  # so that there is something to read
    shown = os.read(ours, 65536).decode()
    os.close(theirs)
    os.close(ours)
    return shown


def test_a_terminal_sees_how_many_are_complete() -> None:
    shown = on_a_terminal(SHOW.format(quiet=False))
    assert "fitting" in shown
    assert "3/3" in shown


def test_quiet_shows_nothing_on_a_terminal() -> None:
    assert on_a_terminal(SHOW.format(quiet=True)).strip() == ""


def test_a_file_sees_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with progress(3, "fitting") as done:
        done()
        done("an outcome")
    assert capsys.readouterr() == ("", "")
