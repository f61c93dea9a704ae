"""The result of planning: movements, with where each ended and whether it went well."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from selfmotion.errors import ShapeError, Status
from selfmotion.motion.labels import UNKNOWN_FRAME, Labels
from selfmotion.motion.recording import Recording, Study
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """Movements that share one time axis, each from a posture towards a target.

    Attributes:
        time: (S,) from 0 (s); it restarts at each movement.
        q: (B, S, n) postures (rad or m).
        qd: (B, S, n) joint velocities (per s).
        x: (B, S, m) task (m, rad).
        xd: (B, S, m) task velocity (per s).
        targets: (B, M), of all M rows where the task keeps only some.
        spring: (B, m, m) the full-grown task spring K (N/m; N m/rad for angles).
        end_error: (B,) distance to the target at the end, in the task's units (m).
        statuses: one for each movement.
        joints: names of the n joints.
        units: units of the m rows.
        names: label of each movement; empty where there is none.
        provenance: what made it.
    """

    time: Float[np.ndarray, " samples"]
    q: Float[np.ndarray, "movements samples joints"]
    qd: Float[np.ndarray, "movements samples joints"]
    x: Float[np.ndarray, "movements samples rows"]
    xd: Float[np.ndarray, "movements samples rows"]
    targets: Float[np.ndarray, "movements all_rows"]
    spring: Float[np.ndarray, "movements rows rows"]
    end_error: Float[np.ndarray, " movements"]
    statuses: tuple[Status, ...]
    joints: tuple[str, ...]
    units: tuple[str, ...]
    provenance: Provenance
    names: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Count the movements."""
        return len(self.q)

    @property
    def status(self) -> Status:
        """Whether all movements went well; else the sentence of the first that did not."""
        bad = [(i, s) for i, s in enumerate(self.statuses) if not s.ok]
        if not bad:
            return Status(True, f"all {len(self)} movements planned")
        i, first = bad[0]
        return Status(False, f"{len(bad)} of {len(self)} movements failed; {self.name(i)}: {first}")

    @property
    def speed(self) -> Float[np.ndarray, "movements samples"]:
        """Tangential speed in the task (units of the rows per s)."""
        return np.linalg.norm(self.xd, axis=2)

    @property
    def end(self) -> Float[np.ndarray, "movements joints"]:
        """Final postures (rad)."""
        return self.q[:, -1]

    def name(self, i: int) -> str:
        """Give the label of movement i, or its number."""
        return self.names[i] if self.names else f"movement {i + 1}"

    def named(self, names: tuple[str, ...]) -> "PlannedMotion":
        """Give the same movements with labels.

        Raises:
            ShapeError: the number of names is not that of the movements.
        """
        if len(names) != len(self):
            raise ShapeError(f"names: {len(names)} for {len(self)} movements")
        return replace(self, names=tuple(names))

    def recording(self, i: int, labels: Labels | None = None) -> Recording:
        """Give movement i as a recording (source ``simulated``)."""
        return Recording(
            self.time,
            q=self.q[i],
            qd=self.qd[i],
            x=self.x[i],
            xd=self.xd[i],
            joints=self.joints,
            labels=Labels(target=self.name(i)) if labels is None else labels,
            frame=UNKNOWN_FRAME,
            source="simulated",
        )

    def study(self, *, subject: str | None = None) -> Study:
        """Give all movements as recordings, the label as their target."""
        labels = (Labels(subject=subject, target=self.name(i)) for i in range(len(self)))
        return Study(tuple(self.recording(i, label) for i, label in enumerate(labels)))

    def to_frame(self) -> "pd.DataFrame":
        """Give a table, one row a sample: movement, time, joints (rad), x and ẋ."""
        import pandas as pd

        n_movements, n_samples = self.q.shape[:2]
        columns: dict[str, object] = {
            "movement": np.repeat([self.name(i) for i in range(n_movements)], n_samples),
            "time": np.tile(self.time, n_movements),
        }
        for j, joint in enumerate(self.joints):
            columns[joint] = self.q[:, :, j].ravel()
        for a in range(self.x.shape[2]):
            columns[f"x{a + 1}"] = self.x[:, :, a].ravel()
        for a in range(self.x.shape[2]):
            columns[f"x{a + 1}_velocity"] = self.xd[:, :, a].ravel()
        return pd.DataFrame(columns)

    def summary(self) -> "pd.DataFrame":
        """Give a table, one row a movement: target, end error, peak speed, status."""
        import pandas as pd

        rows: dict[str, object] = {"movement": [self.name(i) for i in range(len(self))]}
        for a in range(self.targets.shape[1]):
            rows[f"target_x{a + 1}"] = self.targets[:, a]
        rows["end_error"] = self.end_error
        rows["peak_speed"] = self.speed.max(axis=1)
        rows["ok"] = [s.ok for s in self.statuses]
        rows["status"] = [s.sentence for s in self.statuses]
        return pd.DataFrame(rows)
