"""The center-out experiment measured, predicted and compared: [Tommasino2017] Figs 3 and 5 to 8.

DOI 10.3389/fnbot.2017.00065. The paper's recordings, and the subjects' laws (its Tables 1 and 2),
are not at hand, so that people are simulated; recordings of real people go through the same
functions. Deviations: p-values are also given after correction for the 16 movements, and the test
A_sum ≠ 0, which cannot fail, is marked.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.errors import RangeError
from selfmotion.methods.curvature import (
    LEVEL,
    VACUOUS,
    MeanTests,
    mean_tests,
    path_areas,
    path_hysteresis,
)
from selfmotion.methods.passive.joint_law import JointLaw
from selfmotion.methods.passive.planned_motion import PlannedMotion
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.motion.segment import (
    N_SAMPLES,
    equally_spaced,
    movement_bounds,
    path_length,
    stands_apart,
)
from selfmotion.studies.center_out import (
    CENTRE,
    DIRECTIONS,
    NAMES,
    CenterOut,
    predicted,
    target_places,
)

if TYPE_CHECKING:
    import pandas as pd

MOVEMENTS = tuple((name, direction) for direction in DIRECTIONS for name in NAMES)
LABELS = tuple(f"{name} {direction}" for name, direction in MOVEMENTS)


@dataclass(frozen=True, eq=False)
class Movements:
    """Movements of one person, each between onset and offset, and their curvature.

    Attributes:
        target: (B,) index into `NAMES`.
        inbound: (B,) False for a movement out, True for one back.
        trial: (B,) number of the trial.
        duration: (B,) s.
        length: (B,) length of the path (m).
        right: (B,) A_R.
        left: (B,) A_L.
        kept: (B,) False for outliers in length or duration.
        x: (B, 20, 2) path at equally spaced times (m).
        q: (B, 20, 3) joints (rad).
        speed: (B, 20) tangential speed (m/s).
    """

    target: np.ndarray
    inbound: np.ndarray
    trial: np.ndarray
    duration: np.ndarray
    length: np.ndarray
    right: np.ndarray
    left: np.ndarray
    kept: np.ndarray
    x: Float[np.ndarray, "movements samples 2"]
    q: Float[np.ndarray, "movements samples joints"]
    speed: Float[np.ndarray, "movements samples"]

    @property
    def net(self) -> np.ndarray:
        """A_net, positive to the right."""
        return self.right - self.left

    def of(self, name: str, direction: str) -> np.ndarray:
        """Give the indices of the kept movements of one target and direction."""
        inbound = direction == "inbound"
        return np.flatnonzero(
            (self.target == NAMES.index(name)) & (self.inbound == inbound) & self.kept
        )

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a movement."""
        import pandas as pd

        return pd.DataFrame(
            {
                "trial": self.trial,
                "target": [NAMES[i] for i in self.target],
                "direction": [DIRECTIONS[int(i)] for i in self.inbound],
                "duration": self.duration,
                "path_length": self.length,
                "a_right": self.right,
                "a_left": self.left,
                "a_sum": self.right + self.left,
                "a_net": self.net,
                "kept": self.kept,
            }
        )


@dataclass(frozen=True, eq=False)
class Comparison:
    """One person beside a model.

    Attributes:
        data: the person's movements.
        model: the model's 16 movements, out and back, measured in the same way.
        sum_tests: A_sum ≠ 0 by movement; vacuous.
        net_tests: A_net ≠ 0 by movement.
        hysteresis_tests: A_net(out) + A_net(in) ≠ 0 by target, paired by trial.
        model_tests: A_net against the model's by movement.
    """

    data: Movements
    model: Movements
    sum_tests: MeanTests
    net_tests: MeanTests
    hysteresis_tests: MeanTests
    model_tests: MeanTests

    @property
    def captured(self) -> float:
        """Share of the 16 movements whose A_net does not differ from the model's, as printed.

        The paper's criterion: p ≥ 0.05 without correction. It grows as the data get fewer.
        """
        return float(np.mean(~(np.nan_to_num(self.model_tests.p, nan=1.0) < LEVEL)))

    @property
    def captured_corrected(self) -> float:
        """The same with Holm's correction for 16 movements."""
        return float(np.mean(~self.model_tests.differs))

    def to_frame(self) -> "pd.DataFrame":
        """Give all tests in one table."""
        import pandas as pd

        parts = {
            "A_sum": self.sum_tests,
            "A_net": self.net_tests,
            "hysteresis": self.hysteresis_tests,
            "A_net against model": self.model_tests,
        }
        frames = [tests.to_frame().assign(test=name) for name, tests in parts.items()]
        return pd.concat(frames, ignore_index=True)


