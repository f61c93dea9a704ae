"""
Which joints does a person prefer?
==================================

A generated person reaches to several targets with known inverse-kinematics weights. From joint
velocities and Jacobians alone the weights come back, with intervals, and with what the movement
cannot tell.
"""

import matplotlib.pyplot as plt
import numpy as np

import selfmotion as sm
from selfmotion.studies.simulated_people import simulate_reaching

people = simulate_reaching(rng=np.random.default_rng(3))
person = people.people[0]
free = person.weights
condition = next(iter(free))
study = people.study.select(subject=person.name, condition=condition)

# %%
# One call takes all trials of the person. The elbow of this arm alone changes the distance of the
# hand, so no data can tell its weight: it is marked, not guessed.

found = sm.identify_weights(study)
print(found.status)
print(found.to_frame()[["joint", "weight", "lower", "upper"]].to_string(index=False))

# %%
# Ratios are what has a meaning: log-ratios to the first joint, with 95 % intervals.

known = np.isfinite(found.weights)
first, *others = [joint for joint, told in zip(found.joints, known, strict=True) if told]
true = dict(zip(found.joints, free[condition], strict=True))
fig, ax = plt.subplots(figsize=(6, 3))
for i, joint in enumerate(others):
    ratio, stderr = found.log_ratio(joint, first)
    ax.errorbar(i, ratio, 1.96 * stderr, fmt="o", color="#0072B2", capsize=4)
    ax.plot(i, np.log(true[joint] / true[first]), "x", color="#24292F", ms=9)
ax.plot([], [], "x", color="#24292F", label="true")
ax.errorbar([], [], [], fmt="o", color="#0072B2", label="identified, 95 % interval")
ax.set_xticks(range(len(others)), [j.replace("_", " ") for j in others])
ax.set_xlim(-0.6, len(others) - 0.4)
ax.set_ylabel(f"log weight ratio to {first.replace('_', ' ')}")
ax.legend()
plt.tight_layout()
plt.show()
