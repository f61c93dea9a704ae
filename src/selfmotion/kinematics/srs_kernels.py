"""Compiled kernels of the spherical-revolute-spherical relative (`kinematics.srs`).

The functions call each other and so stand in one file, since numba's cache does not notice a
change in another.
"""

from typing import NamedTuple

import numpy as np
from numba import njit


class SrsArrays(NamedTuple):
    """The relative as arrays for the kernel; all directions in ground axes at the home posture."""

    shoulder: np.ndarray  # (3,) centre
    upper_arm: np.ndarray  # (3,) shoulder to elbow
    forearm: np.ndarray  # (3,) elbow to wrist
    axes: np.ndarray  # (7, 3) of the relative's seven angles
    hand_rotation: np.ndarray  # (3, 3) R_ground_hand at home
    wrist_in_hand: np.ndarray  # (3,) wrist centre in the hand frame
    down: np.ndarray  # (3,)
    sideways: np.ndarray  # (3,) stands in for `down` where the line shoulder-wrist is vertical
    mapping: np.ndarray  # (7, 7) K of eq. 6: coordinates of the arm from angles of the relative
    home: np.ndarray  # (7,) coordinates of the arm at home
    elbow_range: np.ndarray  # (2,) angles of the elbow that are worth a posture


class StartChoice(NamedTuple):
    """Which postures of the relative are worth a start, for the kernel `srs_starts`."""

    steps: int = 24  # of swivel angle, round the whole turn
    levels: int = 6  # how often a step is halved
    fast: float = 0.6  # rad in one step: halve it
    most_halvings: int = 64  # for one shoulder centre
    margin: float = 0.8  # rad outside the limits
    out_of_reach: float = 0.3  # in units of sines
    elevation_share: float = 0.75  # of the distance between two elevations, from its own


@njit(cache=True)
def _turn(axis, angle, v):
    """Rotate v about a unit axis."""
    c, s = np.cos(angle), np.sin(angle)
    d = (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]) * (1.0 - c)
    return np.array(
        (
            c * v[0] + s * (axis[1] * v[2] - axis[2] * v[1]) + d * axis[0],
            c * v[1] + s * (axis[2] * v[0] - axis[0] * v[2]) + d * axis[1],
            c * v[2] + s * (axis[0] * v[1] - axis[1] * v[0]) + d * axis[2],
        )
    )


