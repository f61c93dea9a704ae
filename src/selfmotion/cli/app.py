"""The commands by name, each loaded when it is called.

`selfmotion --help` imports no command: the summaries stand here, and a test holds them against
the first lines of the commands' docstrings.
"""

import importlib
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from selfmotion._version import __version__
from selfmotion.cli.progress import compilation_note
from selfmotion.cli.running import run
from selfmotion.errors import unknown_name

# name: what it does, in one line. The module selfmotion.cli.NAME holds a function NAME.
COMMANDS = {
    "demo": "Run the main job on generated people and write a report.",
    "validate": "Say what files hold: their units, frame and gaps.",
    "arms": "List the arms with their joints, limits and sources.",
    "weights": "Identify how costly each joint is, from recorded motion.",
    "angles": "Find joint angles from markers: clusters, joint centres, inverse kinematics.",
    "segment": "Find where movements begin and end, and their strokes.",
    "split": "Part joint velocity into what moves the hand and what does not.",
    "posture": "Find the natural posture for hand poses, by least muscle effort.",
    "effort": "Compute the muscle effort that holds postures, or makes a movement.",
    "curvature": "Measure how far paths veer from straight lines, and to which side.",
    "ik": "Find postures inside the joint limits that bring the hand to targets.",
    "workspace": "Find where the hand can reach, and what limits take away.",
    "donders": "Fit the elasticity of a person's joints to postures.",
    "plan": "Plan how a person moves to targets, by passive motion.",
    "person": "Run all four methods on one person's recordings, and what follows.",
    "view": "Open the studio: drag the hand, set joint ranges, play a recording.",
    "predict": "Hold laws of natural posture against recorded people.",
    "reproduce": "Compute a paper's numbers again and print them beside ours.",
    "cite": "Print how to cite the papers behind the results.",
}


class LazyGroup(TyperGroup):
    """A group that knows its commands by name and imports one when it is called.

    Its parameters are typer's own copies of click's classes, which have no public names there.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """Give the names in the order of the table."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Load a command.

        Raises:
            UnknownNameError: there is none of that name.
        """
        if cmd_name not in COMMANDS:
            raise unknown_name("command", cmd_name, list(COMMANDS))
        return load(cmd_name)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the table into the help."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


def load(name: str) -> Any:
    """Import one command and build its parser."""
    module = importlib.import_module(f"selfmotion.cli.{name}")
    single = typer.Typer(add_completion=False, rich_markup_mode=None)
    words = [word for word in module.CONTRACT.example if word not in ("--json", "--quiet")]
    single.command(name, epilog=f"Example: selfmotion {' '.join(words)}")(getattr(module, name))
    command: Any = typer.main.get_command(single)
    for parameter in command.params:
        if parameter.param_type_name == "argument":
            # typer writes the Python type after the name, which tells a person nothing.
            parameter.display_type_rich = lambda ctx: ""
    return command


def _print_version(wanted: bool) -> bool:
    if wanted:
        print(f"selfmotion {__version__}")
        raise typer.Exit
    return wanted


app = typer.Typer(cls=LazyGroup, add_completion=False, rich_markup_mode=None)


@app.callback()
def selfmotion(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Say which version."
        ),
    ] = False,
) -> None:
    """Kinematic redundancy of the human arm.

    Which joints a person prefers, how they will move to a target, where a patient can reach, and
    what posture a person would take. `selfmotion COMMAND --help` tells more about each.
    Angles typed here are degrees. Exit codes: 0 done, 1 some items failed, 2 bad input.
    """


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and give the exit code.

    Args:
        arguments: without the program's name; left out: those of the process. None at all: help.
    """
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]

    def call() -> Any:
        command = typer.main.get_command(app)
        with (
            compilation_note(quiet="--quiet" in words),
            command.make_context("selfmotion", words) as context,
        ):
            return command.invoke(context)

    return run(call)
