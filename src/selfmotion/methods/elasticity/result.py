"""What a fit of the joint law gives: numbers, errors, and plain sentences on both."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.arrays import as_float_array, freeze, require_shape
from selfmotion.errors import RangeError, Status
from selfmotion.methods.elasticity.fit import entries, symmetric
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

# Standard error over value above which a stiffness counts as not told by the data.
TOLD = 0.5
# Weight below which a posture counts as a stray: it lies four noise widths off, or farther.
STRAY = 0.5
# Standard error above which a rest angle counts as not told (rad).
REST_TOLD = np.radians(5.0)


@dataclass(frozen=True, eq=False)
class ElasticityPrior:
    """What is known about a law beforehand, as independent normal distributions.

    Attributes:
        stiffness: (n, n) mean of K^J at the trace of the fit (N m/rad).
        stiffness_sd: (n, n) its standard deviations; infinite where nothing is known.
        rest: (n,) mean of q* (rad).
        rest_sd: (n,) its standard deviations (rad).
        source: where it comes from, for the result.

    Raises:
        ShapeError: the arrays do not fit each other.
        RangeError: a standard deviation is not above 0.
    """

    stiffness: Float[np.ndarray, "joints joints"]
    stiffness_sd: Float[np.ndarray, "joints joints"]
    rest: Float[np.ndarray, " joints"]
    rest_sd: Float[np.ndarray, " joints"]
    source: str = "given"

    def __post_init__(self) -> None:
        """Check everything."""
        n = len(self.rest)
        shapes = {"stiffness": (n, n), "stiffness_sd": (n, n), "rest": (n,), "rest_sd": (n,)}
        for name, shape in shapes.items():
            array = as_float_array(name, getattr(self, name)).copy()
            require_shape(f"prior {name}", array, shape)
            if name.endswith("_sd") and not (array > 0.0).all():
                raise RangeError(f"prior {name}: every standard deviation must be above 0")
            object.__setattr__(self, name, freeze(array))

    def refuse_misfit(self, n: int) -> None:
        """Check that the prior is about n joints."""
        require_shape("prior rest", self.rest, (n,))

    def rows(self, K: np.ndarray, rest: np.ndarray, trace: float) -> tuple[np.ndarray, np.ndarray]:
        """Give the rows A and right-hand side b of the least squares that the prior adds."""
        where = entries(len(rest))
        sd = np.concatenate([self.stiffness_sd[where], self.rest_sd])
        mean = np.concatenate(
            [self.stiffness[where] * (trace / np.trace(self.stiffness)), self.rest]
        )
        at = np.concatenate([K[where], rest])
        return np.diag(1.0 / sd), (mean - at) / sd


@dataclass(frozen=True, eq=False)
class JointElasticity:
    """A person's joint law from postures.

    Attributes:
        stiffness: (n, n) K^J (N m/rad); postures fix it up to its trace.
        rest: (n,) q* (rad).
        stiffness_stderr: (n, n) standard errors; NaN where the data determine nothing.
        rest_stderr: (n,) standard errors (rad).
        covariance: (p, p) of the entries of K^J (lower triangle row by row), then q*.
        distance: (K, r) of each posture from the law's surface along the self-motion (rad).
        thickness: standard deviation of that distance (rad), strays left out.
        weights: (K,) between 0 and 1: less than 1 for postures far off, 0 past a fold.
        sentences: what the data can and cannot tell.
        status: whether the fit settled on an unfolded surface.
        joints: names of the joints.
        prior: the prior used, if any.
        provenance: what made it.
    """

    stiffness: Float[np.ndarray, "joints joints"]
    rest: Float[np.ndarray, " joints"]
    stiffness_stderr: Float[np.ndarray, "joints joints"]
    rest_stderr: Float[np.ndarray, " joints"]
    covariance: Float[np.ndarray, "parameters parameters"]
    distance: Float[np.ndarray, "samples free"]
    thickness: float
    weights: Float[np.ndarray, " samples"]
    sentences: tuple[str, ...]
    status: Status
    joints: tuple[str, ...]
    prior: ElasticityPrior | None
    provenance: Provenance

    @property
    def thickness_deg(self) -> float:
        """Thickness of the surface in degrees."""
        return float(np.degrees(self.thickness))

    def law(self, *, damping_time: float = 0.08, spring_time: float = 0.08) -> JointLaw:
        """Give the law for planning, with time constants (s)."""
        return JointLaw(self.stiffness, self.rest, damping_time, spring_time)

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a parameter: name, value, standard error, unit."""
        import pandas as pd

        rows = []
        for i, j in zip(*entries(len(self.rest)), strict=True):
            pair = self.joints[i] if i == j else f"{self.joints[j]} x {self.joints[i]}"
            rows.append(
                {
                    "parameter": f"stiffness {pair}",
                    "value": self.stiffness[i, j],
                    "stderr": self.stiffness_stderr[i, j],
                    "unit": "N m/rad",
                }
            )
        for i, joint in enumerate(self.joints):
            rows.append(
                {
                    "parameter": f"rest {joint}",
                    "value": self.rest[i],
                    "stderr": self.rest_stderr[i],
                    "unit": "rad",
                }
            )
        return pd.DataFrame(rows)


