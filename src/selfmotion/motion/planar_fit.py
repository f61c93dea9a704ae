"""Find the planar chain behind recorded joint angles and end-point positions.

Experiment 2 of [Khoramshahi2022] (10.1371/journal.pone.0278228) publishes angles and the position
of the hand of a virtual planar chain, but not its links. In the complex plane (x to the right, y
up) the hand is ``z = b + sum_i c_i exp(i phi_i)`` with ``phi = A q``: the base b and the links
``c_i = length_i exp(i offset_i)`` follow from linear least squares, and the Jacobian in closed
form, ``dz/dq_j = sum_i A_ij i c_i exp(i phi_i)``.

What the angles are measured against is not documented either, so every convention is tried:
relative (``phi_i`` adds up the angles before it) or absolute, each joint with either sign. The
data choose; where two conventions fit alike, the fit is refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Complex, Float

from selfmotion.arrays import JacobianSamples, JointSamples, TaskSamples
from selfmotion.errors import RangeError

# Largest rms distance of fitted from recorded positions, relative to the rms of their spread.
LARGEST_RESIDUAL = 0.02
# The second-best convention must miss by this factor more, and by more than rounding errors.
RIVAL = 1.5
ROUNDING = 1e-6
# Samples of one person that decide the convention; more add nothing but time.
ENOUGH = 4_000


@dataclass(frozen=True)
class Convention:
    """How link directions follow from joint angles: ``phi = A q``."""

    relative: bool
    signs: tuple[int, ...]

    @property
    def matrix(self) -> Float[np.ndarray, "joints joints"]:
        """Give A: each row a link, each column a joint."""
        n = len(self.signs)
        return (np.tril(np.ones((n, n))) if self.relative else np.eye(n)) * np.array(self.signs)

    def __str__(self) -> str:
        """Say it in words, as in ``relative angles, signs + + -``."""
        signs = " ".join("+" if sign > 0 else "-" for sign in self.signs)
        return f"{'relative' if self.relative else 'absolute'} angles, signs {signs}"


@dataclass(frozen=True, eq=False)
class PlanarChainFit:
    """A planar chain that was fitted to recorded positions.

    Attributes:
        lengths: link lengths (n), unit of the positions.
        offsets: direction of each link where its angle is zero (n), rad from the x axis.
        base: position of the first joint (2,), unit of the positions.
        convention: how link directions follow from joint angles.
        residual: rms distance of fitted from recorded positions, relative to their spread.
    """

    lengths: Float[np.ndarray, " joints"]
    offsets: Float[np.ndarray, " joints"]
    base: Float[np.ndarray, "2"]
    convention: Convention
    residual: float

    def value(self, q: JointSamples) -> TaskSamples:
        """Give the hand's position (K, 2) at joint angles (K, n), rad."""
        z = complex(*self.base) + self._links(q).sum(axis=1)
        return np.stack([z.real, z.imag], axis=1)

    def jacobian(self, q: JointSamples) -> JacobianSamples:
        """Give the Jacobian (K, 2, n) of the hand's position."""
        columns = 1j * self._links(q) @ self.convention.matrix
        return np.stack([columns.real, columns.imag], axis=1)

    def _links(self, q: JointSamples) -> Complex[np.ndarray, "samples joints"]:
        angles = q @ self.convention.matrix.T + self.offsets
        return self.lengths * np.exp(1j * angles)


def fit_planar_chain(
    q: JointSamples, x: TaskSamples, convention: Convention
) -> PlanarChainFit | None:
    """Fit links and base to angles (K, n), rad, and positions (K, 2), for a known convention.

    Returns:
        The fit, or None where the angles move too little to tell the links apart.

    Example:
        >>> q = np.random.default_rng(0).uniform(-1, 1, (50, 2))
        >>> x = np.stack([np.cos(q[:, 0]), np.sin(q[:, 0])], axis=1)
        >>> x += 0.5 * np.stack([np.cos(q.sum(axis=1)), np.sin(q.sum(axis=1))], axis=1)
        >>> np.round(fit_planar_chain(q, x, Convention(True, (1, 1))).lengths, 9).tolist()
        [1.0, 0.5]
    """
    z = x[:, 0] + 1j * x[:, 1]
    angles = q @ convention.matrix.T
    design = np.column_stack([np.ones(len(z)), np.exp(1j * angles)])
    solution, _, rank, _ = np.linalg.lstsq(design, z, rcond=ROUNDING)
    if rank < design.shape[1]:
        return None
    missed = np.sqrt(np.mean(np.abs(z - design @ solution) ** 2))
    spread = np.sqrt(np.mean(np.abs(z - z.mean()) ** 2))
    base, links = solution[0], solution[1:]
    return PlanarChainFit(
        lengths=np.abs(links),
        offsets=np.angle(links),
        base=np.array([base.real, base.imag]),
        convention=convention,
        residual=float(missed / spread) if spread > 0.0 else 0.0,
    )


def find_convention(people: Sequence[tuple[JointSamples, TaskSamples]]) -> Convention:
    """Choose the convention of angles that fits all people best.

    Args:
        people: joint angles (K, n), rad, and positions (K, 2) of each person; all conditions of a
            person together, since a joint that is locked in one moves in another.

    Raises:
        RangeError: no convention fits, or two fit alike, or a joint never moves.
    """
    thinned = [(q[:: 1 + len(q) // ENOUGH], x[:: 1 + len(q) // ENOUGH]) for q, x in people]
    n = thinned[0][0].shape[1]
    scores: list[tuple[float, Convention]] = []
    for relative, signs in product((True, False), product((1, -1), repeat=n)):
        convention = Convention(relative, signs)
        fits = [fit_planar_chain(q, x, convention) for q, x in thinned]
        residuals = [fit.residual for fit in fits if fit is not None]
        if residuals and len(residuals) == len(fits):
            scores.append((float(np.sqrt(np.mean(np.square(residuals)))), convention))
    if not scores:
        raise RangeError(
            "planar chain: a joint hardly moves, so the links cannot be told apart (each joint "
            "must move in at least one condition)"
        )
    (best, chosen), (second, rival) = sorted(scores, key=lambda score: score[0])[:2]
    if best > LARGEST_RESIDUAL:
        raise RangeError(
            f"planar chain: the best fit ({chosen}) misses the positions by {100 * best:.3g} % of "
            f"their spread; allowed is {100 * LARGEST_RESIDUAL:g} % (angles must be in radians)"
        )
    if second <= max(RIVAL * best, ROUNDING):
        raise RangeError(
            f"planar chain: '{chosen}' and '{rival}' fit alike ({100 * best:.3g} and "
            f"{100 * second:.3g} % of the spread), so the Jacobian is ambiguous"
        )
    return chosen
