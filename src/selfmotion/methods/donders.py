"""Fit a person's joint elasticity to postures alone: Donders' law as [Tommasino2017] reads it.

doi 10.3389/fnbot.2017.00065; the inverse optimisation is that of Tommasino & Campolo 2016 in
purpose, not in detail. For each target a person takes the posture of least elastic energy
½(q - q*)ᵀK^J(q - q*); K^J (up to a scale: its trace is set to 4 N m/rad) and q* follow from where
postures lie on the self-motion. The distance of a posture from the law's surface is minimised, not
the torque that remains: the latter is linear and exact without noise, but with half a degree of it
the stiffness of pronation collapses to nothing.

Deviations: fits all postures, not a quadratic surface through them, since such a surface has six
parameters and the law eight; gives standard errors, and says which entries the data cannot tell.
"""

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array, require_shape
from selfmotion.errors import RangeError, ShapeError, Status
from selfmotion.methods.elasticity.fit import PostureGeometry, entries
from selfmotion.methods.elasticity.orientations import Form, wrist_angles
from selfmotion.methods.elasticity.result import (
    STRAY,
    ElasticityPrior,
    JointElasticity,
    findings,
)
from selfmotion.methods.elasticity.search import (
    FOLDED,
    SPARE,
    Fit,
    Problem,
    best_fit,
    from_the_middle,
    system,
)
from selfmotion.methods.passive.joint_law import TRACE
from selfmotion.methods.passive.tasks import arm_of
from selfmotion.provenance import Provenance, hash_arrays
from selfmotion.redundancy.task import Pointing, Task

__all__ = ["ElasticityPrior", "JointElasticity", "fit_elasticity"]

# Share of the postures that may lie far off the law's surface.
STRAYS = 0.1
# Share of the trace in one direction from which a collapsed stiffness has gone onto one joint.
ALONE = 0.9
# Smallest eigenvalue of the stiffness, as a share of its trace, below which it has collapsed.
COLLAPSED = 1e-3
# Root mean square distance of postures (rad) from a surface that they cannot be said to follow:
# people keep to theirs within 2 to 5 degrees.
TOO_THICK = np.radians(30.0)
# Second spread of the task values over the first, below which they lie on one line.
LINE = 1e-3
# Singular values of the scaled problem below this share of the largest count as zero.
RANK_TOLERANCE = 1e-9


def fit_elasticity(
    postures: ArrayLike,
    *,
    task: Task | None = None,
    form: Form = "angles",
    prior: ElasticityPrior | None = None,
    trials: ArrayLike | None = None,
    trace: float = TRACE,
) -> JointElasticity:
    """Fit stiffness and rest posture of the joints to postures ([Tommasino2017]).

    Args:
        postures: (K, n) joint angles (rad); for the wrist also rotation vectors (K, 3) (rad),
            quaternions (K, 4) as x, y, z, w, or matrices (K, 3, 3) of the hand, as `form` says.
        task: what the postures were taken for; left out: pointing with the wrist.
        form: "angles", "rotation vectors", "quaternions" or "matrices".
        prior: what is known about the law beforehand; stated in the result.
        trials: (K,) labels; postures with the same label are not independent of each other.
        trace: sum of the joint stiffnesses (N m/rad): postures say nothing about it.

    Returns:
        The law with standard errors and sentences on what the data can and cannot tell.

    Raises:
        ShapeError: shapes do not fit, or there are too few postures.
        NotFiniteError: a posture is not finite.
        RangeError: the postures lie on one line of the task, or at a singular posture.

    Example:
        >>> from selfmotion.arms import wrist
        >>> from selfmotion.methods.elasticity.posture import donders_postures
        >>> from selfmotion.methods.passive.joint_law import JointLaw
        >>> law = JointLaw(np.diag([0.5, 1.5, 2.0]), np.radians([5.0, 0.0, 0.0]))
        >>> angles = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
        >>> targets = np.concatenate([r * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        ...                           for r in (0.2, 0.4)])
        >>> q = donders_postures(Pointing(wrist()), law, targets).q
        >>> fit_elasticity(q).stiffness.diagonal().round(6).tolist()
        [0.5, 1.5, 2.0]
    """
    if task is None:
        from selfmotion.arms import wrist

        task = Pointing(wrist())
    q = _angles(task, postures, form)
    groups = _groups(trials, len(q))
    _refuse_poor_postures(task, q)
    if prior is not None:
        prior.refuse_misfit(q.shape[1])
    if not trace > 0.0:
        raise RangeError(f"trace = {trace:g} N m/rad: must be above 0")
    problem = Problem(PostureGeometry.of(task, q), prior, trace)
    fit = best_fit(problem, from_the_middle(task, q))
    covariance, known = _covariance(problem, fit, groups)
    choices = {"arm": arm_of(task).name, "form": form, "trace": trace, "loss": "Huber"}
    inputs = {"postures": hash_arrays(q)}
    if prior is not None:
        choices["prior"] = prior.source
    return findings(
        (fit.K, fit.rest),
        (covariance, known),
        distance=fit.found.delta,
        used=(fit.weights, _status(fit, arm_of(task).joints)),
        joints=arm_of(task).joints,
        prior=prior,
        provenance=Provenance("fit_elasticity", inputs=inputs, choices=choices),
    )


def _angles(task: Task, postures: ArrayLike, form: Form) -> np.ndarray:
    """Give checked joint angles (K, n)."""
    if form == "angles":
        array = as_float_array("postures", postures, ndim=2)
        return arm_of(task).chain.as_samples(array)
    if arm_of(task).joints != ("pronation", "flexion", "deviation"):
        raise RangeError(f"form = {form!r}: orientations are understood for the arm 'wrist' only")
    return wrist_angles(postures, form)


