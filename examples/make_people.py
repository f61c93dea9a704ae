"""Write examples/people: simulated markers of three people who reach forward and drink.

Run from the top folder: python examples/make_people.py
"""

from pathlib import Path

import numpy as np

from selfmotion.capture.simulated_markers import simulate_markers
from selfmotion.motion.markers import MarkerSet

STEP = 8  # 12.5 Hz keep the files small
TASKS = ("forward", "drink")
STUDY = r"""# Whose file is which, and where in a movement the hand is at its goal.
pattern = '(?P<subject>P\d)_(?P<condition>[a-z]+)\.csv'
static = "{subject}_static.csv"
frame = {up = "z", forward = "y"}
cutoff = 0

[moments.forward]
end_of_reach = {at = "farthest"}

[moments.drink]
mid_drink = {at = "farthest"}
"""


def write(path: Path, markers: MarkerSet, step: int) -> None:
    """Write every so many samples in the layout of Vicon Nexus."""
    lines = ["Trajectories", f"{100 / step:g}"]
    lines += [",," + ",,,".join(f"P:{n}" for n in markers.names) + ",,"]
    lines += ["Frame,Sub Frame" + ",X,Y,Z" * markers.n_markers]
    lines += [",," + ",".join(["mm"] * 3 * markers.n_markers)]
    for k, row in enumerate(1e3 * markers.positions[::step].reshape(-1, 3 * markers.n_markers)):
        lines.append(f"{k + 1},0," + ",".join(f"{v:.1f}" for v in row))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


folder = Path(__file__).parent / "people"
folder.mkdir(exist_ok=True)
(folder / "study.toml").write_text(STUDY, encoding="utf-8")
for person in (1, 2, 3):
    capture = simulate_markers(rng=np.random.default_rng(person), repeats=2)
    write(folder / f"P{person}_static.csv", capture.static.window(0, 2), 1)
    for movement in capture.movements:  # the second repeat is the one that varies
        if movement.labels.condition in TASKS and movement.labels.trial == "2":
            write(folder / f"P{person}_{movement.labels.condition}.csv", movement, STEP)
