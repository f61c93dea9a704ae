"""The option --prior of `selfmotion donders`: what is known about a law beforehand, as TOML."""

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from selfmotion.errors import FileFormatError, SelfmotionError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.methods.elasticity.result import ElasticityPrior

ANGLES = ("rest", "rest_sd")
FIELDS = ("stiffness", "stiffness_sd", "source", *ANGLES, *(f"{name}_deg" for name in ANGLES))


def read_prior(path: Path, n: int) -> "ElasticityPrior":
    """Read a prior: means and standard deviations of stiffness and rest posture.

    Args:
        path: TOML with ``stiffness`` (n rows, or n numbers of a diagonal, N m/rad), ``rest``
            (rad) or ``rest_deg``, and their ``_sd``, one number for all or as many as the means;
            ``inf`` where nothing is known.
        n: number of joints.

    Raises:
        FileFormatError: the file is no TOML, or a field is missing, unknown or not allowed.
    """
    import numpy as np

    from selfmotion.methods.elasticity.result import ElasticityPrior

    try:
        fields = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileFormatError(f"{path}: no TOML: {error}") from None
    for name in fields:
        if name not in FIELDS:
            raise FileFormatError(f"{path}: unknown field {name!r} (known: {', '.join(FIELDS)})")
    try:
        stiffness = _square(fields, "stiffness", n)
        return ElasticityPrior(
            np.diag(stiffness) if stiffness.ndim == 1 else stiffness,
            np.broadcast_to(_square(fields, "stiffness_sd", n), (n, n)),
            _angles(fields, "rest", n),
            np.broadcast_to(_angles(fields, "rest_sd", n), (n,)),
            str(fields.get("source", path.name)),
        )
    except (SelfmotionError, ValueError, TypeError) as error:
        raise FileFormatError(f"{path}: {error}") from None


def _square(fields: dict[str, Any], name: str, n: int) -> "np.ndarray":
    """Give a field that is a matrix (n, n); of a standard deviation also a single number."""
    import numpy as np

    from selfmotion.arrays import as_float_array

    if name not in fields:
        raise FileFormatError(f"{name} is missing")
    array = as_float_array(name, fields[name])
    spread = name.endswith("_sd")
    # A single number counts as one row of one here.
    if array.shape not in ((n, n), (1,) if spread else (n,)) or np.isnan(array).any():
        other = "one number" if spread else f"the {n} numbers of its diagonal"
        raise FileFormatError(f"{name}: {n} rows of {n} numbers are expected, or {other}")
    return array


def _angles(fields: dict[str, Any], name: str, n: int) -> "np.ndarray":
    """Give a field of angles in rad; of a standard deviation also a single number."""
    import numpy as np

    from selfmotion.arrays import as_float_array

    named = [key for key in (name, f"{name}_deg") if key in fields]
    if len(named) != 1:
        raise FileFormatError(f"either {name} or {name}_deg is needed")
    array = as_float_array(named[0], fields[named[0]])
    allowed = ((n,), (1,)) if name.endswith("_sd") else ((n,),)
    if array.shape not in allowed or np.isnan(array).any():
        raise FileFormatError(f"{named[0]}: {n} numbers are expected, one a joint")
    return np.radians(array) if named[0].endswith("_deg") else array
