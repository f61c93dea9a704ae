"""Does a law fitted to some movements of a person predict the postures of the others?

What is predicted is the swivel angle at the place where the wrist was. Beside the law of least
elastic energy stand the mean posture, the repeats of the same task (same moment of the movement),
and the quadratic surface of the upper arm: of all postures that hold the wrist, the one on it. All
of them, the law too, see the wrist's recorded place; none sees the swivel angle that they predict.

Left out in turn are a repeat of every task (has the person done it before?) and a whole task (does
the law carry over?). The law needs a prior, which is stated here: thirteen parameters of four
joints are more than such postures tell, and the elbow's stiffness cannot be told by any, since the
elbow does not move in the self-motion.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float

from selfmotion.kinematics.swivel import swivel_angle
from selfmotion.methods.donders import ElasticityPrior, JointElasticity, fit_elasticity
from selfmotion.methods.elasticity.posture import donders_postures
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.predictors.observation import angle_between, mean_angle
from selfmotion.spatial import exp_rotation
from selfmotion.studies.donders_postures import PersonPostures
from selfmotion.studies.donders_surfaces import surface_of

if TYPE_CHECKING:
    import pandas as pd

# The prior: stiffness alike in all joints, trace 4 N m/rad; its standard deviations.
SHOULDER_SD, COUPLING_SD, ELBOW_SD, REST_SD = 0.5, 0.2, 0.02, np.radians(30.0)
PRIOR = (
    "equal stiffness (shoulder 1 ± 0.5, elbow 1 ± 0.02, couplings 0 ± 0.2 N m/rad), rest posture "
    "median ± 30 deg"
)
LAW, SURFACE, MEAN, REPEATS = "elasticity", "quadratic surface", "mean posture", "other repeats"
EFFORT = "muscle effort"
PREDICTORS = (LAW, SURFACE, MEAN, REPEATS)
REPEAT, TASK = "repeat", "task"
# How far from the mean swivel angle a posture on the surface is looked for (rad).
SEARCH, STEP = np.radians(90.0), np.radians(1.0)


@dataclass(frozen=True, eq=False)
class Fold:
    """One part of a person's postures left out.

    Attributes:
        kind: repeat or task.
        name: which.
        held: (K,) postures left out.
    """

    kind: str
    name: str
    held: Bool[np.ndarray, " samples"]

    def training(self, postures: PersonPostures) -> Bool[np.ndarray, " samples"]:
        """Give the postures that are fitted: on the path of what is not left out."""
        return postures.on_path & ~self.held


def folds(postures: PersonPostures) -> Iterator[Fold]:
    """Leave out each repeat, then each task."""
    for kind, labels in ((REPEAT, postures.trial), (TASK, postures.condition)):
        names = dict.fromkeys(labels.tolist())
        if len(names) > 1:
            yield from (Fold(kind, name, labels == name) for name in names)


def prior_for(q: Float[np.ndarray, "samples joints"]) -> ElasticityPrior:
    """Give what is assumed of a person's law before the postures q are seen; see `PRIOR`."""
    n = q.shape[1]
    sd = np.full((n, n), COUPLING_SD)
    sd[np.diag_indices(n)] = SHOULDER_SD
    sd[-1, :] = sd[:, -1] = ELBOW_SD
    return ElasticityPrior(np.eye(n), sd, np.median(q, axis=0), np.full(n, REST_SD), PRIOR)


def fit_law(postures: PersonPostures, some: Bool[np.ndarray, " samples"]) -> JointElasticity:
    """Fit the law to some of a person's postures; those of one movement depend on each other."""
    q = postures.q[some]
    return fit_elasticity(q, task=postures.task, prior=prior_for(q), trials=postures.movement[some])


def fold_laws(postures: PersonPostures) -> dict[tuple[str, str], JointElasticity]:
    """Fit one law for each fold: (kind, name) to law."""
    return {(f.kind, f.name): fit_law(postures, f.training(postures)) for f in folds(postures)}


