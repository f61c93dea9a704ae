"""
How will a person move to a target?
===================================

Wrist pointing by passive motion (λ0-PMP): the way out to a diagonal target and the way back veer
to the same side, so that together they enclose an area.
"""

import matplotlib.pyplot as plt
import numpy as np

import selfmotion as sm

task = sm.Pointing(sm.load_arm("wrist"))
law = sm.JointLaw(np.diag([0.5, 1.5, 2.0]), rest=np.radians([5.0, 0.0, 0.0]))
settings = sm.PlanSettings(spring=22.5)
centre = np.zeros(2)
start = sm.plan(task, law, law.rest, centre, settings).end[0]

# %%
# Eight targets on a circle of π/12 m, out and back.

fig, ax = plt.subplots(figsize=(5, 5))
for k in range(8):
    target = np.pi / 12 * np.array([np.cos(k * np.pi / 4), np.sin(k * np.pi / 4)])
    legs = sm.plan_sequence(task, law, start, [target, centre], settings)
    for x, style, name in zip(legs.x, ("-", "--"), ("outbound", "inbound"), strict=True):
        ax.plot(*x.T, style, color="#0072B2", lw=1.5, label=name if k == 0 else None)
    ax.plot(*target, "o", color="#24292F", ms=4)
    out = sm.path_areas(legs.x[0], centre, target).net
    back = sm.path_areas(legs.x[1], target, centre).net
    ax.annotate(f"{out + back:+.3f}", 1.12 * target, ha="center", va="center", fontsize=8)
ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", xlim=(-0.34, 0.34), ylim=(-0.34, 0.34))
ax.set_title("numbers: hysteresis, A_net(out) + A_net(back)", fontsize=9)
ax.legend(loc="upper left", fontsize=8)
plt.tight_layout()
plt.show()
