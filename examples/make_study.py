"""Make examples/study: two generated people who reach under two conditions, a file a movement.

python examples/make_study.py
selfmotion weights examples/study --study examples/study/study.toml --arm exoskeleton
"""

from pathlib import Path

import numpy as np

from selfmotion.motion.files.angles_csv import write_angles_csv
from selfmotion.studies.demonstration import angles_only
from selfmotion.studies.simulated_people import ReachingProtocol, simulate_reaching

FOLDER = Path(__file__).parent / "study"
TARGETS = ("forward", "high", "inward")
TRIALS = ("1", "2")
STUDY = r"""# Which file is whose movement: the named groups of the pattern become labels.
pattern = '(?P<subject>P\d+)_(?P<condition>[A-Za-z]+)_(?P<target>[a-z]+)_(?P<trial>\d+)\.csv'
cutoff = 0
"""


def main() -> None:
    """Write the files and the study file."""
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / "study.toml").write_text(STUDY, encoding="utf-8")
    protocol = ReachingProtocol(n_people=2, n_trials=2, n_samples=30, step=0.03)
    made = simulate_reaching(protocol, rng=np.random.default_rng(11))
    for recording in angles_only(made.study):
        labels = recording.labels
        if labels.target in TARGETS and labels.trial in TRIALS:
            name = f"{labels.subject}_{labels.condition}_{labels.target}_{labels.trial}.csv"
            write_angles_csv(FOLDER / name, [recording])


if __name__ == "__main__":
    main()
