"""The report of `selfmotion workspace`: a person's reach, for a physiotherapist.

Which part of the space that this person would reach is kept and which is lost, with what certainty;
which everyday places that concerns; which movement's limit is to blame; and what was assumed.
"""

from collections.abc import Sequence
from pathlib import Path

from selfmotion.kinematics.body_shapes import BodyShapes, Posture
from selfmotion.methods.reaching.details import WorkspaceDetails
from selfmotion.methods.workspace import Workspace
from selfmotion.report.html import Footer, Picture, Section, Table, write_report
from selfmotion.report.workspace_body_figures import (
    bounded_slices_figure,
    cuts_figure,
    ranges_figure,
    regions_figure,
)
from selfmotion.report.workspace_tables import (
    PagePerson,
    body_words,
    boundary_frame,
    cm3,
    measured_frame,
    norms_of,
    percent,
    person_frame,
    ranges_frame,
    regions_frame,
    set_title,
    volume_frame,
)
from selfmotion.report.workspace_words import (
    boundary_sentences,
    is_anatomical,
    joined,
    joint_title,
    regained_sentences,
    zero_words,
)

# A region that lost more than this (%) is named in the summary; so many are.
MUCH, MOST_NAMED = 10.0, 3


def write_workspace_report(
    path: str | Path,
    space: Workspace,
    person: PagePerson,
    details: WorkspaceDetails,
    *,
    more: Sequence[Section] = (),
) -> Path:
    """Write the report on a workspace; give its path.

    Args:
        path: the HTML file.
        space: what is reached.
        person: whose it is.
        details: regions, boundary and cuts, of `workspace_details`.
        more: sections before the last, as of maps and recordings.
    """
    whose = person.name or f"a person's {person.side} arm"
    sections = [
        Section("Person", tables=(Table(person_frame(space, person), "Who was looked at."),)),
        *kept_sections(space, person, details),
        ranges_section(space, person),
        regions_section(details),
        cuts_section(space, person, details),
        *boundary_sections(space, person, details),
        *more,
        assumed_section(space, person, details),
    ]
    footer = Footer((space.provenance,), ("DeBoon",))
    title = f"Reach of {whose}"
    return write_report(path, title, sections, summary=summary(space, details), footer=footer)


def summary(space: Workspace, details: WorkspaceDetails) -> str:
    """Say what to take home: kept, lost, where, and what would help most."""
    free = space.regions["free"]
    if space.limited_arm is None:
        return f"The hand reaches {cm3(free.volume, free.standard_error)} cm³."
    limited, lost = space.regions["limited"], space.regions["lost"]
    kept, whole, gone = (f"{cm3(r.volume, r.standard_error)} cm³" for r in (limited, free, lost))
    if not limited.inside.any():
        return space.summary()
    text = (
        f"With its limits the hand reaches {kept} of the {whole} that it would reach without them: "
        f"{percent(limited, free)} is kept; {gone} ({percent(lost, free)}) are lost. "
    )
    parts = {}
    for reach in details.regions:
        there = reach.sets["free"].volume
        if there > 0 and 100.0 * reach.sets["lost"].volume / there > MUCH:
            share = 100.0 * reach.sets["lost"].volume / there
            parts[reach.region.title] = share
    if parts:
        worst = sorted(parts, key=lambda title: -parts[title])[:MOST_NAMED]
        named = [f"“{title}” ({parts[title]:.0f} %)" for title in worst]
        text += f"Lost most: {joined(named)}. "
    best = max(details.regained.items(), key=lambda item: item[1].part, default=None)
    if best is not None and len(details.regained) > 1 and best[1].points:
        name = joint_title(space.arm, best[0])
        text += f"Most would come back with the full range of {name} ({1e2 * best[1].part:.0f} %)."
    return text.strip()


def kept_sections(space: Workspace, person: PagePerson, details: WorkspaceDetails) -> list[Section]:
    """Show volumes with their errors, and what each joint alone would give back."""
    words = (
        "The space is that of the middle of the palm, with the hand turned in any way. The "
        "standard error comes from repeating the count with the points moved.",
        "The hull is the smallest shape without dents around all that is reached. It also counts "
        "hollows and the body, which the hand does not reach: compare volumes, not hulls.",
    )
    back = regained_sentences(space.arm, details.regained)
    made = [
        Section(
            "What is kept and what is lost" if space.limited_arm else "How much is reached",
            words=words,
            tables=(Table(volume_frame(space, person), "Volume that the hand reaches."),),
        )
    ]
    if len(back) > 1:
        note = (
            "If one joint alone had its free range and all others stayed as they are. The parts "
            "need not add up to all: some places need two joints at once, some either of them."
        )
        made.append(Section("Which joint would give back most", words=(note,), points=tuple(back)))
    return made


