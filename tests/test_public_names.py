import ast
import subprocess
import sys
from pathlib import Path

import pytest

import selfmotion

STUB = Path(selfmotion.__file__).with_suffix(".pyi")
IMPORTS = [n for n in ast.parse(STUB.read_text()).body if isinstance(n, ast.ImportFrom)]
NAMES = [(n.module, alias) for n in IMPORTS for alias in n.names]


@pytest.mark.parametrize(("module", "alias"), NAMES, ids=[alias.name for _, alias in NAMES])
def test_public_name_is_that_of_its_module(module: str, alias: ast.alias) -> None:
    # `import X as X` is how a stub says that a name is public.
    assert alias.asname == alias.name
    value = getattr(selfmotion, alias.name)
    namespace: dict[str, object] = {}
    exec(f"from {module} import {alias.name}", namespace)
    assert value is namespace[alias.name]


def test_public_names_are_unique_and_hide_no_module() -> None:
    names = [alias.name for _, alias in NAMES]
    assert len(set(names)) == len(names)
    modules = {path.stem for path in STUB.parent.iterdir() if not path.name.startswith("__")}
    assert not modules & set(names)


def test_star_import_gives_all_of_them() -> None:
    namespace: dict[str, object] = {}
    exec("from selfmotion import *", namespace)
    assert {alias.name for _, alias in NAMES} <= set(namespace) & set(dir(selfmotion))


def test_import_alone_loads_nothing_heavy() -> None:
    code = "import sys, selfmotion; assert 'numpy' not in sys.modules, 'numpy'"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(AttributeError, match="no attribute 'load_arms'; did you mean 'load_arm'?"):
        _ = selfmotion.load_arms  # type: ignore[attr-defined]
    assert not hasattr(selfmotion, "__wrapped__")
