"""Every figure and table of the four papers, and what stands for it in `reproduce`.

One entry each, in the paper's order, so that a reader who comes from the paper finds its place;
what is missing is named with the reason. Nothing is computed here.
"""

from dataclasses import dataclass, replace

COMPUTED = "computed again"
GENERATED = "computed on generated people"
GIVEN = "computed on the people given"
OWN = "computed, without measured curves"
TAKEN = "taken over"
NO_RESULT = "not a result"
MISSING = "not at hand"

NUMBERS = "Published numbers beside ours"


@dataclass(frozen=True)
class PaperFigure:
    """A figure, table or passage with numbers of a paper, and what stands for it here.

    Attributes:
        where: as the paper counts it.
        shows: what it shows, in a few words.
        here: one of the words above.
        section: heading of the section of the report where it stands; empty if nowhere.
        difference: a word on how far it agrees, and why not further.
    """

    where: str
    shows: str
    here: str
    section: str
    difference: str


_EXAMPLE_1 = "Example 1: random chains"
_EXAMPLE_2 = "Example 2: two joints with a busy null space"
_REACHING = "Experiment 1: reaching in a viscous field"
_SCREEN = "Experiment 2: an elbow that is not one's own"
KHORAMSHAHI2022 = (
    PaperFigure(
        "Eqs 13, 14",
        "two ways to split one velocity",
        COMPUTED,
        NUMBERS,
        "equal; what the paper calls ẋ there are joint velocities",
    ),
    PaperFigure(
        "Fig 1",
        "weights of Algorithm 1 over iterations, 100 random data sets",
        COMPUTED,
        _EXAMPLE_1,
        "agrees where null-space velocity is read as not projected",
    ),
    PaperFigure("Fig 2", "the same for several γ", COMPUTED, _EXAMPLE_1, "same order of γ"),
    PaperFigure(
        "Fig 3",
        "two joints, several γ and a schedule",
        COMPUTED,
        _EXAMPLE_2,
        "agrees with −0.1 q₁ read per sample; the printed schedule freezes on the way",
    ),
    PaperFigure("Fig 4", "photograph of the exoskeleton", NO_RESULT, "", ""),
    PaperFigure(
        "Fig 5",
        "joint velocities of one participant",
        GENERATED,
        _REACHING,
        "curves of a generated person: only the layout can be compared",
    ),
    PaperFigure(
        "Fig 6",
        "weights of 17 participants, Hotelling's T²",
        GENERATED,
        _REACHING,
        "drawn around the published weights, so that the means agree by construction; the test "
        "is made on log-ratios, which do not depend on the joint that is set to 1",
    ),
    PaperFigure(
        "Fig 7",
        "null-space velocity with identified weights and with W = I",
        GENERATED,
        _REACHING,
        "the fall with identified weights is found; how large it is depends on the people",
    ),
    PaperFigure("Fig 8", "the second setup and its chain", NO_RESULT, "", ""),
    PaperFigure(
        "Fig 9",
        "weights of 10 participants in four conditions",
        GENERATED,
        _SCREEN,
        "shown by maximum likelihood too, which says where nothing can be told",
    ),
    PaperFigure(
        "Table 1",
        "the same as contributions β",
        GENERATED,
        _SCREEN,
        "with a locked or coupled elbow the numbers describe the movement, not the person",
    ),
    PaperFigure(
        "S1 File",
        "error against null-space noise",
        COMPUTED,
        _EXAMPLE_1,
        "the file is not at hand; the text says that the error grows, and it does",
    ),
    PaperFigure(
        "S1, S2 Datasets",
        "the recordings",
        MISSING,
        "",
        "--data FILE.mat runs either experiment on them",
    ),
)

_PLANNED, _PEOPLE = "Planned movements", "Simulated people"
TOMMASINO2017 = (
    PaperFigure("Fig 1", "diagrams of PMP and λ0-PMP", NO_RESULT, "", ""),
    PaperFigure("Fig 2", "drawing of task and wrist", TAKEN, _PLANNED, "targets as in Fig 3, A"),
    PaperFigure(
        "Fig 3",
        "A paths, B joint angles, C speed of planned movements",
        COMPUTED,
        _PLANNED,
        "agrees in what is said of it; the spring printed there is ten times that of eq. 10",
    ),
    PaperFigure(
        "Fig 4",
        "areas right and left of a path",
        TAKEN,
        _PLANNED,
        "drawn for one planned movement; the text takes the line between targets, the caption "
        "that between the movement's ends",
    ),
    PaperFigure(
        "Fig 5",
        "mean paths of six subjects, with the model",
        GENERATED,
        _PEOPLE,
        "other people; thick lines and stars after correction for many tests",
    ),
    PaperFigure("Fig 6", "A_net of subjects and model", GENERATED, _PEOPLE, "other people"),
    PaperFigure(
        "Fig 7",
        "joint angles to and from E and W",
        GENERATED,
        _PEOPLE,
        "other people: the paper's vary far more in pronation",
    ),
    PaperFigure(
        "Fig 8",
        "speed of a representative subject",
        GENERATED,
        _PEOPLE,
        "bell-shaped; that the model is faster than people cannot show, as the model moves them",
    ),
    PaperFigure(
        "Tables 1, 2",
        "stiffness and rest posture of the subjects",
        MISSING,
        "",
        "left out of the text at hand; the simulated people have laws of their own",
    ),
)

