"""The papers that the library implements, as records: `selfmotion cite` prints them.

A docstring names a paper by its key, as in ``[Khoramshahi2022] eq. 4``.
"""

from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class Paper:
    """One paper: how to cite it and what the library takes from it."""

    key: str
    authors: str
    year: int
    title: str
    venue: str
    doi: str | None
    used_for: str


_RECORDS = (
    Paper(
        "Khoramshahi2022",
        "Khoramshahi M, Roby-Brami A, Parry R, Jarrassé N",
        2022,
        "Identification of inverse kinematic parameters in redundant systems: Towards "
        "quantification of inter-joint coordination in the human upper extremity",
        "PLoS ONE 17(12): e0278228",
        "10.1371/journal.pone.0278228",
        "inverse-kinematics weights from recorded motion; task and null-space velocity",
    ),
    Paper(
        "Tommasino2017",
        "Tommasino P, Campolo D",
        2017,
        "An Extended Passive Motion Paradigm for Human-Like Posture and Movement Planning in "
        "Redundant Manipulators",
        "Frontiers in Neurorobotics 11: 65",
        "10.3389/fnbot.2017.00065",
        "joint elasticity from Donders' law; prediction of posture and movement",
    ),
    Paper(
        "DeBoon",
        "DeBoon B, Foley RCA, Nokleby S, La Delfa NJ, Rossa C",
        2020,
        "Nine Degree-of-Freedom Kinematic Modelling of the Upper Limb Complex for "
        "Constrained Workspace Evaluation",
        "Journal of Biomechanical Engineering",
        None,
        "the 9-DoF arm, inverse kinematics inside joint limits, the workspace of a patient",
    ),
    Paper(
        "Li2022",
        "Li Q, Xia Y, Wang X, Xin P, Chen W, Xiong C",
        2022,
        "Muscle-Effort-Minimization-Inspired Kinematic Redundancy Resolution for Replicating "
        "Natural Posture of Human Arm",
        "IEEE Transactions on Neural Systems and Rehabilitation Engineering 30",
        "10.1109/TNSRE.2022.3198400",
        "the natural posture for a hand pose: least muscle effort; the swivel angle",
    ),
)

PAPERS = MappingProxyType({paper.key: paper for paper in _RECORDS})

MODEL_TERMS = (
    "The default arm with muscles (myoarm) comes from the package myo-sim, declared Apache-2.0 "
    "(https://pypi.org/project/myo-sim/). It derives from MoBL-ARMS (Saul et al. 2015, "
    "https://doi.org/10.1080/10255842.2014.916698), whose own terms are non-commercial. Nothing "
    "of it is part of selfmotion; name both where you publish what was computed with it."
)
