"""The joint ranges that a person sets in the studio, and the splint."""

from dataclasses import dataclass, field

import numpy as np

from selfmotion.errors import RangeError, unknown_name
from selfmotion.kinematics.arm import Arm


@dataclass(frozen=True)
class Splint:
    """What a splint holds: a joint and its range (degrees)."""

    joint: str = "elbow_flexion"
    range_deg: tuple[float, float] = (64.2, 114.0)


@dataclass
class Ranges:
    """The ranges that a person has set for the joints of an arm.

    Attributes:
        arm: with the model's own limits.
        limits_deg: joint to its range (degrees), where it has been changed.
        splint: the splint, if it is on.
    """

    arm: Arm
    limits_deg: dict[str, tuple[float, float]] = field(default_factory=dict)
    splint: Splint | None = None

    def own_deg(self, joint: str) -> tuple[float, float]:
        """Give the model's own range of a joint (degrees)."""
        i = self.arm.chain.index(joint)
        return float(np.degrees(self.arm.lower[i])), float(np.degrees(self.arm.upper[i]))

    def set(self, joint: str, low: float, high: float) -> None:
        """Set a range (degrees); it is kept inside the model's own.

        Raises:
            UnknownNameError: there is no such joint.
            RangeError: low is above high, or nothing of the model's range is left.
        """
        if joint not in self.arm.joints:
            raise unknown_name("joint", joint, self.arm.joints)
        own = self.own_deg(joint)
        kept = (max(low, own[0]), min(high, own[1]))
        if not kept[0] <= kept[1]:
            raise RangeError(
                f"{joint}: {low:g} to {high:g} degrees leaves nothing of the model's range, "
                f"{own[0]:.1f} to {own[1]:.1f}"
            )
        self.limits_deg[joint] = kept

    def limited(self) -> Arm:
        """Give the arm with these ranges; the splint takes what it takes.

        Raises:
            RangeError: the splint leaves nothing of a range.
        """
        ranges = dict(self.limits_deg)
        if self.splint is not None and self.splint.joint in self.arm.joints:
            own = ranges.get(self.splint.joint, self.own_deg(self.splint.joint))
            low = max(own[0], self.splint.range_deg[0])
            high = min(own[1], self.splint.range_deg[1])
            if not low <= high:
                raise RangeError(f"{self.splint.joint}: the splint leaves nothing of its range")
            ranges[self.splint.joint] = (low, high)
        return self.arm.with_limits({j: _radians(r) for j, r in ranges.items()})


def _radians(pair: tuple[float, float]) -> tuple[float, float]:
    low, high = np.radians(pair)
    return float(low), float(high)
