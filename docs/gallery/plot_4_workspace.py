"""
What does a splinted elbow take away?
=====================================

The workspace of the nine-joint arm, free and with the elbow held between 64 and 114 degrees.
"""

import matplotlib.pyplot as plt
import numpy as np

import selfmotion as sm
from selfmotion.methods.workspace import WorkspaceOptions

arm = sm.load_arm("upper_limb")
splint = arm.with_limits({"elbow_flexion": tuple(np.radians([64.2, 114.0]))})
found = sm.workspace(arm, limited=splint, options=WorkspaceOptions(n_points=4096, shifts=4))
for name, region in found.regions.items():
    print(f"{name:8s} {region.volume:6.4f} ± {region.standard_error:.4f} m³")

# %%
# Points of a thin layer at shoulder height, kept and lost.

fig, ax = plt.subplots(figsize=(5, 5))
for name, colour in (("limited", "#0072B2"), ("lost", "#E69F00")):
    region = found.regions[name]
    near = region.inside & (np.abs(region.points[:, 2]) < 0.03)
    label = {"limited": "kept", "lost": "lost"}[name]
    ax.plot(*region.points[near, :2].T, ".", ms=3, color=colour, label=label)
ax.plot(0.188, 0, "k+", ms=10, label="shoulder")
ax.set(xlabel="to the right (m)", ylabel="forward (m)", aspect="equal")
ax.legend(loc="lower left")
plt.tight_layout()
plt.show()
