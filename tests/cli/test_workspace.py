from pathlib import Path

import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.cli.app import main
from selfmotion.kinematics.forward import forward_kinematics
from tests.cli.running import Capture, answered, refused, written

QUICK = ("--points", "128", "--shifts", "2")
SPLINT = ("--limit", "elbow_flexion=64.2:114")
SUBJECT = """
name = "P1"
[lengths_mm]
clavicle = 180
upper_arm = 300
forearm = 250
palm = 80
[ranges]
elbow_flexion = [0, 140]
[impairments]
elbow_flexion = [60, 110]
"""


def test_the_free_workspace_holds_the_limited_one(capsys: Capture) -> None:
    found = answered(capsys, "workspace", *SPLINT, "--compare", *QUICK, "--slice", "0")
    volume = found["volume_m3"]
    assert 0 < volume["limited"] < volume["free"]
    assert volume["lost"] == pytest.approx(volume["free"] - volume["limited"])
    area = found["slices"][0]["area_m2"]
    assert found["slices"][0]["z"] == 0
    assert area["lost"] == pytest.approx(area["free"] - area["limited"])
    limits = dict(zip(found["joints"], found["limited_limits"], strict=True))
    assert np.degrees(limits["elbow_flexion"]) == pytest.approx([64.2, 114.0])


def test_without_compare_only_what_was_asked_for_is_known(capsys: Capture) -> None:
    free = answered(capsys, "workspace", *QUICK, "--slice", "0")
    assert free["volume_m3"]["limited"] is None
    assert free["limited_limits"] is None
    limited = answered(capsys, "workspace", *SPLINT, *QUICK, "--slice", "0")
    assert limited["volume_m3"]["free"] is None
    assert limited["volume_m3"]["limited"] < free["volume_m3"]["free"]


def test_places_are_told_without_compare_too(capsys: Capture) -> None:
    words = ("workspace", *SPLINT, *QUICK, "--slice", "0", "--details")
    places = answered(capsys, *words)["details"]["regions"]
    assert main([*map(str, words)]) == 0
    told = capsys.readouterr().out
    assert "nothing to reach" not in told
    for place in places:
        reached = place["volume_m3"]["limited"]
        line = next(t for t in told.splitlines() if t.startswith(f"{place['title']}: "))
        assert f": {1e3 * reached:.1f} litres" in line
        assert (place["space_m3"] is None) == line.endswith("litres")
    open_places = {p["name"] for p in places if p["space_m3"] is None}
    assert 0 < len(open_places) < len(places)


