"""An arm some of whose joints are held: a law for the others only, in fits as in plans."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from selfmotion.errors import ModelError, RangeError
from selfmotion.kinematics.arm import Arm
from selfmotion.kinematics.chain import Coupling


def hold_joints(arm: Arm, held: Mapping[str, float]) -> Arm:
    """Give the arm with some joints held at values; q then lists the others, in their order.

    Args:
        arm: any.
        held: joint to its value (rad or m).

    Raises:
        UnknownNameError: a joint does not exist.
        RangeError: no joint is left, or a value is not finite.
        ModelError: a joint follows a held one along a curve.

    Example:
        >>> from selfmotion.arms import exoskeleton
        >>> hold_joints(exoskeleton(), {"elbow_flexion": 1.0}).joints
        ('shoulder_elevation', 'shoulder_rotation', 'shoulder_flexion')
    """
    chain, coupling = arm.chain, arm.chain.coupling
    fixed = [chain.index(joint) for joint in held]
    values = np.array(list(held.values()), dtype=np.float64)
    for joint, value in held.items():
        if not np.isfinite(value):
            raise RangeError(f"{joint} held at {value}: a finite value is needed")
    free = [i for i in range(arm.n_joints) if i not in fixed]
    if not free:
        raise RangeError(f"held: all {arm.n_joints} joints of {arm.name!r}; at least one must move")
    for curve in coupling.curves:
        if curve.coordinate in fixed:
            name = coupling.coordinates[curve.coordinate]
            raise ModelError(f"{name}: {chain.names[curve.joint]} follows it along a curve")
    place = {old: new for new, old in enumerate(free)}
    kept = Coupling(
        tuple(coupling.coordinates[i] for i in free),
        coupling.matrix[:, free].copy(),
        coupling.offset + coupling.matrix[:, fixed] @ values,
        tuple(replace(c, coordinate=place[c.coordinate]) for c in coupling.curves),
    )
    lower, upper = chain.lower[free].copy(), chain.upper[free].copy()
    return replace(arm, chain=replace(chain, lower=lower, upper=upper, coupling=kept))
