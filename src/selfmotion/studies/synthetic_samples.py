"""Synthetic samples of the two numerical examples of [Khoramshahi2022] section 4.1.

DOI 10.1371/journal.pone.0278228. The paper leaves the recipe open in places; the readings used
here are the ones that give its numbers:

- Example 1: the hand velocity is x = J q0 with q0 standard normal, and q̇ = J# x + V with V
  normal, standard deviation σ, **not** projected on the null space. The hand velocity handed to
  an estimator is J q̇. `projected=True` gives what eq. 15 says instead (J V = 0).
- Example 2: the null-space motion is -0.1·q1 per sample of 0.1 s (that is -1·q1 per second), not
  projected, and the hand follows the target by proportional control.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import as_float_array
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import Recording, sample_numbers
from selfmotion.redundancy.projection import project

EXAMPLE_1_WEIGHTS = (1.0, 0.8, 0.6, 0.4, 0.2)
EXAMPLE_2_WEIGHTS = (1.0, 0.01)
EXAMPLE_2_STEP = 0.1  # s
EXAMPLE_2_SAMPLES = 60
# Target of the hand from each time on: (s, m).
EXAMPLE_2_TARGETS = ((0.0, 1.0), (2.0, 1.5), (3.0, 0.5))


@dataclass(frozen=True)
class TwoJointSettings:
    """What the paper leaves open in its second example.

    Attributes:
        gain: proportional gain of the hand toward its target (1/s).
        pull: how fast the first joint is drawn to zero (1/s); the paper's 0.1 per sample.
        start: both joints' first value (m).
    """

    gain: float = 3.0
    pull: float = 1.0
    start: float = 0.5


def random_samples(
    weights: ArrayLike = EXAMPLE_1_WEIGHTS,
    *,
    rng: np.random.Generator,
    n_samples: int = 500,
    n_rows: int = 3,
    sigma: float = 0.2,
    projected: bool = False,
) -> Recording:
    """Draw independent samples of a random chain that moves by weighted inverse kinematics.

    Args:
        weights: (n,) true weights.
        rng: source of randomness.
        n_samples: K.
        n_rows: task dimensions m.
        sigma: standard deviation of the added motion (rad/s).
        projected: project the added motion on the null space, so that eq. 15 holds exactly.

    Returns:
        A recording with `qd` and `jacobian`; its samples have no order in time.

    Example:
        >>> made = random_samples(rng=np.random.default_rng(1), n_samples=4)
        >>> made.jacobian.shape
        (4, 3, 5)
    """
    w = as_float_array("weights", weights, ndim=1)
    n = len(w)
    J = rng.standard_normal((n_samples, n_rows, n))
    q0 = rng.standard_normal((n_samples, n))
    V = sigma * rng.standard_normal((n_samples, n))
    p = project(J, w)
    if projected:
        V = np.einsum("kij,kj->ki", p.null, V)
    qd = q0 - np.einsum("kij,kj->ki", p.null, q0) + V  # J#J q0 + V
    return Recording(sample_numbers(n_samples), qd=qd, jacobian=J, timed=False)


def two_joint_run(settings: TwoJointSettings | None = None) -> Recording:
    """Simulate two sliding joints along one line that follow a target which jumps twice.

    Returns:
        A recording (60 samples, 0.1 s apart) with q, qd, x, xd and jacobian (all 1).
    """
    s = settings or TwoJointSettings()
    time = EXAMPLE_2_STEP * np.arange(EXAMPLE_2_SAMPLES)
    share = project([[1.0, 1.0]], EXAMPLE_2_WEIGHTS).inverse[0, :, 0]
    q, qd = np.empty((2, EXAMPLE_2_SAMPLES, 2))
    posture = np.array([s.start, s.start])
    for k, t in enumerate(time):
        goal = [x for since, x in EXAMPLE_2_TARGETS if t >= since - 1e-9][-1]
        velocity = share * s.gain * (goal - posture.sum())
        velocity[0] -= s.pull * posture[0]
        q[k], qd[k] = posture, velocity
        posture = posture + EXAMPLE_2_STEP * velocity
    ones = np.ones((EXAMPLE_2_SAMPLES, 1, 2))
    return Recording(
        time,
        q=q,
        qd=qd,
        x=q.sum(axis=1, keepdims=True),
        xd=qd.sum(axis=1, keepdims=True),
        jacobian=ones,
        joints=("first", "second"),
        rows=("x",),
        labels=Labels(condition="example 2"),
    )