def ranges_section(space: Workspace, person: PagePerson) -> Section:
    """Show ranges beside those of healthy adults."""
    norms = norms_of(space.arm)
    frame = ranges_frame(space.arm, space.limited_arm, norms)
    words = []
    if norms:
        words.append(
            "Norms: range that 95 % of healthy adults keep to (shoulder, elbow, forearm and wrist: "
            "mean and two standard deviations of 109 men, Boone and Azen 1979; shoulder girdle: "
            "Ludewig 2009 and textbooks)."
        )
    if is_anatomical(space.arm):
        words.append(
            "Angles count from the hanging arm, with the palm turned forward: pronation of 90° is "
            "the mid-position. Negative are extension, adduction across the body, internal "
            "rotation, radial deviation, and a shoulder that is drawn back or lowered."
        )
    else:
        words.append(
            f"The model {space.arm.name} counts most angles in its own way; only joints that count "
            "as in the clinic are set beside norms. The arm upper_limb_anatomical counts all so."
        )
    tables = [Table(frame, "Degrees.")]
    if person.measured:
        words.append(
            "Measured from recordings: an end is the angle at or beyond which the joint was for "
            "0.1 s in total; of several recordings the farthest ends count."
        )
        tables.append(Table(measured_frame(space.arm, person), "Degrees, as recorded."))
    return Section(
        "Ranges of motion",
        words=tuple(words),
        pictures=(
            Picture(
                ranges_figure(space.arm, space.limited_arm, norms),
                "Range of each joint; behind it, where known, that of healthy adults.",
                "Joint ranges beside those of healthy adults",
            ),
        ),
        tables=tuple(tables),
    )


def regions_section(details: WorkspaceDetails) -> Section:
    """Show the named places."""
    pictures = ()
    if "limited" in details.regions[0].sets:
        pictures = (
            Picture(
                regions_figure(details.regions),
                "What of each place the free arm reaches, and how much of that is kept.",
                "Kept and lost share of each named place",
            ),
        )
    return Section(
        "Places of daily life",
        words=(
            "Boxes in front of, above, beside and behind the person, sized by the stature. Over "
            "the shoulder counts only with the elbow above the shoulder, the small of the back "
            "only with the elbow below it. “Of the place” says how much of the box the free arm "
            "reaches.",
        ),
        pictures=pictures,
        tables=(Table(regions_frame(details.regions), "Volumes with standard errors."),),
    )


def cuts_section(space: Workspace, person: PagePerson, details: WorkspaceDetails) -> Section:
    """Show the workspace from the side and from the front."""
    return Section(
        "The reach from the side and from the front",
        pictures=(
            Picture(
                cuts_figure(details.cuts, body_drawn(space, person), cut_out=person.cut_out),
                f"Cuts 2 cm thick, with the person's outline. {zero_words(space.arm)} White within "
                "it: not reached, or inside the body.",
                "Reach in a cut through the shoulder and in one before the body",
            ),
        ),
    )


def boundary_sections(
    space: Workspace, person: PagePerson, details: WorkspaceDetails
) -> list[Section]:
    """Say which limits bound the reach, and show it on slices; then the same for the free arm."""
    first = "limited" if "limited" in details.boundary else "free"
    limits = details.boundary[first]
    pictures = ()
    if details.slices:
        shown = body_drawn(space, person)
        cut_out = person.cut_out
        pictures = (
            Picture(
                bounded_slices_figure(details.slices, shown, limits.arm, cut_out=cut_out),
                "Horizontal slices 2 cm thick from above, the person facing up the page. Marks: "
                "which movement's limit stops the hand there.",
                "Horizontal slices with the joint limits that bound the reach",
            ),
        )
    made = [
        Section(
            "What stops the hand, and where",
            words=(
                "Every part of the boundary is put down to the limit that would let the hand go "
                "farthest if it gave way; others may take part. At full stretch the shoulder "
                "girdle, too, is at its end, since it carries the whole arm along.",
            ),
            points=tuple(boundary_sentences(limits)),
            pictures=pictures,
            tables=(Table(boundary_frame(limits), f"{set_title(first, person)}: the boundary."),),
        )
    ]
    if first == "limited":
        free = details.boundary["free"]
        made.append(
            Section(
                "What would stop it without the limits",
                points=tuple(boundary_sentences(free)),
                tables=(Table(boundary_frame(free), "Free arm: the boundary."),),
            )
        )
    return made


def assumed_section(space: Workspace, person: PagePerson, details: WorkspaceDetails) -> Section:
    """Say what the result rests on."""
    arm = space.arm
    lengths = ", ".join(f"{k.replace('_', ' ')} {1e3 * v:.0f} mm" for k, v in arm.lengths.items())
    points = [
        f"Model {arm.name} ({arm.source})." + (f" Lengths: {lengths}." if lengths else ""),
        "Each joint has its range whatever the others do. In a person, ranges depend on each "
        "other (an arm raised sideways rotates less): some places counted cannot be reached.",
        "The hand may be turned in any way, and strength, pain and speed play no part.",
    ]
    if not person.cut_out:
        points.append(
            "The person's own body was not cut out; its outline (seated) is drawn to show where it "
            "is. The option --body seated or standing cuts it out."
        )
    else:
        points.append(
            f"The body ({body_words(person)}) is made of simple shapes; the hand may not be inside "
            "it."
        )
    if person.arm_outside:
        points.append(
            "A place counts only where a posture was found that keeps upper arm and forearm out of "
            "chest, neck and head, too. What stops the hand is told of the hand alone."
        )
    for name, share in details.enters_body.items():
        points.append(
            f"{set_title(name, person)}: for {1e2 * share.part:.1f} ± "
            f"{1e2 * share.standard_error:.1f} % of the volume every posture tried moves the upper "
            "arm or forearm into chest or head. These places are counted as reached."
        )
    if not is_anatomical(arm):
        points.append(
            "The printed model of the paper bends and turns some joints otherwise than people do."
        )
    return Section("What was assumed", points=tuple(points))


def body_drawn(space: Workspace, person: PagePerson) -> BodyShapes:
    """Give the body that was cut out, or else a seated one for its outline."""
    if person.shapes is not None:
        return person.shapes
    posture: Posture = "standing" if person.body == "standing" else "seated"
    return BodyShapes.of(space.arm, posture)
