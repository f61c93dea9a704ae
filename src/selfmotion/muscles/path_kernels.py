"""Compiled lengths and moment arms of muscle paths over sites, spheres and cylinders.

The geometry is MuJoCo's: a path is straight between sites; on a sphere or cylinder it lies as a
circular arc in the plane of the two sites (a helix on a cylinder), on the side that the side site
names; where that site is inside the surface, the path touches it from inside, at one point.
Written out here since most of the time of a natural posture goes into paths, and one pass over a
posture takes about half of what MuJoCo's general machinery takes. Deviation: where a path touches
from inside, the angle is solved for to rounding, and not to 1e-6. MuJoCo is the oracle in the
tests. The functions call each other and so stand in one file, since numba's cache does not notice
a change in another.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

SITE, SPHERE, CYLINDER = 0, 1, 2
GROUND, NO_SIDE = -1, -2
_TINY = 1e-15
# Steps and tolerance (rad) of Newton's method for a path that touches a surface from inside.
_INSIDE_STEPS, _INSIDE_TOLERANCE = 60, 1e-13


class PathTables(NamedTuple):
    """Paths of M muscles over E elements, and the joints that carry them."""

    first: np.ndarray  # (M + 1,) where each path's elements begin
    kind: np.ndarray  # (E,) SITE, SPHERE or CYLINDER
    carrier: np.ndarray  # (E,) joint whose body carries the element, or GROUND
    place: np.ndarray  # (E, 3) its origin in the joint's z-frame (m)
    turn: np.ndarray  # (E, 3, 3) its axes there (surfaces)
    radius: np.ndarray  # (E,) m
    side_carrier: np.ndarray  # (E,) of the side site; NO_SIDE where there is none
    side_place: np.ndarray  # (E, 3)
    gear: np.ndarray  # (M,) factor of length
    parent: np.ndarray  # (N,)
    prismatic: np.ndarray  # (N,) bool


@njit(cache=True, error_model="numpy")
def _place_all(R, p, carriers, local, out):
    """Fill out (E,3) with points of the joints' z-frames in the ground."""
    for e in range(carriers.shape[0]):
        c = carriers[e]
        x, y, z = local[e, 0], local[e, 1], local[e, 2]
        if c < 0:
            out[e, 0], out[e, 1], out[e, 2] = x, y, z
            continue
        for a in range(3):
            out[e, a] = p[c, a] + R[c, a, 0] * x + R[c, a, 1] * y + R[c, a, 2] * z


@njit(cache=True, error_model="numpy")
def _crossing(a0, a1, b0, b1, c0, c1, d0, d1):
    """Tell whether the segments a-b and c-d in the plane cross."""
    det = (d1 - c1) * (b0 - a0) - (d0 - c0) * (b1 - a1)
    if abs(det) < _TINY:
        return False
    s = ((d0 - c0) * (a1 - c1) - (d1 - c1) * (a0 - c0)) / det
    t = ((b0 - a0) * (a1 - c1) - (b1 - a1) * (a0 - c0)) / det
    return 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0


@njit(cache=True, error_model="numpy")
def _around(x0, y0, x1, y1, side0, side1, has_side, radius):
    """Give the arc of a path around a circle, -1 where it misses it, and where it touches."""
    none = (-1.0, 0.0, 0.0, 0.0, 0.0)
    far0, far1, square = x0 * x0 + y0 * y0, x1 * x1 + y1 * y1, radius * radius
    dx, dy = x1 - x0, y1 - y0
    apart = dx * dx + dy * dy
    if far0 < square or far1 < square or radius < _TINY or apart < _TINY:
        return none
    share = min(max(-(dx * x0 + dy * y0) / apart, 0.0), 1.0)
    nx, ny = x0 + share * dx, y0 + share * dy
    if nx * nx + ny * ny > square and (not has_side or side0 * nx + side1 * ny >= 0.0):
        return none
    root0, root1 = np.sqrt(far0 - square), np.sqrt(far1 - square)
    best, chosen = -np.inf, 0
    t0, t1, t2, t3 = 0.0, 0.0, 0.0, 0.0
    crossed = False
    for i in range(2):
        sign = 1.0 if i == 0 else -1.0
        a0 = (x0 * square + sign * radius * y0 * root0) / far0
        a1 = (y0 * square - sign * radius * x0 * root0) / far0
        b0 = (x1 * square - sign * radius * y1 * root1) / far1
        b1 = (y1 * square + sign * radius * x1 * root1) / far1
        if has_side:
            tx, ty = a0 + b0, a1 + b1
            size = np.sqrt(tx * tx + ty * ty)
            good = (tx * side0 + ty * side1) / size if size > _TINY else side0
        else:
            good = -((a0 - b0) ** 2 + (a1 - b1) ** 2)
        meets = _crossing(x0, y0, a0, a1, x1, y1, b0, b1)
        if meets:
            good = -10000.0
        if good > best:
            best, chosen, crossed = good, i, meets
            t0, t1, t2, t3 = a0, a1, b0, b1
    if crossed:
        return none
    cosine = (t0 * t2 + t1 * t3) / square
    angle = np.arccos(min(max(cosine, -1.0), 1.0))
    turn = t1 * t2 - t0 * t3
    if (turn > 0.0 and chosen == 1) or (turn < 0.0 and chosen == 0):
        angle = 2.0 * np.pi - angle
    return radius * angle, t0, t1, t2, t3


