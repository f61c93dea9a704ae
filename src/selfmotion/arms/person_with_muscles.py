"""The myo-sim arm with muscles for a person: each segment at its own length.

Rules of scaling, each a stated choice:

- geometry: a segment grows evenly in all directions by one factor, its measured length over the
  model's: the places of joints, of the points of muscle paths and of the bodies that they wrap
  over, and the radii of these. So a path stays exact, and the moment arms stay minus the
  derivative of length. Trunk and shoulder girdle grow by the clavicle's factor; where that was
  not measured, by the mean of the three others. The ground's origin is the centre of the scaling;
- muscles: fibre and tendon grow by one ratio a muscle, its path's mean length in the new arm over
  that in the model, over postures spread evenly within the joint limits: in the mean a muscle
  works at the same normalised lengths as in the model;
- mass: a segment's mass grows with its volume, the cube of its factor; if a share of the model's
  mass is given, all are then brought to it. If the body mass is given instead, upper arm, forearm
  and hand weigh their shares of it (de Leva 1996, mean of women and men: 2.63, 1.50 and 0.585 %),
  and clavicle and scapula change by the ratio of these three together;
- strength: greatest forces stay (`constant`), follow each muscle's cross-section, the square of its
  ratio (`area`), or follow the arm's mass to the power 2/3 (`mass`).

With all factors alike this is `scale_to_person`. Joint limits stay as they are.
"""

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import mujoco
import numpy as np
from jaxtyping import Float

from selfmotion.arms._body import mean_share
from selfmotion.arms._myoarm import SIDE, arm_of_myo_sim
from selfmotion.arrays import halton, require_between
from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.forward import tip_positions
from selfmotion.muscles.fitted import STRENGTHS
from selfmotion.muscles.geometry import MuscleGeometry, MusculoskeletalArm
from selfmotion.muscles.hill import MuscleSet, StiffTendonForces
from selfmotion.muscles.mujoco_bridge import load_myo_sim, muscles_from_mujoco

# Segment: the landmarks at its ends, and the first body of the model that belongs to it; what
# comes before the upper arm (trunk and girdle) belongs to the clavicle.
SEGMENTS = {
    "clavicle": ("sternoclavicular", "shoulder", ""),
    "upper_arm": ("shoulder", "elbow", "humphant"),
    "forearm": ("elbow", "wrist", "ulna"),
    "hand": ("wrist", "middle_knuckle", "lunate"),
}
GIRDLE = "clavicle"
# Segments whose share of the body mass is known.
WEIGHED = ("upper_arm", "forearm", "hand")
BODY_MASSES = (2.0, 400.0)  # kg, allowed
# Lengths (m) that an arm may have, as shares of the model's.
LEAST, GREATEST = 0.4, 2.5
# Postures, spread over the limits, over which path lengths are averaged.
N_POSTURES = 64


@dataclass(frozen=True)
class PersonSize:
    """How large, heavy and strong a person's arm is.

    Attributes:
        lengths: segment to length (m): `clavicle` (sternoclavicular joint to shoulder centre),
            `upper_arm` (shoulder centre to elbow centre), `forearm` (elbow centre to wrist
            centre), `hand` (wrist centre to middle knuckle). Left out, a segment keeps the
            model's length, the clavicle the mean factor of the three others.
        mass: the arm's mass as a share of the model's; left out: by the cubes of the factors.
        body_mass: mass of the whole body (kg), instead of `mass`.
        strength: constant, area or mass (see the module).
    """

    lengths: Mapping[str, float]
    mass: float | None = None
    strength: str = "area"
    body_mass: float | None = None

    def __post_init__(self) -> None:
        """Check names and ranges; the lengths are checked against the model."""
        for segment in self.lengths:
            if segment not in SEGMENTS:
                raise unknown_name("segment", segment, tuple(SEGMENTS))
        if self.mass is not None:
            require_between("mass", self.mass, 0.01, 100.0)
        if self.body_mass is not None:
            require_between("body mass (kg)", self.body_mass, *BODY_MASSES)
            if self.mass is not None:
                raise RangeError(f"mass = {self.mass:g}: body_mass is given already; leave one out")
        if self.strength not in STRENGTHS:
            raise unknown_name("strength", self.strength, STRENGTHS)


