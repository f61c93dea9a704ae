"""The report of `selfmotion person`: one arm of one person through all four methods."""

from pathlib import Path

import numpy as np
import pandas as pd

from selfmotion.methods.donders import JointElasticity
from selfmotion.methods.workspace import Workspace
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.person_figures import (
    compensation_figure,
    natural_posture_figure,
    plans_figure,
    weights_change_figure,
    weights_of_person_figure,
)
from selfmotion.report.workspace_figures import slices_figure
from selfmotion.studies.one_person import OnePerson, identified, sizes_of_errors
from selfmotion.studies.people_means import means_by
from selfmotion.studies.person_plans import OWN_LAW, OWN_WEIGHTS

PAPERS = ("Khoramshahi2022", "Tommasino2017", "DeBoon", "Li2022")


def write_person_report(path: str | Path, found: OnePerson) -> Path:
    """Write the report; give its path."""
    sections = [
        capture_section(found),
        weights_section(found),
        elasticity_section(found),
        reach_section(found),
        posture_section(found),
        plans_section(found),
        splint_section(found),
    ]
    if found.missing:
        table = pd.DataFrame(list(found.missing), columns=["what", "why"])
        sections.append(Section("What could not be had", tables=(Table(table, ""),)))
    return write_report(
        path,
        f"{found.name}: how it moves, and where it reaches",
        sections,
        summary=" ".join(sentences(found)),
        footer=Footer((found.provenance,), PAPERS),
    )


def sentences(found: OnePerson) -> list[str]:
    """Say what was found, in plain sentences."""
    said = [f"{found.name}: {len(found.person.movements)} movements."]
    if identified(found.weights) and found.weights is not None:
        known = np.flatnonzero(np.isfinite(found.weights.weights))
        order = known[np.argsort(-found.weights.weights[known])]
        names = [found.weights.joints[i].replace("_", " ") for i in order]
        said.append(f"The joint spared most is {names[0]}, least {names[-1]}.")
    else:
        said.append("The weights could not be told from these movements; all count alike below.")
    if found.law is not None:
        said.append(
            f"Shoulder and elbow keep to one law of posture within {found.law.thickness_deg:.1f}°."
        )
    if found.splinted is not None:
        free, kept = (found.splinted.regions[k].volume for k in ("free", "limited"))
        said.append(f"A splinted elbow would leave {kept / free:.0%} of the workspace.")
    if found.change is not None:
        said.append(found.change.sentence())
    return said


def _worded(table: pd.DataFrame) -> pd.DataFrame:
    """Write the joints' names as words."""
    return _plain(table, "joint")


def _mean_size(errors: np.ndarray) -> str:
    """Give the mean of errors (degrees) in words, and how many poses could not be predicted."""
    known = errors[np.isfinite(errors)]
    if not known.size:
        return "none, since they allow no posture for the hand poses"
    lost = len(errors) - known.size
    return f"{known.mean():.0f}°" + (f" ({lost} of {len(errors)} poses not possible)" * bool(lost))


def _plain(table: pd.DataFrame, column: str) -> pd.DataFrame:
    """Write the names in a column as words."""
    return table.assign(**{column: [str(name).replace("_", " ") for name in table[column]]})


def _nothing(heading: str, found: OnePerson, part: str) -> Section:
    why = next((reason for what, reason in found.missing if what == part), "no data")
    return Section(heading, warning=f"Could not be had: {why}")


def _heading(column: str) -> str:
    """Write the name of a column of measures as words: ``swivel_end_deg``, ``rms_landmark_mm``."""
    if column.startswith("swivel_"):
        moment = column.removeprefix("swivel_").removesuffix("_deg").replace("_", " ")
        return f"swivel at {moment} (°)"
    return {"rms_landmark_mm": "error (mm)"}.get(column, column.replace("_", " "))


def capture_section(found: OnePerson) -> Section:
    """Show lengths and how well the arm fits."""
    lengths = pd.DataFrame(
        {
            "segment": [k.replace("_", " ") for k in found.person.person.lengths],
            "mm": [1e3 * v for v in found.person.person.lengths.values()],
        }
    )
    measures = [str(c) for c in found.capture.columns if c not in ("task", "trial")]
    means = means_by(found.capture, ["task"], measures)
    means.columns = pd.Index([_heading(str(c)) for c in means.columns])
    return Section(
        "Markers to joint angles",
        words=(
            "The arm was scaled to the person and its joint angles found from the markers, inside "
            "the ranges of adults.",
        ),
        tables=(
            Table(lengths, "Segment lengths."),
            Table(
                means,
                "Mean over the movements of a task: how far the arm misses the landmarks, and the "
                "swivel angle of the elbow (0: hanging down, positive: out to the side).",
            ),
        ),
    )


