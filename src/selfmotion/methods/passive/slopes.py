"""Passive motion of many movements at once in NumPy: any task, damping, potential and planner."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from selfmotion.methods.passive.arrays import KernelDrive
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.kernels import growth_at
from selfmotion.methods.passive.lockstep import Slope
from selfmotion.methods.passive.potentials import ElasticPotential
from selfmotion.methods.passive.settings import PlanSettings
from selfmotion.methods.passive.task_planners import ForceField
from selfmotion.redundancy.task import Task

# Eigenvalues of JW⁻¹Jᵀ below this share of the largest count as lost.
RANK_TOLERANCE = 1e-12


@dataclass(frozen=True, eq=False)
class Drive:
    """What pulls the hand in each of B movements.

    Attributes:
        start: (B, n) postures (rad).
        goals: (B, M) targets, of all M rows where the task keeps only some.
        time: (S,) times of the output (s).
        spring: (B, m, m) full-grown springs.
        points: (B, S or 1, M) where the spring is tied to.
        speeds: same shape, velocity of that place.
        follow: whether B ẋ_d is added.
        field: a force field that replaces the spring.
        kept: (m,) rows of the goals that the task keeps.
    """

    start: Float[np.ndarray, "movements joints"]
    goals: Float[np.ndarray, "movements all_rows"]
    time: Float[np.ndarray, " samples"]
    spring: Float[np.ndarray, "movements rows rows"]
    points: Float[np.ndarray, "movements some all_rows"]
    speeds: Float[np.ndarray, "movements some all_rows"]
    follow: bool
    field: ForceField | None
    kept: Int[np.ndarray, " rows"]

    def take(self, which: np.ndarray) -> "Drive":
        """Give some of the movements."""
        return Drive(
            self.start[which],
            self.goals[which],
            self.time,
            self.spring[which],
            self.points[which],
            self.speeds[which],
            self.follow,
            self.field,
            self.kept,
        )

    def for_kernels(self) -> KernelDrive:
        """Give the form that the compiled kernels take."""
        return KernelDrive(
            self.start,
            np.ascontiguousarray(self.spring),
            np.ascontiguousarray(self.points[:, :, self.kept]),
            np.ascontiguousarray(self.speeds[:, :, self.kept]),
            float(self.follow),
            float(self.time[-1]),
            len(self.time) - 1,
        )

    def sight(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Give the points (B, m) that the springs are tied to at time t, and their velocity."""
        if self.points.shape[1] == 1:
            return self.points[:, 0], self.speeds[:, 0]
        h = self.time[1] - self.time[0]
        i = int(np.clip(t // h, 0, len(self.time) - 2))
        u = t / h - i
        y0, y1 = self.points[:, i], self.points[:, i + 1]
        d0, d1 = h * self.speeds[:, i], h * self.speeds[:, i + 1]
        c2, c3 = 3.0 * (y1 - y0) - 2.0 * d0 - d1, 2.0 * (y0 - y1) + d0 + d1
        return (
            y0 + u * (d0 + u * (c2 + u * c3)),
            (d0 + u * (2.0 * c2 + 3.0 * u * c3)) / h,
        )


class PassiveSlopes:
    """The right-hand side of passive motion for the free joints of B movements."""

    def __init__(
        self,
        task: Task,
        law: JointLaw,
        settings: PlanSettings,
        drive: Drive,
        free: np.ndarray,
        admittance: Callable[..., np.ndarray],
    ) -> None:
        """Keep what the movements share."""
        self.task, self.law, self.settings, self.drive = task, law, settings, drive
        self.free, self.admittance = free, admittance
        elastic = ElasticPotential(law.stiffness, law.rest)
        self.potentials = (elastic, *settings.potentials) if settings.model != "pmp1" else ()
        self.blocked = settings.model == "lambda0"
        self.rank_lost = np.zeros(len(drive.start), dtype=bool)

    def full(self, free: np.ndarray) -> np.ndarray:
        """Give whole postures (B, n) from the free joints (B, f)."""
        q = self.drive.start.copy()
        q[:, self.free] = free
        return q

    def __call__(self, t: float, free: np.ndarray) -> Slope:
        """Give velocity and approximate Jacobian of the free joints at time t."""
        velocity, turning = self._moving(t, free)
        J, through, inverse, Winv, stiffness = turning
        vq = Winv @ self._bending(self.full(free))
        kept = vq - through @ inverse @ (J @ vq) if self.blocked else vq
        return Slope(velocity, -through @ stiffness @ J - kept)

    def velocity(self, t: float, free: np.ndarray) -> np.ndarray:
        """Give the velocity of the free joints at time t."""
        return self._moving(t, free)[0]

    def _moving(self, t: float, free: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        """Give the velocity, and what its Jacobian is made of."""
        q = self.full(free)
        J = self.task.jacobian(q)[:, :, self.free]
        Winv = self.admittance(self.law, self.settings, q, self.free)
        through = Winv @ np.swapaxes(J, 1, 2)  # M
        inverse = self._task_damping(J @ through)  # B
        v = self._relaxation(q, Winv)
        force, stiffness, pushed = self._force(t, q)
        if self.blocked and self.potentials:
            pushed = pushed + np.einsum("bai,bi->ba", J, v)
        force = force + np.einsum("bac,bc->ba", inverse, pushed)
        velocity = np.einsum("bia,ba->bi", through, force) - v
        return velocity, (J, through, inverse, Winv, stiffness)

    def samples(self, free: np.ndarray) -> tuple[np.ndarray, ...]:
        """Give q, q̇, x, ẋ at the times of output, and when each movement lost rank (or NaN)."""
        n_movements, n_samples = free.shape[:2]
        n, m = self.drive.start.shape[1], len(self.drive.kept)
        q, qd = (np.full((n_movements, n_samples, n), np.nan) for _ in range(2))
        x, xd = (np.full((n_movements, n_samples, m), np.nan) for _ in range(2))
        lost = np.full(n_movements, np.nan)
        for k, t in enumerate(self.drive.time):
            if not np.isfinite(free[:, k]).all():
                break
            q[:, k] = self.full(free[:, k])
            qd[:, k] = 0.0
            qd[:, k, self.free] = self.velocity(float(t), free[:, k])
            x[:, k] = self.task.value(q[:, k])
            xd[:, k] = np.einsum("bai,bi->ba", self.task.jacobian(q[:, k]), qd[:, k])
            lost[self.rank_lost & np.isnan(lost)] = t
        return q, qd, x, xd, lost

    def _task_damping(self, mobility: np.ndarray) -> np.ndarray:
        """Invert JW⁻¹Jᵀ where it has its rank, and note where it has not."""
        values, vectors = np.linalg.eigh(mobility)
        kept = values > RANK_TOLERANCE * values[:, -1:]
        self.rank_lost = ~kept.all(axis=1)
        gain = np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)
        return (vectors * gain[:, None, :]) @ np.swapaxes(vectors, 1, 2)

    def _relaxation(self, q: np.ndarray, Winv: np.ndarray) -> np.ndarray:
        """Give W⁻¹ times the gradient of the potentials."""
        g = np.zeros((len(q), len(self.free)))
        for potential in self.potentials:
            g = g + potential.gradient(q)[:, self.free]
        return np.einsum("bij,bj->bi", np.broadcast_to(Winv, (*g.shape, g.shape[1])), g)

    def _bending(self, q: np.ndarray) -> np.ndarray:
        """Give the second derivative of the potentials for the free joints."""
        n_free = len(self.free)
        H = np.zeros((len(q), n_free, n_free))
        for potential in self.potentials:
            H = H + potential.hessian(q)[:, self.free[:, None], self.free]
        return H

    def _force(self, t: float, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Give the force on the hand, its stiffness, and the velocity that is to be followed."""
        if self.drive.field is not None:
            x = self.task.value(q)
            goals = self.drive.goals[:, self.drive.kept]
            force = np.asarray(self.drive.field.force(t, x, goals), dtype=np.float64)
            stiffness = self.drive.field.stiffness(t, x, goals)
            return force, stiffness, np.zeros_like(force)
        point, speed = self.drive.sight(t)
        K = growth_at(t, self.law.spring_time) * self.drive.spring
        force = np.einsum("bac,bc->ba", K, self.task.error(q, point))
        speed = speed[:, self.drive.kept]
        return force, K, speed if self.drive.follow else np.zeros_like(speed)
