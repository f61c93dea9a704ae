"""Which ratios of IK weights the data can tell at all, and which they tell well enough.

[Khoramshahi2022] sections 3.1 and 4.2 (the "over-specified joint"), made general. Three questions,
in this order:

1. Structure, from the null space alone. Z_k spans null(J_k). A joint whose row of Z_k is zero in
   every sample is over-specified: no other joint can stand in for it, and its weight has no
   effect. Two joints belong to one scale group if a chain of joints with (Z_kZ_kᵀ)_ij ≠ 0 joins
   them; between groups no movement whatever says anything.
2. Excitation, from the Fisher matrix F = Σ diag(p) NᵀN diag(p) of θ = log w at the estimate. A
   log-ratio θ_i - θ_j is estimable iff it is orthogonal to null(F) (FF⁺c = c). Estimable
   contrasts form a linear space, so this is an equivalence relation and needs no tie rule.
3. Precision, from the standard errors. "Standard error of θ_i - θ_j at most 1" is not transitive,
   so groups are made by complete linkage: starting from single joints, the two groups whose worst
   pair has the smallest standard error are merged while that error is at most the limit. Then
   every ratio inside a reported group, not only that to its reference, is within the limit. Of
   equal candidates the one with the earlier joints is merged first.

A bare pseudo-inverse reports a small false error for contrasts that are not estimable; here these
are infinite.
"""

from dataclasses import dataclass

import numpy as np

STRUCTURE_TOLERANCE = 1e-6
"""Size of an entry of Z (and of ZZᵀ) below which it counts as zero; above single precision."""
EXCITATION_TOLERANCE = 1e-10
"""Eigenvalue of the Fisher matrix, scaled to a unit diagonal, below which it counts as zero."""
ROUNDING = 1e3 * float(np.finfo(np.float64).eps)
"""Rounding of an entry of the Fisher matrix, relative to its largest."""
ESTIMABLE_TOLERANCE = 1e-4
"""Part of a contrast (relative length) that may lie in null(F)."""


@dataclass(frozen=True, eq=False)
class Structure:
    """What the null spaces alone allow.

    Attributes:
        groups: scale groups of two or more joints (indices, ascending).
        over_specified: joints that no other joint can stand in for.
        idle: joints that share null space with no other joint: their column of J is zero.
    """

    groups: tuple[tuple[int, ...], ...]
    over_specified: tuple[int, ...]
    idle: tuple[int, ...]


def connected(linked: np.ndarray) -> tuple[tuple[int, ...], ...]:
    """Find the connected components of a graph given as a Boolean matrix (n, n).

    Example:
        >>> connected(np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0]], dtype=bool))
        ((0, 2), (1,))
    """
    unseen: list[int] = list(range(len(linked)))
    components: list[tuple[int, ...]] = []
    while unseen:
        component: set[int] = set()
        frontier = [unseen[0]]
        while frontier:
            joint = frontier.pop()
            if joint not in component:
                component.add(joint)
                frontier.extend(int(other) for other in np.flatnonzero(linked[joint]))
        components.append(tuple(sorted(component)))
        unseen = [joint for joint in unseen if joint not in component]
    return tuple(components)


def find_structure(coupling: np.ndarray, moving: np.ndarray) -> Structure:
    """Find scale groups and over-specified joints from max |ZZᵀ| over the samples.

    Args:
        coupling: max over samples of |Z_kZ_kᵀ| (n, n).
        moving: which joints take part (n); the others are in no group.

    Example:
        >>> Z = np.array([[0.6], [0.8], [0.0]])
        >>> find_structure(np.abs(Z @ Z.T), np.ones(3, dtype=bool))
        Structure(groups=((0, 1),), over_specified=(2,), idle=())
    """
    linked = coupling > STRUCTURE_TOLERANCE
    linked &= moving[:, None] & moving[None, :]
    np.fill_diagonal(linked, False)
    in_null_space = np.diag(coupling) > STRUCTURE_TOLERANCE**2
    groups: list[tuple[int, ...]] = []
    single: list[int] = []
    for component in connected(linked):
        if len(component) > 1:
            groups.append(component)
        else:
            single.extend(i for i in component if moving[i])
    return Structure(
        groups=tuple(groups),
        over_specified=tuple(i for i in single if not in_null_space[i]),
        idle=tuple(i for i in single if in_null_space[i]),
    )