@njit(cache=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _crossed(a, b):
    return np.array(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )


@njit(cache=True)
def _two_angles(axis, u, v, wanted):
    """Solve ``u . Rot(axis, x) v = wanted``: two angles, and by how far it is out of reach."""
    along = _dot(axis, u) * _dot(axis, v)
    a = _dot(u, v) - along
    b = _dot(u, _crossed(axis, v))
    size = np.sqrt(a * a + b * b)
    ratio = (wanted - along) / max(size, 1e-300)
    out = max(abs(ratio) - 1.0, 0.0)
    middle = np.arctan2(b, a)
    half = np.arccos(min(max(ratio, -1.0), 1.0))
    return middle + half, middle - half, out


@njit(cache=True)
def _angle_between(axis, u, v):
    """Give the angle about `axis` that takes the part of u square to it onto that of v."""
    c = _dot(u, v) - _dot(axis, u) * _dot(axis, v)
    s = _dot(axis, _crossed(u, v))
    return np.arctan2(s, c)


@njit(cache=True)
def _three_angles(R, a1, a2, a3, out):
    """Split R over three axes: out (2,3) holds both solutions; gives how far out of reach."""
    x, y, beyond = _two_angles(a2, a1, a3, _dot(a1, R @ a3))
    for i in range(2):
        t2 = x if i == 0 else y
        out[i, 1] = t2
        out[i, 0] = _angle_between(a1, _turn(a2, t2, a3), R @ a3)
        out[i, 2] = -_angle_between(a3, _turn(a2, -t2, a1), R.T @ a1)
    return beyond


@njit(cache=True)
def _frame(u, v):
    """Give a rotation with first column along u and second in the plane of u and v."""
    F = np.empty((3, 3))
    e = u / np.sqrt(_dot(u, u))
    w = v - _dot(v, e) * e
    size = np.sqrt(_dot(w, w))
    if size < 1e-12:  # a straight arm: any plane will do
        w = _crossed(e, np.array((e[1], e[2], -e[0])))
        size = np.sqrt(_dot(w, w))
    f = w / size
    F[:, 0] = e
    F[:, 1] = f
    F[:, 2] = _crossed(e, f)
    return F


@njit(cache=True)
def _rotation(axis, angle):
    R = np.empty((3, 3))
    for i in range(3):
        e = np.zeros(3)
        e[i] = 1.0
        R[:, i] = _turn(axis, angle, e)
    return R


@njit(cache=True)
def srs_postures(s, T_hand, swivel, middle):
    """Give postures (P,8,7) and how far out of reach they are (P,8), for P swivel angles."""
    return _postures_at(s, s.shoulder, T_hand, swivel, middle)


@njit(cache=True)
def _postures_at(s, centre, T_hand, swivel, middle):
    n = swivel.shape[0]
    q = np.empty((n, 8, 7))
    out = np.empty((n, 8))
    R_hand = np.ascontiguousarray(T_hand[:3, :3])
    W = T_hand[:3, 3] + R_hand @ s.wrist_in_hand
    SW = W - centre
    D = np.sqrt(_dot(SW, SW))
    along = SW / D
    down = s.down - _dot(s.down, along) * along
    if _dot(down, down) < 1e-18:
        down = s.sideways - _dot(s.sideways, along) * along
    down = down / np.sqrt(_dot(down, down))
    side = _crossed(down, along)
    du2, df2 = _dot(s.upper_arm, s.upper_arm), _dot(s.forearm, s.forearm)
    # |u + Rot(a4) f|^2 = D^2
    x4, y4, far = _two_angles(s.axes[3], s.upper_arm, s.forearm, 0.5 * (D * D - du2 - df2))
    R_back = np.ascontiguousarray(s.hand_rotation.T)
    shoulder, wrist = np.empty((2, 3)), np.empty((2, 3))
    for k in range(n):
        c, r = np.cos(swivel[k]), np.sin(swivel[k])
        outwards = c * down + r * side
        i = 0
        for elbow in range(2):
            t4 = x4 if elbow == 0 else y4
            t4 -= 2.0 * np.pi * np.round(t4 / (2.0 * np.pi))
            if not s.elbow_range[0] <= t4 <= s.elbow_range[1]:
                q[k, i : i + 4] = np.nan
                out[k, i : i + 4] = np.inf
                i += 4
                continue
            reach = s.upper_arm + _turn(s.axes[3], t4, s.forearm)
            length = np.sqrt(_dot(reach, reach))
            part = _dot(s.upper_arm, reach) / max(length, 1e-12)
            rise = np.sqrt(max(du2 - part * part, 0.0))
            R_S = _frame(along, part * along + rise * outwards) @ _frame(reach, s.upper_arm).T
            R_S = np.ascontiguousarray(R_S)
            R_F = _rotation(s.axes[3], -t4) @ np.ascontiguousarray(R_S.T) @ R_hand @ R_back
            one = _three_angles(R_S, s.axes[0], s.axes[1], s.axes[2], shoulder)
            two = _three_angles(R_F, s.axes[4], s.axes[5], s.axes[6], wrist)
            for a in range(2):
                for b in range(2):
                    out[k, i] = max(far, max(one, two))
                    for j in range(7):
                        v = s.home[j]
                        for m in range(3):
                            v += s.mapping[j, m] * shoulder[a, m]
                            v += s.mapping[j, 4 + m] * wrist[b, m]
                        v += s.mapping[j, 3] * t4
                        turns = np.round((v - middle[j]) / (2.0 * np.pi))
                        q[k, i, j] = v - 2.0 * np.pi * turns
                    i += 1
    return q, out


@njit(cache=True)
def srs_starts(s, centres, elevations, T_hand, limits, choice):
    """Collect postures (S,7) near the box of limits (2,7), and their scores (S,).

    The relative stands at each of the `centres` (C,3) by turns, which are right for `elevations`
    (C,). The swivel angle goes round by steps, halved wherever a branch turns a coordinate fast
    on its way through the box, as beside a singular shoulder or wrist.
    """
    middle = 0.5 * (limits[0] + limits[1])
    most = centres.shape[0] * (choice.steps + choice.most_halvings) * 8
    found, score = np.empty((most, 7)), np.empty(most)
    count = 0
    share = np.inf
    if centres.shape[0] > 1:
        share = choice.elevation_share * abs(elevations[1] - elevations[0])
    swivel = np.empty(choice.steps)
    for k in range(choice.steps):
        swivel[k] = -np.pi + 2.0 * np.pi * k / choice.steps
    # Stretches of swivel that are still to be looked at, with the postures at their ends.
    depth = 2 * choice.levels + 4
    low, high, level = np.empty(depth), np.empty(depth), np.empty(depth, np.int64)
    q_low, q_high = np.empty((depth, 8, 7)), np.empty((depth, 8, 7))
    one = np.empty(1)
    for c in range(centres.shape[0]):
        q, out = _postures_at(s, centres[c], T_hand, swivel, middle)
        for k in range(choice.steps):
            count = _keep(q[k], out[k], limits, elevations[c], share, choice, found, score, count)
        halvings = 0
        for k in range(choice.steps):
            top = 0
            low[0], high[0], level[0] = swivel[k], swivel[k] + 2.0 * np.pi / choice.steps, 0
            q_low[0], q_high[0] = q[k], q[(k + 1) % choice.steps]
            while top >= 0 and halvings < choice.most_halvings:
                turns_fast = level[top] < choice.levels and _turns_fast(
                    q_low[top], q_high[top], limits, elevations[c], share, choice
                )
                if not turns_fast:
                    top -= 1
                    continue
                one[0] = 0.5 * (low[top] + high[top])
                q_one, out_one = _postures_at(s, centres[c], T_hand, one, middle)
                halvings += 1
                count = _keep(
                    q_one[0], out_one[0], limits, elevations[c], share, choice, found, score, count
                )
                level[top] += 1
                low[top + 1], high[top + 1], level[top + 1] = low[top], one[0], level[top]
                q_low[top + 1], q_high[top + 1] = q_low[top], q_one[0]
                low[top] = one[0]
                q_low[top] = q_one[0]
                top += 1
    return found[:count], score[:count]


@njit(cache=True)
def _keep(q, out, limits, elevation, share, choice, found, score, count):
    """Append those of the postures (8,7) that are finite; gives the new number of postures."""
    for i in range(8):
        if not np.isfinite(out[i]):
            continue
        worst = -np.inf
        for j in range(7):
            worst = max(worst, limits[0, j] - q[i, j], q[i, j] - limits[1, j])
        worst += out[i]
        if out[i] > choice.out_of_reach or abs(q[i, 1] - elevation) > share:
            worst += 10.0
        found[count] = q[i]
        score[count] = worst
        count += 1
    return count


@njit(cache=True)
def _turns_fast(q_low, q_high, limits, elevation, share, choice):
    """Tell whether a branch turns a coordinate fast between two swivel angles, near the box."""
    for i in range(8):
        fast, near = False, True
        for j in range(7):
            a = q_low[i, j]
            d = q_high[i, j] - a
            if not np.isfinite(d):
                near = False
                break
            d -= 2.0 * np.pi * np.round(d / (2.0 * np.pi))
            least, most = min(a, a + d), max(a, a + d)
            fast = fast or abs(d) > choice.fast
            if most - least < np.pi and (
                least > limits[1, j] + choice.margin or most < limits[0, j] - choice.margin
            ):
                near = False
            if j == 1 and (least > elevation + share or most < elevation - share):
                near = False
        if fast and near:
            return True
    return False
