"""Kinematic redundancy of the human arm.

The public names, grouped by job, stand in ``__init__.pyi``: one line there adds a name, for this
module as for type checkers. Each is imported when it is first used, so that `import selfmotion`
costs nothing.

>>> import selfmotion
>>> selfmotion.load_arm("wrist").joints
('pronation', 'flexion', 'deviation')
"""

from typing import Any

from selfmotion._version import __version__ as __version__


def _modules_of_names() -> dict[str, str]:
    """Read from the stub which module each public name comes from."""
    import ast
    from pathlib import Path

    stub = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    imports = (node for node in ast.parse(stub).body if isinstance(node, ast.ImportFrom))
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name.startswith("__") and name != "__all__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    modules = _modules_of_names()
    if name == "__all__":
        return sorted(modules)
    if name not in modules:
        from difflib import get_close_matches

        near = get_close_matches(name, modules, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{hint}")
    from importlib import import_module

    value = getattr(import_module(modules[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, whether or not they have been used."""
    return sorted({*globals(), *_modules_of_names()})
