"""The report of a study: its files, its people's weights, and what differs between conditions."""

from collections.abc import Mapping
from pathlib import Path

from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.study_figures import angle_bands_figure, contribution_radar
from selfmotion.report.study_people_figures import (
    people_weights_figure,
    shares_figure,
    swivel_bands_figure,
)
from selfmotion.report.study_tables import groups_frame, people_frame, swivel_frame
from selfmotion.report.svg import write_png
from selfmotion.report.theme import words
from selfmotion.studies.study_run import StudyRun
from selfmotion.studies.study_statistics import comparison_lines
from selfmotion.studies.study_summary import LEAST_OFF_LINE

TRIAL_COLUMNS = (
    "subject",
    "side",
    "condition",
    "trial",
    "movement_s",
    "rms_landmark_mm",
    "elbow_disagreement_mm",
    "share_at_limit",
    "moments_missing",
)


def write_study_report(path: str | Path, run: StudyRun) -> Path:
    """Write the report of a study; give its path."""
    pictures = study_pictures(run)
    sections = [
        weights_section(run, pictures),
        tests_section(run),
        shares_section(run, pictures),
        angles_section(pictures),
        *swivel_sections(run, pictures),
        files_section(run),
    ]
    footer = Footer((run.provenance,), ("Khoramshahi2022", "DeBoon"))
    return write_report(
        path, "Joint preferences of a study", sections, summary=summary(run), footer=footer
    )


def summary(run: StudyRun) -> str:
    """Say what was run and how much of it could be identified."""
    found = sum(bool(e.groups) for e in run.estimates.values())
    people = run.trials["subject"].nunique()
    return (
        f"{len(run.trials)} files of {people} people; {run.n_failed} could not be used. Of "
        f"{len(run.estimates)} sets of weights (a person, a side, a condition) {found} hold ratios "
        "that the movements determine."
    )


def study_pictures(run: StudyRun) -> dict[str, Picture]:
    """Draw all pictures of a study, by the name that their files take."""
    pictures: dict[str, Picture] = {}
    for name, estimates in (("weights", run.estimates), ("weights_pooled", run.pooled)):
        if any(e.groups for e in estimates.values()):
            which = ", all conditions of a person together" if estimates is run.pooled else ""
            pictures[name] = Picture(
                people_weights_figure(estimates),
                f"A line is a person{which}; black: geometric mean over people and its 95 % "
                "interval. What holds no identified ratio is left out.",
                f"Weights of each joint by person{which}",
            )
    if pictures:
        pictures["contributions"] = Picture(
            contribution_radar({**run.estimates, **run.pooled}),
            "Contribution of each joint (eq. 26), one line a person.",
            "Radar charts of the contributions of the joints, by condition",
        )
    pictures["shares"] = Picture(
        shares_figure(run.groups),
        "A point is a person; mean and 95 % interval beside. Weights of the other conditions "
        "were not fitted to these movements. Below: synergy over the repeats.",
        "Task shares and synergy index by condition",
    )
    for (side,), part in run.movements.group("side").items():
        of = f"{side} arm: " if side else ""
        pictures[f"angles_{side}" if side else "angles"] = Picture(
            angle_bands_figure(part),
            f"{of}mean and standard deviation over people, 0 to 100 % of the movement; joints: "
            + ", ".join(words(j) for j in part.joints)
            + ".",
            f"{of}angle of each joint over the movement, by condition",
        )
    if len(run.swivel):
        pictures["swivel"] = Picture(
            swivel_bands_figure(run.swivel, run.trials),
            "Swivel angle from the landmarks: mean and standard deviation over the repeats of each "
            "person. No line where the hand is above the shoulder and the angle does not exist.",
            "Swivel angle over the movement, by side and condition, one line a person",
        )
    return pictures