def weights_section(found: OnePerson) -> Section:
    """Show the weights and velocity shares."""
    if found.weights is None:
        return _nothing("Which joints are spared", found, "weights")
    columns = ["joint", "weight", "lower", "upper", "reason"]
    table = _worded(pd.DataFrame(found.weights.to_frame(), columns=columns))
    shares = found.shares.rename(
        columns={"task_share": "task share", "task_share_alike": "with all weights alike"}
    )
    trouble = "" if identified(found.weights) else f"Not identified: {found.weights.status}"
    pictures = []
    if not trouble:
        pictures.append(
            Picture(
                weights_of_person_figure(found.weights),
                "Points: weights beside the largest, which is 1. Lines: 95 % intervals.",
                "Weights of the joints with their intervals",
            )
        )
    return Section(
        "Which joints are spared",
        words=(
            "Weights of inverse kinematics with the wrist's place as the task, all movements "
            "together. A large weight means that the joint is moved little for the hand.",
        ),
        warning=trouble,
        pictures=tuple(pictures),
        tables=(
            Table(table, "Weights with 95 % intervals; a dash: not identified."),
            Table(shares, "Share of squared joint velocity that serves the wrist's path."),
        ),
    )


def elasticity_section(found: OnePerson) -> Section:
    """Show the law of the joints."""
    if found.law is None:
        return _nothing("Elasticity behind the postures", found, "elasticity")
    kept = ["segment", "task", "postures", "thickness_deg", "held_out_deg"]
    thin = pd.DataFrame(found.surfaces, columns=kept)
    thin.columns = pd.Index([name.removesuffix("_deg").replace("_", " ") for name in kept])
    return Section(
        "Elasticity behind the postures",
        words=("A law of least elastic energy for shoulder and elbow, fitted to all postures.",),
        points=tuple(sentence.replace("_", " ") for sentence in found.law.sentences),
        tables=(
            Table(law_table(found.law), "The law; stiffness up to its trace, set to 4 N m/rad."),
            Table(thin, "Thickness of Donders' surfaces (°): beside all postures, and held out."),
        ),
    )


def law_table(law: JointElasticity) -> pd.DataFrame:
    """Give stiffness and rest posture (degrees) of each joint with standard errors."""
    found = law.to_frame().set_index("parameter")
    joints = [str(p).removeprefix("rest ") for p in found.index if str(p).startswith("rest ")]
    stiffness = found.loc[[f"stiffness {joint}" for joint in joints]]
    rest = found.loc[[f"rest {joint}" for joint in joints]]
    return pd.DataFrame(
        {
            "joint": [joint.replace("_", " ") for joint in joints],
            "stiffness (N m/rad)": stiffness["value"].to_numpy(float),
            "standard error": stiffness["stderr"].to_numpy(float),
            "rest (°)": np.degrees(rest["value"].to_numpy(float)),
            "its standard error": np.degrees(rest["stderr"].to_numpy(float)),
        }
    )


def _volumes(space: Workspace, name: str) -> pd.DataFrame:
    rows = [
        (words, 1e3 * space.regions[key].volume, 1e3 * space.regions[key].standard_error)
        for key, words in (("free", "ranges of adults"), ("limited", name), ("lost", "lost"))
    ]
    return pd.DataFrame(rows, columns=["ranges", "litres", "standard error"])


