"""Compiled kernels for arms whose hand pose leaves one freedom: refinement and continuation.

A posture has seven coordinates, a hand pose six rows; what is left is a curve, the self-motion
manifold. A step on it solves seven equations: the pose, and where on the curve (square to the
tangent, or on a joint limit). Numba's cache asks that functions that call each other share a file.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

# How a trace along the curve ends.
CLOSED, OUTSIDE, FULL, STUCK = range(4)
_CORRECTIONS = 6
_SMALLEST_STEP = 1e-5
_ASIDE = 2e-3  # a step that ends so far (rad) from the mean of its tangents is on another branch


class PathArrays(NamedTuple):
    """The joints that carry the hand, as arrays (`kinematics.serial_path.SerialPath`)."""

    prismatic: np.ndarray  # (P,)
    cos_twist: np.ndarray  # (P,)
    sin_twist: np.ndarray  # (P,)
    shift: np.ndarray  # (P, 3)
    angle_offset: np.ndarray  # (P,)
    base: np.ndarray  # (2,) cosine and sine of the first turn
    tip_rotation: np.ndarray  # (3, 3)
    tip_position: np.ndarray  # (3,)
    matrix: np.ndarray  # (P, n)
    offset: np.ndarray  # (P,)
    curve: np.ndarray  # (P,) index of the curve that the joint follows, or -1
    curve_lead: np.ndarray  # (C,) coordinate
    curve_breaks: np.ndarray  # (C, B) padded with infinity
    curve_coefficients: np.ndarray  # (C, order, B)


@njit(cache=True, error_model="numpy")
def _curve_value(p, c, x):
    """Give value and slope of a joint that follows a curve."""
    breaks = p.curve_breaks[c]
    piece = 0
    while piece + 2 < breaks.shape[0] and x >= breaks[piece + 1]:
        if breaks[piece + 2] == np.inf:
            break
        piece += 1
    u = x - breaks[piece]
    value = 0.0
    slope = 0.0
    for k in range(p.curve_coefficients.shape[1]):
        slope = slope * u + value
        value = value * u + p.curve_coefficients[c, k, piece]
    return value, slope


@njit(cache=True, error_model="numpy")
def hand_and_jacobian(p, q, T, J, scratch):
    """Fill T (3,4), rotation and position of the hand, and J (6,n), linear rows first.

    `scratch` (P,7) holds axis, origin and slope of each joint.
    """
    n_path = p.matrix.shape[0]
    n = p.matrix.shape[1]
    c, s = p.base[0], p.base[1]
    T[:] = 0.0
    T[0, 0], T[0, 1], T[1, 0], T[1, 1], T[2, 2] = c, -s, s, c, 1.0
    for i in range(n_path):
        value = p.offset[i]
        slope = 0.0
        if p.curve[i] >= 0:
            k = p.curve[i]
            value, slope = _curve_value(p, k, q[p.curve_lead[k]])
        else:
            for j in range(n):
                value += p.matrix[i, j] * q[j]
        angle = p.angle_offset[i]
        if p.prismatic[i] == 0:
            angle += value
        c, s = np.cos(angle), np.sin(angle)
        ct, st = p.cos_twist[i], p.sin_twist[i]
        for a in range(3):
            x, y, z = T[a, 0], T[a, 1], T[a, 2]
            T[a, 3] += x * p.shift[i, 0] + y * p.shift[i, 1] + z * p.shift[i, 2]
            y, z = ct * y + st * z, ct * z - st * y
            T[a, 0] = c * x + s * y
            T[a, 1] = c * y - s * x
            T[a, 2] = z
            if p.prismatic[i] != 0:
                T[a, 3] += value * z
            scratch[i, a] = z
            scratch[i, 3 + a] = T[a, 3]
        scratch[i, 6] = slope
    for a in range(3):
        x, y, z = T[a, 0], T[a, 1], T[a, 2]
        T[a, 3] += x * p.tip_position[0] + y * p.tip_position[1] + z * p.tip_position[2]
        for b in range(3):
            T[a, b] = x * p.tip_rotation[0, b] + y * p.tip_rotation[1, b] + z * p.tip_rotation[2, b]
    J[:] = 0.0
    for i in range(n_path):
        zx, zy, zz = scratch[i, 0], scratch[i, 1], scratch[i, 2]
        if p.prismatic[i] == 0:
            dx, dy, dz = T[0, 3] - scratch[i, 3], T[1, 3] - scratch[i, 4], T[2, 3] - scratch[i, 5]
            vx, vy, vz = zy * dz - zz * dy, zz * dx - zx * dz, zx * dy - zy * dx
            wx, wy, wz = zx, zy, zz
        else:
            vx, vy, vz = zx, zy, zz
            wx, wy, wz = 0.0, 0.0, 0.0
        for j in range(n):
            share = p.matrix[i, j]
            if p.curve[i] >= 0:
                share = scratch[i, 6] if p.curve_lead[p.curve[i]] == j else 0.0
            if share != 0.0:
                J[0, j] += share * vx
                J[1, j] += share * vy
                J[2, j] += share * vz
                J[3, j] += share * wx
                J[4, j] += share * wy
                J[5, j] += share * wz


@njit(cache=True, error_model="numpy")
def _pose_error(T, goal, e):
    """Fill e (6): position and rotation vector that take T to the goal; give both sizes."""
    # M = R_goal R^T
    m00 = goal[0, 0] * T[0, 0] + goal[0, 1] * T[0, 1] + goal[0, 2] * T[0, 2]
    m01 = goal[0, 0] * T[1, 0] + goal[0, 1] * T[1, 1] + goal[0, 2] * T[1, 2]
    m02 = goal[0, 0] * T[2, 0] + goal[0, 1] * T[2, 1] + goal[0, 2] * T[2, 2]
    m10 = goal[1, 0] * T[0, 0] + goal[1, 1] * T[0, 1] + goal[1, 2] * T[0, 2]
    m11 = goal[1, 0] * T[1, 0] + goal[1, 1] * T[1, 1] + goal[1, 2] * T[1, 2]
    m12 = goal[1, 0] * T[2, 0] + goal[1, 1] * T[2, 1] + goal[1, 2] * T[2, 2]
    m20 = goal[2, 0] * T[0, 0] + goal[2, 1] * T[0, 1] + goal[2, 2] * T[0, 2]
    m21 = goal[2, 0] * T[1, 0] + goal[2, 1] * T[1, 1] + goal[2, 2] * T[1, 2]
    m22 = goal[2, 0] * T[2, 0] + goal[2, 1] * T[2, 1] + goal[2, 2] * T[2, 2]
    x, y, z = 0.5 * (m21 - m12), 0.5 * (m02 - m20), 0.5 * (m10 - m01)
    sine = np.sqrt(x * x + y * y + z * z)
    angle = np.arctan2(sine, 0.5 * (m00 + m11 + m22 - 1.0))
    # At half a turn the axis is lost; a step along any small remainder leads away from there.
    factor = angle / sine if sine > 1e-9 else 1.0
    for a in range(3):
        e[a] = goal[a, 3] - T[a, 3]
    e[3], e[4], e[5] = factor * x, factor * y, factor * z
    return np.sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2), angle


@njit(cache=True, error_model="numpy")
def solve_dense(A, b):
    """Solve A x = b in place by elimination with row pivots; False where A is singular."""
    n = A.shape[0]
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if not abs(A[pivot, k]) > 1e-13:
            return False
        if pivot != k:
            for j in range(k, n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, n):
            f = A[i, k] / A[k, k]
            if f != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= f * A[k, j]
                b[i] -= f * b[k]
    for k in range(n - 1, -1, -1):
        s = b[k]
        for j in range(k + 1, n):
            s -= A[k, j] * b[j]
        b[k] = s / A[k, k]
    return True


@njit(cache=True, error_model="numpy")
def refine_many(p, Q, goals, free, tolerance, max_iterations, iterations, errors):
    """Refine postures Q (K,n) in place by damped least squares towards goals (K,4,4).

    `free` (C,n) says which coordinates move; the rows are taken by turns ([Li2022] Table II).
    `tolerance` (2,) m and rad. Fills `iterations` (K,), -1 where not reached, and `errors` (K,2).
    """
    n = Q.shape[1]
    T, J = np.empty((3, 4)), np.empty((6, n))
    T2, J2 = np.empty((3, 4)), np.empty((6, n))
    scratch = np.empty((p.matrix.shape[0], 7))
    e, e2, y = np.empty(6), np.empty(6), np.empty(6)
    A, trial = np.empty((6, 6)), np.empty(n)
    for k in range(Q.shape[0]):
        q = Q[k]
        hand_and_jacobian(p, q, T, J, scratch)
        far, turn = _pose_error(T, goals[k], e)
        size = 0.0
        for a in range(6):
            size += e[a] * e[a]
        boost = 1e-2
        done = -1
        for iteration in range(max_iterations + 1):
            if far <= tolerance[0] and turn <= tolerance[1]:
                done = iteration
                break
            mask = free[iteration % free.shape[0]]
            # A damping that shrinks with the error keeps the last steps quadratic.
            damping = boost * size + 1e-15
            for a in range(6):
                for b in range(6):
                    s = damping if a == b else 0.0
                    for j in range(n):
                        s += mask[j] * J[a, j] * J[b, j]
                    A[a, b] = s
                y[a] = e[a]
            if not solve_dense(A, y):
                boost = min(max(10.0 * boost, 1e-6), 1e6)
                continue
            for j in range(n):
                s = 0.0
                for a in range(6):
                    s += J[a, j] * y[a]
                trial[j] = q[j] + mask[j] * min(max(s, -0.7), 0.7)
            hand_and_jacobian(p, trial, T2, J2, scratch)
            far2, turn2 = _pose_error(T2, goals[k], e2)
            size2 = 0.0
            for a in range(6):
                size2 += e2[a] * e2[a]
            if size2 < size:
                q[:] = trial
                far, turn, size = far2, turn2, size2
                T[:] = T2
                J[:] = J2
                e[:] = e2
                boost = max(0.1 * boost, 1e-8)
            else:
                boost = 10.0 * boost
                if boost > 1e8:
                    break
        iterations[k] = done
        errors[k, 0], errors[k, 1] = far, turn


@njit(cache=True, error_model="numpy")
def _tangent(J, before, M, t):
    """Fill t (7): unit vector of the null space of J that looks the way of `before`."""
    for a in range(6):
        for j in range(7):
            M[a, j] = J[a, j]
        t[a] = 0.0
    for j in range(7):
        M[6, j] = before[j]
    t[6] = 1.0
    if not solve_dense(M, t):
        return False
    size = 0.0
    for j in range(7):
        size += t[j] * t[j]
    size = np.sqrt(size)
    for j in range(7):
        t[j] /= size
    return True


@njit(cache=True, error_model="numpy")
def _correct(p, q, goal, row, wanted, T, J, scratch, e, M, d):
    """Bring q (7) onto the pose and ``row . q = wanted`` by Newton steps; True if it converged.

    On return T and J belong to a posture one (vanishing) step before q.
    """
    last = np.inf
    for _ in range(_CORRECTIONS):
        hand_and_jacobian(p, q, T, J, scratch)
        _pose_error(T, goal, e)
        rest = wanted
        for j in range(7):
            rest -= row[j] * q[j]
            M[6, j] = row[j]
            for a in range(6):
                M[a, j] = J[a, j]
        for a in range(6):
            d[a] = e[a]
        d[6] = rest
        if not solve_dense(M, d):
            return False
        size = 0.0
        for j in range(7):
            size = max(size, abs(d[j]))
        if size > 0.3 or size > 2.0 * last:
            return False
        for j in range(7):
            q[j] += d[j]
        if size < 1e-9:
            return True
        last = size
    return last < 1e-6


@njit(cache=True, error_model="numpy")
def null_direction(p, q, t):
    """Fill t (7) with the unit null vector of the Jacobian at q, whichever way it looks."""
    T, J = np.empty((3, 4)), np.empty((6, 7))
    M, guess = np.empty((7, 7)), np.zeros(7)
    scratch = np.empty((p.matrix.shape[0], 7))
    hand_and_jacobian(p, q, T, J, scratch)
    best = 0.0
    trial = np.empty(7)
    for j in range(7):  # the row that borders J best is the largest part of the null vector
        guess[:] = 0.0
        guess[j] = 1.0
        if _tangent(J, guess, M, trial) and abs(trial[j]) > best:
            best = abs(trial[j])
            t[:] = trial
    return best > 0.0


@njit(cache=True, error_model="numpy")
def _passed_start(nodes, tangents, count):
    """Tell whether the first node lies on the last stretch, walked the same way."""
    here, q = nodes[count - 2], nodes[count - 1]
    along, t = tangents[count - 2], tangents[count - 1]
    facing, begun, left, step = 0.0, 0.0, 0.0, 0.0
    for j in range(7):
        facing += t[j] * tangents[0, j]
        begun += along[j] * (nodes[0, j] - here[j])
        left += t[j] * (q[j] - nodes[0, j])
        step += (q[j] - here[j]) ** 2
    if facing < 0.9 or begun < 0.0 or left < 0.0:
        return False
    step = np.sqrt(step)
    u = begun / max(begun + left, 1e-300)
    off = 0.0
    for j in range(7):
        a, b, ta, tb = here[j], q[j], step * along[j], step * t[j]
        x = a + u * (ta + u * (3.0 * (b - a) - 2.0 * ta - tb + u * (2.0 * (a - b) + ta + tb)))
        off += (x - nodes[0, j]) ** 2
    return np.sqrt(off) < 0.05 * step


@njit(cache=True, error_model="numpy")
def trace(p, start, goal, direction, box, max_step, nodes, tangents, arc):
    """Walk along the manifold from `start` (7) the way of `direction` (7).

    Stops when the curve closes (the last node is then the first), leaves `box` (2,7), fills `nodes`
    (N,7), `tangents` (N,7) and `arc` (N,), or gets stuck. Gives the number of nodes and the reason.
    """
    T, J = np.empty((3, 4)), np.empty((6, 7))
    M, d, e = np.empty((7, 7)), np.empty(7), np.empty(6)
    scratch = np.empty((p.matrix.shape[0], 7))
    q, t = np.empty(7), np.empty(7)
    hand_and_jacobian(p, start, T, J, scratch)
    if not _tangent(J, direction, M, t):
        return 0, STUCK
    nodes[0], tangents[0], arc[0] = start, t, 0.0
    step = 0.5 * max_step
    count = 1
    while count < nodes.shape[0]:
        here, along = nodes[count - 1], tangents[count - 1]
        wanted = step
        for j in range(7):
            q[j] = here[j] + step * along[j]
            wanted += along[j] * here[j]
        good = _correct(p, q, goal, along, wanted, T, J, scratch, e, M, d)
        good = good and _tangent(J, along, M, t)
        bend, aside = 0.0, 0.0
        for j in range(7):
            bend += t[j] * along[j]
            aside += (q[j] - here[j] - 0.5 * step * (t[j] + along[j])) ** 2
        if not good or bend < 0.97 or aside > _ASIDE * _ASIDE:
            step *= 0.5
            if step < _SMALLEST_STEP:
                return count, STUCK
            continue
        nodes[count], tangents[count] = q, t
        length, outside = 0.0, False
        for j in range(7):
            length += (q[j] - here[j]) ** 2
            outside = outside or q[j] < box[0, j] or q[j] > box[1, j]
        arc[count] = arc[count - 1] + np.sqrt(length)
        count += 1
        if outside:
            return count, OUTSIDE
        if count > 4 and _passed_start(nodes, tangents, count):
            # The loop ends where it began, exactly.
            nodes[count - 1], tangents[count - 1] = nodes[0], tangents[0]
            length = ((nodes[0] - nodes[count - 2]) ** 2).sum()
            if length < 1e-16:  # the node before is the start already
                return count - 1, CLOSED
            arc[count - 1] = arc[count - 2] + np.sqrt(length)
            return count, CLOSED
        if bend > 0.995:
            step = min(1.5 * step, max_step)
    return count, FULL


@njit(cache=True, error_model="numpy")
def correct_many(p, Q, rows, wanted, goal):
    """Bring postures Q (K,7) onto the pose and ``rows[k] . Q[k] = wanted[k]``; gives success."""
    T, J = np.empty((3, 4)), np.empty((6, 7))
    M, d, e = np.empty((7, 7)), np.empty(7), np.empty(6)
    scratch = np.empty((p.matrix.shape[0], 7))
    good = np.empty(Q.shape[0], np.bool_)
    for k in range(Q.shape[0]):
        good[k] = _correct(p, Q[k], goal, rows[k], wanted[k], T, J, scratch, e, M, d)
    return good