def test_a_person_has_lengths_ranges_and_impairments(tmp_path: Path, capsys: Capture) -> None:
    subject = written(tmp_path / "subject.toml", SUBJECT)
    found = answered(
        capsys, "workspace", "--subject", subject, "--compare", *QUICK, "--slice", "0",
        "--out", tmp_path / "out", "--report", tmp_path / "r.html",
    )  # fmt: skip
    i = found["joints"].index("elbow_flexion")
    assert np.degrees(found["free_limits"][i]) == pytest.approx([0, 140])
    assert np.degrees(found["limited_limits"][i]) == pytest.approx([60, 110])
    assert found["subject"] == "P1"
    assert found["hull_volume_m3"]["free"] < 4 / 3 * np.pi * (0.3 + 0.25 + 0.08 + 0.18) ** 3
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"workspace.json", "workspace.csv", "slices.csv", "subject.toml"}
    assert "Reach of P1" in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_recorded_positions_are_held_against_it(tmp_path: Path, capsys: Capture) -> None:
    arm = load_arm("upper_limb")
    q = arm.random_postures(20, np.random.default_rng(1))
    x = forward_kinematics(arm.chain, q, arm.tip("hand"))[:, :3, 3]
    x[-1] = [3.0, 0.0, 0.0]
    arrays = {"qd": np.zeros_like(q), "jacobian": np.zeros((20, 3, 9)), "x": x}
    np.savez(tmp_path / "r.npz", **arrays)
    found = answered(capsys, "workspace", *QUICK, "--slice", "0", "--recording", tmp_path / "r.npz")
    assert found["recording"]["points"] == 20
    assert found["recording"]["inside_percent"]["free"] == pytest.approx(95.0)
    assert found["recording"]["farthest_mm"]["free"] > 2000


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("name = 'a'\n[ranges\n", "line 2"),
        ("nam = 'a'\n", "unknown field 'nam'; did you mean 'name'?"),
        (SUBJECT.replace("= 180", "= -180"), "lengths_mm.clavicle = -180: allowed is 1 to 2000"),
        (SUBJECT.replace("palm = 80\n", ""), "lengths_mm: a table with clavicle"),
        (SUBJECT.replace("[0, 140]", "[140, 0]"), "ranges.elbow_flexion = [140, 0]: allowed is"),
        (SUBJECT.replace("[0, 140]", "[0, 400]"), "ranges.elbow_flexion = [0, 400]: allowed is"),
        (SUBJECT.replace("[0, 140]", "[nan, 90]"), "ranges.elbow_flexion = [nan, 90]"),
        (SUBJECT.replace("[0, 140]", "140"), "[low, high] in degrees is expected"),
        (SUBJECT.replace("elbow_flexion", "elbow_flex"), "elbow_flex"),
    ],
)
def test_a_bad_subject_is_one_line(tmp_path: Path, capsys: Capture, text: str, reason: str) -> None:
    subject = written(tmp_path / "subject.toml", text)
    line = refused(capsys, "workspace", "--subject", subject, *QUICK)
    assert reason in line
    assert str(subject) in line


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--compare",), "--compare: name the limits with --limit"),
        (("--limit", "elbow=1:2"), "elbow"),
        (("--limit", "elbow_flexion=114:64"), "the low bound 114 is above the high 64"),
        (("--limit", "elbow_flexion=0:400"), "allowed are angles from -360 to 360 degrees"),
        (("--limit", "elbow_flexion=-60:90", "--compare"), "elbow_flexion"),
        (("--points", "3"), "n_points = 3: allowed is 64"),
        (("--slice", "nan"), "not finite"),
        (("--jobs", "0"), "--jobs 0"),
    ],
)
def test_bad_options_are_one_line(capsys: Capture, options: tuple[str, ...], reason: str) -> None:
    words = options if "--points" in options else (*options, *QUICK)
    assert reason in refused(capsys, "workspace", *words)


def test_a_body_is_cut_out_and_named(capsys: Capture) -> None:
    free = answered(capsys, "workspace", *QUICK, "--slice", "-0.2")
    cut = answered(capsys, "workspace", *QUICK, "--slice", "-0.2", "--body", "seated")
    assert 0 < cut["volume_m3"]["free"] < free["volume_m3"]["free"]
    assert cut["slices"][0]["area_m2"]["free"] < free["slices"][0]["area_m2"]["free"]
    assert cut["provenance"]["choices"]["body"] == "seated"
    assert "body" not in free["provenance"]["choices"]
    assert "prone" in refused(capsys, "workspace", *QUICK, "--body", "prone")


