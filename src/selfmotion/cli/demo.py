"""`selfmotion demo`: the main job on generated people, with one report."""

from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.options import Json, Out, Quiet, Seed
from selfmotion.cli.output import Contract, Document, Number, Part, finish, numbers
from selfmotion.provenance import Provenance
from selfmotion.writing import write_whole

if TYPE_CHECKING:
    from selfmotion.studies.demonstration import Demonstration

FOLDER, PERSON = Path("demo"), "person"


class ConditionWeights(Part, frozen=True, kw_only=True):
    """Mean contribution (eq. 26) of each joint in a condition, found and true.

    A joint that is not `identified` in anybody counts as 1, the paper's convention.
    """

    condition: str
    joints: list[str]
    identified: list[bool]
    contribution: list[Number]
    true_contribution: list[Number]


class DemoDocument(Document, frozen=True, tag="selfmotion/demo/1", kw_only=True):
    """What the demonstration found, and where its report lies."""

    report: str
    files: list[str]
    people: int
    recordings: int
    conditions: list[ConditionWeights]
    hotelling_p: Number


CONTRACT = Contract(DemoDocument, ("demo", "--out", "build/demo", "--json"))


def demo(json: Json = False, out: Out = None, seed: Seed = 0, quiet: Quiet = False) -> int:
    """Run the main job on generated people and write a report."""
    from selfmotion.cli.progress import stages

    folder = out or FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    with stages(quiet=quiet) as tell:
        tell("generating people and identifying their weights")
        from selfmotion.report.demo_page import write_demo_report
        from selfmotion.studies.demonstration import demonstrate

        shown = demonstrate(seed=seed)
        tell("drawing the report")
        provenance = Provenance("demo", seed=seed, choices={"people": len(shown.made.people)})
        report = write_demo_report(folder / "report.html", shown, provenance)
    files = [*save_recordings(shown, folder), *save_person(folder / PERSON, seed)]
    reaching = shown.reaching
    document = DemoDocument(
        provenance=provenance,
        report=str(report),
        files=[str(path) for path in files],
        people=len(shown.made.people),
        recordings=len(shown.study),
        conditions=[contributions_of(shown, condition) for condition in reaching.conditions],
        hotelling_p=reaching.test.p_value if reaching.test else None,
    )
    return finish(document, as_text(document), json=json)


def save_recordings(shown: "Demonstration", folder: Path) -> list[Path]:
    """Write the recordings of one person as joint angles, and the table of all weights."""
    from selfmotion.motion.files.angles_csv import write_angles_csv
    from selfmotion.studies.demonstration import angles_only

    person = shown.made.people[0].name
    recordings = angles_only(shown.study.select(subject=person))
    table = shown.reaching.weights.to_csv(index=False)
    return [
        write_angles_csv(folder / "reach.csv", recordings),
        write_whole(folder / "weights_of_people.csv", table),
    ]


def save_person(folder: Path, seed: int) -> list[Path]:
    """Write the markers of one generated person; give the study file and the table of the truth."""
    import numpy as np

    from selfmotion.studies.simulated_person import simulate_person, write_person

    made = simulate_person(rng=np.random.default_rng(seed))
    return write_person(made, folder)[:2]


def contributions_of(shown: "Demonstration", condition: str) -> ConditionWeights:
    """Compare mean contributions, found and true."""
    import numpy as np

    from selfmotion.methods.weights.estimate import contributions

    true = np.mean([contributions(p.weights[condition]) for p in shown.made.people], axis=0)
    table = shown.reaching.weights
    of_condition = table[(table["condition"] == condition) & table["identified"]]
    known = set(of_condition["joint"].tolist())
    return ConditionWeights(
        condition=condition,
        joints=list(shown.study.joints),
        identified=[joint in known for joint in shown.study.joints],
        contribution=numbers(shown.reaching.beta["ml"][condition]),
        true_contribution=numbers(true),
    )


def as_text(document: DemoDocument) -> str:
    """Write the outcome as a person reads it."""
    lines = [f"{document.people} generated people, {document.recordings} movements"]
    for c in document.conditions:
        lines.append(f"{c.condition}: contribution of each joint, mean over people (true)")
        rows = zip(c.joints, c.contribution, c.true_contribution, c.identified, strict=True)
        for joint, found, true, known in rows:
            words = joint.replace("_", " ")
            note = "" if known else "  not identified: no other joint can stand in; counts as 1"
            lines.append(f"  {words:20} {_two(found)} ({_two(true)}){note}")
    lines += [f"wrote {path}" for path in document.files]
    lines.append("and markers of one generated person beside the study file, for `person`")
    lines.append(f"report: {document.report}")
    return "\n".join(lines)


def _two(value: float | None) -> str:
    return "   ?" if value is None else f"{value:4.2f}"
