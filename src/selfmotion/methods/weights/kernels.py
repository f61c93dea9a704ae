"""Compiled sums over samples behind the identification of IK weights.

[Khoramshahi2022], doi 10.1371/journal.pone.0278228, eqs 4, 12, 16-22. Everything here is a sum
over samples of something small, so that a million samples stream through a few kilobytes.

Notation, for one sample: h = w^(-1/2), G = orthonormal rows that span J diag(h), Π = GᵀG. Then
J#J = diag(h) Π diag(1/h), and with y the joint velocity (less any feedback), f = Π y/h,
r̃ = y/h - f, d = (I - Π)(h² r̃), the residual is r = N y = h r̃ and

    ∂r/∂θ_i   = N e_i p_i,  p = h f                       (θ = log w)
    gradient_i = f_i d_i
    (NᵀN)_ij p_i p_j = f_i f_j (h_i² δ_ij - Π_ij (h_i² + h_j²) + (Gᵀ(G h² Gᵀ)G)_ij)
    Σ r·∂²r    = Π_ij (f_i d_j + f_j d_i) - δ_ij f_i d_i   (what Gauss-Newton leaves out)

The rows of G come from modified Gram-Schmidt, which does not square the condition of J. A column
with h = 0 is a joint taken out of the chain (w = ∞). Blocks of `LANES` samples run side by side,
which lets LLVM use vector registers. The kernels release the GIL and run on ordinary threads (see
`samples.sweep`): numba's own parallel loops are not safe to enter from two Python
threads, and compile more slowly. Kernels that call each other stay in this module: numba's cache
does not notice an edited callee in another file.
"""

import numpy as np
from numba import njit

LANES = 64
RANK_TOLERANCE = 1e-6
"""A row of J counts as dependent if its angle (rad) to the rows above it is smaller."""

KEPT, HAS_NAN, HAS_INF, RANK_DEFICIENT = 0, 1, 2, 3
POSTURE, CONSTANT = 0, 1

_SQUARED_RANK_TOLERANCE = RANK_TOLERANCE**2


@njit(cache=True, nogil=True, error_model="numpy")
def _lane_sum(lanes):
    """Add the lanes in order."""
    total = 0.0
    for lane in range(LANES):
        total += lanes[lane]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _load(qd, jac, keep, start, stop, y, rows):
    """Copy samples start..stop into lanes; what is not kept becomes a resting, regular arm."""
    m, n = jac.shape[1], jac.shape[2]
    for lane in range(LANES):
        k = start + lane
        if k < stop and keep[k] == KEPT:
            for i in range(n):
                y[i, lane] = qd[k, i]
            for a in range(m):
                for i in range(n):
                    rows[a, i, lane] = jac[k, a, i]
        else:
            for i in range(n):
                y[i, lane] = 0.0
            for a in range(m):
                for i in range(n):
                    rows[a, i, lane] = 1.0 if i == a else 0.0


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _orthonormal_rows(rows, h, G, work, full_rank):
    """Orthonormalise the rows of J diag(h); a dependent row becomes zero and is noted."""
    m, n = rows.shape[0], rows.shape[1]
    before, after = work[0], work[1]
    for lane in range(LANES):
        full_rank[lane] = 1.0
    for a in range(m):
        for lane in range(LANES):
            before[lane] = 0.0
        for i in range(n):
            for lane in range(LANES):
                v = rows[a, i, lane] * h[i]
                G[a, i, lane] = v
                before[lane] += v * v
        for b in range(a):
            for lane in range(LANES):
                after[lane] = 0.0
            for i in range(n):
                for lane in range(LANES):
                    after[lane] += G[b, i, lane] * G[a, i, lane]
            for i in range(n):
                for lane in range(LANES):
                    G[a, i, lane] -= after[lane] * G[b, i, lane]
        for lane in range(LANES):
            after[lane] = 0.0
        for i in range(n):
            for lane in range(LANES):
                after[lane] += G[a, i, lane] * G[a, i, lane]
        for lane in range(LANES):
            independent = after[lane] > _SQUARED_RANK_TOLERANCE * before[lane]
            after[lane] = 1.0 / np.sqrt(after[lane]) if independent else 0.0
            full_rank[lane] = full_rank[lane] if independent else 0.0
        for i in range(n):
            for lane in range(LANES):
                G[a, i, lane] *= after[lane]


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _project(G, v, onto, work):
    """Compute Π v = Gᵀ(G v)."""
    m, n = G.shape[0], G.shape[1]
    part = work[0]
    for i in range(n):
        for lane in range(LANES):
            onto[i, lane] = 0.0
    for a in range(m):
        for lane in range(LANES):
            part[lane] = 0.0
        for i in range(n):
            for lane in range(LANES):
                part[lane] += G[a, i, lane] * v[i, lane]
        for i in range(n):
            for lane in range(LANES):
                onto[i, lane] += G[a, i, lane] * part[lane]


