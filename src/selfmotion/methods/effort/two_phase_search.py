"""The published two-phase search for the posture of least muscle effort.

Implements [Li2022] Table III with eqs 8 to 11 (doi 10.1109/TNSRE.2022.3198400). It is offered as
published, drift included: steps along the null space are not corrected, so that the hand leaves
its pose by millimetres, and the least minimum is found with a probability only. Rule (11) is met
after the first pass in practice. Deviations: candidates are searched in step with each other,
which changes no result; a step that would leave the joint limits counts as one of infinite
effort, since the paper does not say what happens there; where no posture is feasible, nothing is
searched.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from selfmotion.arrays import Transform, require_between
from selfmotion.errors import RangeError
from selfmotion.kinematics.forward import forward_kinematics, geometric_jacobian
from selfmotion.kinematics.srs import SrsRelative
from selfmotion.methods.hybrid_ik import hybrid_ik
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.static_optimization import EffortOptions, muscle_problem
from selfmotion.redundancy.feasible import Clearance

# Postures nearer than this (rad, norm over all joints) are one local minimum.
SAME_MINIMUM = 0.02
_MAX_STEPS = 2000
_MAX_PASSES = 4


@dataclass(frozen=True)
class TwoPhaseOptions:
    """Parameters of the published search; defaults are the paper's.

    Attributes:
        interval: spacing of the candidates, δψ_S (rad).
        step: first step ρ (rad, norm over all joints, coupled ones too).
        smallest_step: a candidate is done when its step is below this, κ (eq. 9).
        rule: stopping rule of the global phase, eq. 10 or 11.
        epsilon: ε of eq. 10.
        delta: δ of eq. 11.
        cap: greatest length a candidate may walk (rad); left out: none. The paper names none;
            its authors' program has one.
    """

    interval: float = float(np.deg2rad(2.0))
    step: float = 0.05
    smallest_step: float = 0.01
    rule: int = 11
    epsilon: float = 0.1
    delta: float = 0.1
    cap: float | None = None

    def __post_init__(self) -> None:
        """Check the ranges."""
        require_between("interval", self.interval, 1e-4, np.pi)
        require_between("smallest_step", self.smallest_step, 1e-9, self.step)
        if self.rule not in (10, 11):
            raise RangeError(f"rule = {self.rule}: allowed are 10 and 11")


@dataclass(frozen=True, eq=False)
class TwoPhaseResult:
    """What the published search found for one hand pose.

    Attributes:
        q: (W, 7) local minima, the least effort first.
        effort: (W,) their muscle effort.
        drift: (W, 2) how far the hand is from its pose: m and rad.
        n_candidates: postures searched from, M of eqs 10 and 11.
        n_evaluations: postures for which effort was computed.
        passes: samplings of the manifold, 1 where nothing was sampled again.
    """

    q: Float[np.ndarray, "minima 7"]
    effort: Float[np.ndarray, " minima"]
    drift: Float[np.ndarray, "minima 2"]
    n_candidates: int
    n_evaluations: int
    passes: int


def two_phase_search(
    model: MusculoskeletalArm,
    T_hand: Transform,
    *,
    effort: EffortOptions,
    options: TwoPhaseOptions | None = None,
    clearance: Clearance | None = None,
) -> TwoPhaseResult:
    """Search the posture of least effort as published ([Li2022] Table III).

    Args:
        model: arm with muscles.
        T_hand: hand pose in the ground.
        effort: how effort is computed.
        options: parameters; left out: the paper's.
        clearance: how far postures are outside bodies that the arm may not enter (m).
    """
    chosen = TwoPhaseOptions() if options is None else options
    relative = SrsRelative.of(model.arm)
    searched = np.empty(0)
    minima, values = np.empty((0, 7)), np.empty(0)
    walker = _Walker(model, effort, chosen, clearance)
    interval, passes, n_candidates = chosen.interval, 0, 0
    while True:
        passes += 1
        swivel = np.arange(-np.pi, np.pi - 1e-9, interval)
        new = swivel[~np.isin(np.round(swivel, 9), searched)]
        searched = np.union1d(searched, np.round(swivel, 9))
        found = hybrid_ik(model.arm, T_hand, new, relative=relative)
        candidates = found.q[found.feasible]
        if clearance is not None and len(candidates):
            candidates = candidates[clearance(candidates) >= 0]
        n_candidates += len(candidates)
        q, E = walker.walk(candidates)
        minima, values = walker.distinct(np.vstack([minima, q]), np.concatenate([values, E]))
        done = _stop(len(minima), n_candidates, chosen)
        if done or passes == _MAX_PASSES or len(minima) == 0:
            break
        interval /= 2.0
    drift = _drift(model, minima, T_hand)
    return TwoPhaseResult(minima, values, drift, n_candidates, walker.n_evaluations, passes)


def _stop(found: int, tried: int, options: TwoPhaseOptions) -> bool:
    """Tell whether enough has been sampled (eqs 10 and 11); w minima among M candidates."""
    w, M = found, tried
    if options.rule == 10:
        return M - w - 2 > 0 and w * (M - 1) / (M - w - 2) < w + options.epsilon
    return M > 1 and w * (w + 1) / (M * (M - 1)) < options.delta


class _Walker:
    """Walks candidates downhill along the null space, all in step."""

    def __init__(
        self,
        model: MusculoskeletalArm,
        effort: EffortOptions,
        options: TwoPhaseOptions,
        clearance: Clearance | None,
    ) -> None:
        self.model, self.effort, self.options = model, effort, options
        self.clearance = clearance
        self.n_evaluations = 0

    def walk(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give local minima (K, 7) and their effort (K,) from candidates (K, 7)."""
        q, o = q.copy(), self.options
        E = self.evaluate(q)
        rho = np.full(len(q), o.step)
        walked = np.zeros(len(q))
        for _ in range(_MAX_STEPS):
            active = np.flatnonzero(rho >= o.smallest_step)
            if len(active) == 0:
                break
            step = rho[active, None] * self._direction(q[active])
            plus, minus = q[active] + step, q[active] - step
            E_plus, E_minus = self.evaluate(plus), self.evaluate(minus)
            here = E[active]
            forth = (E_plus < here) & (here < E_minus)
            back = (E_minus < here) & (here < E_plus)
            q[active[forth]], E[active[forth]] = plus[forth], E_plus[forth]
            q[active[back]], E[active[back]] = minus[back], E_minus[back]
            stay = ~(forth | back)
            walked[active[~stay]] += rho[active[~stay]]
            rho[active[stay]] *= 0.5
            if o.cap is not None:
                rho[walked > o.cap] = 0.0
        return q, E

    def evaluate(self, q: np.ndarray) -> np.ndarray:
        """Give effort (K,), infinite outside the limits or in an excluded body."""
        arm = self.model.arm
        E = np.full(len(q), np.inf)
        slack = 1e-9
        inside = np.asarray(((q >= arm.lower - slack) & (q <= arm.upper + slack)).all(axis=1))
        if self.clearance is not None and inside.any():
            inside[inside] = self.clearance(q[inside]) >= 0
        if inside.any():
            activations, _, _ = muscle_problem(self.model, q[inside], self.effort).solve(
                self.effort
            )
            E[inside] = (activations**self.effort.exponent).sum(axis=1)
            self.n_evaluations += int(inside.sum())
        return E

    def _direction(self, q: np.ndarray) -> np.ndarray:
        """Give the null-space direction, of unit length over all joints (eq. 8)."""
        arm = self.model.arm
        J = geometric_jacobian(arm.chain, q, arm.tip("hand"))
        n = np.linalg.svd(J)[2][:, -1]
        all_joints = np.einsum("kNn,kn->kN", arm.chain.coupling.derivative(q), n)
        return n / np.linalg.norm(all_joints, axis=1)[:, None]

    def distinct(self, q: np.ndarray, E: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Leave each local minimum once, the least effort first."""
        order = np.argsort(E, kind="stable")
        kept: list[int] = []
        for i in order:
            if all(np.linalg.norm(q[i] - q[j]) > SAME_MINIMUM for j in kept):
                kept.append(int(i))
        return q[kept], E[kept]


def _drift(model: MusculoskeletalArm, q: np.ndarray, T_hand: np.ndarray) -> np.ndarray:
    from selfmotion.spatial import log_rotation

    if len(q) == 0:
        return np.empty((0, 2))
    T = forward_kinematics(model.arm.chain, q, model.arm.tip("hand"))
    far = np.linalg.norm(T[:, :3, 3] - T_hand[:3, 3], axis=1)
    turn = log_rotation(T_hand[:3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2))
    return np.column_stack([far, np.linalg.norm(turn, axis=1)])
