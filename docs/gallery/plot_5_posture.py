"""
How would a person hold the arm?
================================

A hand pose leaves the elbow free to turn about the line from shoulder to wrist. Muscle effort over
that swivel angle, and its least value.
"""

import matplotlib.pyplot as plt
import numpy as np

import selfmotion as sm

model = sm.load_musculoskeletal_arm()
posture = [0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1]
pose = sm.forward_kinematics(model.arm.chain, posture, model.arm.tip("hand"))[0]

found = sm.natural_posture(model, pose)
print(found.status)
minima = found.to_frame()
print(minima[["swivel", "effort", "at", "tied", "flat"]].round(3).to_string(index=False))

# %%
# The same search shows the whole curve.

manifold = sm.self_motion_manifold(model.arm, pose)
fig, ax = plt.subplots(figsize=(6, 3.2))
for interval in manifold.intervals:
    q = interval.at(np.linspace(0.0, interval.length, 200) + interval.arc[0])
    swivel = np.unwrap(sm.arm_swivel_angle(model.arm, q))
    effort = sm.muscle_effort(model, q).effort
    ax.plot(np.degrees(swivel), effort, color="#0072B2")
ax.plot(np.degrees(found.swivel), found.effort, "o", color="#24292F", label="least effort")
ax.set(xlabel="swivel angle (°)", ylabel="muscle effort E")
ax.legend()
plt.tight_layout()
plt.show()
