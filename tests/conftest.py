"""Shapes are types in the tests: every call into the library is checked against its annotations."""

import functools
import inspect
import os
import typing
from collections.abc import Callable
from typing import Any

# No test opens a window, asks for a display or spreads over all cores (numba reads it on import).
os.environ["MPLBACKEND"] = "Agg"
os.environ.setdefault("NUMBA_NUM_THREADS", "2")

import jaxtyping
import numba
import numpy.typing


def _compiling_the_bare_function(decorator: Callable[..., Any]) -> Callable[..., Any]:
    """Let a numba decorator see the function itself, which the import hook has wrapped.

    The hook puts its checker below all other decorators; numba cannot compile a checker.
    """

    @functools.wraps(decorator)
    def decorate(*args: Any, **options: Any) -> Any:
        if args and inspect.isfunction(args[0]):
            return decorator(inspect.unwrap(args[0]), *args[1:], **options)
        made = decorator(*args, **options)
        return lambda function: made(inspect.unwrap(function))

    return decorate


for _name in ("njit", "jit", "vectorize", "guvectorize"):
    setattr(numba, _name, _compiling_the_bare_function(getattr(numba, _name)))

_jaxtyped = jaxtyping.jaxtyped


def _checking_what_others_call(*args: Any, **options: Any) -> Callable[[Any], Any]:
    """Let the import hook's decorator pass by functions that only their own module can call.

    Making a checker takes milliseconds: a function defined inside another would pay them each time
    that the outer one runs.
    """
    check = _jaxtyped(*args, **options)

    def decorate(made: Any) -> Any:
        inside = "<locals>" in made.__qualname__
        private = made.__name__.startswith("_") and not made.__name__.endswith("__")
        return made if inside or private else check(made)

    return decorate


setattr(jaxtyping, "jaxtyped", _checking_what_others_call)  # noqa: B010

# NumPy's ArrayLike refuses tuples when it is checked (they have no __reversed__). What the library
# is given as such it checks itself, in `as_float_array`.
setattr(numpy.typing, "ArrayLike", object)  # noqa: B010  (the type checker sees the real one)

# Every Protocol is checked by its members, whether or not it says @runtime_checkable.
setattr(typing.Protocol, "_is_runtime_protocol", True)  # noqa: B010

# An int is welcome where a float is asked for, as in the type checkers.
jaxtyping.install_import_hook(
    "selfmotion", "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))"
)
