"""Array types with named dimensions, and the checks that public functions make on entry.

Dimension words are fixed across the library: samples, joints, coords, rows, muscles, swivels.
"""

from typing import TypeAlias

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy.typing import ArrayLike

from selfmotion.errors import NotFiniteError, RangeError, ShapeError

JointVector: TypeAlias = Float[np.ndarray, " joints"]
JointSamples: TypeAlias = Float[np.ndarray, "samples joints"]
TaskSamples: TypeAlias = Float[np.ndarray, "samples rows"]
JacobianSamples: TypeAlias = Float[np.ndarray, "samples rows joints"]
Transform: TypeAlias = Float[np.ndarray, "4 4"]
SampleMask: TypeAlias = Bool[np.ndarray, " samples"]
SampleIndex: TypeAlias = Int[np.ndarray, " samples"]

PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71)


def as_float_array(name: str, value: ArrayLike, ndim: int | None = None) -> np.ndarray:
    """Convert to a C-contiguous float64 array.

    Args:
        name: the word for the array in the error message.
        value: anything that NumPy can turn into real numbers.
        ndim: number of dimensions required, if any.

    Raises:
        ShapeError: the value is not numeric, is complex, or has the wrong number of dimensions.
    """
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ShapeError(f"{name}: rows have different lengths ({error})") from None
    if array.dtype.kind not in "biuf":
        raise ShapeError(f"{name}: expected real numbers, found dtype {array.dtype}")
    if ndim is not None and array.ndim != ndim:
        raise ShapeError(f"{name}: expected {ndim} dimension(s), found shape {array.shape}")
    return np.ascontiguousarray(array, dtype=np.float64)


def require_shape(name: str, array: np.ndarray, shape: tuple[int | None, ...]) -> None:
    """Check a shape; None in `shape` stands for any length.

    Raises:
        ShapeError: names the shape found and the shape expected.
    """
    fits = len(array.shape) == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if want is None else str(want) for want in shape)
        raise ShapeError(f"{name}: expected shape ({wanted}), found {array.shape}")


def require_fillable(name: str, array: np.ndarray, shape: tuple[int, ...]) -> None:
    """Check an array that a caller gives to be filled.

    Raises:
        ShapeError: it has another shape, is read-only, or not of 64-bit floats in C order.
    """
    require_shape(name, array, shape)
    if not (array.flags.c_contiguous and array.flags.writeable and array.dtype == np.float64):
        raise ShapeError(f"{name}: expected a writable array of 64-bit floats in C order")


def require_finite(name: str, array: np.ndarray) -> None:
    """Check that every entry is finite.

    Raises:
        NotFiniteError: counts the bad entries and names the first by its index.
    """
    finite = np.isfinite(array)
    if finite.all():
        return
    first = tuple(int(i) for i in np.argwhere(~finite)[0])
    where = ", ".join(map(str, first))
    raise NotFiniteError(
        f"{name}: {int((~finite).sum())} of {array.size} values are not finite; "
        f"the first is {name}[{where}] = {array[first]}"
    )


def require_between(name: str, value: float, low: float, high: float) -> None:
    """Check that a number lies in [low, high].

    Raises:
        RangeError: names the value and the range.
    """
    if not low <= value <= high:
        raise RangeError(f"{name} = {value:g}: allowed is {low:g} to {high:g}")


def freeze(array: np.ndarray) -> np.ndarray:
    """Make an array read-only and return it (the frozen dataclasses hold such arrays)."""
    array.setflags(write=False)
    return array


def halton(n_points: int, n_dimensions: int) -> Float[np.ndarray, "points dimensions"]:
    """Give points that fill the unit cube evenly: the Halton sequence after its first, the origin.

    That of ``scipy.stats.qmc``, which takes a second to import.

    Args:
        n_points: points.
        n_dimensions: at most the number of `PRIMES`.

    Example:
        >>> halton(3, 2).round(3).tolist()
        [[0.5, 0.333], [0.25, 0.667], [0.75, 0.111]]
    """
    out = np.zeros((n_points, n_dimensions))
    for column, base in zip(out.T, PRIMES[:n_dimensions], strict=True):
        left, digit = np.arange(1, n_points + 1), 1.0
        while left.any():
            digit /= base
            left, rest = np.divmod(left, base)
            column += digit * rest
    return out
