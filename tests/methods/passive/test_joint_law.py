import numpy as np
import pytest

from selfmotion.errors import FileFormatError
from selfmotion.methods.passive.joint_law import read_law


def write(path, text):
    path.write_text(text)
    return path


def test_a_law_is_read(tmp_path):
    file = write(tmp_path / "law.toml", "stiffness = [0.5, 1.5, 2.0]\nrest_deg = [5, 0, 0]\n")
    law = read_law(file)
    np.testing.assert_allclose(law.stiffness, np.diag([0.5, 1.5, 2.0]))
    np.testing.assert_allclose(law.rest, [np.radians(5.0), 0.0, 0.0])
    np.testing.assert_allclose(law.damping.diagonal(), [0.04, 0.12, 0.16])  # eq. 9
    full = "stiffness = [[1.0, 0.1], [0.1, 2.0]]\nrest = [0.1, 0.2]\nspring_time = 0\n"
    law = read_law(write(tmp_path / "full.toml", full))
    assert (law.stiffness[0, 1], law.spring_time) == (0.1, 0.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("stiffness = ", "no TOML"),
        ("rest = [0, 0]", "needs stiffness"),
        ("stiffness = [1, 2]", "either rest or rest_deg"),
        ("stiffness = [1, 2]\nrest = [0, 0]\ndamping = 1", "unknown field 'damping'"),
        ("stiffness = [1, 2]\nrest = [0, 0, 0]", "expected shape"),
        ("stiffness = [1, -2]\nrest = [0, 0]", "positive definite"),
        ("stiffness = [1, 2]\nrest = [0, 0]\ndamping_time = 'slow'", "a number of seconds"),
        ("stiffness = [1, 'b']\nrest = [0, 0]", "stiffness"),
    ],
)
def test_a_bad_file_is_named_with_its_field(tmp_path, text, words):
    with pytest.raises(FileFormatError, match=words) as caught:
        read_law(write(tmp_path / "law.toml", text))
    assert "law.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_says_so(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_law(tmp_path / "none.toml")
