import importlib
import inspect
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable

import pytest

from selfmotion._version import __version__
from selfmotion.cli import app
from selfmotion.cli.running import run
from selfmotion.errors import ShapeError

Capture = pytest.CaptureFixture[str]


def python(*arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)


def refused(capsys: Capture, *words: str) -> str:
    """Run a command that must be refused, and give its one line."""
    assert app.main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("selfmotion: ")
    assert captured.err.count("\n") == 1
    return captured.err


def raising(error: BaseException) -> Callable[[], int]:
    def call() -> int:
        raise error

    return call


def test_help_lists_every_command_and_imports_nothing_heavy() -> None:
    code = (
        "import sys; from selfmotion.cli.app import main; assert main(['--help']) == 0;"
        "heavy = {'numpy', 'scipy', 'pandas', 'numba', 'matplotlib', 'mujoco', 'msgspec',"
        " 'pydantic', 'rich'} & set(sys.modules); assert not heavy, heavy"
    )
    done = python("-c", code)
    assert done.returncode == 0, done.stderr
    assert all(f"\n  {name} " in done.stdout for name in app.COMMANDS)


@pytest.mark.parametrize("name", app.COMMANDS)
def test_summary_is_the_first_line_of_the_docstring(name: str) -> None:
    function = getattr(importlib.import_module(f"selfmotion.cli.{name}"), name)
    assert (inspect.getdoc(function) or "").splitlines()[0] == app.COMMANDS[name]


@pytest.mark.parametrize("name", app.COMMANDS)
def test_help_of_a_command_explains_every_option(name: str, capsys: Capture) -> None:
    assert app.main([name, "--help"]) == 0
    assert "Usage: selfmotion" in capsys.readouterr().out
    assert all(parameter.help for parameter in app.load(name).params)  # type: ignore[attr-defined]


def test_without_a_command_the_help_is_shown(capsys: Capture) -> None:
    assert app.main([]) == 0
    assert "Commands:" in capsys.readouterr().out


def test_version(capsys: Capture) -> None:
    assert app.main(["--version"]) == 0
    assert capsys.readouterr().out == f"selfmotion {__version__}\n"


def test_module_runs_as_the_program_does() -> None:
    done = python("-m", "selfmotion", "cite", "li2022", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["papers"][0]["key"] == "Li2022"


def test_unknown_command_is_refused_with_the_nearest(capsys: Capture) -> None:
    assert "unknown command 'cit'; did you mean 'cite'?" in refused(capsys, "cit")


def test_unknown_option_is_refused(capsys: Capture) -> None:
    line = refused(capsys, "cite", "--bibtx")
    assert "--bibtx" in line
    assert "`selfmotion cite --help`" in line


def test_bad_input_is_one_line_and_2(capsys: Capture) -> None:
    assert run(raising(ShapeError("qd: expected\nshape (K, 7)"))) == 2
    assert capsys.readouterr().err == "selfmotion: qd: expected shape (K, 7)\n"


def test_a_file_that_is_not_there_is_named(capsys: Capture) -> None:
    assert run(lambda: open("nowhere/reach.npz").close()) == 2
    assert capsys.readouterr().err == "selfmotion: nowhere/reach.npz: no such file or directory\n"


def test_interruption_is_one_line(capsys: Capture) -> None:
    assert run(raising(KeyboardInterrupt())) == 2
    assert capsys.readouterr().err == "selfmotion: interrupted\n"


def test_a_defect_is_one_line_and_70(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SELFMOTION_DEBUG", raising=False)
    assert run(raising(ZeroDivisionError("1/0"))) == 70
    err = capsys.readouterr().err
    assert err.startswith("selfmotion: internal error: ZeroDivisionError: 1/0")
    assert err.count("\n") == 1


def test_debug_shows_the_traceback(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SELFMOTION_DEBUG", "1")
    assert run(raising(ShapeError("qd"))) == 2
    assert "Traceback" in capsys.readouterr().err


def test_a_warning_is_one_line_and_does_not_fail(capsys: Capture) -> None:
    def call() -> int:
        warnings.warn("3 of 100 samples hold NaN\nand were dropped", UserWarning, stacklevel=1)
        return 0

    assert run(call) == 0
    line = "selfmotion: warning: 3 of 100 samples hold NaN and were dropped\n"
    assert capsys.readouterr().err == line


def test_exit_code_of_the_command_is_passed_on() -> None:
    assert run(lambda: 1) == 1
    assert run(lambda: None) == 0


@pytest.mark.skipif(os.name == "nt", reason="needs a POSIX pipe")
def test_a_reader_that_leaves_early_is_no_error() -> None:
    code = "import sys; from selfmotion.cli.running import run; sys.exit(run(lambda: print('x')))"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-c", code], stdout=write, stderr=subprocess.PIPE, check=False
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")
