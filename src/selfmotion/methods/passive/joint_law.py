"""What a person's joints do by themselves: stiffness, rest posture and two time constants."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import as_float_array, freeze, require_finite, require_shape
from selfmotion.errors import FileFormatError, RangeError, SelfmotionError
from selfmotion.methods.passive.potentials import positive_definite

# The sum of the joint stiffnesses in the wrist's law, N m/rad.
TRACE = 4.0
# Rest angles that a file may hold (rad): one turn; more was meant as degrees.
FARTHEST_REST = 2.0 * np.pi * (1.0 + 1e-12)


@dataclass(frozen=True, eq=False)
class JointLaw:
    """Elasticity and damping of the joints, as [Tommasino2017] sets them.

    Attributes:
        stiffness: (n, n) K^J, symmetric, positive definite (N m/rad).
        rest: (n,) q*, the posture without elastic torque (rad).
        damping_time: τ₀ in W = τ₀ K^J, eq. 7 (s).
        spring_time: τ of the task spring, eq. 8 (s); 0 for a spring that is there at once.

    Raises:
        ShapeError: stiffness and rest do not fit.
        NotFiniteError: an entry is not finite.
        RangeError: stiffness is not symmetric positive definite, or a time is not allowed.

    Example:
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> float(law.damping[2, 2])  # eq. 9
        0.16
    """

    stiffness: Float[np.ndarray, "joints joints"]
    rest: Float[np.ndarray, " joints"]
    damping_time: float = 0.08
    spring_time: float = 0.08

    def __post_init__(self) -> None:
        """Check everything; make arrays read-only."""
        rest = as_float_array("rest", self.rest, ndim=1).copy()
        require_finite("rest", rest)
        object.__setattr__(self, "rest", freeze(rest))
        stiffness = positive_definite("stiffness", self.stiffness, len(rest))
        object.__setattr__(self, "stiffness", freeze(stiffness))
        if not (np.isfinite(self.damping_time) and self.damping_time > 0.0):
            raise RangeError(f"damping_time = {self.damping_time:g} s: must be above 0")
        if not (np.isfinite(self.spring_time) and self.spring_time >= 0.0):
            raise RangeError(f"spring_time = {self.spring_time:g} s: must be 0 or above")

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.rest)

    @property
    def damping(self) -> Float[np.ndarray, "joints joints"]:
        """W = τ₀ K^J (N m s/rad), eq. 7."""
        return self.damping_time * self.stiffness


def read_law(path: str | Path) -> JointLaw:
    """Read a law from TOML: `stiffness`, `rest`, and `damping_time`, `spring_time` if given.

    Args:
        path: file with ``stiffness`` (n rows of n numbers, or n numbers for a diagonal,
            N m/rad), ``rest`` (rad) or ``rest_deg`` (degrees), and the two times (s).

    Raises:
        FileFormatError: the file is no TOML, a field is missing or unknown, or a value is
            not allowed; the message names file and field.
    """
    try:
        with open(path, "rb") as stream:
            fields = tomllib.load(stream)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML: {error}") from None
    except OSError as error:
        raise FileFormatError(f"{path}: cannot be read: {error.strerror}") from None
    known = ("stiffness", "rest", "rest_deg", "damping_time", "spring_time")
    for name in fields:
        if name not in known:
            raise FileFormatError(f"{path}: unknown field {name!r} (known: {', '.join(known)})")
    if "stiffness" not in fields or ("rest" in fields) == ("rest_deg" in fields):
        raise FileFormatError(f"{path}: needs stiffness, and either rest or rest_deg")
    try:
        stiffness = as_float_array("stiffness", fields["stiffness"])
        if stiffness.ndim == 1:
            stiffness = np.diag(stiffness)
        rest = as_float_array("rest", fields["rest" if "rest" in fields else "rest_deg"], ndim=1)
        if "rest_deg" in fields:
            rest = np.radians(rest)
        require_shape("stiffness", stiffness, (len(rest), len(rest)))
        if (np.abs(rest) > FARTHEST_REST).any():
            i = int(np.argmax(np.abs(rest)))
            raise RangeError(
                f"rest[{i}] = {rest[i]:g} rad: allowed is up to one turn; degrees go into rest_deg"
            )
        return JointLaw(
            stiffness,
            rest,
            *(_seconds(name, fields.get(name, 0.08)) for name in ("damping_time", "spring_time")),
        )
    except SelfmotionError as error:
        raise FileFormatError(f"{path}: {error}") from None


def _seconds(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise RangeError(f"{name} = {value!r}: a number of seconds is expected")
    return float(value)