_SPACE, _ABSENT = "Scenario 1: the workspace", "What cannot be compared"
_SATURATED = "Joint limits as saturation"
_ISLAND = "Scenario 1: over the shoulder"
_SAGITTAL = "Scenario 2: circles in the sagittal plane"
_CORONAL = "Scenario 3: circles in the coronal plane"
DEBOON = (
    PaperFigure(
        "Table 1, Fig 1",
        "Denavit–Hartenberg parameters and frames",
        TAKEN,
        NUMBERS,
        "the arm is built from them; selfmotion arms upper_limb lists it",
    ),
    PaperFigure(
        "Fig 2",
        "saturation functions; block diagram",
        COMPUTED,
        _SATURATED,
        "eqs 10 and 11, with the limits of Table 3: the caption's “Table 1” has none; the diagram "
        "is selfmotion ik --method paper",
    ),
    PaperFigure("Figs 3, 4", "setup, photographs", NO_RESULT, "", ""),
    PaperFigure("Table 2", "list of landmarks", NO_RESULT, "", ""),
    PaperFigure(
        "Fig 5",
        "measured angles over time",
        MISSING,
        _ABSENT,
        "their extremes are Table 3",
    ),
    PaperFigure(
        "Table 3",
        "ranges of motion",
        TAKEN,
        NUMBERS,
        "three upper limits are lost in the text at hand and assumed",
    ),
    PaperFigure(
        "Fig 6",
        "hulls of the workspace, free and splinted",
        OWN,
        _SPACE,
        "the constrained set lies inside the free one, as said; no volume is printed",
    ),
    PaperFigure(
        "Fig 7",
        "slice at z = 0, with an island over the shoulder",
        OWN,
        _ISLAND,
        "as the set that is reached: a hull overstates a hollow slice",
    ),
    PaperFigure(
        "Figs 8, 9",
        "slices above and below, with cut-outs of the body",
        OWN,
        _SPACE,
        "cut out by shapes of our own: the paper gives no sizes",
    ),
    PaperFigure(
        "Fig 10", "arcs of the sagittal device", OWN, _SAGITTAL, "the notch's place is not printed"
    ),
    PaperFigure(
        "Fig 11",
        "elbow and wrist along them",
        OWN,
        _SAGITTAL,
        "only the elbow is fixed well enough to say more than the cost chosen",
    ),
    PaperFigure(
        "Fig 12", "arcs of the coronal device", OWN, _CORONAL, "the notch's place is not printed"
    ),
    PaperFigure("Fig 13", "elbow and wrist along them", OWN, _CORONAL, "as Fig 11"),
)

_SHOULDER = "The shoulder centre moves"
_HYBRID = "Hybrid inverse kinematics, and times"
_EXAMPLE = "The example pose"
# Sections with recorded people, where there are some.
_ON_PEOPLE, _OTHERS = "On recorded people", "Other laws"
_RECORDED = "needs recorded people: --recordings DIR --study FILE.toml"
LI2022 = (
    PaperFigure("Figs 1, 2", "flowchart; definition of the swivel angle", NO_RESULT, "", ""),
    PaperFigure(
        "Table I",
        "Denavit–Hartenberg parameters of the 7-DoF arm",
        TAKEN,
        "",
        "its structure; the lengths are those of our arm",
    ),
    PaperFigure(
        "Fig 3",
        "displacement of the shoulder centre",
        COMPUTED,
        _SHOULDER,
        "the default arm instead of one scaled to a person; the sign to the right is a misprint",
    ),
    PaperFigure(
        "Fig 4",
        "swivel angle with a fixed and with a moving shoulder",
        COMPUTED,
        _SHOULDER,
        "the paper's hand pose is not printed",
    ),
    PaperFigure(
        "Tables II, III",
        "the two algorithms",
        TAKEN,
        "",
        "selfmotion posture --search paper runs them",
    ),
    PaperFigure(
        "Fig 5",
        "errors of the hybrid inverse kinematics",
        COMPUTED,
        _HYBRID,
        "no number is printed; refined to far below a millimetre",
    ),
    PaperFigure(
        "Fig 6",
        "effort over the swivel angle",
        COMPUTED,
        _EXAMPLE,
        "the paper's hand pose is not printed; traced to its ends instead of sampled",
    ),
    PaperFigure("Fig 7", "photograph of the experiment", NO_RESULT, "", ""),
    PaperFigure("Fig 8", "error by place", MISSING, _ON_PEOPLE, _RECORDED),
    PaperFigure("Fig 9", "errors of all trials", MISSING, _ON_PEOPLE, _RECORDED),
    PaperFigure(
        "Table IV",
        "errors of other laws",
        TAKEN,
        _OTHERS,
        "as printed: each law on people of its own",
    ),
)
_ON_OUR_PEOPLE = "other people, tasks and arm: the published error does not carry over"

FIGURES = {
    "khoramshahi2022": KHORAMSHAHI2022,
    "tommasino2017": TOMMASINO2017,
    "deboon": DEBOON,
    "li2022": LI2022,
}


def figures_of(paper: str, headings: frozenset[str]) -> tuple[PaperFigure, ...]:
    """Give the figures and tables of a paper, as a report with these sections holds them.

    Args:
        paper: its key, as in `reproduce`.
        headings: of the report's sections; people of one's own fill what else is missing.
    """
    if _ON_PEOPLE not in headings:
        return FIGURES[paper]
    given = {"here": GIVEN, "section": _ON_PEOPLE, "difference": _ON_OUR_PEOPLE}
    return tuple(
        replace(one, **given) if one.section in (_ON_PEOPLE, _OTHERS) else one
        for one in FIGURES[paper]
    )
