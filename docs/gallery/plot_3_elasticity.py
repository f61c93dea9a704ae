"""
A person's joint elasticity from postures alone
===============================================

Postures of a wrist with half a degree of noise, as sensors give them, and the law behind them:
how far the targets reach decides what can be told.
"""

import matplotlib.pyplot as plt
import numpy as np

import selfmotion as sm
from selfmotion.methods.elasticity.posture import donders_postures

law = sm.JointLaw(np.diag([0.5, 1.5, 2.0]), rest=np.radians([5.0, 0.0, 0.0]))
task = sm.Pointing(sm.load_arm("wrist"))
rng = np.random.default_rng(7)


def measured(reach_deg: float) -> np.ndarray:
    """Give noisy postures toward random targets within a reach."""
    radius = np.sin(np.radians(reach_deg)) * np.sqrt(rng.random(400))
    angle = 2 * np.pi * rng.random(400)
    targets = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    q = donders_postures(task, law, targets).q
    return q + rng.normal(scale=np.radians(0.5), size=q.shape)


# %%
# The same person, looked at within 15 and within 30 degrees.

fits = {reach: sm.fit_elasticity(measured(reach)) for reach in (15, 30)}
for reach, fit in fits.items():
    print(f"±{reach}°: {fit.status}")
    for sentence in fit.sentences:
        print(f"    {sentence}")

# %%
# At ±15° the stiffness of pronation is hardly told; its interval says so.

true = np.diag(law.stiffness) * 4 / np.trace(law.stiffness)
fig, ax = plt.subplots(figsize=(6, 3))
for k, (reach, fit) in enumerate(fits.items()):
    at = np.arange(3) + 0.2 * k - 0.1
    K, error = np.diag(fit.stiffness), 1.96 * np.diag(fit.stiffness_stderr)
    colour = ("#E69F00", "#0072B2")[k]
    ax.errorbar(at, K, error, fmt="o", capsize=4, color=colour, label=f"within ±{reach}°")
ax.plot(range(3), true, "x", color="#24292F", ms=9, label="true")
ax.set_xticks(range(3), fit.joints)
ax.set_ylabel("stiffness (N m/rad, trace 4)")
ax.legend()
plt.tight_layout()
plt.show()
