"""Which field of a MATLAB struct holds what, where nobody has documented the names.

A field is told by its name (patterns below) and its shape; where two fields answer to one part
the file is refused, and where there is a task velocity it must be what Jacobian and joint
velocity make. Whatever was concluded is said in words.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations

import numpy as np

from selfmotion.arrays import JacobianSamples
from selfmotion.errors import FileFormatError
from selfmotion.motion.checks import CONSISTENCY, refuse_infinite, velocity_residual
from selfmotion.motion.files.matlab import Tree

VELOCITY = re.compile(r"vel|dot|speed|^d(q|x|theta|p)|^(q|x)d$|^(q|x)p$")
JOINT = re.compile(r"joint|^d?q|theta|angle|human")
EFFECTOR = re.compile(r"eff|^ee|ee$|hand|cart|tip|task|endpoint|^d?x")
# In this order: the first pattern that is found in the folded name decides.
PARTS: tuple[tuple[str, re.Pattern[str]], ...] = (
    ("ik_data", re.compile(r"ikdata")),
    ("null", re.compile(r"null")),
    ("weights", re.compile(r"weight|^w(hat|ik|est)?$|^ikw")),
    ("dt", re.compile(r"^dt$|timestep|sampl(e|ing)(time|period)")),
    ("target", re.compile(r"target|goal")),
    ("jacobian", re.compile(r"jac|^j(k|t|all)?$")),
    ("virtual", re.compile(r"virt|prosth|robot|elbow|^q(bar)?3$")),
    ("time", re.compile(r"^t$|time|^tvec")),
)


@dataclass(frozen=True, eq=False)
class Motion:
    """One movement with time along axis 0, and what was concluded about it, in words."""

    arrays: dict[str, np.ndarray]
    said: tuple[str, ...]


@lru_cache(maxsize=1024)  # the same few names stand in thousands of trials
def part_of(name: str) -> str | None:
    """Give what a field of this name holds: q, qd, x, xd, jacobian, time ...; None: not told."""
    folded = re.sub(r"[^a-z0-9]", "", name.lower())
    for part, pattern in PARTS:
        if pattern.search(folded):
            return part
    joint, effector = bool(JOINT.search(folded)), bool(EFFECTOR.search(folded))
    if joint == effector:
        return None
    return ("q" if joint else "x") + ("d" if VELOCITY.search(folded) else "")


def parts(struct: Mapping[str, Tree]) -> dict[str, str]:
    """Give the field that holds each part.

    Raises:
        FileFormatError: two fields answer to one part.
    """
    found: dict[str, str] = {}
    for name, value in struct.items():
        part = part_of(name)
        # Arrays only: a struct called "targets" is a level of the file, not a position.
        if part is None or not (_is_numeric(value) or (part == "jacobian" and _is_cells(value))):
            continue
        if part in found and part not in ("null", "weights", "ik_data"):
            raise FileFormatError(
                f"fields {found[part]!r} and {name!r} both look like {part}: rename one"
            )
        found[part] = name
    return found


def is_motion(struct: Mapping[str, Tree]) -> bool:
    """Tell whether a struct is one movement: velocities with a Jacobian, or angles and a hand."""
    names = {part_of(name) for name, v in struct.items() if _is_numeric(v) or _is_cells(v)}
    return {"q", "jacobian"} <= names or {"qd", "jacobian"} <= names or {"q", "x"} <= names


def with_jacobian(struct: Mapping[str, Tree]) -> Motion:
    """Read a movement that brings its Jacobian (experiment 1, IK_data, a flat file).

    Raises:
        FileFormatError: shapes that do not fit together, or in more than one way.
    """
    found = parts(struct)
    said = [f"{part} = {name!r}" for part, name in found.items() if part in USED]
    flat = {part: _matrix(name, struct[name]) for part, name in found.items() if part in FLAT}
    samples = _samples(flat, struct[found["jacobian"]])
    flat = {part: _upright(found[part], array, samples) for part, array in flat.items()}
    moving = flat.get("qd", flat.get("q"))
    if moving is None:
        raise FileFormatError("no joint velocities beside the Jacobian")
    jacobian = _jacobian(
        struct[found["jacobian"]], samples, moving.shape[1], (moving, flat.get("xd"))
    )
    if "qd" not in flat:
        _refuse_unless(_fits(jacobian, moving, flat.get("xd")), f"{found['q']!r} holds velocities")
        flat["qd"] = flat.pop("q")
        said.append(f"{found['q']!r} holds joint velocities, as the task velocity shows")
    if "xd" in flat:
        jacobian, flat["xd"] = _common_rows(jacobian, flat["qd"], flat["xd"], said)
    if flat.get("x") is not None and flat["x"].shape[1] != jacobian.shape[1]:
        said.append(f"{found['x']!r} left aside: {flat['x'].shape[1]} columns")
        del flat["x"]
    return Motion({**flat, "jacobian": jacobian, **_clock(struct, found, samples)}, tuple(said))


def planar(struct: Mapping[str, Tree]) -> Motion:
    """Read a movement of the virtual planar chain (experiment 2): q (K, 3) and x (K, 2).

    The third angle is that of the virtual elbow, which moves the hand; the person's own elbow is
    kept as `human_elbow`.

    Raises:
        FileFormatError: shapes that do not fit together.
    """
    found = parts(struct)
    for part in ("q", "x", "time"):
        if part not in found:
            raise FileFormatError(f"no field looks like {part} (fields: {', '.join(struct)})")
    said = [f"{part} = {name!r}" for part, name in found.items() if part in USED]
    flat = {part: _matrix(found[part], struct[found[part]]) for part in ("q", "x")}
    time = np.ravel(_matrix(found["time"], struct[found["time"]]))
    flat = {part: _upright(found[part], array, len(time)) for part, array in flat.items()}
    q, x = flat["q"], flat["x"]
    if "virtual" in found:
        virtual = np.ravel(_matrix(found["virtual"], struct[found["virtual"]]))
    elif q.shape[1] == 4:
        virtual, q = q[:, 3], q[:, :3]
        said.append(f"virtual elbow = column 4 of {found['q']!r}")
    else:
        raise FileFormatError(f"no field looks like the virtual elbow ({', '.join(struct)})")
    x = _plane(found["x"], x, said)
    if q.shape[1] not in (2, 3) or len(virtual) != len(time):
        raise FileFormatError(
            f"joint angles {q.shape} and virtual elbow {virtual.shape}: ({len(time)}, 3) and "
            f"({len(time)},) are needed"
        )
    arrays = {"q": np.column_stack([q[:, :2], virtual]), "x": x, "time": time}
    if q.shape[1] == 3:
        arrays["human_elbow"] = np.ascontiguousarray(q[:, 2])
    if "target" in found:
        arrays["target"] = _matrix(found["target"], struct[found["target"]])
    return Motion(arrays, tuple(said))


FLAT = ("q", "qd", "x", "xd")
USED = (*FLAT, "jacobian", "time", "dt", "virtual", "target")


def _is_numeric(value: Tree) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.size > 0


def _is_cells(value: Tree) -> bool:
    return isinstance(value, list) and len(value) > 0 and all(map(_is_numeric, value))


def _shape(value: Tree) -> tuple[int, ...]:
    return value.shape if isinstance(value, np.ndarray) else ()


def _matrix(name: str, value: Tree) -> np.ndarray:
    array = np.asarray(value, dtype=np.float64)
    if array.ndim != 2:
        raise FileFormatError(f"{name!r} has shape {array.shape}: samples by columns are needed")
    refuse_infinite(name, array)
    return array


def _samples(flat: Mapping[str, np.ndarray], jacobian: Tree) -> int:
    """Give the number of samples: the longest length that all arrays have."""
    shapes = [set(array.shape) for array in flat.values()]
    shapes.append({len(jacobian)} if isinstance(jacobian, list) else set(_shape(jacobian)))
    common = set.intersection(*shapes)
    if not common:
        words = ", ".join(str(array.shape) for array in flat.values())
        have = len(jacobian) if isinstance(jacobian, list) else _shape(jacobian)
        raise FileFormatError(f"no common number of samples: {words} and Jacobian {have}")
    return max(common)


def _upright(name: str, array: np.ndarray, samples: int) -> np.ndarray:
    """Turn an array so that time runs along axis 0."""
    if array.shape[0] == array.shape[1]:
        raise FileFormatError(f"{name!r} has shape {array.shape}: which axis is time is ambiguous")
    if samples not in array.shape:
        raise FileFormatError(f"{name!r} has shape {array.shape}: {samples} samples are needed")
    return np.ascontiguousarray(array if array.shape[0] == samples else array.T)


def _jacobian(
    value: Tree, samples: int, joints: int, velocities: tuple[np.ndarray, np.ndarray | None]
) -> JacobianSamples:
    """Bring a Jacobian of any order of axes, or one cell a sample, to (K, m, n)."""
    if isinstance(value, list):
        shapes = {_shape(cell) for cell in value}
        if len(shapes) != 1:
            raise FileFormatError(f"Jacobian cells have different shapes: {sorted(shapes)}")
        array = np.stack([np.asarray(cell, dtype=np.float64) for cell in value])
    else:
        array = np.asarray(value, dtype=np.float64)
    if array.ndim != 3:
        raise FileFormatError(f"Jacobian has shape {array.shape}: three axes are needed")
    refuse_infinite("Jacobian", array)
    shape, wanted = array.shape, (samples, joints)
    orders = [p for p in permutations(range(3)) if (shape[p[0]], shape[p[2]]) == wanted]
    if not orders:
        raise FileFormatError(
            f"Jacobian has shape {array.shape}: {samples} samples and {joints} joints are needed"
        )
    if len(orders) > 1 and velocities[1] is not None:
        orders = [p for p in orders if _fits(array.transpose(p), *velocities)]
    elif len(orders) > 1:  # square: rows come before columns, as MATLAB writes matrices
        orders = [p for p in orders if p[1] < p[2] and p[0] in (0, 2)]
    if len(orders) != 1:
        raise FileFormatError(f"Jacobian has shape {array.shape}: the order of axes is ambiguous")
    return np.ascontiguousarray(array.transpose(orders[0]))


def _fits(jacobian: np.ndarray, qd: np.ndarray, xd: np.ndarray | None) -> bool:
    if xd is None:
        return False
    m = min(jacobian.shape[1], xd.shape[1])
    return velocity_residual(jacobian[:, :m], qd, xd[:, :m]) <= CONSISTENCY


def _common_rows(
    jacobian: np.ndarray, qd: np.ndarray, xd: np.ndarray, said: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Keep the rows that Jacobian and task velocity share (published: 3 rows beside 4 columns)."""
    m = min(jacobian.shape[1], xd.shape[1])
    if jacobian.shape[1] != xd.shape[1]:
        _refuse_unless(
            _fits(jacobian, qd, xd),
            f"the first {m} rows of a Jacobian {jacobian.shape} belong to velocities {xd.shape}",
        )
        said.append(f"the first {m} of {max(jacobian.shape[1], xd.shape[1])} task rows are used")
    jacobian, xd = jacobian[:, :m], xd[:, :m]
    rows = np.nanmax(np.abs(jacobian), axis=(0, 2), initial=0.0) > 0.0
    if m >= jacobian.shape[2] and rows.any() and not rows.all():
        said.append(f"{int((~rows).sum())} task row(s) of zeros left out")
        jacobian, xd = jacobian[:, rows], xd[:, rows]
    return np.ascontiguousarray(jacobian), np.ascontiguousarray(xd)


def _plane(name: str, x: np.ndarray, said: list[str]) -> np.ndarray:
    """Keep the two columns of positions that move."""
    if x.shape[1] == 2:
        return x
    moving = np.flatnonzero(np.nanstd(x, axis=0) > 1e-9 * np.nanstd(x))
    if len(moving) != 2:
        raise FileFormatError(f"{name!r} has shape {x.shape}: positions in a plane are needed")
    said.append(f"columns {moving[0] + 1} and {moving[1] + 1} of {name!r} move")
    return np.ascontiguousarray(x[:, moving])


def _clock(
    struct: Mapping[str, Tree], found: Mapping[str, str], samples: int
) -> dict[str, np.ndarray]:
    for part, shape in (("time", (samples,)), ("dt", (1,))):
        if part in found:
            values = np.ravel(np.asarray(struct[found[part]], dtype=np.float64))
            if values.shape == shape:
                return {part: values}
    return {}


def _refuse_unless(true: bool, claim: str) -> None:
    if not true:
        raise FileFormatError(f"the data do not show that {claim}, so the file is ambiguous")
