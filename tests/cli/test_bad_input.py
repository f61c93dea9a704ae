"""What people mistype, over all commands: one line that names it, exit code 2, no traceback."""

from pathlib import Path

import pytest

from tests.cli.golden import ROOT
from tests.cli.running import Capture, refused

EXAMPLES = ROOT / "examples"
REACH = f"{EXAMPLES}/reach.csv --arm exoskeleton"
MARKERS = f"{EXAMPLES}/markers_drink.csv --static {EXAMPLES}/markers_static.csv"
TARGETS = f"{EXAMPLES}/targets.csv"
PEOPLE = f"{EXAMPLES}/people --study {EXAMPLES}/people/study.toml"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "folder").mkdir()
    for name, text in {
        "empty.csv": "",
        "header.csv": "time,elbow_flexion\n",
        "nan.csv": "x,y,z\n0.3,0.3,nan\n",
        "word.csv": "x,y,z\n0.3,abc,0.1\n",
        "other.csv": "a,b\n1,2\n",
        "broken.toml": "x = [",
        "law.toml": "stiffness = [1, 2]\n",
        "bytes.npz": "no archive",
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        # Files and folders.
        ("weights nothere.csv --arm exoskeleton", "nothere.csv: no such file"),
        ("weights folder --arm exoskeleton", "folder: no recording in this folder"),
        ("weights empty.csv --arm exoskeleton", "empty.csv: 0 line(s)"),
        ("weights header.csv --arm exoskeleton", "header.csv: 1 line(s)"),
        ("weights bytes.npz", "bytes.npz: not an .npz archive"),
        (f"split {REACH} --weights nothere.json", "nothere.json: no such file"),
        (f"angles {MARKERS.split()[0]} --static nothere.csv", "nothere.csv: no such file"),
        (f"angles {REACH.split()[0]} --static {MARKERS.split()[-1]}", "no marker trajectories"),
        ("segment empty.csv", "empty.csv: 0 line(s)"),
        ("curvature other.csv", "other.csv: no column time"),
        ("ik nan.csv", "row 2, column z: 'nan' is no finite number"),
        ("ik word.csv", "row 2, column y: 'abc' is no number"),
        ("ik other.csv", "no column x, y, z (there are: a, b)"),
        (f"ik {TARGETS} --out {TARGETS}", "a file stands where a folder should be"),
        ("workspace --subject broken.toml", "broken.toml: no TOML"),
        ("donders other.csv --arm wrist", "other.csv: 0 forms of posture"),
        ("plan --arm wrist --center-out --law law.toml", "law.toml: needs stiffness"),
        ("posture other.csv", "no column qx, qy, qz, qw, x, y, z"),
        ("effort other.csv", "unknown column in other.csv: 'a'"),
        ("validate folder", "folder: no file in this folder"),
        ("predict folder --study broken.toml", "broken.toml: no TOML"),
        (f"person folder --study {PEOPLE.split()[-1]}", "folder: no file is named as the pattern"),
        (f"person {PEOPLE} --subject P1 --out empty.csv", "a file stands where a folder should be"),
        (f"demo --out {TARGETS}", "a file stands where a folder should be"),
        ("view nothere.csv", "nothere.csv: no such file"),
        # Names and values of options.
        (f"weights {REACH}ton", "did you mean 'exoskeleton'?"),
        (f"weights {REACH} --method mll", "'mll' is not one of 'ml', 'paper', 'feedback'"),
        (f"weights {REACH} --null-ratio 1.5 --method paper", "null_ratio = 1.5"),
        (f"split {REACH} --weights 1,2", "2 numbers for 4 joints"),
        (f"angles {MARKERS} --side rigth", "'rigth' is not one of 'right', 'left'"),
        (f"ik {TARGETS} --task pos", "did you mean 'pose'?"),
        (f"ik {TARGETS} --limit elbow=0:90", "unknown joint 'elbow'"),
        (f"ik {TARGETS} --limit elbow_flexion=90", "write joint=low:high in degrees"),
        (f"ik {TARGETS} --jobs 0", "--jobs 0: allowed is 1 and above"),
        (f"ik {TARGETS} --resume", "--resume: name the folder"),
        ("workspace --limit elbow_flexion=114:64", "low bound 114 is above the high 64"),
        ("workspace --points 0", "n_points = 0"),
        ("plan --arm wrist", "give either --targets FILE or --center-out"),
        ("plan --arm wrist --center-out --duration nan", "duration = nan s"),
        ("plan --arm wrist --center-out --spring stiff", "--spring 'stiff'"),
        (f"person {PEOPLE} --side rigth", "'rigth' is not one of 'right', 'left'"),
        (f"person {PEOPLE} --subject P1 --jobs 0", "--jobs 0: allowed is 1 and above"),
        (f"predict {PEOPLE} --resume", "--resume: name the folder"),
        ("reproduce khoramshahi", "did you mean 'khoramshahi2022'?"),
        ("cite nobody", "unknown paper 'nobody'"),
        ("arms nope", "unknown arm 'nope'"),
        ("demo --seed x", "'x' should be a valid integer"),
        ("demo --seed -1", "'-1' should be greater than or equal to 0"),
        ("view --port 99999999", "--port 99999999: allowed is 1 to 65535"),
    ],
)
def test_one_line_says_what_is_wrong(capsys: Capture, typed: str, told: str) -> None:
    assert told in refused(capsys, *typed.split())