@njit(cache=True, error_model="numpy")
def _through(x0, y0, x1, y1, radius):
    """Give 0 for a path that touches a circle from inside, -1 where it does not, and where.

    The path is shortest where both straight parts meet the circle at the same angle h: with
    A = radius / distance of an end, ``asin(A sin h) + asin(B sin h) - 2 h + G = 0``, G the angle
    between the ends. This falls from G at h = 0 to below 0 at a right angle wherever the straight
    line passes the circle by, so that the root is there and is the only one.
    """
    none = (-1.0, 0.0, 0.0, 0.0, 0.0)
    far0, far1 = np.sqrt(x0 * x0 + y0 * y0), np.sqrt(x1 * x1 + y1 * y1)
    if far0 <= radius or far1 <= radius or radius < _TINY:
        return none
    A, B = radius / far0, radius / far1
    cross = x0 * y1 - y0 * x1
    G = np.arctan2(abs(cross), x0 * x1 + y0 * y1)
    low, high = 0.0, 0.5 * np.pi
    if np.arcsin(A) + np.arcsin(B) - np.pi + G >= 0.0:  # the straight line goes through it
        return none
    h = 0.25 * np.pi
    for _ in range(_INSIDE_STEPS):
        s, c = np.sin(h), np.cos(h)
        f = np.arcsin(A * s) + np.arcsin(B * s) - 2.0 * h + G
        if f > 0.0:
            low = h
        else:
            high = h
        slope = A * c / np.sqrt(1.0 - A * A * s * s) + B * c / np.sqrt(1.0 - B * B * s * s) - 2.0
        step = h - f / slope
        if not low <= step <= high:
            step = 0.5 * (low + high)
        moved = abs(step - h)
        h = step
        if moved < _INSIDE_TOLERANCE:
            break
    turn = h - np.arcsin(A * np.sin(h))
    if cross < 0.0:
        turn = -turn
    c, s = radius * np.cos(turn) / far0, radius * np.sin(turn) / far0
    return 0.0, c * x0 - s * y0, s * x0 + c * y0, c * x0 - s * y0, s * x0 + c * y0


@njit(cache=True, error_model="numpy")
def _plane(a0, a1, a2, b0, b1, b2):
    """Give two unit vectors in the plane of two points and the centre of a sphere."""
    size = np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
    u0, u1, u2 = a0 / size, a1 / size, a2 / size
    n0, n1, n2 = u1 * b2 - u2 * b1, u2 * b0 - u0 * b2, u0 * b1 - u1 * b0
    size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if size < _TINY:  # both points and the centre on one line: any plane will do
        w0 = 1.0 if abs(u0) <= abs(u1) and abs(u0) <= abs(u2) else 0.0
        w1 = 1.0 if w0 == 0.0 and abs(u1) <= abs(u2) else 0.0
        w2 = 1.0 - w0 - w1
        n0, n1, n2 = u1 * w2 - u2 * w1, u2 * w0 - u0 * w2, u0 * w1 - u1 * w0
        size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    n0, n1, n2 = n0 / size, n1 / size, n2 / size
    return u0, u1, u2, n1 * u2 - n2 * u1, n2 * u0 - n0 * u2, n0 * u1 - n1 * u0


