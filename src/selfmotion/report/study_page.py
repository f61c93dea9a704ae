"""The report of a study: its files, its people's weights, and what differs between conditions."""

from pathlib import Path

from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.study_figures import angle_bands_figure, contribution_radar
from selfmotion.report.theme import words
from selfmotion.report.weights_figures import weights_figure
from selfmotion.studies.study_run import StudyRun
from selfmotion.studies.weight_tables import weight_table

TRIAL_COLUMNS = (
    "subject",
    "side",
    "condition",
    "trial",
    "status",
    "frames",
    "movement_s",
    "rms_landmark_mm",
    "elbow_disagreement_mm",
    "share_at_limit",
    "swivel_start_deg",
    "swivel_end_deg",
)


def write_study_report(path: str | Path, run: StudyRun) -> Path:
    """Write the report of a study; give its path."""
    sections = [weights_section(run), tests_section(run), angles_section(run), files_section(run)]
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


def weights_section(run: StudyRun) -> Section:
    """Show weights by person, contributions, and shares of the velocity."""
    both = len({side for _, side, _ in run.estimates}) > 1
    table = weight_table(
        {(p, f"{c} {s}".strip() if both else c): e for (p, s, c), e in run.estimates.items()}
    )
    return Section(
        "Weights",
        words=(
            "A weight is what it costs to move a joint for the task; only ratios mean anything, "
            "and only where the movements excite them: a few repeats to one target often do not.",
        ),
        pictures=(
            Picture(
                weights_figure(table),
                "Each point is a person; bars are geometric mean and 95 % interval.",
                "Weights of each joint, by person and condition",
            ),
            Picture(
                contribution_radar(run.estimates),
                "Contribution of each joint (eq. 26), one line a person.",
                "Radar charts of the contributions of the joints, by condition",
            ),
        ),
        tables=(
            Table(
                run.groups,
                "By person, side and condition. task_share: of squared joint velocity, with these "
                "weights and (identity) with all alike; synergy: index of the uncontrolled "
                "manifold over the repeats, mean over the movement.",
            ),
        ),
    )


def tests_section(run: StudyRun) -> Section:
    """Show the paired tests and the descriptive table."""
    tables = []
    if len(run.tests):
        tables.append(Table(run.tests, "Paired Hotelling tests on log-ratios of weights."))
    if len(run.changes):
        tables.append(
            Table(
                run.changes,
                "Mean over people of the change of each log-weight against the mean joint, second "
                "against first, with its 95 % t-interval.",
            )
        )
    points = tuple(
        f"{r['comparison']}, {r['level']}: {r['sentence']}" for r in run.tests.to_dict("records")
    )
    return Section(
        "Comparisons",
        words=("The tests are not corrected for their number: count them.",),
        points=points,
        tables=tuple(tables),
    )


def angles_section(run: StudyRun) -> Section:
    """Show joint angles over the movement."""
    return Section(
        "Joint angles",
        pictures=(
            Picture(
                angle_bands_figure(run.movements),
                "Mean and standard deviation over people, 0 to 100 % of the movement; joints: "
                + ", ".join(words(j) for j in run.movements.joints)
                + ".",
                "Angle of each joint over the movement, by condition",
            ),
        ),
    )


def files_section(run: StudyRun) -> Section:
    """List the files with their quality."""
    failed = run.trials.loc[~run.trials["ok"].astype(bool)]
    columns = [name for name in TRIAL_COLUMNS if name in run.trials.columns]
    return Section(
        "Files",
        points=tuple(f"{r['file']}: {r['status']}" for r in failed.to_dict("records")),
        tables=(
            Table(run.trials.loc[:, columns], "One row a file; share_at_limit: of its frames."),
        ),
        warning=f"{len(failed)} files could not be used." if len(failed) else "",
    )
