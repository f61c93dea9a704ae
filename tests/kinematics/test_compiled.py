"""The cache of compiled kernels: an edit in another file must not leave old code running."""

import os
import subprocess
import sys
from pathlib import Path

CALLEE = "from numba import njit\n@njit(cache=True)\ndef part(x):\n    return x + {}\n"
CALLER = """import callee
from selfmotion.kinematics.compiled import compiled
@compiled(callee)
def whole(x):
    return callee.part(x)
if __name__ == "__main__":
    print(whole(1))
"""


def run(folder: Path) -> str:
    words = [sys.executable, "-c", "import caller; print(caller.whole(1))"]
    beside = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    done = subprocess.run(words, cwd=folder, env=beside, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_an_edited_callee_is_noticed_and_the_code_is_kept_otherwise(tmp_path: Path) -> None:
    (tmp_path / "caller.py").write_text(CALLER)
    (tmp_path / "callee.py").write_text(CALLEE.format(1))
    assert run(tmp_path) == "2"
    kept = {p: p.stat().st_mtime_ns for p in (tmp_path / "__pycache__").glob("caller.whole*")}
    assert len(kept) == 2
    assert run(tmp_path) == "2"
    assert {p: p.stat().st_mtime_ns for p in kept} == kept
    (tmp_path / "callee.py").write_text(CALLEE.format(10))
    assert run(tmp_path) == "11"