def write_pictures(run: StudyRun, folder: Path) -> list[Path]:
    """Write all pictures of a study as PNG files."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, picture in study_pictures(run).items():
        written.append(folder / f"{name}.png")
        write_png(picture.figure, str(written[-1]))
    return written


def weights_section(run: StudyRun, pictures: Mapping[str, Picture]) -> Section:
    """Show weights by person, and contributions."""
    names = ("weights", "weights_pooled", "contributions")
    tables = ()
    if len(run.summary.joints):
        tables = (
            Table(
                run.summary.joints,
                "Geometric mean over people, largest = 1; lower and upper: 95 % interval "
                "(jackknife over people); lowest and highest person; people in whom the joint was "
                "identified, of how many.",
            ),
        )
    return Section(
        "Weights",
        words=(
            "A weight is what it costs to move a joint for the task; only ratios mean anything, "
            "and only where the movements excite them: a few repeats to one target often do not.",
        ),
        pictures=tuple(pictures[name] for name in names if name in pictures),
        tables=tables,
    )


def shares_section(run: StudyRun, pictures: Mapping[str, Picture]) -> Section:
    """Show shares of the velocity and synergy over repeats."""
    return Section(
        "Shares and synergy",
        pictures=(pictures["shares"],),
        tables=(
            Table(
                people_frame(run.summary.people),
                "Mean over people with standard deviation and 95 % interval.",
            ),
            Table(
                groups_frame(run.groups, run.estimates),
                "By person, side and condition. Task share: of squared joint velocity, with the "
                "weights of these movements, with all alike and with those of the person's other "
                "conditions; synergy: index of the uncontrolled manifold over the repeats, mean "
                "over the movement; joints whose weights the movements determine. More in "
                "groups.csv.",
            ),
        ),
    )


def tests_section(run: StudyRun) -> Section:
    """Show the paired tests and the descriptive table."""
    tables = []
    if "t2" in run.tests:
        made = run.tests.dropna(subset=["t2"]).drop(columns=["sentence"])
        tables.append(Table(made, "Paired Hotelling tests on log-ratios of weights."))
    if len(run.changes):
        tables.append(
            Table(
                run.changes,
                "Mean over people of the change of each log-weight against the mean joint, second "
                "against first, with its 95 % t-interval.",
            )
        )
    points = tuple(comparison_lines(run.tests))
    return Section(
        "Comparisons",
        words=("The tests are not corrected for their number: count them.",),
        points=points,
        tables=tuple(tables),
    )


def angles_section(pictures: Mapping[str, Picture]) -> Section:
    """Show joint angles over the movement."""
    return Section(
        "Joint angles",
        pictures=tuple(p for name, p in pictures.items() if name.startswith("angles")),
    )


def swivel_sections(run: StudyRun, pictures: Mapping[str, Picture]) -> list[Section]:
    """Show the swivel angle; nothing where the files held no markers."""
    if "swivel" not in pictures:
        return []
    near = f"{LEAST_OFF_LINE:.0f} mm"
    return [
        Section(
            "Swivel angle",
            pictures=(pictures["swivel"],),
            tables=(
                Table(
                    swivel_frame(run.summary.swivel),
                    "In degrees. Within: standard deviation over a person's repeats, pooled; "
                    "between: that of the people's means; in brackets: "
                    "95 % intervals. Which: all "
                    f"movements, and where these are fewer, those with the elbow at least {near} "
                    "off the line from shoulder to wrist, near which the angle hardly exists.",
                ),
            ),
        )
    ]


def files_section(run: StudyRun) -> Section:
    """List the files with their quality."""
    failed = run.trials.loc[~run.trials["ok"].astype(bool)]
    columns = [name for name in TRIAL_COLUMNS if name in run.trials.columns]
    used = run.trials.loc[run.trials["ok"].astype(bool), columns]
    whole = Table(used, "One row a file that was used; share_at_limit: of its frames.")
    tables = (whole,)
    if len(run.summary.quality):
        over = "Median, 5th and 95th percentile over all files (mm; share_at_limit: of frames)."
        tables = (Table(run.summary.quality, over), whole)
    return Section(
        "Files",
        points=tuple(f"{r['file']}: {r['status']}" for r in failed.to_dict("records")),
        tables=tables,
        warning=f"{len(failed)} files could not be used." if len(failed) else "",
    )
