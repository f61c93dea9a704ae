"""`selfmotion curvature`, on paths whose areas are known by hand, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest

from tests.cli.running import Capture, answered, refused, written

ROOT = Path(__file__).parents[2]
REACH = ROOT / "examples/reach.csv"


def half_circle(side: float, trial: int, scale: float = 1.0) -> dict[str, np.ndarray]:
    """Go north along half an ellipse to one side, from rest to rest; its area is π/8 at scale 1."""
    u = np.linspace(0.0, 1.0, 401)
    turn = np.pi * (10 * u**3 - 15 * u**4 + 6 * u**5)
    x = np.stack([side * scale * 0.5 * np.sin(turn), 0.5 * (1.0 - np.cos(turn))], axis=1)
    return {"x": x, "time": 0.5 * u, "trial": np.full(len(u), trial)}


def saved(path: Path, *parts: dict[str, np.ndarray], **more: object) -> Path:
    joined = {k: np.concatenate([p[k] for p in parts]) for k in parts[0]}
    np.savez(path, **joined, **more)  # type: ignore[arg-type]
    return path


def chord_area(side: float, scale: float) -> float:
    """Area between half an ellipse and its chord where speed falls below a fifth of its peak."""
    part = half_circle(side, 1, scale)
    speed = np.linalg.norm(np.gradient(part["x"], part["time"], axis=0), axis=1)
    fast = np.flatnonzero(speed >= 0.2 * speed.max())
    p = part["x"][fast[0] - 1 : fast[-1] + 2]
    x, y = p.T
    # Shoelace over the closed polygon: an oracle that knows nothing of lines and strips.
    area = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return abs(float(area)) / float(np.sum((p[-1] - p[0]) ** 2))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_areas_are_those_of_the_polygon(side: float, tmp_path: Path, capsys: Capture) -> None:
    file = saved(tmp_path / "p.npz", half_circle(side, 1))
    (movement,) = answered(capsys, "curvature", file)["movements"]
    assert movement["a_sum"] == pytest.approx(chord_area(side, 1.0), rel=1e-6)
    assert movement["a_net"] == pytest.approx(side * movement["a_sum"], rel=1e-9)


def test_a_path_in_space_seen_from_above_is_that_in_the_plane(
    tmp_path: Path, capsys: Capture
) -> None:
    part = half_circle(1.0, 1)
    flat = saved(tmp_path / "flat.npz", part)
    part["x"] = np.column_stack([part["x"], 0.0 * part["time"]])
    space = saved(tmp_path / "space.npz", part)
    areas = [answered(capsys, "curvature", flat)["movements"][0]["a_net"]]
    areas += [
        answered(capsys, "curvature", space, "--up", up)["movements"][0]["a_net"]
        for up in ("z", "-z")
    ]
    assert areas[1] == pytest.approx(areas[0]) and areas[2] == pytest.approx(-areas[0])


def test_tests_by_direction(tmp_path: Path, capsys: Capture) -> None:
    parts = [half_circle(1.0, i, s) for i, s in enumerate((0.5, 0.6, 0.7, 0.55))]
    file = saved(tmp_path / "p.npz", *parts)
    document = answered(capsys, "curvature", file, "--out", tmp_path / "out")
    assert not any(m["stands_apart"] for m in document["movements"])
    net, total = document["tests"]
    values = [m["a_net"] for m in document["movements"]]
    assert net["n"] == 4 and net["mean"] == pytest.approx(np.mean(values)) and net["differs"]
    assert net["t"] == pytest.approx(np.mean(values) / (np.std(values, ddof=1) / 2.0))
    assert "nothing" in total["note"] and net["note"] == ""
    assert len((tmp_path / "out/curvature.csv").read_text().splitlines()) == 5


def test_center_out_takes_the_line_between_targets(tmp_path: Path, capsys: Capture) -> None:
    part = half_circle(1.0, 1)
    part["x"] = part["x"] * np.pi / 12  # to the target in the north, whose distance is 15 degrees
    file = saved(tmp_path / "p.npz", part, target="N", condition="outbound")
    words = ("curvature", file, "--line", "center-out")
    (movement,) = answered(capsys, *words)["movements"]
    # Onset and offset lie on the ellipse, just off the ends of the line.
    assert movement["a_right"] == pytest.approx(np.pi / 8, rel=0.05) and movement["a_left"] == 0.0


def test_one_that_does_not_move_has_a_status_and_the_rest_goes_on(
    tmp_path: Path, capsys: Capture
) -> None:
    still = half_circle(1.0, 2)
    still["x"] = np.zeros_like(still["x"])
    file = saved(tmp_path / "p.npz", half_circle(1.0, 1), still)
    document = answered(capsys, "curvature", file, code=1)
    assert [m["failed"] for m in document["movements"]] == [False, True]
    assert document["movements"][1]["a_sum"] is None
    assert "nothing moves" in document["movements"][1]["status"]
    assert [t["n"] for t in document["tests"]] == [1, 1]


def test_angles_without_an_arm_are_refused(capsys: Capture) -> None:
    assert "no path x; name the arm" in refused(capsys, "curvature", REACH)


def test_a_task_without_an_arm_is_refused(tmp_path: Path, capsys: Capture) -> None:
    file = saved(tmp_path / "p.npz", half_circle(1.0, 1))
    assert "--arm" in refused(capsys, "curvature", file, "--task", "position")


def test_an_axis_that_is_none_is_refused(capsys: Capture) -> None:
    assert "--up" in refused(capsys, "curvature", REACH, "--up", "north")


def test_up_that_nobody_says_fails_by_name(tmp_path: Path, capsys: Capture) -> None:
    part = half_circle(1.0, 1)
    part["x"] = np.column_stack([part["x"], part["time"]])
    file = saved(tmp_path / "p.npz", part)
    (movement,) = answered(capsys, "curvature", file, code=1)["movements"]
    assert "--up z" in movement["status"] and str(file) in movement["status"]


def test_labels_that_center_out_does_not_know_fail_by_name(tmp_path: Path, capsys: Capture) -> None:
    file = saved(tmp_path / "p.npz", half_circle(1.0, 1), target="up")
    words = ("curvature", file, "--line", "center-out")
    (movement,) = answered(capsys, *words, code=1)["movements"]
    assert "target 'up'" in movement["status"] and "outbound" in movement["status"]


def test_a_bad_cell_is_refused_with_its_row(tmp_path: Path, capsys: Capture) -> None:
    file = written(tmp_path / "bad.csv", "time,elbow,hand_x,hand_y\n0,0,0,0\n0.1,0,x,0\n")
    line = refused(capsys, "curvature", file)
    assert "bad.csv" in line and "'x'" in line


def test_a_csv_with_the_hand_needs_no_arm(tmp_path: Path, capsys: Capture) -> None:
    part = half_circle(1.0, 1)
    rows = [
        f"{t!r},0.0,{x!r},{y!r}"
        for t, (x, y) in zip(part["time"].tolist(), part["x"].tolist(), strict=True)
    ]
    file = written(tmp_path / "hand.csv", "\n".join(["time,elbow,hand_x,hand_y", *rows]) + "\n")
    (movement,) = answered(capsys, "curvature", file)["movements"]
    assert movement["a_net"] == pytest.approx(chord_area(1.0, 1.0), rel=1e-6)


def center_out(nets: dict[tuple[str, int], float]) -> list[dict[str, np.ndarray]]:
    """Go north along half ellipses and back; `nets` says to which side and how far, by trial."""
    parts = []
    for (way, trial), side in nets.items():
        part = half_circle(1.0, trial, side)
        if way == "inbound":
            part["x"] = (np.array([0.0, 1.0]) - part["x"]) * [1.0, 1.0]
        part |= {"condition": np.full(len(part["x"]), way), "target": np.full(len(part["x"]), "N")}
        parts.append(part)
    return parts


def test_hysteresis_is_tested_over_the_pairs_of_a_target(tmp_path: Path, capsys: Capture) -> None:
    """Way out and back to the same side: the loop is as wide as both together."""
    nets = {("outbound", i): 0.5 + 0.01 * i for i in range(1, 5)}
    nets |= {("inbound", i): 0.5 - 0.02 * i for i in range(1, 5)}
    file = saved(tmp_path / "p.npz", *center_out(nets))
    document = answered(capsys, "curvature", file)
    net = {(m["condition"], m["trial"]): m["a_net"] for m in document["movements"]}
    wanted = [net["outbound", str(i)] + net["inbound", str(i)] for i in range(1, 5)]
    assert [loop["hysteresis"] for loop in document["hysteresis"]] == pytest.approx(wanted)
    (test,) = (t for t in document["tests"] if t["measure"] == "hysteresis")
    assert test["n"] == 4 and test["mean"] == pytest.approx(np.mean(wanted)) and test["differs"]
    t = np.mean(wanted) / (np.std(wanted, ddof=1) / 2.0)
    assert test["t"] == pytest.approx(t) and (test["target"], test["condition"]) == ("N", None)
    assert answered(capsys, "curvature", file, "--pair", "there,back")["hysteresis"] == []
    assert "two conditions" in refused(capsys, "curvature", file, "--pair", "there")


def test_back_on_the_way_out_has_no_hysteresis(tmp_path: Path, capsys: Capture) -> None:
    """To the right on the way out and to the left, seen on the way back, is the same path."""
    parts = center_out({("outbound", 1): 0.5, ("inbound", 1): -0.5})
    (loop,) = answered(capsys, "curvature", saved(tmp_path / "p.npz", *parts))["hysteresis"]
    assert loop["hysteresis"] == pytest.approx(0.0, abs=1e-9)


def test_a_run_goes_on_where_it_was_and_several_processes_find_the_same(
    tmp_path: Path, capsys: Capture
) -> None:
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    for i, side in enumerate((1.0, -1.0)):
        saved(folder / f"{i}.npz", half_circle(side, i))
    bad = written(folder / "bad.csv", "time,elbow\n0,x\n")
    words = ("curvature", folder)
    report = tmp_path / "r.html"
    first = answered(capsys, *words, "--out", out, "--report", report, code=1)
    assert "bad.csv: not read" in report.read_text(encoding="utf-8")
    assert [entry["file"] for entry in first["unread"]] == [str(bad)]
    journal = (out / "curvature.journal.jsonl").read_text()
    again = answered(capsys, *words, "--out", out, "--resume", "--jobs", 2, "--quiet", code=1)
    assert again == first
    # Only the file that could not be read is tried again.
    more = (out / "curvature.journal.jsonl").read_text().removeprefix(journal)
    assert [str(bad) in line for line in more.split("\n") if line] == [True]


def test_the_report_shows_paths_and_loops(tmp_path: Path, capsys: Capture) -> None:
    nets = {(way, i): 0.5 + 0.01 * i for way in ("outbound", "inbound") for i in range(3)}
    still = half_circle(1.0, 9)
    still |= {"x": 0.0 * still["x"], "condition": np.full(401, "outbound")}
    still |= {"target": np.full(401, "N")}
    file = saved(tmp_path / "p.npz", *center_out(nets), still)
    report = tmp_path / "r.html"
    answered(capsys, "curvature", file, "--report", report, code=1)
    page = report.read_text(encoding="utf-8")
    assert all(word in page for word in ("Hysteresis", "A_net", "nothing moves", "Tommasino"))
    assert page.count("<svg") == 3


def test_angles_of_a_mot_go_through_the_arm_and_labels_through_the_file_name(
    tmp_path: Path, capsys: Capture
) -> None:
    from selfmotion.motion.files import load
    from selfmotion.motion.files.storage import write_mot

    for recording in load(REACH):
        labels = recording.labels
        write_mot(tmp_path / f"{labels.subject}_{labels.target}_{labels.trial}.mot", recording)
    study = r"pattern = '(?P<subject>[^_]+)_(?P<target>[^_]+)_(?P<trial>\d+)\.mot'"
    words = ("curvature", tmp_path, "--study", written(tmp_path / "study.toml", study))
    found = answered(capsys, *words, "--arm", "exoskeleton")["movements"]
    wanted = answered(capsys, "curvature", REACH, "--arm", "exoskeleton")["movements"]
    assert {(m["target"], m["trial"]): m["a_net"] for m in found} == pytest.approx(
        {(m["target"], m["trial"]): m["a_net"] for m in wanted}
    )