@njit(cache=True, nogil=True, error_model="numpy")
def _classify(qd, jac, q, k):
    """Say whether a sample is finite, has a gap (NaN) or holds an infinite value."""
    total = 0.0
    for i in range(qd.shape[1]):
        total += abs(qd[k, i])
    for a in range(jac.shape[1]):
        for i in range(jac.shape[2]):
            total += abs(jac[k, a, i])
    if q.shape[0] > 0:
        for i in range(q.shape[1]):
            total += abs(q[k, i])
    if np.isnan(total):
        return HAS_NAN
    if np.isinf(total):
        return HAS_INF
    return KEPT


@njit(cache=True, nogil=True, error_model="numpy")
def _task_mismatch(qd, jac, xd, k, sums):
    """Add ‖ẋ - Jq̇‖² and ‖ẋ‖² of one sample; a gap in ẋ is passed over."""
    wrong, size = 0.0, 0.0
    for a in range(jac.shape[1]):
        difference = xd[k, a]
        size += difference * difference
        for i in range(jac.shape[2]):
            difference -= jac[k, a, i] * qd[k, i]
        wrong += difference * difference
    if not np.isnan(wrong):
        sums[0] += wrong
        sums[1] += size


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def survey_samples(qd, jac, q, xd, keep, bounds, h, moment, linear, coupling, mismatch):
    """Mark usable samples and add up what does not depend on the weights.

    Fills keep (samples) if every h is one; per chunk: moment = Σ q̇q̇ᵀ, linear = Σ diag(q̇) ZZᵀ
    diag(q̇), coupling = max |ZZᵀ|, mismatch = (Σ‖ẋ - Jq̇‖², Σ‖ẋ‖²). q and xd may be empty. With
    some h zero, Z spans the null space of the chain without those joints.
    """
    m, n = jac.shape[1], jac.shape[2]
    y, rows = np.empty((n, LANES)), np.empty((m, n, LANES))
    G, work, full_rank = np.empty((m, n, LANES)), np.empty((2, LANES)), np.empty(LANES)
    whole = h.min() == 1.0
    lin, top, mom = np.empty((n, n, LANES)), np.empty((n, n, LANES)), np.empty((n, n, LANES))
    for c in range(bounds.shape[0]):
        lin.fill(0.0)
        top.fill(0.0)
        mom.fill(0.0)
        mismatch[c, 0] = mismatch[c, 1] = 0.0
        for start in range(bounds[c, 0], bounds[c, 1], LANES):
            stop = bounds[c, 1]
            if whole:
                for k in range(start, min(stop, start + LANES)):
                    keep[k] = _classify(qd, jac, q, k)
                    if keep[k] == KEPT and xd.shape[0] > 0:
                        _task_mismatch(qd, jac, xd, k, mismatch[c])
            _load(qd, jac, keep, start, stop, y, rows)
            _orthonormal_rows(rows, h, G, work, full_rank)
            for lane in range(LANES):
                k = start + lane
                if k >= stop or keep[k] != KEPT:
                    full_rank[lane] = 0.0
                elif not whole:
                    full_rank[lane] = 1.0
                elif full_rank[lane] == 0.0:
                    keep[k] = RANK_DEFICIENT
            for i in range(n):
                for j in range(i, n):
                    for lane in range(LANES):
                        null = 1.0 if i == j else 0.0
                        for a in range(m):
                            null -= G[a, i, lane] * G[a, j, lane]
                        null *= full_rank[lane]
                        product = y[i, lane] * y[j, lane] * full_rank[lane]
                        mom[i, j, lane] += product
                        lin[i, j, lane] += product * null
                        top[i, j, lane] = max(top[i, j, lane], abs(null))
        for i in range(n):
            for j in range(i, n):
                moment[c, i, j] = moment[c, j, i] = _lane_sum(mom[i, j])
                linear[c, i, j] = linear[c, j, i] = _lane_sum(lin[i, j])
                coupling[c, i, j] = coupling[c, j, i] = top[i, j].max()


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _add_curvature(G, f, d, h2, F, work, gauss_newton, remainder, second):
    """Add f M fᵀ (Gauss-Newton) and, if asked, the second-derivative term of one block."""
    m, n = G.shape[0], G.shape[1]
    part, both = work[0], work[1]
    for a in range(m):
        for i in range(n):
            for lane in range(LANES):
                F[a, i, lane] = 0.0
        for b in range(m):
            for lane in range(LANES):
                part[lane] = 0.0
            for i in range(n):
                for lane in range(LANES):
                    part[lane] += G[a, i, lane] * G[b, i, lane] * h2[i]
            for i in range(n):
                for lane in range(LANES):
                    F[a, i, lane] += part[lane] * G[b, i, lane]
    terms = f.shape[0]
    for i in range(n):
        for j in range(i, n):
            diagonal = 1.0 if i == j else 0.0
            for lane in range(LANES):
                part[lane] = 0.0
                both[lane] = diagonal * h2[i]
            for a in range(m):
                for lane in range(LANES):
                    part[lane] += G[a, i, lane] * G[a, j, lane]
                    both[lane] += G[a, i, lane] * F[a, j, lane]
            for lane in range(LANES):
                both[lane] -= part[lane] * (h2[i] + h2[j])
            for s in range(terms):
                for t in range(s, terms):
                    for lane in range(LANES):
                        gauss_newton[s, t, i, j, lane] += f[s, i, lane] * both[lane] * f[t, j, lane]
                    if t > s and j > i:
                        for lane in range(LANES):
                            gauss_newton[s, t, j, i, lane] += (
                                f[s, j, lane] * both[lane] * f[t, i, lane]
                            )
            if not second:
                continue
            for lane in range(LANES):
                mixed = f[0, i, lane] * d[j, lane] + f[0, j, lane] * d[i, lane]
                remainder[0, i, j, lane] += (
                    part[lane] * mixed - diagonal * f[0, i, lane] * d[i, lane]
                )
            for t in range(1, terms):
                for lane in range(LANES):
                    remainder[t, i, j, lane] += d[i, lane] * part[lane] * f[t, j, lane]
                if j > i:
                    for lane in range(LANES):
                        remainder[t, j, i, lane] += d[j, lane] * part[lane] * f[t, i, lane]