def measure(study: Study) -> Movements:
    """Measure every movement of one person: onset, offset, outliers, areas, 20 samples.

    Args:
        study: recordings with `x` (m at 1 m) and `q`, labelled by target, condition (outbound or
            inbound) and trial.

    Raises:
        RangeError: a label is missing or unknown.
        ShapeError: a recording has no path or no joints.
    """
    places = target_places()
    rows = []
    for recording in study:
        name, direction = recording.labels.target, recording.labels.condition
        if name not in NAMES or direction not in DIRECTIONS:
            raise RangeError(
                f"{recording.name}: target must be one of {', '.join(NAMES)} and condition "
                "outbound or inbound"
            )
        ends = (CENTRE, places[NAMES.index(name)])
        rows.append(_measured(recording, *(ends if direction == "outbound" else ends[::-1])))
    duration, length, areas, x, q, speed = zip(*rows, strict=True)
    apart = stands_apart(np.array(duration)) | stands_apart(np.array(length))
    return Movements(
        np.array([NAMES.index(r.labels.target or "") for r in study]),
        np.array([r.labels.condition == "inbound" for r in study]),
        np.array([int(r.labels.trial or 0) for r in study]),
        np.array(duration),
        np.array(length),
        np.array([a.right for a in areas]),
        np.array([a.left for a in areas]),
        ~apart,
        np.array(x),
        np.array(q),
        np.array(speed),
    )


def measure_planned(motion: PlannedMotion) -> Movements:
    """Measure the 16 movements of `predicted` in the same way; none is left out."""
    found = measure(
        Study(
            tuple(
                _labelled(motion, i, name, direction)
                for i, (name, direction) in enumerate(MOVEMENTS)
            )
        )
    )
    return replace(found, kept=np.ones(len(motion), dtype=bool))


def compare(study: Study, law: JointLaw, protocol: CenterOut | None = None) -> Comparison:
    """Compare a person's movements with what a law predicts ([Tommasino2017] Figs 5 and 6).

    Args:
        study: the person's recordings, as for `measure`.
        law: fitted to the person's postures, say.
        protocol: duration and settings of the prediction.

    Returns:
        Areas and tests of both.
    """
    data, model = measure(study), measure_planned(predicted(law, protocol))
    groups = [data.of(*movement) for movement in MOVEMENTS]
    against = np.array([model.net[model.of(*movement)][0] for movement in MOVEMENTS])
    total = data.right + data.left
    return Comparison(
        data,
        model,
        mean_tests([total[g] for g in groups], LABELS, note=VACUOUS),
        mean_tests([data.net[g] for g in groups], LABELS),
        mean_tests([hysteresis(data, name) for name in NAMES], NAMES),
        mean_tests([data.net[g] for g in groups], LABELS, against=against),
    )


def hysteresis(movements: Movements, name: str) -> np.ndarray:
    """Give A_net(out) + A_net(in) of one target, for each trial in which both were kept."""
    these = np.flatnonzero(movements.target == NAMES.index(name))
    # An outlier keeps its place, so that no movement back belongs to another one's way out.
    net = np.where(movements.kept, movements.net, np.nan)[these]
    ways = [(name, DIRECTIONS[int(inbound)]) for inbound in movements.inbound[these]]
    trials = [str(trial) for trial in movements.trial[these]]
    found = path_hysteresis(net, ways, trials, directions=DIRECTIONS).get(name, np.empty(0))
    return found[np.isfinite(found)]


def _labelled(motion: PlannedMotion, i: int, name: str, direction: str) -> Recording:
    return motion.recording(i, Labels(target=name, condition=direction, trial="1"))


def _measured(recording: Recording, start: np.ndarray, end: np.ndarray) -> tuple:
    """Give duration, length, areas, and path, joints and speed at 20 samples."""
    time, x, q = recording.time, recording.array("x"), recording.array("q")
    speed = np.linalg.norm(np.gradient(x, time, axis=0), axis=1)
    bounds = movement_bounds(speed)
    part = slice(bounds.onset, bounds.offset + 1)
    t = time[part]
    return (
        float(t[-1] - t[0]),
        path_length(x[part]),
        path_areas(x[part], start, end),
        equally_spaced(t, x[part], n_samples=N_SAMPLES),
        equally_spaced(t, q[part], n_samples=N_SAMPLES),
        equally_spaced(t, speed[part][:, None], n_samples=N_SAMPLES)[:, 0],
    )
