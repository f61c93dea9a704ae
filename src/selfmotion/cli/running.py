"""Run a command: exceptions become one line on stderr and an exit code."""

import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

import typer

from selfmotion.errors import SelfmotionError

DONE, SOME_FAILED, BAD_INPUT, DEFECT = 0, 1, 2, 70
DEBUG = "SELFMOTION_DEBUG"

# typer carries its own copy of click, whose base exception has no public name there.
_UsageError = next(c for c in typer.BadParameter.__mro__ if c.__name__ == "ClickException")


def run(call: Callable[[], Any]) -> int:
    """Call a command and give the exit code of the process.

    Bad input (a `SelfmotionError`, a file that cannot be read or written, an option that does not
    exist) is one line on stderr and 2. What the library did not foresee is one line and 70; the
    environment variable SELFMOTION_DEBUG=1 adds the traceback to either.

    Args:
        call: gives the exit code, or None for 0.
    """
    try:
        with _warnings_as_lines():
            code = call()
        sys.stdout.flush()
    except typer.Exit as leaving:
        return leaving.exit_code
    except BrokenPipeError:
        # The reader (`| head`) has seen enough; Python must not complain when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except (Exception, KeyboardInterrupt) as error:
        code, sentence = explain(error)
        if os.environ.get(DEBUG, "") not in ("", "0"):
            import traceback

            traceback.print_exc()
        say(sentence)
        return code
    return DONE if code is None else int(code)


def explain(error: BaseException) -> tuple[int, str]:
    """Give the exit code for an exception, and the sentence that tells a person about it."""
    if isinstance(error, SelfmotionError):
        return BAD_INPUT, str(error)
    if isinstance(error, KeyboardInterrupt):
        return BAD_INPUT, "interrupted"
    if isinstance(error, OSError):
        return BAD_INPUT, _file_trouble(error)
    if isinstance(error, _UsageError):
        return BAD_INPUT, _usage_trouble(error)
    if isinstance(error, MemoryError):
        return BAD_INPUT, f"the memory of this machine does not suffice ({error})"
    name = type(error).__name__
    return DEFECT, f"internal error: {name}: {error} ({DEBUG}=1 shows where; please report it)"


def say(sentence: str) -> None:
    """Write one line to stderr, whatever line breaks the sentence has."""
    print("selfmotion:", " ".join(sentence.split()), file=sys.stderr)


def _file_trouble(error: OSError) -> str:
    if error.filename is None or error.strerror is None:
        return str(error) or type(error).__name__
    reason = error.strerror[:1].lower() + error.strerror[1:]
    if isinstance(error, FileExistsError | NotADirectoryError):
        reason = "a file stands where a folder should be"
    return f"{error.filename}: {reason}"


def _usage_trouble(error: Any) -> str:
    message = error.format_message().rstrip(".").replace("Value error, ", "")
    # typer leaves the checking to pydantic, whose sentences do not name what was typed.
    given = getattr(error.__cause__, "errors", list)()
    if given and "input" in given[0]:
        message = message.replace("Input should", f"{given[0]['input']!r} should")
    context = getattr(error, "ctx", None)
    path = context.command_path if context else "selfmotion"
    return f"{message} (`{path} --help` lists what is allowed)"


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Show each warning as one line, when the command is done.

    A command that refuses its input says one line only, so its warnings are not shown. Warnings
    meant for developers stay as Python has them.
    """
    held: list[str] = []

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        held.append(f"warning: {message}")

    with warnings.catch_warnings():
        warnings.filterwarnings("always", category=UserWarning)
        warnings.showwarning = show
        yield
    for sentence in dict.fromkeys(held):
        say(sentence)