def findings(
    law: tuple[np.ndarray, np.ndarray],
    certainty: tuple[Float[np.ndarray, "p p"], Bool[np.ndarray, " p"]],
    *,
    distance: np.ndarray,
    used: tuple[np.ndarray, Status],
    joints: tuple[str, ...],
    prior: ElasticityPrior | None,
    provenance: Provenance,
) -> JointElasticity:
    """Put a fit into words."""
    K, rest = law
    covariance, known = certainty
    weights, status = used
    n = len(rest)
    near = weights >= STRAY
    kept = distance[near] if near.any() else distance
    stderr = np.where(known, np.sqrt(np.maximum(covariance.diagonal(), 0.0)), np.nan)
    K_stderr = symmetric(stderr[:-n], n)
    sentences = [_on_stiffness(K, K_stderr, joints), _on_rest(stderr[-n:], joints)]
    sentences += _on_strays(distance, weights)
    if prior is not None:
        sentences.append(f"a prior was used ({prior.source}): errors include it")
    if not status.ok:
        sentences.insert(0, status.sentence)
    return JointElasticity(
        stiffness=K,
        rest=rest,
        stiffness_stderr=K_stderr,
        rest_stderr=stderr[-n:],
        covariance=covariance,
        distance=distance,
        thickness=float(np.sqrt((kept**2).mean())),
        weights=weights,
        sentences=tuple(sentences),
        status=status,
        joints=joints,
        prior=prior,
        provenance=provenance,
    )


def _on_stiffness(K: np.ndarray, stderr: np.ndarray, joints: tuple[str, ...]) -> str:
    with np.errstate(invalid="ignore"):
        weak = [i for i in range(len(joints)) if not stderr[i, i] < TOLD * K[i, i]]
    if not weak:
        return "the stiffness of every joint is told by these postures, up to one common factor"
    named = ", ".join(f"{joints[i]} ({K[i, i]:.2g} ± {stderr[i, i]:.2g} N m/rad)" for i in weak)
    return (
        f"these postures cannot tell the stiffness of {named}; wider targets (30°) or a prior would"
    )


def _on_strays(distance: np.ndarray, weights: np.ndarray) -> list[str]:
    """Say how many postures hardly count, and why."""
    past, far = int((weights == 0.0).sum()), int(((weights > 0.0) & (weights < STRAY)).sum())
    said = []
    if past:
        said.append(f"{past} of {len(weights)} postures lie past a fold of the law's surface")
    if far:
        said.append(f"{far} of {len(weights)} postures lie far off and count less")
    if said and past + far < len(weights):
        whole = np.degrees(np.sqrt((distance**2).mean()))
        said.append(f"the thickness leaves these postures out (with them: {whole:.2g}°)")
    return said


def _on_rest(stderr: np.ndarray, joints: tuple[str, ...]) -> str:
    weak = [joints[i] for i in range(len(joints)) if not stderr[i] < REST_TOLD]
    if not weak:
        return "the rest posture is told to within 5° in every joint"
    return f"the rest posture is not told to within 5° in {', '.join(weak)}"
