"""Any MJCF or URDF as an arm, read through MuJoCo.

From a URDF, shapes are left out (their meshes are often not at hand, and an arm needs only
`inertial`); `mimic` is read from the file, as not every MuJoCo does; a joint whose two limits are
equal is fixed there.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from selfmotion.errors import FileFormatError, ModelError, RangeError, SelfmotionError
from selfmotion.kinematics.arm import LANDMARKS, Arm
from selfmotion.kinematics.chain import Tip
from selfmotion.kinematics.forward import tip_positions
from selfmotion.kinematics.mujoco_chain import MujocoChain, chain_from_mujoco
from selfmotion.spatial import transform, unit

# Words by which a body or site is taken for a joint centre, if the caller names none.
_WORDS: Mapping[str, tuple[str, ...]] = {
    "shoulder": ("shoulder", "humerus", "upperarm", "upper_arm", "glenohumeral"),
    "elbow": ("elbow", "ulna", "forearm", "fore_arm", "lowerarm", "lower_arm"),
    "wrist": ("wrist", "lunate", "proximal_row", "carpus"),
}
# MuJoCo compiles no moving body without mass; a URDF may hold some. Taken back after compiling.
_TINY = 1e-8


@dataclass(frozen=True)
class ModelChoices:
    """What a model file does not say.

    Attributes:
        tip: body or site that is the hand; left out: the last site, else the last body.
        landmarks: landmark to the body or site that is there.
        held: joints that do not move, with their values (rad or m).
        up: upward direction in the model's ground frame; left out: against its gravity (a URDF
            has none: z, with 9.81 m/s²).
        forward: direction in which the person looks.
    """

    tip: str | None = None
    landmarks: Mapping[str, str] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    up: tuple[float, float, float] | None = None
    forward: tuple[float, float, float] | None = None


def read_model(path: str | Path, choices: ModelChoices | None = None) -> Arm:
    """Read an arm from an MJCF or URDF file.

    Landmarks are, in this order: those that the choices name; the hand at the tip; a body or
    site on the way whose name says shoulder, elbow or wrist; the first joint for the shoulder,
    the last for the wrist, and for the elbow the joint between them that is farthest from both.

    Args:
        path: the file.
        choices: tip, landmarks, joints held, directions.

    Raises:
        FileFormatError: the file does not exist, or MuJoCo cannot read it.
        ModelError: a joint on the way is neither hinge nor slide, or the way closes a loop.
        UnknownNameError: a name in the choices is not in the model.
    """
    file, wanted = Path(path), choices or ModelChoices()
    model, fixed, is_urdf = _compile(file)
    try:
        taken = chain_from_mujoco(model, tip=wanted.tip, held={**fixed, **wanted.held})
        landmarks = _landmarks(taken, wanted)
    except SelfmotionError as error:
        raise type(error)(f"{file}: {error}") from None
    up, gravity = _directions(np.array(model.opt.gravity), wanted.up, is_urdf=is_urdf)
    return arm_from_chain(
        taken,
        name=file.stem,
        landmarks=landmarks,
        directions=(gravity, up, _forward(up, wanted.forward)),
        source=f"{file.name}; limits, masses and inertias as in the file",
    )


def arm_from_chain(
    taken: MujocoChain,
    *,
    name: str,
    landmarks: Mapping[str, Tip],
    directions: tuple[np.ndarray, np.ndarray, np.ndarray],
    source: str,
) -> Arm:
    """Make an arm of a chain taken from MuJoCo.

    Args:
        taken: the chain.
        name: of the arm.
        landmarks: with shoulder, elbow, wrist and hand.
        directions: gravity (m/s²), up and forward in the ground.
        source: where it comes from.
    """
    tips = [landmarks[key] for key in LANDMARKS]
    home = np.clip(np.zeros(taken.chain.n_coordinates), taken.chain.lower, taken.chain.upper)
    points = tip_positions(taken.chain, home, tips)[0]
    sizes = np.linalg.norm(np.diff(points, axis=0), axis=1).tolist()
    gravity, up, forward = directions
    return Arm(
        name=name,
        chain=taken.chain,
        landmarks=landmarks,
        lengths=dict(zip(("upper_arm", "forearm", "hand"), sizes, strict=True)),
        mass=np.array([s.mass for s in taken.segments]),
        com=np.array([s.com for s in taken.segments]),
        inertia=np.array([s.inertia for s in taken.segments]),
        gravity=gravity,
        up=up,
        forward=forward,
        source=source,
    )


def _compile(file: Path) -> tuple[mujoco.MjModel, dict[str, float], bool]:
    """Compile a file; give joints that it fixes, and whether it is a URDF."""
    if not file.is_file():
        raise FileFormatError(f"{file}: there is no such file")
    try:
        root = ET.fromstring(file.read_bytes())
        if root.tag == "robot":
            return *_compile_urdf(root), True
        if root.tag != "mujoco":
            raise FileFormatError(
                f"{file}: the root element is <{root.tag}>; expected <mujoco> or <robot>"
            )
        return mujoco.MjSpec.from_file(str(file)).compile(), {}, False
    except ET.ParseError as error:
        raise FileFormatError(f"{file}: not well-formed XML ({error})") from None
    except FileFormatError:
        raise
    except (ValueError, mujoco.FatalError) as error:
        raise FileFormatError(f"{file}: {' '.join(str(error).split())}") from None


def _compile_urdf(root: ET.Element) -> tuple[mujoco.MjModel, dict[str, float]]:
    for link in root.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    spec.compiler.fusestatic = False  # or fixed links lose their names
    spec.compiler.boundmass = spec.compiler.boundinertia = _TINY
    known = {equality.name1 for equality in spec.equalities}
    fixed: dict[str, float] = {}
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        limit, mimic = joint.find("limit"), joint.find("mimic")
        if limit is not None and joint.get("type") in ("revolute", "prismatic"):
            low, high = (float(limit.get(key, "0")) for key in ("lower", "upper"))
            if low == high:
                fixed[name] = low
        if mimic is not None and name not in known:
            slope, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
            spec.add_equality(
                type=mujoco.mjtEq.mjEQ_JOINT,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                name1=name,
                name2=mimic.get("joint", ""),
                data=[offset, slope] + 9 * [0.0],
            )
    model = spec.compile()
    model.body_mass[model.body_mass <= _TINY] = 0.0
    model.body_inertia[model.body_inertia <= _TINY] = 0.0
    return model, fixed


def _directions(
    gravity: np.ndarray, up: tuple[float, float, float] | None, *, is_urdf: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Give the upward direction and gravity."""
    if up is None:
        upward = -unit("gravity", gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])
        return upward, gravity
    upward = unit("up", up)
    return upward, -9.81 * upward if is_urdf else gravity