def test_maps_are_computed_and_written(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "out"
    words = ("workspace", *QUICK, "--slice", "0", "--map", "margin, manipulability")
    words = (*words, "--map-step", "0.4", "--out", out)
    found = answered(capsys, *words, "--report", tmp_path / "r.html")["maps"]
    assert found["limits"] == "free" and found["failed"] == 0
    assert [m["name"] for m in found["maps"]] == ["margin", "manipulability"]
    assert 0 < found["reached"] < found["points"] == np.prod(found["shape"])
    assert 0 < found["maps"][0]["median"] < found["maps"][0]["best"] <= 1
    for name in ("maps.vtk", "maps.ply", "maps.csv"):
        assert (out / name).stat().st_size > 100
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "Maps over the space" in page and "Plotly.newPlot" in page
    again = answered(capsys, *words, "--resume")["maps"]
    assert again == found


def test_the_hand_is_held_on_a_plane(tmp_path: Path, capsys: Capture) -> None:
    held = answered(
        capsys, "workspace", *SPLINT, "--compare", *QUICK, "--slice", "0", "--hold",
        "x=0.15,rot_y=0", "--out", tmp_path,
    )["held"]  # fmt: skip
    free, limited = held
    assert (free["limits"], limited["limits"], free["unit"]) == ("free", "limited", "m²")
    assert 0 < limited["size"] <= limited["by_position"] < free["by_position"]
    assert free["held"] == {"x": 0.15, "rot_y": 0.0}
    assert (tmp_path / "held_limited.csv").exists()


def test_a_circle_is_followed(tmp_path: Path, capsys: Capture) -> None:
    circle = ("--circle", "yz:0.15,0.36,-0.16:0.27", "--hold", "rot_y=0")
    found = answered(
        capsys, "workspace", *SPLINT, *QUICK, "--slice", "0", *circle, "--out", tmp_path
    )
    (part,) = found["circles"]
    assert found["held"] == []
    assert part["limits"] == "limited" and 0 < part["share"] < 1
    arcs = sum(arc["last"] - arc["first"] for arc in part["arcs"])
    assert part["share"] == pytest.approx(arcs / (2 * np.pi))
    header = (tmp_path / "circle_limited.csv").read_text().splitlines()[0]
    assert header.startswith("arc,angle,x,y,z,scapula_protraction")


def test_positions_are_mapped_to_another_person(tmp_path: Path, capsys: Capture) -> None:
    other = written(tmp_path / "b.toml", 'name = "B"\n[impairments]\nelbow_flexion = [64.2, 114]\n')
    points = written(tmp_path / "p.csv", "x,y,z_mm\n0.2,0.4,-100\n0.1,0.5,0\n")
    found = answered(
        capsys, "workspace", *QUICK, "--slice", "0", "--map-to", other, "--map-points", points,
        "--out", tmp_path / "out",
    )["mapping"]  # fmt: skip
    assert found["to"] == "B" and len(found["points"]) == 2
    assert found["points"][0]["point"] == pytest.approx([0.2, 0.4, -0.1])
    assert found["volumes_m3"][1] < found["volumes_m3"][0]
    for row in found["points"]:
        away = [np.subtract(row[k], c) for k, c in zip(("point", "image"), found["centres"])]  # noqa: B905
        np.testing.assert_allclose(np.cross(*away), 0.0, atol=1e-9)  # the direction is kept
    assert (tmp_path / "out" / "mapped.csv").exists()


def test_recordings_are_compared_one_by_one(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "in").mkdir()
    for name, height in (("low", -0.3), ("high", 0.3)):
        written(
            tmp_path / "in" / f"{name}.csv",
            f"time,x,y,z\n0,0.2,0.4,{height}\n1,0.2,0.3,{height}\n",
        )
    found = answered(
        capsys, "workspace", *SPLINT, "--compare", *QUICK, "--slice", "0", "--recording",
        tmp_path / "in", "--report", tmp_path / "r.html", "--out", tmp_path / "out",
    )["recording"]  # fmt: skip
    rows = {(row["recording"], row["workspace"]): row for row in found["clouds"]}
    assert len(rows) == 4 and found["points"] == 4
    free = {name: row for (name, limits), row in rows.items() if limits == "free"}
    assert sorted(row["above_percent"] for row in free.values()) == [0.0, 100.0]
    assert all(row["inside_percent"] == 100.0 for row in free.values())
    assert "Recorded positions" in (tmp_path / "r.html").read_text(encoding="utf-8")
    assert (tmp_path / "out" / "recordings.csv").exists()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--map", "comfort"), "unknown map 'comfort'"),
        (("--map", "effort"), "upper_limb has no muscles; allowed is --arm myoarm"),
        (("--map", "margin", "--map-step", "0"), "spacing = 0: allowed is"),
        (("--map-step", "0.1"), "--map-step 0.1: name the maps with --map"),
        (("--resume", "--out", "x"), "--resume: only maps take so long"),
        (("--hold", "x=2"), "no posture of upper_limb has x = 2000 mm; allowed is about"),
        (("--hold", "y=0.5,z=0.5"), "y = 500 mm and z = 500 mm together"),
        (("--hold", "roll=2"), "unknown --hold row 'roll'"),
        (("--hold", "x"), "--hold 'x': write row=value"),
        (("--hold", "x=1,x=2"), "x stands twice"),
        (("--circle", "yz:1,2:3"), "write plane:x,y,z:radius"),
        (("--circle", "ab:0,0.3,0:0.2"), "plane = 'ab': allowed is yz, xz, xy"),
        (("--circle", "yz:0.15,3,0:0.2"), "all of it is out of reach"),
        (("--circle", "yz:0.15,0.3,0:0.2", "--hold", "x=0.1"), "--hold x with --circle"),
        (("--recording", "none.csv"), "none.csv: no such file"),
        (("--map-to", "none.toml", "--map-points", "p.csv"), "none.toml: no such file"),
        (("--map-to", "b.toml"), "--map-to b.toml: name the hand positions"),
        (("--map-points", "p.csv"), "--map-points p.csv: name the other person"),
    ],
)
def test_bad_extras_are_one_line(capsys: Capture, options: tuple[str, ...], reason: str) -> None:
    assert reason in refused(capsys, "workspace", *QUICK, "--slice", "0", *options)