@dataclass(frozen=True, eq=False)
class Excitation:
    """The estimable space of log-weights at an estimate.

    Attributes:
        scale: D^(-1/2), D the diagonal of F (n); zero for joints without curvature.
        seen: eigenvectors of D^(-1/2) F D^(-1/2) that the movement excites (n, rank).
        unseen: the others (n, n - rank).
    """

    scale: np.ndarray
    seen: np.ndarray
    unseen: np.ndarray

    @property
    def rank(self) -> int:
        """Number of independent log-ratios that the movement excites."""
        return self.seen.shape[1]

    def estimable(self, i: int, j: int) -> bool:
        """Tell whether log w_i - log w_j can be told from the data: FF⁺c = c."""
        if self.scale[i] == 0.0 or self.scale[j] == 0.0:
            return False
        contrast = np.zeros(len(self.scale))
        contrast[i], contrast[j] = self.scale[i], -self.scale[j]
        part = np.linalg.norm(self.unseen.T @ contrast)
        return bool(part <= ESTIMABLE_TOLERANCE * np.linalg.norm(contrast))

    def inverse(self, matrix: np.ndarray) -> np.ndarray:
        """Give a symmetric generalised inverse on the estimable space; exact for its contrasts."""
        scaled = self.scale[:, None] * self.seen
        return scaled @ np.linalg.solve(scaled.T @ matrix @ scaled, scaled.T)

    def definite(self, matrix: np.ndarray) -> bool:
        """Tell whether a matrix is positive definite on the estimable space."""
        scaled = self.scale[:, None] * self.seen
        values = np.linalg.eigvalsh(scaled.T @ matrix @ scaled)
        return bool(len(values) == 0 or values[0] > EXCITATION_TOLERANCE)


def find_excitation(fisher: np.ndarray, structure: Structure) -> Excitation:
    """Part the log-weights into what the movement excites and what it does not.

    The scale of each group is never excited, whatever rounding makes of its eigenvalue.
    """
    n = len(fisher)
    scale = np.zeros(n)
    for group in structure.groups:
        for i in group:
            scale[i] = 1.0 / np.sqrt(fisher[i, i]) if fisher[i, i] > 0.0 else 0.0
    gauge = np.zeros((n, len(structure.groups)))
    for column, group in enumerate(structure.groups):
        live = [i for i in group if scale[i] > 0.0]
        gauge[live, column] = 1.0 / scale[live]
    basis = np.linalg.qr(gauge)[0] if gauge.any() else np.zeros((n, 0))
    away = np.eye(n) - basis @ basis.T
    scaled = away @ (scale[:, None] * fisher * scale[None, :]) @ away
    values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    curved = np.diag(fisher)[scale > 0.0]
    spread = curved.max() / curved.min() if len(curved) else 1.0
    # entries are rounded relative to the largest, which the scaling to a unit diagonal blows up
    excited = values > max(EXCITATION_TOLERANCE, ROUNDING * spread)
    return Excitation(scale, vectors[:, excited], vectors[:, ~excited])


def contrast_errors(excitation: Excitation, covariance: np.ndarray) -> np.ndarray:
    """Give the standard errors of all log-ratios (n, n); infinite where not estimable."""
    n = len(covariance)
    errors = np.full((n, n), np.inf)
    np.fill_diagonal(errors, 0.0)
    if not np.isfinite(covariance).all():
        return errors
    for i in range(n):
        for j in range(i):
            if excitation.estimable(i, j):
                variance = covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j]
                errors[i, j] = errors[j, i] = np.sqrt(max(variance, 0.0))
    return errors


def group_by_precision(
    candidates: tuple[tuple[int, ...], ...], errors: np.ndarray, limit: float
) -> tuple[tuple[int, ...], ...]:
    """Make the reported groups by complete linkage of standard errors (see the module).

    Args:
        candidates: scale groups (indices).
        errors: standard errors of log-ratios (n, n).
        limit: largest standard error inside a group.

    Returns:
        Groups of two or more joints, ascending.

    Example:
        >>> errors = np.array([[0, .1, .9], [.1, 0, 1.1], [.9, 1.1, 0]])
        >>> group_by_precision(((0, 1, 2),), errors, 1.0)
        ((0, 1),)
    """
    reported = []
    for candidate in candidates:
        groups: list[tuple[int, ...]] = [(i,) for i in candidate]
        while len(groups) > 1:
            pairs = [
                (float(errors[np.ix_(groups[a], groups[b])].max()), a, b)
                for a in range(len(groups))
                for b in range(a + 1, len(groups))
            ]
            worst, a, b = min(pairs)
            if not worst <= limit:
                break
            groups[a] = tuple(sorted(groups[a] + groups.pop(b)))
        reported.extend(group for group in groups if len(group) > 1)
    return tuple(sorted(reported))