def _groups(trials: ArrayLike | None, n_samples: int) -> np.ndarray:
    """Number the groups of dependent postures."""
    if trials is None:
        return np.arange(n_samples)
    labels = np.asarray(trials)
    require_shape("trials", labels, (n_samples,))
    return np.unique(labels, return_inverse=True)[1]


def _refuse_poor_postures(task: Task, q: np.ndarray) -> None:
    n = q.shape[1]
    n_parameters = n * (n + 1) // 2 + n - 1
    if n <= len(task.units):
        raise ShapeError(f"task has {len(task.units)} rows for {n} joints: no self-motion is left")
    if len(q) < n_parameters + SPARE:
        raise ShapeError(
            f"postures: {len(q)} are too few for {n_parameters} parameters; "
            f"at least {n_parameters + SPARE} are needed"
        )
    x = task.value(q)
    spread = np.linalg.svd(x - x.mean(axis=0), compute_uv=False)
    if len(task.units) > 1 and not spread[1] > LINE * max(spread[0], 1e-12):
        raise RangeError(
            "postures: they point at one place, or along one line; a law needs targets in two "
            f"directions (spread {spread[1]:.2g} against {spread[0]:.2g})"
        )
    sizes = np.linalg.svd(task.jacobian(q), compute_uv=False)
    if not (sizes[:, -1] > 1e-6 * sizes[:, 0]).all():
        i = int(np.argmin(sizes[:, -1] / sizes[:, 0]))
        raise RangeError(f"postures[{i}]: the task's Jacobian has lost rank there")


def _covariance(
    problem: Problem, fit: Fit, groups: np.ndarray
) -> tuple[Float[np.ndarray, "parameters parameters"], Bool[np.ndarray, " parameters"]]:
    """Give the covariance of (entries of K, q*), and which of them the data determine at all.

    The sandwich: the spread of each group's pull on the law, so that neither unequal noise nor
    postures that depend on each other make the errors look small.
    """
    n = problem.n
    rows, columns = entries(n)
    basis = np.zeros((len(rows) + n, len(rows) + n - 1))
    on_diagonal = (rows == columns).astype(float)[None]
    basis[: len(rows), : len(rows) - 1] = np.linalg.svd(on_diagonal)[2][1:].T
    basis[len(rows) :, len(rows) - 1 :] = np.eye(n)
    A, b = system(problem, fit)
    A = A @ basis
    n_data = fit.found.delta.size
    scale = np.linalg.norm(A, axis=0)
    _, s, Vt = np.linalg.svd(A / scale, full_matrices=False)
    kept = s > RANK_TOLERANCE * s[0]
    half = basis / scale @ Vt.T
    bread = (half[:, kept] / s[kept] ** 2) @ Vt[kept] / scale  # to all parameters from scores
    scores = (A[:n_data] * b[:n_data, None]).reshape(len(groups), -1, A.shape[1]).sum(axis=1)
    n_groups = int(groups.max()) + 1
    pulls = np.zeros((n_groups, A.shape[1]))
    np.add.at(pulls, groups, scores)
    spare = max(n_groups - A.shape[1], 1)
    meat = pulls.T @ pulls * (n_groups / spare)
    meat = meat + fit.scale**2 * A[n_data:].T @ A[n_data:]
    lost = np.abs(half[:, ~kept]).max(axis=1, initial=0.0)
    return bread @ meat @ bread.T, lost < 1e-6 * np.abs(half).max()


def _status(fit: Fit, joints: tuple[str, ...]) -> Status:
    n = len(fit.weights)
    past = int((fit.weights == 0.0).sum())
    if past > FOLDED * n:
        return Status(
            False,
            f"{past} of {n} postures lie past a fold of the law's surface; leave out the farthest "
            "targets",
        )
    stray = int((fit.weights < STRAY).sum())
    if stray > STRAYS * n:
        return Status(
            False,
            f"{stray} of {n} postures do not lie on one surface with the others, or past its fold",
        )
    thickness = float(np.sqrt((fit.found.delta[fit.weights >= STRAY] ** 2).mean()))
    if thickness > TOO_THICK:
        off = f"{np.degrees(thickness):.0f}°"
        return Status(False, f"the postures lie {off} (rms) off the best surface: they follow none")
    values, vectors = np.linalg.eigh(fit.K)
    if has_collapsed(fit.K):
        return Status(False, _collapse(values, vectors, joints))
    if not fit.converged:
        return Status(False, "the fit did not settle: the postures do not determine the law")
    return Status(True, "fitted")


def has_collapsed(stiffness: Float[np.ndarray, "joints joints"]) -> bool:
    """Tell whether the joints have lost their stiffness in one direction, beside the others.

    Example:
        >>> has_collapsed(np.diag([1e-6, 2.0, 2.0])), has_collapsed(np.diag([0.5, 1.5, 2.0]))
        (True, False)
    """
    return bool(np.linalg.eigvalsh(stiffness)[0] < COLLAPSED * np.trace(stiffness))


def _collapse(values: np.ndarray, vectors: np.ndarray, joints: tuple[str, ...]) -> str:
    """Say which joint a collapsed stiffness has left, or gone to."""
    if values[-1] > ALONE * values.sum():
        stiff = joints[int(np.argmax(np.abs(vectors[:, -1])))]
        return (
            f"the stiffness has collapsed onto {stiff}: it hardly moves in these postures, or they "
            "say too little; give a prior, or leave the joint out"
        )
    soft = joints[int(np.argmax(np.abs(vectors[:, 0])))]
    return (
        f"the stiffness of {soft} has collapsed: these postures lie on no surface of least energy, "
        "or say too little; give a prior, or leave out the farthest targets"
    )