def test_what_is_asked_in_vain_is_refused(tmp_path: Path, capsys: Capture) -> None:
    words = ("workspace", *QUICK, "--out", tmp_path / "out")
    assert "name them with --map" in refused(capsys, *words, "--scheduler", "tcp://no:1")
    assert "name the other person" in refused(capsys, *words, "--envelope", "unbroken")
    assert "a folder stands" in refused(capsys, *words, "--report", tmp_path)
    assert not (tmp_path / "out").exists()


def test_positions_in_millimetres_need_their_names(tmp_path: Path, capsys: Capture) -> None:
    metres = written(tmp_path / "a.csv", "x,y,z\n100,400,-100\n150,400,0\n")
    named = written(tmp_path / "b.csv", "x_mm,y_mm,z_mm\n100,400,-100\n150,400,0\n")
    other = written(tmp_path / "o.toml", "[impairments]\nelbow_flexion = [60, 100]\n")
    words = ("workspace", *QUICK, "--slice", "0")
    for more in (("--recording", metres), ("--map-to", other, "--map-points", metres)):
        assert "a hand position of 400 m; allowed" in refused(capsys, *words, *more)
    found = answered(capsys, *words, "--recording", named)["recording"]
    assert found["inside_percent"]["free"] == 100.0


def test_rows_with_gaps_keep_their_place_when_mapped(tmp_path: Path, capsys: Capture) -> None:
    points = written(tmp_path / "p.csv", "x,y,z\n0.1,0.4,-0.1\n0.2,,0\n0.2,0.4,0\n")
    other = written(tmp_path / "o.toml", "[impairments]\nelbow_flexion = [60, 100]\n")
    words = ("workspace", *QUICK, "--slice", "0", "--map-to", other, "--map-points", points)
    found = answered(capsys, *words, code=1)["mapping"]
    assert [row["share"] is None for row in found["points"]] == [False, True, False]
    assert found["points"][1]["image"] == [None] * 3
    assert "Rows with gaps: 1" in found["status"]


def test_the_arm_can_be_kept_out_of_the_body_too(capsys: Capture) -> None:
    words = ("workspace", *SPLINT, "--compare", *QUICK, "--slice", "2", "--arm-outside")
    assert "--arm-outside: name the body" in refused(capsys, *words)
    found = answered(capsys, *words, "--body", "seated", "--points", "64")
    taken = found["taken_off_percent"]
    assert 0 <= taken["limited"] < 20 and 0 <= taken["free"] < 20 and taken["lost"] is None
    volume = found["volume_m3"]
    assert volume["lost"] == pytest.approx(volume["free"] - volume["limited"])
    assert found["provenance"]["choices"]["arm_outside"] is True
