"""Make examples/reach.csv: a generated person who reaches to three targets, angles over time.

The person has known weights, printed below, so that what `selfmotion weights` finds can be held
against the truth::

    python examples/make_reach.py
    selfmotion weights examples/reach.csv --arm exoskeleton
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from selfmotion.motion.files.angles_csv import write_angles_csv
from selfmotion.motion.recording import Recording, Study
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
    natural = made.study.select(condition="Viscous")
    path = Path(__file__).parent / "reach.csv"
    write_angles_csv(path, Study(tuple(angles_only(r) for r in natural)))
    person = made.people[0]
    print(path, "true weights:", person.weights["Viscous"].round(3).tolist())


def angles_only(recording: Recording) -> Recording:
    """Keep time, angles and labels, as a laboratory would export them."""
    # The generated arm counts elevation positive away from the trunk, the arm `exoskeleton` the
    # other way round.
    q = recording.array("q") * np.array([-1.0, 1.0, 1.0, 1.0])
    bare = Recording(recording.time, q=q.round(6), joints=recording.joints)
    return replace(bare, labels=recording.labels, frame=recording.frame, source="simulated")


if __name__ == "__main__":
    main()