def _forward(up: np.ndarray, forward: tuple[float, float, float] | None) -> np.ndarray:
    if forward is not None:
        ahead = unit("forward", forward)
        if abs(ahead @ up) > 0.9:
            raise RangeError(f"forward = {list(forward)}: must point across up, {up.tolist()}")
        return ahead
    x, y, _ = np.eye(3)
    return x if abs(up[0]) < 0.9 else y


def _landmarks(taken: MujocoChain, choices: ModelChoices) -> dict[str, Tip]:
    model, n_joints = taken.model, len(taken.chain.names)
    sites, bodies = _site_names(model), _body_names(model)
    if not (choices.tip or sites or bodies):
        raise ModelError("no site or body has a name; name at least the one that is the hand")
    hand = taken.tip(choices.tip or (sites or bodies)[-1])
    origins = [Tip(i, transform()) for i in range(n_joints)]
    found = {
        "shoulder": origins[0],
        "elbow": origins[_middle_joint(taken, origins)],
        "wrist": origins[-1],
        "hand": hand,
    }
    names = sites + bodies
    for landmark, words in _WORDS.items():
        exact = [name for name in names if name.lower() == landmark]
        similar = [name for name in names if any(word in name.lower() for word in words)]
        if exact or similar:
            found[landmark] = taken.tip((exact or similar)[0])
    for landmark, name in choices.landmarks.items():
        found[landmark] = taken.tip(name)
    return found


def _middle_joint(taken: MujocoChain, origins: list[Tip]) -> int:
    """Give the joint that is farthest, along the chain, from both the first and the last."""
    home = np.clip(np.zeros(taken.chain.n_coordinates), taken.chain.lower, taken.chain.upper)
    points = tip_positions(taken.chain, home, origins)[0]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return int(np.argmax(np.minimum(along, along[-1] - along)))


def _site_names(model: mujoco.MjModel) -> list[str]:
    return [model.site(i).name for i in range(model.nsite) if model.site(i).name]


def _body_names(model: mujoco.MjModel) -> list[str]:
    return [model.body(i).name for i in range(1, model.nbody) if model.body(i).name]