@njit(cache=True, error_model="numpy")
def _turn_all(R, carriers, surfaces, local, axes):
    """Fill axes (E,3,3) of the surfaces: columns are their axes in the ground."""
    for i in range(surfaces.shape[0]):
        e = surfaces[i]
        c = carriers[e]
        for a in range(3):
            for b in range(3):
                if c < 0:
                    axes[e, a, b] = local[e, a, b]
                    continue
                axes[e, a, b] = (
                    R[c, a, 0] * local[e, 0, b]
                    + R[c, a, 1] * local[e, 1, b]
                    + R[c, a, 2] * local[e, 2, b]
                )


@njit(cache=True, error_model="numpy")
def _into(axes, e, x, y, z):
    """Give the parts of a vector along the axes of surface e."""
    return (
        axes[e, 0, 0] * x + axes[e, 1, 0] * y + axes[e, 2, 0] * z,
        axes[e, 0, 1] * x + axes[e, 1, 1] * y + axes[e, 2, 1] * z,
        axes[e, 0, 2] * x + axes[e, 1, 2] * y + axes[e, 2, 2] * z,
    )


@njit(cache=True, error_model="numpy")
def _wrap(surface, radius, has_side, e, X, side, axes, met):
    """Fill met (2,3) with where a path between the sites around surface e meets it.

    Gives the length of the arc, -1 where it does not meet it.
    """
    o0, o1, o2 = X[e, 0], X[e, 1], X[e, 2]
    a0, a1, a2 = _into(axes, e, X[e - 1, 0] - o0, X[e - 1, 1] - o1, X[e - 1, 2] - o2)
    b0, b1, b2 = _into(axes, e, X[e + 1, 0] - o0, X[e + 1, 1] - o1, X[e + 1, 2] - o2)
    tiny = _TINY * _TINY
    if a0 * a0 + a1 * a1 + a2 * a2 < tiny or b0 * b0 + b1 * b1 + b2 * b2 < tiny:
        return -1.0
    u0, u1, u2, v0, v1, v2 = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    if surface == SPHERE:
        u0, u1, u2, v0, v1, v2 = _plane(a0, a1, a2, b0, b1, b2)
    x0, y0 = u0 * a0 + u1 * a1 + u2 * a2, v0 * a0 + v1 * a1 + v2 * a2
    x1, y1 = u0 * b0 + u1 * b1 + u2 * b2, v0 * b0 + v1 * b1 + v2 * b2
    inside, side0, side1 = False, 1.0, 0.0
    if has_side:
        s0, s1, s2 = _into(axes, e, side[e, 0] - o0, side[e, 1] - o1, side[e, 2] - o2)
        inside = s0 * s0 + s1 * s1 + s2 * s2 < radius * radius
        side0, side1 = u0 * s0 + u1 * s1 + u2 * s2, v0 * s0 + v1 * s1 + v2 * s2
        size = np.sqrt(side0 * side0 + side1 * side1)
        if size > _TINY:
            side0, side1 = side0 / size, side1 / size
        else:
            side0, side1 = 1.0, 0.0
    if inside:
        arc, t0, t1, t2, t3 = _through(x0, y0, x1, y1, radius)
    else:
        arc, t0, t1, t2, t3 = _around(x0, y0, x1, y1, side0, side1, has_side, radius)
    if arc < 0.0:
        return -1.0
    m0, m1, m2 = u0 * t0 + v0 * t1, u1 * t0 + v1 * t1, u2 * t0 + v2 * t1
    n0, n1, n2 = u0 * t2 + v0 * t3, u1 * t2 + v1 * t3, u2 * t2 + v2 * t3
    if surface == CYLINDER:
        before, after = np.hypot(a0 - m0, a1 - m1), np.hypot(b0 - n0, b1 - n1)
        rise, whole = b2 - a2, before + arc + after
        m2, n2 = a2 + rise * before / whole, b2 - rise * after / whole
        arc = np.hypot(arc, n2 - m2)
    met[0, 0] = o0 + axes[e, 0, 0] * m0 + axes[e, 0, 1] * m1 + axes[e, 0, 2] * m2
    met[0, 1] = o1 + axes[e, 1, 0] * m0 + axes[e, 1, 1] * m1 + axes[e, 1, 2] * m2
    met[0, 2] = o2 + axes[e, 2, 0] * m0 + axes[e, 2, 1] * m1 + axes[e, 2, 2] * m2
    met[1, 0] = o0 + axes[e, 0, 0] * n0 + axes[e, 0, 1] * n1 + axes[e, 0, 2] * n2
    met[1, 1] = o1 + axes[e, 1, 0] * n0 + axes[e, 1, 1] * n1 + axes[e, 1, 2] * n2
    met[1, 2] = o2 + axes[e, 2, 0] * n0 + axes[e, 2, 1] * n1 + axes[e, 2, 2] * n2
    return arc