@njit(cache=True, nogil=True, error_model="numpy")
def _store_curvature(gauss_newton, remainder, second, curvature, exact):
    """Sum the lanes into the symmetric matrices of one chunk."""
    terms, n = gauss_newton.shape[0], gauss_newton.shape[2]
    for s in range(terms):
        for t in range(s, terms):
            for i in range(n):
                for j in range(i if s == t else 0, n):
                    value = _lane_sum(gauss_newton[s, t, i, j])
                    row, column = s * n + i, t * n + j
                    curvature[row, column] = curvature[column, row] = value
                    if second:
                        if s == 0:
                            value += _lane_sum(remainder[t, i, j])
                        exact[row, column] = exact[column, row] = value


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def sum_normal_equations(
    qd, jac, q, keep, bounds, h, kinds, feedback, cost, gradient, curvature, exact
):
    """Add up ½‖r‖², its gradient and its curvature in (θ, feedback), chunk by chunk.

    r = N(θ)(q̇ - Σ_t φ_t b_t) with φ_t the posture or ones as `kinds` says. `curvature` is the
    Gauss-Newton matrix; `exact`, filled unless it is empty, is the whole Hessian.
    """
    m, n = jac.shape[1], jac.shape[2]
    terms = 1 + kinds.shape[0]
    second = exact.shape[0] > 0
    y, rows = np.empty((n, LANES)), np.empty((m, n, LANES))
    G, F, work = np.empty((m, n, LANES)), np.empty((m, n, LANES)), np.empty((2, LANES))
    full_rank, f, d = np.empty(LANES), np.empty((terms, n, LANES)), np.empty((n, LANES))
    rest, loss = np.empty((n, LANES)), np.empty(LANES)
    grad, gn = np.empty((terms, n, LANES)), np.empty((terms, terms, n, n, LANES))
    extra = np.empty((terms, n, n, LANES))
    h2, h_inverse = h * h, np.zeros(n)
    for i in range(n):
        if h[i] > 0.0:
            h_inverse[i] = 1.0 / h[i]
    for c in range(bounds.shape[0]):
        grad.fill(0.0)
        gn.fill(0.0)
        extra.fill(0.0)
        loss.fill(0.0)
        stop = bounds[c, 1]
        for start in range(bounds[c, 0], stop, LANES):
            _load(qd, jac, keep, start, stop, y, rows)
            _orthonormal_rows(rows, h, G, work, full_rank)
            for t in range(1, terms):
                for lane in range(LANES):
                    k = start + lane
                    used = k < stop and keep[k] == KEPT
                    for i in range(n):
                        value = 0.0
                        if used:
                            value = 1.0 if kinds[t - 1] == CONSTANT else q[k, i]
                        y[i, lane] -= value * feedback[t - 1, i]
                        f[t, i, lane] = -value * h_inverse[i]
            for i in range(n):
                for lane in range(LANES):
                    y[i, lane] *= h_inverse[i]
            _project(G, y, f[0], work)
            for i in range(n):
                for lane in range(LANES):
                    left = y[i, lane] - f[0, i, lane]
                    rest[i, lane] = h2[i] * left
                    loss[lane] += 0.5 * h2[i] * left * left
            _project(G, rest, d, work)
            for i in range(n):
                for lane in range(LANES):
                    d[i, lane] = rest[i, lane] - d[i, lane]
            for t in range(terms):
                for i in range(n):
                    for lane in range(LANES):
                        grad[t, i, lane] += f[t, i, lane] * d[i, lane]
            _add_curvature(G, f, d, h2, F, work, gn, extra, second)
        cost[c] = _lane_sum(loss)
        for t in range(terms):
            for i in range(n):
                gradient[c, t * n + i] = _lane_sum(grad[t, i])
        _store_curvature(gn, extra, second, curvature[c], exact[c] if second else curvature[c])


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def sum_algorithm_one(qd, jac, keep, bounds, h, h_before, ratio_before, cross, error):
    """Add up C = Σ N q̇q̇ᵀ and Σ‖e‖ of Algorithm 1, with v̄ of the iteration before in e.

    e = N q̇ - γ N_before q̇ (eq. 16 with ẋ = Jq̇). Ψ and Ω follow from C and Σ q̇q̇ᵀ.
    """
    m, n = jac.shape[1], jac.shape[2]
    y, rows = np.empty((n, LANES)), np.empty((m, n, LANES))
    G, work, full_rank = np.empty((m, n, LANES)), np.empty((2, LANES)), np.empty(LANES)
    scaled, task, now = np.empty((n, LANES)), np.empty((n, LANES)), np.empty((n, LANES))
    acc, size, total = np.empty((n, n, LANES)), np.empty(LANES), np.empty(LANES)
    for c in range(bounds.shape[0]):
        acc.fill(0.0)
        total.fill(0.0)
        stop = bounds[c, 1]
        for start in range(bounds[c, 0], stop, LANES):
            _load(qd, jac, keep, start, stop, y, rows)
            _orthonormal_rows(rows, h, G, work, full_rank)
            for i in range(n):
                for lane in range(LANES):
                    scaled[i, lane] = y[i, lane] / h[i]
            _project(G, scaled, task, work)
            for i in range(n):
                for lane in range(LANES):
                    now[i, lane] = y[i, lane] - h[i] * task[i, lane]
            for i in range(n):
                for j in range(n):
                    for lane in range(LANES):
                        acc[i, j, lane] += now[i, lane] * y[j, lane]
            if ratio_before != 0.0:
                _orthonormal_rows(rows, h_before, G, work, full_rank)
                for i in range(n):
                    for lane in range(LANES):
                        scaled[i, lane] = y[i, lane] / h_before[i]
                _project(G, scaled, task, work)
                for i in range(n):
                    for lane in range(LANES):
                        lagged = y[i, lane] - h_before[i] * task[i, lane]
                        now[i, lane] -= ratio_before * lagged
            size.fill(0.0)
            for i in range(n):
                for lane in range(LANES):
                    size[lane] += now[i, lane] * now[i, lane]
            for lane in range(LANES):
                total[lane] += np.sqrt(size[lane])
        error[c] = _lane_sum(total)
        for i in range(n):
            for j in range(n):
                cross[c, i, j] = _lane_sum(acc[i, j])
