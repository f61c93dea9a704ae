"""The natural posture for a hand pose: the one of least muscle effort.

Implements [Li2022] eq. 3.1 (doi 10.1109/TNSRE.2022.3198400). The default search is certain where
the paper's (`two_phase_search`, by ``search="paper"``) is probable: every feasible interval of
the self-motion manifold is traced with its ends, effort is sampled along each until its least
value is known to a tolerance, and every local minimum, tie, flat valley and jump is named.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.arrays import Transform, require_between
from selfmotion.errors import SelfmotionError, Status, unknown_name
from selfmotion.methods.effort.curve import FIRST_GAP, EffortCurve, effort_curve
from selfmotion.methods.effort.posture_result import (
    TIE,
    Jump,
    LocalMinimum,
    NaturalPosture,
    local_minima,
    verdict,
)
from selfmotion.methods.effort.two_phase_search import TwoPhaseOptions, two_phase_search
from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.static_optimization import EffortOptions, muscle_effort
from selfmotion.provenance import Provenance, hash_arrays
from selfmotion.redundancy.feasible import Clearance, arm_swivel
from selfmotion.redundancy.manifold import ManifoldFinder, SelfMotionManifold
from selfmotion.redundancy.refine import check_poses


@dataclass(frozen=True)
class SearchOptions:
    """How the least effort is searched for.

    Attributes:
        search: certain (along the whole manifold) or paper ([Li2022] Table III).
        tolerance: relative error of the least effort, for the certain search.
        on_jump: keep a minimum beside a jump of effort, or exclude it.
        published: parameters of the paper's search.
    """

    search: str = "certain"
    tolerance: float = 1e-3
    on_jump: str = "keep"
    published: TwoPhaseOptions = field(default_factory=TwoPhaseOptions)

    def __post_init__(self) -> None:
        """Check the choices."""
        if self.search not in ("certain", "paper"):
            raise unknown_name("search", self.search, ("certain", "paper"))
        if self.on_jump not in ("keep", "exclude"):
            raise unknown_name("on_jump", self.on_jump, ("keep", "exclude"))
        require_between("tolerance", self.tolerance, 1e-8, 0.1)


@dataclass(frozen=True, eq=False)
class PostureFinder:
    """A model made ready for many poses.

    Attributes:
        model: arm with muscles.
        effort: how effort is computed.
        search: how its least value is searched for.
        clearance: how far postures are outside bodies that the arm may not enter (m).
        manifolds: finds feasible intervals.
    """

    model: MusculoskeletalArm
    effort: EffortOptions
    search: SearchOptions
    clearance: Clearance | None
    manifolds: ManifoldFinder

    @classmethod
    def of(
        cls,
        model: MusculoskeletalArm,
        *,
        effort: EffortOptions | None = None,
        search: SearchOptions | None = None,
        clearance: Clearance | None = None,
    ) -> "PostureFinder":
        """Prepare a model; options left out are those of its convention."""
        chosen = EffortOptions.of(model.convention) if effort is None else effort
        how = SearchOptions() if search is None else search
        return cls(model, chosen, how, clearance, ManifoldFinder.of(model.arm))

    def find(self, T_hand: ArrayLike) -> NaturalPosture:
        """Find the posture of least effort for one hand pose; see `natural_posture`.

        Raises:
            RangeError: T_hand is not a rigid transform.
            ShapeError: T_hand is not one pose.
        """
        return self.find_on(self.manifolds.find(T_hand, clearance=self.clearance))

    def find_on(
        self, manifold: SelfMotionManifold, curves: Sequence[EffortCurve] | None = None
    ) -> NaturalPosture:
        """Find the posture of least effort on a manifold that is at hand already.

        Args:
            manifold: of one hand pose.
            curves: effort along its intervals, where that too is at hand.
        """
        if not manifold.intervals:
            return self._none(manifold, manifold.status)
        if self.search.search == "paper":
            return self._published(manifold)
        curves = self.curves(manifold) if curves is None else list(curves)
        minima, jumps = local_minima(
            curves,
            self.model.muscles.names,
            tolerance=self.search.tolerance,
            exclude=self.search.on_jump == "exclude",
        )
        n_evaluations = sum(curve.n_evaluations for curve in curves)
        if not minima:
            sentence = "no minimum is left: each lies beside a jump of effort (on_jump is exclude)"
            return self._none(manifold, Status(False, sentence))
        return self._result(manifold, minima, jumps, n_evaluations)

    def curves(self, manifold: SelfMotionManifold, *, gap: float = FIRST_GAP) -> list[EffortCurve]:
        """Sample effort along every interval of a manifold, at first this far apart (rad)."""
        best = np.inf
        curves: dict[int, EffortCurve] = {}
        order = np.argsort([-interval.length for interval in manifold.intervals])
        for i in order:  # a long interval first: its least effort spares work in the others
            curve = effort_curve(
                self.model,
                manifold.intervals[i],
                self.effort,
                tolerance=self.search.tolerance,
                best=best,
                gap=gap,
            )
            best = min(best, float(curve.effort.min()))
            curves[int(i)] = curve
        return [curves[i] for i in range(len(order))]

    def _published(self, manifold: SelfMotionManifold) -> NaturalPosture:
        found = two_phase_search(
            self.model,
            manifold.T_hand,
            effort=self.effort,
            options=self.search.published,
            clearance=self.clearance,
        )
        if len(found.q) == 0:
            sentence = "the sampled swivel angles hold no feasible posture"
            return self._none(manifold, Status(False, sentence))
        swivel = arm_swivel(self.model.arm, found.q)
        least = found.effort[0]
        minima = [
            LocalMinimum(
                q,
                float(s),
                float(E),
                -1,
                "",
                (float(s), float(s)),
                bool(E <= (1 + TIE) * least),
                False,
            )
            for q, s, E in zip(found.q, swivel, found.effort, strict=True)
        ]
        drift = (float(found.drift[0, 0]), float(found.drift[0, 1]))
        return self._result(manifold, minima, [], found.n_evaluations, drift)

    def _result(
        self,
        manifold: SelfMotionManifold,
        minima: list[LocalMinimum],
        jumps: list[Jump],
        n_evaluations: int,
        drift: tuple[float, float] = (0.0, 0.0),
    ) -> NaturalPosture:
        least = minima[0]
        held = muscle_effort(self.model, least.q, options=self.effort)
        return NaturalPosture(
            self.model.arm.joints,
            least.q,
            least.swivel,
            float(held.effort[0]),
            held.activations[0],
            self.model.muscles.names,
            tuple(minima),
            tuple(manifold.swivel_intervals),
            tuple(jumps),
            drift,
            verdict(held.status[0], minima, drift),
            n_evaluations,
            self._provenance(manifold.T_hand),
        )

    def _none(self, manifold: SelfMotionManifold, status: Status) -> NaturalPosture:
        names = self.model.muscles.names
        return NaturalPosture(
            self.model.arm.joints,
            np.full(7, np.nan),
            float("nan"),
            float("nan"),
            np.full(len(names), np.nan),
            names,
            (),
            tuple(manifold.swivel_intervals),
            (),
            (float("nan"), float("nan")),
            status,
            0,
            self._provenance(manifold.T_hand),
        )

    def _provenance(self, T_hand: Transform) -> Provenance:
        e = self.effort
        choices = {
            "model": self.model.arm.name,
            "source": self.model.arm.source,
            "convention": self.model.convention,
            "search": self.search.search,
            "lower": e.lower,
            "loads": list(e.loads),
            "hand_load": e.hand_load,
            "exponent": e.exponent,
        }
        return Provenance(
            "natural_posture", inputs={"T_hand": hash_arrays(T_hand)}, choices=choices
        )


def natural_posture(
    model: MusculoskeletalArm,
    T_hand: ArrayLike,
    *,
    effort: EffortOptions | None = None,
    search: SearchOptions | None = None,
    clearance: Clearance | None = None,
) -> NaturalPosture:
    """Find the posture of least muscle effort for a hand pose ([Li2022] eq. 3.1).

    Args:
        model: arm with muscles, as from `load_musculoskeletal_arm`.
        T_hand: (4, 4) pose of the hand in the ground (m).
        effort: how effort is computed; left out: by the model's convention.
        search: how its least value is searched for; left out: with certainty, to 1e-3.
        clearance: how far postures are outside bodies that the arm may not enter (m).

    Returns:
        The posture, with every other local minimum. Where the pose is out of reach the status
        says by how much.

    Raises:
        ModelError: the arm has not seven free coordinates, or a load is asked for that the model
            does not have.
        RangeError: T_hand is not a rigid transform.

    Example:
        >>> from selfmotion.arms.with_muscles import load_musculoskeletal_arm
        >>> from selfmotion.kinematics.forward import forward_kinematics
        >>> model = load_musculoskeletal_arm()
        >>> q = [0.6, 0.9, -0.3, 1.4, 0.2, 0.0, 0.1]
        >>> pose = forward_kinematics(model.arm.chain, q, model.arm.tip("hand"))[0]
        >>> found = natural_posture(model, pose)
        >>> bool(found.status), bool(found.effort <= muscle_effort(model, q).effort[0])
        (True, True)
    """
    finder = PostureFinder.of(model, effort=effort, search=search, clearance=clearance)
    return finder.find(T_hand)


def natural_postures(
    finder: PostureFinder, poses: Iterable[ArrayLike]
) -> list[NaturalPosture | SelfmotionError]:
    """Find postures for many poses; a bad pose gives its error in its place, not a stop."""
    out: list[NaturalPosture | SelfmotionError] = []
    for pose in poses:
        try:
            out.append(finder.find(check_poses(pose)[0]))
        except SelfmotionError as error:
            out.append(error)
    return out
