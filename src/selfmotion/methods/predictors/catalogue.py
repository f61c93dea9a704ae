"""The predictors that a study compares: criteria, then those that are fitted on other people."""

from collections.abc import Sequence
from dataclasses import dataclass

from selfmotion.methods.predictors.biased import Biased
from selfmotion.methods.predictors.combination import Combination
from selfmotion.methods.predictors.constant import Constant
from selfmotion.methods.predictors.coplanar import Coplanar
from selfmotion.methods.predictors.gravity_torque import GravityTorque
from selfmotion.methods.predictors.least_displacement import LeastDisplacement
from selfmotion.methods.predictors.manipulability import Manipulability
from selfmotion.methods.predictors.mid_range import MidRange
from selfmotion.methods.predictors.muscle_effort import MuscleEffort
from selfmotion.methods.predictors.observation import Observation, Prediction, Predictor
from selfmotion.methods.predictors.pose_regression import PoseRegression
from selfmotion.methods.predictors.start_angle import StartAngle
from selfmotion.muscles.static_optimization import EffortOptions

BASELINE = "constant per task"
START, HANGING = "nearest to start", "nearest to hanging"
START_ANGLE = "angle at the start"
EFFORT, EFFORT_PASSIVE = "muscle effort", "muscle effort, passive"
_WITH_PASSIVE = ("gravity", "passive")

# The myo-sim arm has no torque of coordinate limits; of the opensim convention the lower bound of
# activation is left.
CRITERIA: tuple[Predictor, ...] = (
    MuscleEffort(EFFORT),
    MuscleEffort(EFFORT_PASSIVE, EffortOptions(loads=_WITH_PASSIVE)),
    MuscleEffort("muscle effort, opensim bound", EffortOptions(lower=0.01)),
    MuscleEffort("muscle effort, cubed", EffortOptions(exponent=3.0)),
    MuscleEffort("muscle effort, cubed, passive", EffortOptions(loads=_WITH_PASSIVE, exponent=3.0)),
    GravityTorque(),
    Manipulability(),
    Coplanar(),
    MidRange(),
    LeastDisplacement(HANGING),
    LeastDisplacement("nearest to hanging, coordinates", measure="coordinates"),
    LeastDisplacement(START, from_start=True),
    LeastDisplacement("nearest to start, coordinates", from_start=True, measure="coordinates"),
    StartAngle(START_ANGLE),
)

FITTED: tuple[Predictor, ...] = (
    Constant(BASELINE),
    Constant("constant", by_kind=False),
    Biased("nearest to start, bias", START),
    Biased("nearest to start, bias per task", START, by_kind=True),
    Biased("angle at the start, bias per task", START_ANGLE, by_kind=True),
    Biased("muscle effort, passive, bias", EFFORT_PASSIVE),
    Biased("muscle effort, passive, bias per task", EFFORT_PASSIVE, by_kind=True),
    PoseRegression(),
    Combination(criteria=(EFFORT_PASSIVE, "gravity torque", "mid-range", HANGING, START)),
)


# Baselines that [Li2022] Table IV names and that are not among these, with the reason.
NOT_COMPUTED = (
    (
        "Li et al. 2015",
        "its five kinematic and dynamic criteria and the weights that join them are not in the "
        "papers at hand",
    ),
    (
        "Zanchettin et al. 2013, as published",
        "its function and numbers are not at hand; the regression on hand pose stands in for it, "
        "fitted anew",
    ),
)


@dataclass(frozen=True)
class Computed:
    """A criterion whose answers the observations hold."""

    name: str

    def fit(self, training: Sequence[Observation]) -> "Computed":
        """Give itself: nothing is fitted."""
        return self

    def swivel(self, observation: Observation) -> Prediction:
        """Look the answer up."""
        return observation.criteria[self.name]
