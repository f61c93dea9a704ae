# The public names. One `from MODULE import NAME as NAME` adds a name; modules are absolute.

# -- the version
from selfmotion._version import __version__ as __version__

# -- recorded motion
from selfmotion.motion.labels import Frame as Frame
from selfmotion.motion.labels import Labels as Labels
from selfmotion.motion.recording import GapWarning as GapWarning
from selfmotion.motion.recording import Recording as Recording
from selfmotion.motion.recording import Study as Study
from selfmotion.motion.filters import differentiate as differentiate
from selfmotion.motion.filters import fill_gaps as fill_gaps
from selfmotion.motion.filters import low_pass as low_pass
from selfmotion.motion.filters import normalise_time as normalise_time
from selfmotion.motion.filters import resample as resample
from selfmotion.motion.filters import smoothing_spline as smoothing_spline
from selfmotion.motion.filters import with_velocities as with_velocities
from selfmotion.motion.files import load as load
from selfmotion.capture.attach import attach_arm as attach_arm
from selfmotion.capture.attach import attach_arm_to_study as attach_arm_to_study

# -- arms and their kinematics
from selfmotion.arms import arm_names as arm_names
from selfmotion.arms import load_arm as load_arm
from selfmotion.kinematics.arm import Arm as Arm
from selfmotion.kinematics.chain import Chain as Chain
from selfmotion.kinematics.chain import Coupling as Coupling
from selfmotion.kinematics.chain import Tip as Tip
from selfmotion.kinematics.dynamics import gravity_torque as gravity_torque
from selfmotion.kinematics.dynamics import inertia_matrix as inertia_matrix
from selfmotion.kinematics.forward import forward_kinematics as forward_kinematics
from selfmotion.kinematics.forward import geometric_jacobian as geometric_jacobian
from selfmotion.kinematics.swivel import arm_swivel_angle as arm_swivel_angle
from selfmotion.kinematics.swivel import swivel_angle as swivel_angle

# -- tasks and redundancy
from selfmotion.redundancy.projection import Projection as Projection
from selfmotion.redundancy.projection import project as project
from selfmotion.redundancy.projection import split_velocity as split_velocity
from selfmotion.redundancy.task import Planar as Planar
from selfmotion.redundancy.task import Pointing as Pointing
from selfmotion.redundancy.task import Pose as Pose
from selfmotion.redundancy.task import Position as Position
from selfmotion.redundancy.task import RowMask as RowMask
from selfmotion.redundancy.task import Task as Task

# -- which joints a person prefers
from selfmotion.methods.identification import IdentificationOptions as IdentificationOptions
from selfmotion.methods.identification import MotionArrays as MotionArrays
from selfmotion.methods.identification import identify_weights as identify_weights
from selfmotion.methods.identification import (
    identify_weights_from_arrays as identify_weights_from_arrays,
)
from selfmotion.methods.weights.estimate import WeightEstimate as WeightEstimate
from selfmotion.methods.weights.series import estimate_each as estimate_each
from selfmotion.methods.weights.series import weights_by_trial as weights_by_trial
from selfmotion.methods.weights.series import weights_by_window as weights_by_window
from selfmotion.methods.velocity_split import split as split
from selfmotion.methods.velocity_split import velocity_bands as velocity_bands
from selfmotion.methods.uncontrolled_manifold import manifold_variance as manifold_variance
from selfmotion.methods.hotelling import compare_weights as compare_weights
from selfmotion.methods.hotelling import hotelling_one_sample as hotelling_one_sample
from selfmotion.methods.hotelling import hotelling_paired as hotelling_paired
from selfmotion.methods.coordination import principal_components as principal_components
from selfmotion.methods.coordination import relative_phase as relative_phase
from selfmotion.methods.coordination import velocity_correlation as velocity_correlation

# -- how a person will move, and why
from selfmotion.methods.passive_motion import plan as plan
from selfmotion.methods.passive_motion import plan_sequence as plan_sequence
from selfmotion.methods.passive_motion import PlanSettings as PlanSettings
from selfmotion.methods.passive.joint_law import JointLaw as JointLaw
from selfmotion.methods.passive.joint_law import read_law as read_law
from selfmotion.methods.passive.planned_motion import PlannedMotion as PlannedMotion
from selfmotion.methods.donders import fit_elasticity as fit_elasticity
from selfmotion.methods.curvature import path_areas as path_areas

