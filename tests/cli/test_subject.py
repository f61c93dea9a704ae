"""A person's file: what it makes, what it refuses, and that what is written can be read again."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from selfmotion.cli.subject import Subject, read_subject, subject_schema
from selfmotion.cli.subject_arms import PersonArms, Typed, person_arms
from selfmotion.cli.subject_toml import subject_toml
from selfmotion.errors import SelfmotionError
from selfmotion.kinematics.body_frame import BodyFrame
from selfmotion.kinematics.solid_shapes import Box
from selfmotion.motion.files.storage import write_mot
from selfmotion.motion.recording import Recording
from tests.cli.golden import ROOT
from tests.cli.running import Capture, answered, refused, written

EXAMPLE = ROOT / "examples" / "subject.toml"
ENDS = "start_cm = [0, 0, 0]\nend_cm = [0, 0, 1]\n"
QUICK = ("--points", "64", "--shifts", "2", "--slice", "0")


def made(path: Path | None, **typed: object) -> PersonArms:
    subject = Subject() if path is None else read_subject(path)
    return person_arms(subject, path, Typed("upper_limb", **typed))  # pyright: ignore


def refusal(path: Path) -> str:
    with pytest.raises(SelfmotionError) as caught:
        made(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_schema_is_that_of_the_types() -> None:
    file = ROOT / "docs" / "subject.schema.json"
    assert file.read_bytes() == subject_schema(), "write it anew: subject_schema()"
    assert "null]" not in subject_schema().decode().replace(" ", "")


def test_the_example_is_a_person() -> None:
    person = made(EXAMPLE)
    free, limited = person.free, person.limited
    assert limited is not None
    elbow = free.chain.index("elbow_flexion")
    assert np.degrees([free.lower[elbow], free.upper[elbow]]) == pytest.approx([0, 150])
    assert np.degrees([limited.lower[elbow], limited.upper[elbow]]) == pytest.approx([40, 125])
    assert free.lengths["forearm"] == pytest.approx(0.255)
    assert person.body is not None
    rest = person.body.shapes["armrest"]
    assert isinstance(rest, Box)
    at = BodyFrame.of(free, 1.75).coordinates(rest.centre[None])[0]
    assert 100 * at == pytest.approx([30, 20, -38])
    assert person.regions[-1].up == pytest.approx((25 / 175, 40 / 175))


def test_what_is_written_makes_the_same_person(tmp_path: Path) -> None:
    for side in ("right", "left"):
        person = made(EXAMPLE, side=side)
        again = made(written(tmp_path / "s.toml", subject_toml(person)))
        assert again.limited is not None and person.limited is not None
        for one, other in ((person.free, again.free), (person.limited, again.limited)):
            assert one.name == other.name
            np.testing.assert_allclose(one.lower, other.lower, atol=1e-6)
            np.testing.assert_allclose(one.upper, other.upper, atol=1e-6)
            np.testing.assert_allclose(one.chain.offsets, other.chain.offsets, atol=1e-6)
        assert person.body is not None and again.body is not None
        points = np.random.default_rng(1).uniform(-1, 1, (200, 3))
        apart = person.body.distance(points) - again.body.distance(points)
        assert np.abs(apart).max() < 1e-5
        assert [r.name for r in person.regions] == [r.name for r in again.regions]


def test_odd_persons_are_written_so_that_they_come_back(tmp_path: Path) -> None:
    text = (
        "name = \"Zoë \\U0001F600 \\\"x\\\"\"\n[body]\nposture = 'seated'\nwithout = ['pelvis']\n"
        "[regions.'my place']\nup_cm = [0, 10]\n"
    )
    person = made(written(tmp_path / "s.toml", text))
    again = made(written(tmp_path / "t.toml", subject_toml(person)))
    assert person.name == again.name == 'Zoë \U0001f600 "x"'
    assert person.body is not None and again.body is not None
    assert list(person.body.shapes) == list(again.body.shapes)
    assert "pelvis" not in again.body.shapes
    assert again.regions[-1].name == "my place"


def test_shapes_stand_without_a_body_too(tmp_path: Path) -> None:
    text = "[body]\nposture = 'none'\n[body.shapes.rest]\nkind = 'capsule'\nradius_cm = 5\n" + ENDS
    person = made(written(tmp_path / "s.toml", text))
    assert person.body is not None and list(person.body.shapes) == ["rest"]
    assert made(tmp_path / "s.toml", body="none").body is None


def test_the_left_arm_is_the_mirror_image_of_the_right() -> None:
    right, left = made(EXAMPLE), made(EXAMPLE, side="left")
    assert left.free.name.endswith("(mirrored)")
    assert left.body is not None and right.body is not None
    points = np.random.default_rng(2).uniform(-1, 1, (100, 3))
    # The armrest stands outwards of either arm.
    apart = left.body.distance(points * [-1, 1, 1]) - right.body.distance(points)
    assert np.abs(apart).max() < 1e-12


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("name = 'a'\n\n[ranges\n", 3, "no TOML"),
        ("name = 'a'\nsid = 'left'\n", 2, "unknown field 'sid'; did you mean 'side'?"),
        ("side = 'lefd'\n", 1, "side = 'lefd': allowed is right, left"),
        ("[body]\npostur = 'seated'\n", 2, "unknown field 'postur' of body; did you mean"),
        ("[body]\nposture = 'prone'\n", 2, "body.posture = 'prone'"),
        ("[body]\nstature_cm = 1.75\n", 2, "body.stature_cm = 1.75"),
        ("[body.shapes.a]\nkind = 'bxo'\n", 1, "unknown kind 'bxo'; did you mean 'box'?"),
        ("[body.shapes.a]\nkind = 'box'\nhalf_cm = [1, 1, 1]\n", 1, "centre_cm"),
        ("[regions.a]\nway = 'ovr'\n", 2, "regions.a.way = 'ovr'"),
        ("[regions.a]\nup_cm = [1, 2, 3]\n", 2, "regions.a.up_cm"),
        ("x = 1\n[ranges]\n", 1, "unknown field 'x'"),
        ("[ranges]\n# first\nelbow_flexion = [nan, 3]\n", 3, "ranges.elbow_flexion = [nan, 3]"),
        ("[ranges]\nelbow_flexion = [10, -10]\n", 2, "allowed is low up to high"),
        ("[ranges]\nelbow_flexion = [-10, 361]\n", 2, "from -360 to 360"),
        ("[lengths_mm]\nclavicle = -1\nupper_arm = 1\nforearm = 1\npalm = 1\n", 2, "clavicle = -1"),
        ("[lengths_mm]\nclavicle = nan\nupper_arm = 1\nforearm = 1\npalm = 1\n", 2, "= nan: allow"),
        ("name = 3\n", 1, "name = 3: Expected str"),
        (
            "[lengths_mm]\nclavicle = 0.2\nupper_arm = 1\nforearm = 1\npalm = 1\n",
            2,
            "allowed is 1 to 2000 mm",
        ),
        ("name = 'a'\n[impairments]\nelbow = [0, 1]\n", 3, "unknown joint 'elbow'"),
        ("[ranges]\nelbow = [0, 1]\n", 2, "unknown joint 'elbow'"),
        ("name = 'a'\n[ regions . a ]\nup_cm = [3, 1]\n", 3, "regions.a.up_cm = [3, 1]: the"),
        ("[body]\nwithout = ['hed']\n", 2, "did you mean 'head'?"),
        ("\n[body.shapes.'my a']\nkind='capsule'\n" + ENDS + "radius_cm=-1\n", 2, "my a: radius"),
        ("[body.shapes.a]\nkind='capsule'\n" + ENDS + "radius_cm=nan\n", 1, "a: radius"),
        ("\nadult_ranges = true\n", 2, "known for upper_limb_anatomical only"),
        ("[recordings.ranges]\nelbow_flexion = ['no.mot']\n", 2, "no.mot"),
        ("\narm = 'octopus'\n", 2, "unknown arm 'octopus'"),
    ],
)
def test_a_bad_field_is_told_with_its_line(
    tmp_path: Path, text: str, line: int, reason: str
) -> None:
    said = refusal(written(tmp_path / "s.toml", text))
    assert reason in said
    assert f"line {line}" in said


def test_a_file_that_is_not_there(tmp_path: Path, capsys: Capture) -> None:
    assert "cannot be opened" in refused(capsys, "workspace", "--subject", tmp_path / "no.toml")


def recording(path: Path, low: float, high: float, *, more: int = 0) -> Path:
    """Write a test of the elbow: three times from one end to the other, half a second at each."""
    up = np.linspace(low, high, 100)
    once = np.concatenate([np.full(50, low), up, np.full(50, high), up[::-1]])
    q = np.deg2rad(np.tile(once, 3))[:, None]
    q = np.concatenate([q, *(0.01 * q for _ in range(more))], axis=1)
    joints = ("elbow_flexion", "shoulder_flexion", "wrist_flexion")[: 1 + more]
    write_mot(path, Recording(np.arange(len(q)) / 100, q=q, joints=joints))
    return path


def test_recordings_of_ranges_become_limits(tmp_path: Path) -> None:
    recording(tmp_path / "free.mot", 5, 145)
    recording(tmp_path / "splint.mot", 64.2, 114)
    text = (
        "[recordings.ranges]\nelbow_flexion = ['free.mot']\n"
        "[recordings.impairments]\nelbow_flexion = ['splint.mot']\n"
    )
    person = made(written(tmp_path / "s.toml", text))
    assert person.limited is not None
    i = person.free.chain.index("elbow_flexion")
    assert np.degrees(person.free.upper[i]) == pytest.approx(145, abs=1e-3)
    assert np.degrees(person.limited.lower[i]) == pytest.approx(64.2, abs=1e-3)
    assert [(kind, r.repeats) for kind, r in person.measured] == [("free", 3), ("limited", 3)]


def test_typed_recordings_tell_their_joint_and_widen_the_free_arm(tmp_path: Path) -> None:
    one = recording(tmp_path / "elbow.mot", -4, 150, more=2)
    person = made(None, ranges=(str(one),))
    other = made(None, ranges=(f"elbow_flexion={one}",))
    assert person.limited is not None and other.limited is not None
    np.testing.assert_array_equal(person.limited.lower, other.limited.lower)
    i = person.free.chain.index("elbow_flexion")
    # Table 3 begins at 15.8 degrees; this person was seen to go beyond.
    assert np.degrees(person.free.lower[i]) == pytest.approx(-4, abs=1e-3)


def test_recordings_of_another_joint_or_of_none_are_refused(tmp_path: Path) -> None:
    elbow = recording(tmp_path / "elbow.mot", 10, 100)
    with pytest.raises(SelfmotionError, match="holds elbow_flexion, and no wrist_flexion"):
        made(None, ranges=(f"wrist_flexion={elbow}",))
    still = recording(tmp_path / "still.mot", 90, 90.5)
    with pytest.raises(SelfmotionError, match="no joint moves by more than 1 degree"):
        made(None, ranges=(str(still),))


def test_a_workspace_from_recordings_with_all_details(tmp_path: Path, capsys: Capture) -> None:
    file = recording(tmp_path / "splint.mot", 64.2, 114)
    found = answered(
        capsys, "workspace", "--ranges", file, "--compare", "--details", "--side", "left",
        "--body", "seated", *QUICK, "--report", tmp_path / "r.html",
    )  # fmt: skip
    assert found["side"] == "left"
    assert found["measured_ranges"][0]["joint"] == "elbow_flexion"
    assert found["measured_ranges"][0]["limits"] == "limited"
    details = found["details"]
    assert {"table", "over_shoulder"} <= {r["name"] for r in details["regions"]}
    for r in details["regions"]:
        kept, free, lost = (r["volume_m3"][k] for k in ("limited", "free", "lost"))
        assert kept <= free
        assert r["space_m3"] is None or free <= r["space_m3"] + 1e-12  # None: an open place
        assert lost == pytest.approx(free - kept, abs=1e-12)
    for rows in details["boundary"].values():
        assert sum(row["share_percent"] for row in rows) == pytest.approx(100)
    assert details["boundary"]["limited"][0]["bounded_by"] == "elbow_flexion"
    assert details["regained"] == [
        {
            "joint": "elbow_flexion",
            "percent": 100.0,
            "standard_error_percent": 0.0,
            "volume_m3": pytest.approx(found["volume_m3"]["lost"]),
        }
    ]
    assert 0 <= details["enters_body_percent"]["limited"] < 30
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    for words in ("What stops the hand", "Elbow extension, which ends at 64°", "What was assumed"):
        assert words in page
    for fetched in ('src="http', "@import", "<script"):
        assert fetched not in page


def test_limits_that_leave_nothing_are_named(capsys: Capture) -> None:
    arm = made(None).free
    limits = [
        f"{j}={v:.6f}:{v:.6f}" for j, v in zip(arm.joints, np.degrees(arm.lower), strict=True)
    ]
    words = [word for limit in limits for word in ("--limit", limit)]
    said = refused(capsys, "workspace", *words, *QUICK)
    assert "no volume, the hand does not move; no range: scapula_protraction, " in said
    found = answered(capsys, "workspace", *words, "--compare", "--details", *QUICK)
    assert found["volume_m3"]["limited"] == 0.0
    assert "reaches no volume (no range: " in found["status"]
    assert msgspec.json.encode(found)
