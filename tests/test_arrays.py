"""The checks on entry: what they let pass, and the one line that they say otherwise."""

import numpy as np
import pytest
from scipy.stats.qmc import Halton

from selfmotion.arrays import (
    as_float_array,
    freeze,
    halton,
    require_between,
    require_finite,
    require_shape,
)
from selfmotion.errors import NotFiniteError, RangeError, SelfmotionError, ShapeError


@pytest.mark.parametrize("value", [1, [1, 2], [[1.5]], np.ones((2, 2), dtype=np.float32), [True]])
def test_numbers_become_contiguous_float64(value):
    array = as_float_array("x", value)
    assert array.dtype == np.float64
    assert array.flags.c_contiguous
    np.testing.assert_array_equal(array, np.asarray(value, dtype=float))


def test_an_array_that_fits_is_not_copied():
    x = np.ones((3, 2))
    assert as_float_array("x", x) is x
    assert as_float_array("x", x.T).flags.c_contiguous


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (["a"], "x: expected real numbers, found dtype"),
        ([1 + 2j], "x: expected real numbers, found dtype complex128"),
        ([None, 1.0], "x: expected real numbers, found dtype object"),
        ([[1.0], [1.0, 2.0]], "x: rows have different lengths"),
        (np.array(["2020-01-01"], dtype="datetime64"), "x: expected real numbers"),
    ],
)
def test_what_is_no_number_is_refused_in_one_line(value, sentence):
    with pytest.raises(ShapeError, match=sentence) as caught:
        as_float_array("x", value)
    assert "\n" not in str(caught.value)


def test_dimensions():
    assert as_float_array("x", [1.0], ndim=1).shape == (1,)
    with pytest.raises(ShapeError, match=r"x: expected 2 dimension\(s\), found shape \(1,\)"):
        as_float_array("x", [1.0], ndim=2)


def test_shapes():
    require_shape("x", np.ones((3, 2)), (None, 2))
    with pytest.raises(ShapeError, match=r"x: expected shape \(any, 3\), found \(3, 2\)"):
        require_shape("x", np.ones((3, 2)), (None, 3))
    with pytest.raises(ShapeError, match=r"found \(3,\)"):
        require_shape("x", np.ones(3), (None, 3))


def test_finite_names_count_and_place():
    require_finite("x", np.ones(3))
    with pytest.raises(NotFiniteError, match=r"x: 2 of 4 values .* x\[0, 1\] = nan"):
        require_finite("x", np.array([[0.0, np.nan], [np.inf, 1.0]]))


def test_ranges():
    require_between("x", 0.5, 0.0, 1.0)
    require_between("x", 1.0, 0.0, 1.0)
    for value in (1.5, -0.1, np.nan):
        with pytest.raises(RangeError, match="x = .*: allowed is 0 to 1"):
            require_between("x", value, 0.0, 1.0)


def test_frozen_arrays_cannot_be_written():
    x = freeze(np.ones(2))
    with pytest.raises(ValueError, match="read-only"):
        x[0] = 2.0


def test_all_errors_are_the_library_s_and_value_errors():
    for error in (ShapeError, NotFiniteError, RangeError):
        assert issubclass(error, SelfmotionError)
        assert issubclass(error, ValueError)


@pytest.mark.parametrize(("n_points", "n_dimensions"), [(1, 1), (24, 7), (400, 20)])
def test_halton_points_are_those_of_scipy(n_points: int, n_dimensions: int) -> None:
    wanted = Halton(n_dimensions, scramble=False).random(n_points + 1)[1:]
    np.testing.assert_allclose(halton(n_points, n_dimensions), wanted, rtol=0.0, atol=1e-15)