# -- where a person can reach
from selfmotion.methods.joint_limited_ik import solve_ik as solve_ik
from selfmotion.methods.workspace import workspace as workspace
from selfmotion.methods.workspace_maps import workspace_maps as workspace_maps
from selfmotion.methods.workspace_mapping import workspace_mapping as workspace_mapping
from selfmotion.methods.hand_constraints import held_reach as held_reach
from selfmotion.methods.hand_circle import DeviceCircle as DeviceCircle
from selfmotion.methods.hand_circle import circle_reach as circle_reach
from selfmotion.methods.reach_clouds import compare_clouds as compare_clouds
from selfmotion.methods.constrained_path import follow as follow
from selfmotion.methods.reaching.boundary import boundary_limits as boundary_limits
from selfmotion.methods.reaching.regained import regained_by_joint as regained_by_joint
from selfmotion.methods.reaching.regions import NamedRegion as NamedRegion
from selfmotion.methods.reaching.regions import region_reach as region_reach
from selfmotion.capture.ranges import joint_range as joint_range

# -- the body that an arm must not enter
from selfmotion.kinematics.body_shapes import BodyShapes as BodyShapes

# -- the natural posture
from selfmotion.arms.with_muscles import load_musculoskeletal_arm as load_musculoskeletal_arm
from selfmotion.muscles.static_optimization import muscle_effort as muscle_effort
from selfmotion.muscles.static_optimization import EffortOptions as EffortOptions
from selfmotion.methods.natural_posture import natural_posture as natural_posture
from selfmotion.methods.natural_posture import SearchOptions as SearchOptions
from selfmotion.methods.hybrid_ik import hybrid_ik as hybrid_ik
from selfmotion.redundancy.manifold import self_motion_manifold as self_motion_manifold
from selfmotion.muscles.fitted import scale_to_person as scale_to_person
from selfmotion.muscles.fitted import mirror_muscles as mirror_muscles
from selfmotion.arms.person_with_muscles import PersonSize as PersonSize
from selfmotion.arms.person_with_muscles import myoarm_of_person as myoarm_of_person

# -- laws of posture against people
from selfmotion.methods.predictors.observation import Observation as Observation
from selfmotion.methods.predictors.observation import Prediction as Prediction
from selfmotion.methods.predictors.observation import Predictor as Predictor
from selfmotion.studies.prediction import PredictionPlan as PredictionPlan
from selfmotion.studies.prediction import left_out as left_out
from selfmotion.studies.prediction import predict_people as predict_people

# -- markers
from selfmotion.motion.files import load_markers as load_markers
from selfmotion.motion.markers import MarkerSet as MarkerSet
from selfmotion.motion.orientations import Orientations as Orientations
from selfmotion.motion.files.orientation import read_orientations as read_orientations
from selfmotion.capture.person import CaptureOptions as CaptureOptions
from selfmotion.capture.person import Person as Person
from selfmotion.capture.person import calibrate_person as calibrate_person
from selfmotion.capture.angles import ArmMotion as ArmMotion
from selfmotion.capture.angles import angles_from_markers as angles_from_markers
from selfmotion.capture.marker_ik import MarkerModel as MarkerModel
from selfmotion.capture.marker_ik import solve_marker_ik as solve_marker_ik
from selfmotion.capture.isb import isb_angles as isb_angles
from selfmotion.capture.protocol import Protocol as Protocol
from selfmotion.capture.protocol import load_protocol as load_protocol

# -- whole studies
from selfmotion.studies.study_file import load_study_file as load_study_file
from selfmotion.studies.study_run import StudyPlan as StudyPlan
from selfmotion.studies.study_run import run_study as run_study

# -- many at once
from selfmotion.batch import Item as Item
from selfmotion.batch import Outcome as Outcome
from selfmotion.batch import Runner as Runner
from selfmotion.batch import iterate_batch as iterate_batch
from selfmotion.batch import run_batch as run_batch

# -- what went wrong, where it comes from, whom to cite
from selfmotion.errors import FileFormatError as FileFormatError
from selfmotion.errors import MissingExtraError as MissingExtraError
from selfmotion.errors import ModelError as ModelError
from selfmotion.errors import NotFiniteError as NotFiniteError
from selfmotion.errors import RangeError as RangeError
from selfmotion.errors import SelfmotionError as SelfmotionError
from selfmotion.errors import ShapeError as ShapeError
from selfmotion.errors import Status as Status
from selfmotion.errors import UnknownNameError as UnknownNameError
from selfmotion.papers import PAPERS as PAPERS
from selfmotion.papers import Paper as Paper
from selfmotion.provenance import Provenance as Provenance
