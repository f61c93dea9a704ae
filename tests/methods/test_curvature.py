import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from selfmotion.errors import RangeError, ShapeError
from selfmotion.methods.curvature import holm, mean_tests, path_areas, path_hysteresis


def arc(side: float, n: int = 4001) -> np.ndarray:
    """Half a circle from (0, 0) to (0, 2), to the right for side = 1."""
    a = np.linspace(-np.pi / 2, np.pi / 2, n)
    return np.stack([side * np.cos(a), 1.0 + np.sin(a)], axis=1)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_half_a_circle(side):
    areas = path_areas(arc(side), [0.0, 0.0], [0.0, 2.0])
    assert areas.total == pytest.approx(np.pi / 2 / 4, rel=1e-6)
    assert areas.net == pytest.approx(side * np.pi / 8, rel=1e-6)


def test_a_path_that_crosses_the_line_has_both_areas():
    s = np.linspace(0.0, 1.0, 10001)
    path = np.stack([s, 0.1 * np.sin(2 * np.pi * s)], axis=1)  # first left of east, then right
    areas = path_areas(path, [0.0, 0.0], [1.0, 0.0])
    assert areas.left == pytest.approx(0.1 / np.pi, rel=1e-6)
    assert areas.right == pytest.approx(0.1 / np.pi, rel=1e-6)
    assert areas.net == pytest.approx(0.0, abs=1e-12)
    # The crossing lies between samples: two triangles of base 1/2 and height 1.
    zigzag = path_areas([[0, 0], [0.25, 1], [0.75, -1], [1, 0]], [0, 0], [1, 0])
    assert (zigzag.right, zigzag.left) == (0.25, 0.25)


def test_ends_are_closed_by_perpendiculars_and_the_line_can_be_the_movement_s():
    path = np.array([[0.0, 0.1], [1.0, 0.1]])
    assert path_areas(path, [0, 0], [1, 0]).left == pytest.approx(0.1)
    assert path_areas(path, [0, 0], [1, 0], reference="movement").total == 0.0


@settings(max_examples=40, deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(0.1, 5.0), st.integers(0, 10_000))
def test_areas_do_not_depend_on_place_size_or_direction(angle, size, seed):
    rng = np.random.default_rng(seed)
    steps = rng.normal([0.2, 0.0], 0.1, (30, 2))
    # Never backwards: a piece that runs back counts with its size alone, the polygon with its sign.
    path = np.cumsum(np.abs(steps) * [1.0, 0.0] + steps * [0.0, 1.0], axis=0)
    c, s = np.cos(angle), np.sin(angle)
    moved = size * path @ [[c, s], [-s, c]] + [3.0, -2.0]
    ends = np.array([[0.0, 0.0], [6.0, 0.0]])
    there = size * ends @ [[c, s], [-s, c]] + [3.0, -2.0]
    one, two = path_areas(path, *ends), path_areas(moved, *there)
    assert (two.right, two.left) == pytest.approx((one.right, one.left), abs=1e-12)
    mirrored = path_areas(path * [1.0, -1.0], *ends)
    assert (mirrored.right, mirrored.left) == pytest.approx((one.left, one.right), abs=1e-12)
    shapely = abs(0.5 * (path[1:, 1] + path[:-1, 1]) @ np.diff(path[:, 0])) / 36.0
    assert abs(one.net) == pytest.approx(shapely, abs=1e-12)


def test_back_along_the_same_path_the_net_area_turns_its_sign():
    there = path_areas(arc(1.0), [0.0, 0.0], [0.0, 2.0])
    back = path_areas(arc(1.0)[::-1], [0.0, 2.0], [0.0, 0.0])
    assert there.net + back.net == pytest.approx(0.0, abs=1e-12)  # no hysteresis


def test_paths_in_space_are_seen_from_above():
    path = np.concatenate([arc(1.0), np.full((4001, 1), 0.7)], axis=1)
    areas = path_areas(path, [0, 0, 0.7], [0, 2, 0.7], up=[0, 0, 1])
    assert areas.right == pytest.approx(np.pi / 8, rel=1e-6)
    with pytest.raises(ShapeError, match="up"):
        path_areas(path, [0, 0, 0.7], [0, 2, 0.7])
    with pytest.raises(RangeError, match="parallel"):
        path_areas(path, [0, 0, 0], [0, 0, 1], up=[0, 0, 1])


def test_bad_paths_are_refused():
    with pytest.raises(RangeError, match="coincide"):
        path_areas(arc(1.0), [0, 0], [0, 0])
    with pytest.raises(ShapeError, match="expected"):
        path_areas(arc(1.0), [0, 0, 0], [0, 1, 0])


def test_tests_of_means_are_scipy_s():
    rng = np.random.default_rng(0)
    groups = [rng.normal(m, 1.0, 10) for m in (0.0, 1.0, 2.0)]
    tests = mean_tests(groups, ["a", "b", "c"], against=[0.0, 0.0, 0.5])
    for x, value, t, p in zip(groups, tests.against, tests.t, tests.p, strict=True):
        known = stats.ttest_1samp(x, value)  # (statistic, p)
        assert (t, p) == pytest.approx(tuple(known))
    assert (tests.p_corrected >= tests.p).all()
    single = mean_tests([[1.0]], ["alone"])
    assert np.isnan(single.p[0])
    assert not single.differs[0]


def test_holm_by_hand():
    # Sorted 0.005, 0.01, 0.03, 0.04: times 4, 3, 2, 1, then never falling.
    np.testing.assert_allclose(
        holm([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02], atol=1e-15
    )
    np.testing.assert_array_equal(holm([np.nan, 0.04])[1], 0.04)


def test_hysteresis_is_the_area_between_the_way_out_and_the_way_back():
    """Out along an arc to the right and back along one to the right: a closed lens between them."""
    out, back = arc(1.0), arc(1.0) * [-0.5, 1.0]
    ends = np.array([[0.0, 0.0], [0.0, 2.0]])
    net = [path_areas(out, *ends).net, path_areas(back[::-1], *ends[::-1]).net]
    (found,) = path_hysteresis(net, [("N", "outbound"), ("N", "inbound")]).values()
    loop = np.concatenate([out, back[::-1]])
    x, y = loop.T
    polygon = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 4.0
    assert found[0] == pytest.approx(polygon, rel=1e-6)
    same = path_areas(out[::-1], *ends[::-1]).net
    (none,) = path_hysteresis([net[0], same], [("N", "outbound"), ("N", "inbound")]).values()
    assert none[0] == pytest.approx(0.0, abs=1e-9)


def test_pairs_of_hysteresis_are_those_of_one_trial_and_target():
    ways = [("N", "outbound"), ("S", "outbound"), ("N", "inbound"), ("N", "outbound")]
    ways += [("N", "inbound"), ("N", "inbound"), ("W", "inbound"), ("N", "elsewhere")]
    trials = ["1", "1", "1", "2", "2", "2", "2", "2"]
    net = [1.0, 5.0, 10.0, np.nan, 20.0, 7.0, 3.0, 100.0]
    found = path_hysteresis(net, ways, trials)
    assert list(found) == ["N"]
    np.testing.assert_array_equal(found["N"], [11.0, np.nan])
    renamed = path_hysteresis([1.0, 2.0], [("N", "go"), ("N", "come")], directions=("go", "come"))
    assert renamed["N"].tolist() == [3.0]
    with pytest.raises(ShapeError, match="2 movements, 1 ways"):
        path_hysteresis([1.0, 2.0], [("N", "outbound")])
