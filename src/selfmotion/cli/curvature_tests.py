"""The records of `selfmotion curvature`: movements, loops out and back, and tests by direction."""

from selfmotion.cli.output import Number, Part, numbers


class CurvedMovement(Part, frozen=True, kw_only=True):
    """Areas between one path and its straight line, over the squared length of that line.

    `a_right` and `a_left` lie right and left of the line, seen along the movement; `a_sum` is
    their sum and `a_net` right minus left. `duration` is in s where `timed`, else in samples;
    `length` is in m (m at 1 m for a pointing wrist). `stands_apart`: its duration or length is
    more than two interquartile ranges from the median of the person; the tests leave it out. A
    recording that could not be used has a status that says why.
    """

    name: str
    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    trial: str | None
    duration: Number
    timed: bool
    length: Number
    a_right: Number
    a_left: Number
    a_sum: Number
    a_net: Number
    stands_apart: bool
    failed: bool
    status: str


class Loop(Part, frozen=True, kw_only=True):
    """A movement out and the one back: `hysteresis` is the sum of their A_net."""

    subject: str | None
    side: str | None
    target: str | None
    hysteresis: float


class DirectionTest(Part, frozen=True, kw_only=True):
    """Student's t of the mean over the repetitions of one direction against zero.

    `measure` is a_net, a_sum (of a target and condition) or hysteresis (of a target; condition is
    null). `p_corrected` is after Holm for the directions of the person; `note` says that A_sum
    cannot be negative. Null: fewer than two repetitions, or no spread.
    """

    subject: str | None
    side: str | None
    condition: str | None
    target: str | None
    measure: str
    n: int
    mean: Number
    sd: Number
    t: Number
    p: Number
    p_corrected: Number
    differs: bool
    note: str


def marked(movements: list[CurvedMovement]) -> list[CurvedMovement]:
    """Mark the movements that stand apart from those of the same person and side."""
    from msgspec.structs import replace

    from selfmotion.motion.segment import stands_apart

    out = list(movements)
    for key in dict.fromkeys((m.subject, m.side) for m in movements):
        some = [i for i, m in enumerate(movements) if (m.subject, m.side) == key and not m.failed]
        apart = stands_apart([movements[i].duration or 0.0 for i in some])
        apart = apart | stands_apart([movements[i].length or 0.0 for i in some])
        for i, far in zip(some, apart.tolist(), strict=True):
            out[i] = replace(movements[i], stands_apart=far)
    return out


def people(movements: list[CurvedMovement]) -> list[list[CurvedMovement]]:
    """Sort movements by person and side, in order of appearance."""
    keys = dict.fromkeys((m.subject, m.side) for m in movements)
    return [[m for m in movements if (m.subject, m.side) == key] for key in keys]


def pairs_of(own: list[CurvedMovement], ways: tuple[str, str]) -> dict[str | None, list[float]]:
    """Give the hysteresis of each pair of one person by target; pairs with a bad one left out."""
    import numpy as np

    from selfmotion.methods.curvature import path_hysteresis

    usable = [not (m.failed or m.stands_apart) for m in own]
    both = zip(own, usable, strict=True)
    net = [m.a_net if good and m.a_net is not None else np.nan for m, good in both]
    labels = [(m.target, m.condition) for m in own]
    found = path_hysteresis(net, labels, [m.trial for m in own], directions=ways)
    known = {target: pairs[np.isfinite(pairs)].tolist() for target, pairs in found.items()}
    return {target: pairs for target, pairs in known.items() if pairs}


def loops(movements: list[CurvedMovement], ways: tuple[str, str]) -> list[Loop]:
    """Give the hysteresis of every pair out and back."""
    return [
        Loop(subject=own[0].subject, side=own[0].side, target=target, hysteresis=value)
        for own in people(movements)
        for target, values in pairs_of(own, ways).items()
        for value in values
    ]


def direction_tests(
    movements: list[CurvedMovement], ways: tuple[str, str] = ("outbound", "inbound")
) -> list[DirectionTest]:
    """Test A_net, A_sum and hysteresis, each corrected over the directions of a person."""
    from selfmotion.methods.curvature import VACUOUS

    out = []
    for own in people(movements):
        usable = [m for m in own if not (m.failed or m.stands_apart)]
        for measure, note in (("a_net", ""), ("a_sum", VACUOUS)):
            groups: dict[tuple[str | None, str | None], list[float]] = {}
            for m in usable:
                groups.setdefault((m.condition, m.target), []).append(getattr(m, measure))
            out += _tests((own[0], measure, note), groups)
        out += _tests(
            (own[0], "hysteresis", ""),
            {(None, target): values for target, values in pairs_of(own, ways).items()},
        )
    return out


def _tests(
    what: tuple[CurvedMovement, str, str],
    groups: dict[tuple[str | None, str | None], list[float]],
) -> list[DirectionTest]:
    """Test the groups (condition, target) of one person and measure together."""
    from selfmotion.methods.curvature import mean_tests

    person, measure, note = what
    found = mean_tests(list(groups.values()), [str(way) for way in groups], note=note)
    columns = ("mean", "sd", "t", "p", "p_corrected")
    values = {name: numbers(getattr(found, name)) for name in columns}
    return [
        DirectionTest(
            subject=person.subject,
            side=person.side,
            condition=condition,
            target=target,
            measure=measure,
            n=int(found.n[i]),
            **{name: column[i] for name, column in values.items()},
            differs=bool(found.differs[i]),
            note=note,
        )
        for i, (condition, target) in enumerate(groups)
    ]
