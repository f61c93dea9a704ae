"""C3D files made for tests, by ezc3d."""

import ezc3d
import numpy as np


def written(tmp_path, *, labels=("A", "B"), units="mm", screen=None, frames=4, analog=0):
    made = ezc3d.c3d()
    point = made["parameters"]["POINT"]
    point["UNITS"]["value"] = [units] if units else []
    point["LABELS"]["value"] = list(labels)
    point["RATE"]["value"] = [100.0]
    rng = np.random.default_rng(1)
    points = np.ones((4, len(labels), frames))
    points[:3] = rng.normal(size=(3, len(labels), frames)) * 500
    made["data"]["points"] = points
    if analog:
        made["parameters"]["ANALOG"]["RATE"]["value"] = [1000.0]
        made["parameters"]["ANALOG"]["LABELS"]["value"] = [f"emg{i}" for i in range(analog)]
        made["data"]["analogs"] = rng.normal(size=(1, analog, 10 * frames))
    if screen:
        made.add_parameter("POINT", "X_SCREEN", ["+X"])
        made.add_parameter("POINT", "Y_SCREEN", [screen])
    path = tmp_path / "x.c3d"
    made.write(str(path))
    return path, points[:3].transpose(2, 1, 0)
