"""Constants and records that the compiled kernels of passive motion share; nothing compiled."""

from typing import NamedTuple

import numpy as np

WRIST, POINTING, POSITION = 0, 1, 2
REVOLUTE = 0
DONE, TOO_STIFF, RANK_LOST = 0, 1, 2
# Product of step and fastest rate up to which one Runge-Kutta step is taken: stable to 2.78, and
# here small enough for errors below 1e-5 rad (0.0006°) in the fastest part of a movement.
STEP_RATE = 0.5
# Steps in one output interval beyond which an implicit method is cheaper.
MAX_STEPS = 64
# Smallest ratio of a pivot of JW⁻¹Jᵀ to its diagonal entry at which J still has its rank.
PIVOT_TOLERANCE = 1e-12


class KernelTask(NamedTuple):
    """A task on the joints from the ground to one tip, every axis along z of its frame."""

    kind: int
    joint_type: np.ndarray  # (P,)
    rotations: np.ndarray  # (P, 3, 3)
    translations: np.ndarray  # (P, 3)
    point: np.ndarray  # (3,) tip, or direction times distance, in the last frame
    rows: np.ndarray  # (m, 3) rows of the task as combinations of x, y, z
    matrix: np.ndarray  # (P, n) joints from free coordinates
    offset: np.ndarray  # (P,)


class KernelLaw(NamedTuple):
    """What the joints do by themselves."""

    admittance: np.ndarray  # (n, n) W⁻¹, zero in rows and columns of locked joints
    relaxation: np.ndarray  # (n, n) W⁻¹K^J
    rest: np.ndarray  # (n,)
    slow_rate: float  # bound on the eigenvalues of `relaxation`
    elastic: float  # e: 1 with elasticity, 0 without (PMP1)
    blocked: float  # s: 1 where λ0 keeps the elasticity out of the task
    spring_time: float  # τ of eq. 8, 0 for a constant spring


class KernelDrive(NamedTuple):
    """What pulls the hand: for each movement a spring and the point that it is tied to."""

    start: np.ndarray  # (B, n)
    spring: np.ndarray  # (B, m, m)
    points: np.ndarray  # (B, S+1 or 1, m)
    velocities: np.ndarray  # same shape; used as feed-forward where `follow` is 1
    follow: float
    duration: float
    n_steps: int


class KernelOut(NamedTuple):
    """Where the samples of all movements go."""

    q: np.ndarray  # (B, S+1, n)
    qd: np.ndarray
    x: np.ndarray  # (B, S+1, m)
    xd: np.ndarray
    code: np.ndarray  # (B,) DONE, TOO_STIFF or RANK_LOST
    when: np.ndarray  # (B,) time of it (s)
