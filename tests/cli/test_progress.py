import os
import subprocess
import sys

import pytest

from selfmotion.cli.progress import COMPILING, progress

SHOW = """
from selfmotion.cli.progress import COMPILING, progress
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


STAGES = """
import time
from selfmotion.cli.progress import stages
with stages(quiet={quiet}) as tell:
    tell("calibrating")
    time.sleep(0.3)
"""


def test_a_terminal_sees_what_is_being_done() -> None:
    assert "calibrating" in on_a_terminal(STAGES.format(quiet=False))
    assert on_a_terminal(STAGES.format(quiet=True)).strip() == ""


COMPILES = """
import time
from selfmotion.cli.progress import COMPILING, compilation_note
with compilation_note(quiet={quiet}):
    from numba import njit
    time.sleep(1.0)  # until the note has seen numba
    njit(lambda x: 2 * x)(1)
    njit(lambda x: 3 * x)(1)
"""


def test_a_terminal_is_told_once_that_kernels_are_compiled() -> None:
    assert on_a_terminal(COMPILES.format(quiet=False)).count(COMPILING) == 1
    assert on_a_terminal(COMPILES.format(quiet=True)).strip() == ""