def prediction_table(
    postures: PersonPostures, laws: dict[tuple[str, str], JointElasticity]
) -> "pd.DataFrame":
    """Predict what was left out.

    Returns:
        A table, one row a fold, predictor and posture: recorded and predicted swivel angle (rad),
        and their difference (`error_deg`).
    """
    import pandas as pd

    rows = []
    natural = postures.swivel(postures.q)
    for fold in folds(postures):
        held = np.flatnonzero(fold.held)
        said = predictions(postures, fold, laws[fold.kind, fold.name])
        for name, angles in said.items():
            rows.append(
                pd.DataFrame(
                    {
                        "subject": postures.subject,
                        "side": postures.side,
                        "left_out": fold.kind,
                        "task": postures.condition[held],
                        "trial": postures.trial[held],
                        "moment": postures.moment[held],
                        "predictor": name,
                        "recorded": natural[held],
                        "predicted": angles,
                        "error_deg": np.degrees(angle_between(angles, natural[held])),
                    }
                )
            )
    return pd.concat(rows, ignore_index=True)


def predictions(
    postures: PersonPostures, fold: Fold, fit: JointElasticity
) -> dict[str, Float[np.ndarray, " held"]]:
    """Give the swivel angles (rad) that each predictor says for the postures left out.

    A law whose fit failed says nothing (NaN).
    """
    q = postures.q[fold.held]
    training = fold.training(postures)
    middle = mean_angle(postures.swivel(postures.q[training]))
    said = {
        LAW: swivel_of_law(postures, fit.law(), q) if fit.status.ok else np.full(len(q), np.nan),
        SURFACE: swivel_on_surface(postures, fold, middle),
        MEAN: np.full(len(q), middle),
    }
    if fold.kind == REPEAT:
        said[REPEATS] = _of_repeats(postures, fold)
    return said


def swivel_of_law(
    postures: PersonPostures, law: JointLaw, q: Float[np.ndarray, "samples joints"]
) -> Float[np.ndarray, " samples"]:
    """Give the swivel angle of least elastic energy where the wrist is; NaN where there is none."""
    found = donders_postures(postures.task, law, postures.task.value(q))
    angles = np.full(len(q), np.nan)
    if found.least.any():
        angles[found.least] = postures.swivel(found.q[found.least])
    return angles


def swivel_on_surface(
    postures: PersonPostures, fold: Fold, middle: float
) -> Float[np.ndarray, " held"]:
    """Give the swivel angle at which the upper arm lies on the surface of the other postures.

    Of several the one nearest to their mean angle; where there is none, the nearest approach.
    """
    surface = surface_of(postures, "shoulder", fold.training(postures))
    S, E, W = np.swapaxes(postures.points(postures.q[fold.held]), 0, 1)
    R = postures.rotations["shoulder"][fold.held]
    line = (W - S) / np.linalg.norm(W - S, axis=1, keepdims=True)
    turns = np.arange(-np.pi, np.pi, STEP)
    out = np.full(len(R), np.nan)
    for k in range(len(R)):
        spin = exp_rotation(turns[:, None] * line[k])
        angles = swivel_angle(S[k], S[k] + spin @ (E[k] - S[k]), W[k], down=-postures.arm.up)
        away = angle_between(angles, middle)
        near = np.flatnonzero(np.abs(away) < SEARCH)
        near = near[np.argsort(away[near])]
        if near.size:
            out[k] = middle + _crossing(away[near], surface.residual(spin[near] @ R[k]))
    return out


def _crossing(at: np.ndarray, residual: np.ndarray) -> float:
    """Give where the residual is zero, nearest to 0; else where it is least."""
    change = np.flatnonzero(np.sign(residual[1:]) != np.sign(residual[:-1]))
    if not change.size:
        return float(at[np.argmin(np.abs(residual))])
    a, b = residual[change], residual[change + 1]
    zeros = at[change] + (at[change + 1] - at[change]) * a / (a - b)
    return float(zeros[np.argmin(np.abs(zeros))])


def _of_repeats(postures: PersonPostures, fold: Fold) -> np.ndarray:
    """Give the mean of the same moment of the same task in the other repeats."""
    natural = postures.swivel(postures.q)
    out = []
    for k in np.flatnonzero(fold.held):
        same = ~fold.held & (postures.condition == postures.condition[k])
        same &= (postures.moment == postures.moment[k]) & (postures.phase == postures.phase[k])
        out.append(mean_angle(natural[same]))
    return np.array(out)
