"""Compiled search for the places where a curve between nodes crosses the joint limits."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _hermite(a, b, ta, tb, u):
    """Give the cubic with end values a, b and end slopes ta, tb at u in [0, 1]."""
    return a + u * (ta + u * (3.0 * (b - a) - 2.0 * ta - tb + u * (2.0 * (a - b) + ta + tb)))


@njit(cache=True, error_model="numpy")
def limit_crossings(nodes, tangents, arc, limits, found):
    """Find where coordinates cross their limits (2,7) along nodes (N,7).

    Fills `found` (C,4): arc, coordinate, side (0 lower, 1 upper), segment; gives how many.
    """
    count = 0
    knots = np.empty(4)
    for k in range(nodes.shape[0] - 1):
        h = arc[k + 1] - arc[k]
        for j in range(7):
            a, b = nodes[k, j], nodes[k + 1, j]
            ta, tb = h * tangents[k, j], h * tangents[k + 1, j]
            # Extremes of the cubic: c + 2 b2 u + 3 a3 u^2 = 0
            a3, b2 = 2.0 * (a - b) + ta + tb, 3.0 * (b - a) - 2.0 * ta - tb
            n_knots = 1
            knots[0] = 0.0
            disc = b2 * b2 - 3.0 * a3 * ta
            if disc > 0.0:
                w = -(b2 + np.copysign(np.sqrt(disc), b2))
                u1 = w / (3.0 * a3) if a3 != 0.0 else -1.0
                u2 = ta / w if w != 0.0 else -1.0
                if u1 > u2:
                    u1, u2 = u2, u1
                if 0.0 < u1 < 1.0:
                    knots[n_knots] = u1
                    n_knots += 1
                if 0.0 < u2 < 1.0:
                    knots[n_knots] = u2
                    n_knots += 1
            knots[n_knots] = 1.0
            for side in range(2):
                limit = limits[side, j]
                for i in range(n_knots):
                    low, high = knots[i], knots[i + 1]
                    f_low = _hermite(a, b, ta, tb, low) - limit
                    f_high = _hermite(a, b, ta, tb, high) - limit
                    if (f_low < 0.0) == (f_high < 0.0):
                        continue
                    for _ in range(50):
                        mid = 0.5 * (low + high)
                        if (_hermite(a, b, ta, tb, mid) - limit < 0.0) == (f_low < 0.0):
                            low = mid
                        else:
                            high = mid
                    if count < found.shape[0]:
                        found[count, 0] = arc[k] + 0.5 * (low + high) * h
                        found[count, 1] = j
                        found[count, 2] = side
                        found[count, 3] = k
                        count += 1
    return count


@njit(cache=True, error_model="numpy")
def between_nodes(arc, nodes, tangents, s, Q, t):
    """Fill Q and t (K,n): points and unit tangents at places s, by cubics that fit both ends."""
    n = nodes.shape[1]
    for k in range(s.shape[0]):
        i = 0
        j = arc.shape[0] - 1
        while j - i > 1:
            middle = (i + j) // 2
            if s[k] < arc[middle]:
                j = middle
            else:
                i = middle
        h = arc[j] - arc[i] if j > i else 1.0
        u = (s[k] - arc[i]) / h
        size = 0.0
        for c in range(n):
            a, b = nodes[i, c], nodes[j, c]
            ta, tb = h * tangents[i, c], h * tangents[j, c]
            square = 3.0 * (b - a) - 2.0 * ta - tb
            cube = 2.0 * (a - b) + ta + tb
            Q[k, c] = a + u * (ta + u * (square + u * cube))
            t[k, c] = ta + u * (2.0 * square + u * 3.0 * cube)
            size += t[k, c] * t[k, c]
        size = np.sqrt(size)
        for c in range(n):
            t[k, c] /= size


@njit(cache=True, error_model="numpy")
def distance_to_curve(points, nodes, tangents, arc, near, distance):
    """Fill `distance` (S,): from points (S,n) to the cubics between nodes, greatest coordinate.

    Where a point is farther than `near` from a stretch's chord, that stretch is passed over.
    """
    n = nodes.shape[1]
    for k in range(points.shape[0]):
        distance[k] = np.inf
        for i in range(arc.shape[0] - 1):
            h = arc[i + 1] - arc[i]
            u = 0.0
            for c in range(n):
                u += (points[k, c] - nodes[i, c]) * (nodes[i + 1, c] - nodes[i, c])
            u = min(max(u / (h * h), 0.0), 1.0)
            far = 0.0
            for c in range(n):
                x = nodes[i, c] + u * (nodes[i + 1, c] - nodes[i, c])
                far = max(far, abs(points[k, c] - x))
            if far > near:
                continue
            for turn in range(4):
                slope = 0.0
                rest = 0.0
                far = 0.0
                for c in range(n):
                    a, b = nodes[i, c], nodes[i + 1, c]
                    ta, tb = h * tangents[i, c], h * tangents[i + 1, c]
                    square, cube = 3.0 * (b - a) - 2.0 * ta - tb, 2.0 * (a - b) + ta + tb
                    gap = points[k, c] - (a + u * (ta + u * (square + u * cube)))
                    d = ta + u * (2.0 * square + u * 3.0 * cube)
                    rest += d * gap
                    slope += d * d
                    far = max(far, abs(gap))
                distance[k] = min(distance[k], far)
                if turn < 3:
                    u = min(max(u + rest / max(slope, 1e-300), 0.0), 1.0)
