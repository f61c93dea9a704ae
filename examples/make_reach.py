"""Make examples/reach.csv: a generated person who reaches to three targets, angles over time.

The person has known weights, printed below, so that what `selfmotion weights` finds can be held
against the truth::

    python examples/make_reach.py
    selfmotion weights examples/reach.csv --arm exoskeleton
"""

from pathlib import Path

import numpy as np

from selfmotion.motion.files.angles_csv import write_angles_csv
from selfmotion.studies.demonstration import angles_only
from selfmotion.studies.simulated_people import ReachingProtocol, simulate_reaching


def main() -> None:
    """Write the file beside this one."""
    protocol = ReachingProtocol(
        n_people=1,
        n_trials=10,
        n_samples=40,
        step=0.0225,
        spread_person=0.0,
        spread_condition=0.0,
        spread_length=0.0,
    )
    made = simulate_reaching(protocol, rng=np.random.default_rng(7))
    chosen = made.study.select(condition="Viscous")
    path = Path(__file__).parent / "reach.csv"
    write_angles_csv(path, angles_only(chosen))
    person = made.people[0]
    print(path, "true weights:", person.weights["Viscous"].round(3).tolist())


if __name__ == "__main__":
    main()