def myoarm_lengths() -> dict[str, float]:
    """Give the segment lengths (m) of the myo-sim arm as `myoarm_of_person` counts them.

    Example:
        >>> {segment: round(length, 3) for segment, length in myoarm_lengths().items()}
        {'clavicle': 0.147, 'upper_arm': 0.291, 'forearm': 0.258, 'hand': 0.082}
    """
    return _lengths(_generic()[1])


@lru_cache(maxsize=1)
def _generic() -> tuple[mujoco.MjModel, Arm]:
    """Compile the model once, which takes seconds; people's arms are copies of it."""
    generic = load_myo_sim("myoarm")
    return generic, arm_of_myo_sim(generic)


def myoarm_of_person(size: PersonSize, *, convention: str = "plain") -> MusculoskeletalArm:
    """Give the myo-sim arm with muscles at a person's segment lengths.

    For a left arm, hand the result to `mirror_muscles`. The lengths that `calibrate_person` finds
    (``person.lengths``) can be given as they are.

    Args:
        size: segment lengths (m), and the rules for mass and strength.
        convention: how effort is computed (see `muscles.static_optimization`).

    Raises:
        RangeError: a length is not between 0.4 and 2.5 times the model's.
        UnknownNameError: there is no such segment, rule of strength or convention.

    Example:
        >>> model = myoarm_of_person(PersonSize({"upper_arm": 0.31, "forearm": 0.25}))
        >>> round(model.arm.lengths["upper_arm"], 3), round(model.arm.lengths["forearm"], 3)
        (0.31, 0.25)
    """
    generic, standard = _generic()
    factors = _factors(size, _lengths(standard))
    of_body = _factor_of_body(generic, factors)
    scaled = _scaled_model(generic, of_body)
    _weigh(scaled, generic, of_body, standard, size)
    arm = arm_of_myo_sim(scaled)
    said = ", ".join(f"{name} {factor:.4g}" for name, factor in factors.items())
    heavy = "" if size.body_mass is None else f"; body mass {size.body_mass:g} kg"
    arm = replace(arm, source=f"{arm.source}; scaled to a person by {said}{heavy}")
    muscles, inner, forces = muscles_from_mujoco(generic, standard.chain)
    geometry = muscles_from_mujoco(scaled, arm.chain)[1]
    ratio = _path_ratio(geometry, inner, arm)
    share = float(arm.mass.sum() / standard.mass.sum())
    strength = {"constant": 1.0, "area": ratio**2, "mass": share ** (2 / 3)}[size.strength]
    relaxed = muscles if forces.passive_muscles is None else forces.passive_muscles
    own, own_relaxed = (_scaled_muscles(m, ratio, strength) for m in (muscles, relaxed))
    return MusculoskeletalArm(
        arm, own, geometry, StiffTendonForces(own, forces.curves, own_relaxed), convention
    )


def _lengths(arm: Arm) -> dict[str, float]:
    home = np.clip(np.zeros(arm.n_joints), arm.lower, arm.upper)
    out = {}
    for segment, (near, far, _) in SEGMENTS.items():
        points = tip_positions(arm.chain, home, [arm.tip(near), arm.tip(far)])[0]
        out[segment] = float(np.linalg.norm(points[1] - points[0]))
    return out