def reach_section(found: OnePerson) -> Section:
    """Show workspaces and ranges."""
    if found.reach is None or found.splinted is None:
        return _nothing("Where the hand reaches", found, "workspace")
    ranges = pd.DataFrame(
        [
            (j.replace("_", " "), np.degrees(r.low), np.degrees(r.high))
            for j, r in found.ranges.items()
        ],
        columns=["joint", "from (°)", "to (°)"],
    )
    return Section(
        "Where the hand reaches",
        words=(
            "Ranges used are what these movements needed; they are no measurement of what the "
            "person can do.",
        ),
        pictures=(
            Picture(
                slices_figure(found.splinted),
                "Horizontal slices: kept with a splinted elbow, and lost.",
                "Slices of the workspace with kept and lost areas",
            ),
        ),
        tables=(
            Table(ranges, "Ranges used in all movements together."),
            Table(_volumes(found.reach, "ranges used"), "Workspace in the ranges used."),
            Table(_volumes(found.splinted, "splinted elbow"), "Workspace with a splinted elbow."),
        ),
    )


def posture_section(found: OnePerson) -> Section:
    """Show natural postures beside predictions."""
    if not len(found.postures):
        return _nothing("Natural posture", found, "natural posture")
    errors = sizes_of_errors(found.postures)
    means = means_by(errors, ["task", "moment"], ["effort", "bounded"])
    table = _plain(means, "moment")
    table.columns = pd.Index(["task", "moment", "least effort", "in the ranges used otherwise"])
    effort, bounded = (_mean_size(errors[c].to_numpy(float)) for c in ("effort", "bounded"))
    return Section(
        "Natural posture",
        words=(
            "Swivel angle at the moments that the study names, beside that of least muscle "
            "effort on the model arm at the person's size: inside the ranges of adults, and inside "
            "what this person used in the other movements, and 5° more. Mean error in the ranges "
            f"of adults: {effort}; in the ranges used otherwise: {bounded}.",
        ),
        pictures=(
            Picture(
                natural_posture_figure(found.postures),
                "Each mark is a movement.",
                "Recorded and predicted swivel angles by task",
            ),
        ),
        tables=(Table(table, "Mean size of the error (°)."),),
    )


def plans_section(found: OnePerson) -> Section:
    """Show planned beside recorded movements."""
    if not len(found.plans):
        return _nothing("Planned movements", found, "plans")
    columns = ["apart_mm", "posture_error_deg", "swivel_error_deg"]
    table = means_by(found.plans, ["task", "model"], columns)
    table.columns = pd.Index(["task", "model", "path (mm)", "posture (°)", "swivel (°)"])
    note = (
        ""
        if identified(found.weights)
        else ("No weights could be identified: as damping all joints count alike.")
    )
    return Section(
        "Planned movements",
        words=(
            "λ0-PMP from the recorded start to where the wrist was at the goal, with the fitted "
            f"law and its own damping ({OWN_LAW}), and with this person's inverse-kinematics "
            f"weights as damping ({OWN_WEIGHTS}). Law and weights come from the same movements.",
        ),
        warning=note,
        pictures=(
            Picture(
                plans_figure(found.plans),
                "Dots: movements. Bars: their mean.",
                "Distance of planned from recorded movements by task and model",
            ),
        ),
        tables=(Table(table, "Means over movements."),),
    )


def splint_section(found: OnePerson) -> Section:
    """Show what a splint changes."""
    change = found.change
    if change is None:
        return _nothing("With a splinted elbow", found, "splint")
    reached = pd.DataFrame(
        [(task, share) for task, share in change.by_condition.items()],
        columns=["task", "share of the path"],
    )
    costs = "with this person's weights as costs"
    if not identified(found.weights):
        costs = "with the same cost for every joint, since no weight could be identified"
    table = _worded(change.to_frame())
    table.columns = pd.Index(
        ["joint", "range before (°)", "range after (°)", "weight before", "weight after"]
    )
    pictures = [
        Picture(
            compensation_figure(change),
            "What moves more with the splint compensates.",
            "Range of each joint without and with the splint",
        )
    ]
    if change.before is not None and change.after is not None:
        pictures.append(
            Picture(
                weights_change_figure(change),
                "Weights identified from the same wrist paths, followed with the same costs: what "
                "differs is due to the splint alone.",
                "Weights without and with the splint",
            )
        )
    return Section(
        "With a splinted elbow",
        words=(
            change.sentence(),
            f"The recorded paths of the wrist, followed by this arm {costs}: once with all ranges, "
            "once with the elbow between 64° and 114°.",
        ),
        pictures=tuple(pictures),
        tables=(
            Table(reached, "How much of the wrist's paths can still be followed."),
            Table(table, "Joints; weights as an observer would identify them."),
        ),
    )