@njit(cache=True, error_model="numpy", inline="always")
def _straight(parent, prismatic, R, p, A, a, carrier_a, B, b, carrier_b, slope):
    """Give the length from A[a] to B[b], and add its derivative by every joint to slope (N,)."""
    u0, u1, u2 = B[b, 0] - A[a, 0], B[b, 1] - A[a, 1], B[b, 2] - A[a, 2]
    length = np.sqrt(u0 * u0 + u1 * u1 + u2 * u2)
    if length < _TINY or carrier_a == carrier_b:
        return length
    u0, u1, u2 = u0 / length, u1 / length, u2 / length
    # u . (z x (x - o)) = z . ((x - o) x u) is the same for both ends, as u lies along a - b.
    x0, x1, x2 = A[a, 0], A[a, 1], A[a, 2]
    i, j = carrier_a, carrier_b
    while i != j:  # joints that carry both ends do not change their distance
        if i > j:
            k, sign = i, -1.0
            i = parent[i]
        else:
            k, sign = j, 1.0
            j = parent[j]
        z0, z1, z2 = R[k, 0, 2], R[k, 1, 2], R[k, 2, 2]
        if prismatic[k]:
            slope[k] += sign * (u0 * z0 + u1 * z1 + u2 * z2)
            continue
        d0, d1, d2 = x0 - p[k, 0], x1 - p[k, 1], x2 - p[k, 2]
        slope[k] += sign * (
            z0 * (d1 * u2 - d2 * u1) + z1 * (d2 * u0 - d0 * u2) + z2 * (d0 * u1 - d1 * u0)
        )
    return length


@njit(cache=True, error_model="numpy")
def lengths_and_moment_arms(t, R, p, coupling, lengths, arms):
    """Fill lengths (K,M) and moment arms (K,M,n) from frames R (K,N,3,3), p (K,N,3)."""
    n_samples, n_muscles = lengths.shape
    n_joints, n = coupling.shape[1], coupling.shape[2]
    n_elements = t.kind.shape[0]
    first, kind, carrier, radius = t.first, t.kind, t.carrier, t.radius
    parent, prismatic, gear, side_carrier = t.parent, t.prismatic, t.gear, t.side_carrier
    surfaces = np.flatnonzero(kind != SITE)
    X, side = np.empty((n_elements, 3)), np.empty((n_elements, 3))
    axes, met = np.empty((n_elements, 3, 3)), np.empty((2, 3))
    slope = np.empty(n_joints)
    for k in range(n_samples):
        Rk, pk = R[k], p[k]
        _place_all(Rk, pk, carrier, t.place, X)
        _place_all(Rk, pk, side_carrier, t.side_place, side)
        _turn_all(Rk, carrier, surfaces, t.turn, axes)
        for m in range(n_muscles):
            slope[:] = 0.0
            length = 0.0
            e, last = first[m], first[m + 1] - 1
            while e < last:
                ahead = e + 1 if kind[e + 1] == SITE else e + 2
                c0, c1, s = carrier[e], carrier[ahead], e + 1
                arc = -1.0
                if ahead == e + 2:
                    has_side = side_carrier[s] != NO_SIDE
                    arc = _wrap(kind[s], radius[s], has_side, s, X, side, axes, met)
                if arc < 0.0:
                    length += _straight(parent, prismatic, Rk, pk, X, e, c0, X, ahead, c1, slope)
                else:
                    c = carrier[s]
                    length += arc
                    length += _straight(parent, prismatic, Rk, pk, X, e, c0, met, 0, c, slope)
                    length += _straight(parent, prismatic, Rk, pk, met, 1, c, X, ahead, c1, slope)
                e = ahead
            lengths[k, m] = gear[m] * length
            for c in range(n):
                arms[k, m, c] = 0.0
            for i in range(n_joints):
                if slope[i] != 0.0:
                    v = -gear[m] * slope[i]
                    for c in range(n):
                        arms[k, m, c] += v * coupling[k, i, c]