def _factors(size: PersonSize, standard: Mapping[str, float]) -> dict[str, float]:
    """Give the factor of each segment."""
    factors = {}
    for segment, length in standard.items():
        wanted = float(size.lengths.get(segment, length))
        require_between(f"length of {segment} (m)", wanted, LEAST * length, GREATEST * length)
        factors[segment] = wanted / length
    if GIRDLE not in size.lengths:
        factors[GIRDLE] = float(np.mean([factors[name] for name in SEGMENTS if name != GIRDLE]))
    return factors


def _factor_of_body(
    model: mujoco.MjModel, factors: Mapping[str, float]
) -> Float[np.ndarray, " bodies"]:
    """Give the factor of each body of the model: that of the segment it is on."""
    return np.array([factors[segment] for segment in _segment_of_body(model)])


def _segment_of_body(model: mujoco.MjModel) -> list[str]:
    first = {body + SIDE: segment for segment, (_, _, body) in SEGMENTS.items() if body}
    out = [GIRDLE]
    for body in range(1, model.nbody):
        segment = first.get(model.body(body).name)
        out.append(out[model.body_parentid[body]] if segment is None else segment)
    return out


def _scaled_model(model: mujoco.MjModel, of_body: Float[np.ndarray, " bodies"]) -> mujoco.MjModel:
    """Give a copy in which all that is fixed to a body has that body's factor."""
    out = copy.deepcopy(model)
    out.body_pos[:] = of_body[model.body_parentid][:, None] * model.body_pos
    out.body_ipos[:] = of_body[:, None] * model.body_ipos
    out.jnt_pos[:] = of_body[model.jnt_bodyid][:, None] * model.jnt_pos
    out.site_pos[:] = of_body[model.site_bodyid][:, None] * model.site_pos
    out.geom_pos[:] = of_body[model.geom_bodyid][:, None] * model.geom_pos
    out.geom_size[:] = of_body[model.geom_bodyid][:, None] * model.geom_size
    return out


def _weigh(
    out: mujoco.MjModel,
    model: mujoco.MjModel,
    of_body: Float[np.ndarray, " bodies"],
    standard: Arm,
    size: PersonSize,
) -> None:
    """Set masses and inertias: the cubes of the factors, then the mass that is wanted."""
    ratio = of_body**3
    out.body_mass[:] = ratio * model.body_mass
    if size.mass is not None:
        ratio = ratio * size.mass * standard.mass.sum() / arm_of_myo_sim(out).mass.sum()
    elif size.body_mass is not None:
        ratio = _ratio_of_mass(model, size.body_mass)
    out.body_mass[:] = ratio * model.body_mass
    out.body_inertia[:] = (ratio * of_body**2)[:, None] * model.body_inertia


def _ratio_of_mass(model: mujoco.MjModel, body_mass: float) -> Float[np.ndarray, " bodies"]:
    """Give the factor of each body's mass that brings the segments to their shares."""
    of_body = np.array(_segment_of_body(model))
    weights = {segment: model.body_mass[of_body == segment].sum() for segment in WEIGHED}
    wanted = {segment: body_mass * mean_share(segment) for segment in WEIGHED}
    ratio = {segment: wanted[segment] / weights[segment] for segment in WEIGHED}
    ratio[GIRDLE] = sum(wanted.values()) / sum(weights.values())
    return np.array([ratio[segment] for segment in of_body])


def _path_ratio(
    here: MuscleGeometry, there: MuscleGeometry, arm: Arm
) -> Float[np.ndarray, " muscles"]:
    spread = halton(N_POSTURES, arm.n_joints)
    q = arm.lower + spread * (arm.upper - arm.lower)
    return here.lengths(q).mean(axis=0) / there.lengths(q).mean(axis=0)


def _scaled_muscles(
    muscles: MuscleSet,
    ratio: Float[np.ndarray, " muscles"],
    strength: float | Float[np.ndarray, " muscles"],
) -> MuscleSet:
    return replace(
        muscles,
        max_force=strength * muscles.max_force,
        fibre=ratio * muscles.fibre,
        tendon=ratio * muscles.tendon,
    )
