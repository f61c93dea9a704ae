"""Write examples/markers_static.csv and markers_drink.csv: simulated markers as Vicon exports them.

Run from the top folder: python examples/make_markers.py
"""

from pathlib import Path

import numpy as np

from selfmotion.capture.simulated_markers import MarkerFaults, simulate_markers
from selfmotion.motion.markers import MarkerSet

STEP = 4  # 25 Hz keep the file small


def write(path: Path, markers: MarkerSet, step: int) -> None:
    """Write every so many samples in the layout of Vicon Nexus."""
    rate = round(100 / step)
    lines = ["Trajectories", str(rate), ",," + ",,,".join(f"P1:{n}" for n in markers.names) + ",,"]
    lines += ["Frame,Sub Frame" + ",X,Y,Z" * markers.n_markers]
    lines += [",," + ",".join(["mm"] * 3 * markers.n_markers)]
    for k, row in enumerate(1e3 * markers.positions[::step].reshape(-1, 3 * markers.n_markers)):
        lines.append(f"{k + 1},0," + ",".join("" if np.isnan(v) else f"{v:.2f}" for v in row))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


capture = simulate_markers(
    faults=MarkerFaults(noise=2e-4, skin=3e-3, gaps=2), rng=np.random.default_rng(1)
)
folder = Path(__file__).parent
write(folder / "markers_static.csv", capture.static.window(0, 5), 1)
drink = next(m for m in capture.movements if m.labels.condition == "drink")
write(folder / "markers_drink.csv", drink, STEP)
