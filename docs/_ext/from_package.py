"""Write the command reference and the API pages from the package itself, before Sphinx reads.

The commands say their own help and the stub `selfmotion/__init__.pyi` groups the public names, so
neither can be forgotten when one is added.
"""

import ast
import importlib
import re
from pathlib import Path

from click.testing import CliRunner

import selfmotion
from selfmotion.cli.app import COMMANDS, load

WIDTH = 98


def setup(app):
    """Register with Sphinx."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir) / "_generated"))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(folder: Path) -> None:
    """Write commands.md and api.md into a folder."""
    folder.mkdir(exist_ok=True)
    _write(folder / "commands.md", _commands())
    _write(folder / "api.md", _api())


def _write(path: Path, text: str) -> None:
    # An unchanged page keeps its date, so that Sphinx does not read it again.
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def _commands() -> str:
    lines = [
        "# Commands\n",
        "Angles typed at the command line are degrees. Every command ends with 0 (done), 1 (some",
        "items failed; each says why) or 2 (bad input; one line says what). `--json` prints one",
        "document whose schema and an example lie in `docs/cli`.\n",
    ]
    for name, summary in COMMANDS.items():
        result = CliRunner().invoke(
            load(name), ["--help"], prog_name=f"selfmotion {name}", terminal_width=WIDTH
        )
        if result.exit_code:
            raise RuntimeError(f"selfmotion {name} --help: {result.output}")
        lines += [f"## {name}\n", f"{summary}\n", "```text", result.output.rstrip(), "```\n"]
    return "\n".join(lines)


def _api() -> str:
    stub = Path(selfmotion.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    lines = [
        "# Library reference\n",
        "Everything here is imported as `from selfmotion import NAME`. Lengths are metres, angles",
        "radians, times seconds; time is axis 0.\n",
    ]
    for heading, block in re.findall(r"^# -- (.+)\n((?:(?!# -- ).*\n?)*)", stub, re.MULTILINE):
        imports = [n for n in ast.parse(block).body if isinstance(n, ast.ImportFrom)]
        names = [(str(n.module), a.name) for n in imports for a in n.names]
        public = [(m, n) for m, n in names if not n.startswith("_")]
        if public:
            lines.append(f"## {heading[0].upper()}{heading[1:]}\n")
            lines += [_entry(module, name) for module, name in public]
    return "\n".join(lines)


def _entry(module: str, name: str) -> str:
    value = getattr(importlib.import_module(module), name)
    if isinstance(value, type):
        directive, options = "autoclass", ["   :members:"]
    elif callable(value):
        directive, options = "autofunction", []
    else:
        directive, options = "autodata", ["   :no-value:"]
    body = [f".. {directive}:: selfmotion.{name}", *options]
    return "\n".join(["```{eval-rst}", *body, "```\n"])
