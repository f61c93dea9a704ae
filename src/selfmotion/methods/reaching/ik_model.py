"""Compiled kernels of inverse kinematics: joint values, axes and origins, the frame of the tip."""

import numpy as np

from selfmotion.kinematics import sine_cosine as trigonometry
from selfmotion.kinematics.compiled import compiled
from selfmotion.kinematics.sine_cosine import sine_cosine
from selfmotion.methods.reaching import ik_arrays
from selfmotion.methods.reaching.ik_arrays import DRIVER, KERNEL, Work

CALLED = (trigonometry, ik_arrays)


@compiled(*CALLED, **DRIVER)
def make_work(n_path, n):
    """Allocate the scratch memory."""
    return Work(
        np.zeros(n_path),
        np.zeros(n_path),
        np.zeros(n_path),
        np.zeros(n_path),
        np.zeros((n_path, 3)),
        np.zeros((n_path, 3)),
        np.zeros((3, 4)),
        np.zeros(6),
        np.zeros((3, 3)),
        np.zeros((6, n)),
        np.zeros((6, 6)),
        np.zeros((6, 6)),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(6),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n, np.uint8),
        np.zeros(n),
        np.zeros((3, 3, 3)),
    )


@compiled(*CALLED, **KERNEL)
def _curve(model, c, x):
    """Give value and slope of a piecewise polynomial."""
    breaks = model.curve_breaks[c]
    piece = 0
    while piece + 2 < breaks.shape[0] and x >= breaks[piece + 1] and breaks[piece + 2] < np.inf:
        piece += 1
    u = x - breaks[piece]
    value, slope = 0.0, 0.0
    for k in range(model.curve_coefficients.shape[1]):
        slope = slope * u + value
        value = value * u + model.curve_coefficients[c, k, piece]
    return value, slope


@compiled(*CALLED, **KERNEL)
def joint_values(model, q, w):
    """Fill the values of the path's joints, then their sines and cosines."""
    lead, curve, offset, values = model.lead, model.curve, model.offset, w.values
    matrix, turning, angle_offset = model.matrix, model.turning, model.angle_offset
    sines, cosines = w.sines, w.cosines
    n_path = lead.shape[0]
    for i in range(n_path):
        if lead[i] >= 0:
            values[i] = q[lead[i]] + offset[i]
        elif curve[i] >= 0:
            c = curve[i]
            values[i], w.slope[i] = _curve(model, c, q[model.curve_lead[c]])
        else:
            value = offset[i]
            for j in range(q.shape[0]):
                value += matrix[i, j] * q[j]
            values[i] = value
    for i in range(n_path):
        sines[i], cosines[i] = sine_cosine(turning[i] * values[i] + angle_offset[i])


@compiled(*CALLED, **KERNEL)
def forward(model, q, w):
    """Fill the axes and origins of the joints and the frame of the tip."""
    joint_values(model, q, w)
    shift, cos_twist, sin_twist, turning = (
        model.shift,
        model.cos_twist,
        model.sin_twist,
        model.turning,
    )
    axes, origins, values, sines, cosines = w.axes, w.origins, w.values, w.sines, w.cosines
    cb, sb = model.base[0], model.base[1]
    x0, x1, x2 = cb, sb, 0.0
    y0, y1, y2 = -sb, cb, 0.0
    z0, z1, z2 = 0.0, 0.0, 1.0
    p0, p1, p2 = 0.0, 0.0, 0.0
    for i in range(turning.shape[0]):
        a, b, d = shift[i, 0], shift[i, 1], shift[i, 2]
        p0 += x0 * a + y0 * b + z0 * d
        p1 += x1 * a + y1 * b + z1 * d
        p2 += x2 * a + y2 * b + z2 * d
        c, s = cos_twist[i], sin_twist[i]
        u0, u1, u2 = y0 * c + z0 * s, y1 * c + z1 * s, y2 * c + z2 * s
        z0, z1, z2 = z0 * c - y0 * s, z1 * c - y1 * s, z2 * c - y2 * s
        axes[i, 0], axes[i, 1], axes[i, 2] = z0, z1, z2
        origins[i, 0], origins[i, 1], origins[i, 2] = p0, p1, p2
        if turning[i] == 0.0:
            slide = values[i]
            p0, p1, p2 = p0 + z0 * slide, p1 + z1 * slide, p2 + z2 * slide
        c, s = cosines[i], sines[i]
        y0, y1, y2 = u0 * c - x0 * s, u1 * c - x1 * s, u2 * c - x2 * s
        x0, x1, x2 = x0 * c + u0 * s, x1 * c + u1 * s, x2 * c + u2 * s
    R, t, hand = model.tip_rotation, model.tip_position, w.hand
    for b in range(3):
        hand[0, b] = x0 * R[0, b] + y0 * R[1, b] + z0 * R[2, b]
        hand[1, b] = x1 * R[0, b] + y1 * R[1, b] + z1 * R[2, b]
        hand[2, b] = x2 * R[0, b] + y2 * R[1, b] + z2 * R[2, b]
    hand[0, 3] = p0 + x0 * t[0] + y0 * t[1] + z0 * t[2]
    hand[1, 3] = p1 + x1 * t[0] + y1 * t[1] + z1 * t[2]
    hand[2, 3] = p2 + x2 * t[0] + y2 * t[1] + z2 * t[2]
