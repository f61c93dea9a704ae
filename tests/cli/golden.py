"""The files that docs/cli promises: a JSON Schema and one example for each command.

`python -m tests.cli.golden` (`make golden`) writes them anew, from the types and the commands.
"""

import importlib
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

from selfmotion.cli.app import COMMANDS
from selfmotion.cli.output import Contract, schema
from selfmotion.writing import write_whole

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "cli"

# Keys whose values differ from run to run or from release to release.
VOLATILE = frozenset({"version", "software", "seconds"})
RELATIVE, ABSOLUTE = 1e-5, 1e-8


# Documents beside that of the command itself, and the modules that hold their contracts.
BESIDE = {"weights-study": "study_weights"}
DOCUMENTS = (*COMMANDS, *BESIDE)


def contract(name: str) -> Contract:
    return importlib.import_module(f"selfmotion.cli.{BESIDE.get(name, name)}").CONTRACT


def schema_file(name: str) -> Path:
    return FOLDER / f"{name}.schema.json"


def example_file(name: str) -> Path:
    return FOLDER / f"{name}.example.json"


def difference(found: Any, wanted: Any, where: str = "$") -> str | None:
    """Say where two documents differ; numbers may differ by rounding."""
    if isinstance(wanted, dict) and isinstance(found, dict):
        if found.keys() != wanted.keys():
            return f"{where}: keys {sorted(found)} instead of {sorted(wanted)}"
        steps = [(f"{where}.{k}", k) for k in wanted if k not in VOLATILE]
    elif isinstance(wanted, list) and isinstance(found, list):
        if len(found) != len(wanted):
            return f"{where}: {len(found)} items instead of {len(wanted)}"
        steps = [(f"{where}[{i}]", i) for i in range(len(wanted))]
    elif isinstance(wanted, float) and isinstance(found, float):
        close = math.isclose(found, wanted, rel_tol=RELATIVE, abs_tol=ABSOLUTE)
        return None if close else f"{where}: {found} instead of {wanted}"
    else:
        return None if found == wanted else f"{where}: {found!r} instead of {wanted!r}"
    return next((d for at, k in steps if (d := difference(found[k], wanted[k], at))), None)


def regenerate(name: str) -> None:
    write_whole(schema_file(name), schema(contract(name).document))
    command = [sys.executable, "-m", "selfmotion", *contract(name).example]
    done = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE)
    text = json.dumps(json.loads(done.stdout), indent=2, ensure_ascii=False)
    write_whole(example_file(name), text + "\n")


if __name__ == "__main__":
    for command_name in sys.argv[1:] or DOCUMENTS:
        regenerate(command_name)
