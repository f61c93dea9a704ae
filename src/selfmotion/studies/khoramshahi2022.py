"""Every number of [Khoramshahi2022] beside ours.

DOI 10.1371/journal.pone.0278228. The numerical examples are recomputed; the two experiments run on
generated people, because the published recordings are not at hand, or on those recordings where
a file of them is given. Each number says which it is: the same computation, or the same kind.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from selfmotion.errors import RangeError
from selfmotion.motion.files.mat import PublishedDataset
from selfmotion.motion.labels import Labels
from selfmotion.provenance import Provenance
from selfmotion.redundancy.projection import project
from selfmotion.studies.numerical_examples import (
    EXAMPLE_1_GAMMA,
    FIG_2_ITERATIONS,
    FIG_3_ITERATIONS,
    example_1,
    example_2,
    gamma_sweep,
    noise_sweep,
)
from selfmotion.studies.published import (
    KHORAMSHAHI2022,
    KIND,
    SAME,
    SAME_DATA,
    TREND,
    Ours,
    as_text,
    beside,
)
from selfmotion.studies.reaching_study import (
    ReachingResult,
    analyse_reaching,
    experiment_1,
    null_rms,
)
from selfmotion.studies.results import Convergence, NoiseSweep, Sweep
from selfmotion.studies.screen_study import ScreenResult, analyse_screen, experiment_2
from selfmotion.studies.simulated_people import ReachingProtocol
from selfmotion.studies.simulated_screen import ScreenProtocol
from selfmotion.studies.velocity_profiles import IDENTIFIED, IDENTITY
from selfmotion.studies.weight_tables import LONG_RUN, SHORT_RUN

LAYOUTS = ("experiment 1", "experiment 2")
# Iterations count as settled when the weights stay within this of their last value.
SETTLED = 0.01
# A run has a limit cycle if its last weights still swing by more than this.
CYCLE, LAST = 0.01, 50


@dataclass(frozen=True)
class Size:
    """How much is computed.

    Attributes:
        repeats: data sets drawn for Fig 1; the paper's 100.
        sweep_repeats: data sets drawn for Fig 2 and for each level of noise.
        iterations: of Algorithm 1 in Figs 2 and 3.
        generated_iterations: of Algorithm 1 on generated people, for whom it is stopped early.
        recorded_iterations: of Algorithm 1 on recorded people, at most.
        reaching: people and trials of experiment 1.
        screen: people and targets of experiment 2.
    """

    repeats: int = 100
    sweep_repeats: int = 5
    iterations: tuple[int, int] = (FIG_2_ITERATIONS, FIG_3_ITERATIONS)
    generated_iterations: int = SHORT_RUN
    recorded_iterations: int = LONG_RUN
    reaching: ReachingProtocol = ReachingProtocol()
    screen: ScreenProtocol = ScreenProtocol()


@dataclass(frozen=True, eq=False)
class Reproduction:
    """The paper, computed again.

    Attributes:
        table: each published number beside ours (`published.beside`).
        fig1: convergence of example 1.
        fig2: the same with different γ.
        fig3: example 2 with different γ.
        noise: error against null-space noise.
        reaching: experiment 1, generated or recorded.
        screen: experiment 2, generated or recorded.
        authors: our weights beside the authors', for recorded people; None otherwise.
        provenance: where it comes from.
    """

    table: pd.DataFrame
    fig1: Convergence
    fig2: Sweep
    fig3: Sweep
    noise: NoiseSweep
    reaching: ReachingResult
    screen: ScreenResult
    authors: pd.DataFrame | None
    provenance: Provenance


def reproduce(
    *,
    seed: int = 2022,
    size: Size | None = None,
    data: PublishedDataset | None = None,
) -> Reproduction:
    """Compute the paper again, and put each published number beside ours.

    Args:
        seed: of everything random; each part has a stream of its own.
        size: how much is computed; left out: as much as the paper.
        data: a published data set; its experiment then runs on it, the other on generated people.

    Raises:
        RangeError: the data are not of one of the two published layouts.
    """
    if data is not None and data.layout not in LAYOUTS:
        raise RangeError(f"data: layout {data.layout!r}; allowed is {' or '.join(LAYOUTS)}")
    s = size or Size()
    streams = np.random.default_rng(seed).spawn(5)
    fig1 = example_1(rng=streams[0], repeats=s.repeats)
    fig2 = gamma_sweep(rng=streams[1], repeats=s.sweep_repeats, iterations=s.iterations[0])
    fig3 = example_2(iterations=s.iterations[1])
    noise = noise_sweep(rng=streams[2], repeats=s.sweep_repeats)
    layout = data.layout if data is not None else "generated people"
    if data is not None and layout == "experiment 1":
        reaching = analyse_reaching(
            data.study, rng=streams[3], paper_iterations=s.recorded_iterations
        )
    else:
        reaching = experiment_1(
            rng=streams[3], protocol=s.reaching, paper_iterations=s.generated_iterations
        )
    if data is not None and layout == "experiment 2":
        screen = analyse_screen(data.study, paper_iterations=s.recorded_iterations)
    else:
        screen = experiment_2(
            rng=streams[4], protocol=s.screen, paper_iterations=s.generated_iterations
        )
    ours = (
        *_splits(),
        *_examples(fig1, fig2, fig3),
        _noise(noise),
        *_experiment_1(reaching),
        *_experiment_2(screen),
    )
    authors = None
    if data is not None and data.authors_weights:
        measured = reaching if layout == "experiment 1" else screen
        authors = against_authors(measured.weights, data.authors_weights)
    choices = {"repeats": s.repeats, "data": layout}
    return Reproduction(
        table=beside(KHORAMSHAHI2022, ours),
        fig1=fig1,
        fig2=fig2,
        fig3=fig3,
        noise=noise,
        reaching=reaching,
        screen=screen,
        authors=authors,
        provenance=Provenance("reproduce khoramshahi2022", seed=seed, choices=choices),
    )


def _splits() -> list[Ours]:
    """Split the velocity of eqs 13 and 14: two prismatic joints, of which the second moves."""
    J, qd = np.ones((1, 1, 2)), np.array([0.0, 1.0])
    rows = []
    for key, weights in (("split_equal", [1.0, 1.0]), ("split_weighted", [1.0, 1.0 / 9.0])):
        split = project(J, weights)
        task = qd - split.null[0] @ qd
        null = as_text(tuple((qd - task).tolist()))
        rows.append(Ours(key, tuple(task.tolist()), SAME, f"null-space part: {null}"))
    return rows


def _noise(sweep: NoiseSweep) -> Ours:
    """Say whether the error of Algorithm 1 grows with the noise, as the text has it."""
    table = sweep.table.loc[sweep.table["method"] == "paper"]
    free = table.loc[table["noise"] != "projected"].sort_values("sigma")
    errors = free["error"].to_numpy(dtype=float)
    pairs = zip(free["sigma"].tolist(), errors.tolist(), strict=True)
    found = ", ".join(f"{error:.2g} (σ = {sigma:g})" for sigma, error in pairs)
    return Ours("noise", (bool((np.diff(errors) > 0).all()),), TREND, f"error: {found}")


def _examples(fig1: Convergence, fig2: Sweep, fig3: Sweep) -> list[Ours]:
    settled = {
        g: float(r.iterations_to(SETTLED).mean())
        for g, r in zip(fig2.gammas, fig2.runs, strict=True)
        if g < 1.0
    }
    never = fig2.run(1.0).weights
    fastest = min(settled, key=lambda gamma: settled[gamma])
    counts = ", ".join(f"{n:.0f} (γ = {g:g})" for g, n in settled.items())
    still = {
        g: float(np.ptp(r.weights[0, -LAST:], axis=0).max()) <= CYCLE and r.weights[0, -1, 0] > 0.5
        for g, r in zip(fig3.gammas, fig3.runs, strict=True)
        if g == g
    }
    threshold = min((g for g, settled_there in still.items() if settled_there), default=np.nan)
    zero, high = (tuple(fig3.run(g).weights[0, -1].tolist()) for g in (0.0, 0.9))
    return [
        Ours(
            "example_1_error",
            (fig1.final_error,),
            SAME,
            f"mean of {len(fig1.weights)} random data sets, γ = {EXAMPLE_1_GAMMA:g}; null-space "
            "velocity read as not projected, which alone gives the printed number",
        ),
        Ours(
            "gamma_monotone",
            (fastest == 0.0, bool(np.ptp(never, axis=1).max() == 0.0)),
            TREND,
            f"iterations to within {SETTLED:g} of the end: {counts}",
        ),
        Ours(
            "example_2_zero",
            zero,
            TREND,
            "null-space motion read as 0.1 per sample, the only reading with this result",
        ),
        Ours("example_2_high", high, TREND, f"after {len(fig3.runs[0].weights[0]) - 1} steps"),
        Ours(
            "example_2_threshold",
            (float(threshold),),
            TREND,
            f"least γ of those tried that ends without a cycle wider than {CYCLE:g}",
        ),
    ]


def _experiment_1(result: ReachingResult) -> list[Ours]:
    kind = KIND if result.generated else SAME_DATA
    first, second = result.conditions
    drawn = "people drawn around the published values; " if result.generated else ""
    rows = []
    for key, condition in (("beta_natural", first), ("beta_viscous", second)):
        other = as_text(tuple(result.beta["paper"][condition]))
        note = f"{drawn}maximum likelihood, mean of people; Algorithm 1 as run: {other}"
        rows.append(Ours(key, tuple(result.beta["ml"][condition].tolist()), kind, note))
    if result.test is None:
        note = "too few people whose weights are identified in both conditions"
        unknown = (float("nan"),)
        keys = ("hotelling_t2", "hotelling_f", "hotelling_p")
        rows += [Ours(key, unknown, kind, note) for key in keys]
    else:
        t = result.test
        note = f"{drawn}on log-ratios of maximum likelihood, {t.n_people} people"
        rows += [
            Ours("hotelling_t2", (t.t2,), kind, note),
            Ours("hotelling_f", (t.f,), kind, f"F ({t.df[0]}, {t.df[1]})"),
            Ours("hotelling_p", (t.p_value,), kind, f"by sign flips: {t.p_permutation:.2g}"),
        ]
    rms = null_rms(result.null)
    own = [rms[c, IDENTIFIED] for c in (first, second)]
    plain = [rms[c, IDENTITY] for c in (first, second)]
    note = (
        f"rms null-space speed (rad/s), {first} and {second}: identified "
        f"{own[0]:.3f}, {own[1]:.3f}; W = I {plain[0]:.3f}, {plain[1]:.3f}"
    )
    smaller = tuple(bool(a < b) for a, b in zip(own, plain, strict=True))
    reversal = (bool(own[1] > own[0]), bool(plain[0] > plain[1]))
    return [
        *rows,
        Ours("null_smaller", smaller, kind, note),
        Ours("null_reversal", reversal, kind, "the same four numbers"),
    ]


def _experiment_2(result: ScreenResult) -> list[Ours]:
    kind = KIND if result.generated else SAME_DATA
    person = "a simulated person of our own design; " if result.generated else ""
    notes = {
        "Locked": "; the elbow never moves, so hip and shoulder have no redundancy to share and "
        "no data can tell their weights (maximum likelihood: not identified)",
        "Coupled": "; weights run to their bound (maximum likelihood: not identified)",
    }
    rows = []
    for condition in result.conditions:
        name = "Coupled" if condition.lower() == "synergy" else condition.capitalize()
        beta = result.beta["paper"][condition]
        note = f"{person}Algorithm 1, mean of people{notes.get(name, '')}"
        rows.append(Ours(f"table1_{name.lower()}", tuple(beta.tolist()), kind, note))
    return rows


def against_authors(table: pd.DataFrame, authors: Mapping[Labels, np.ndarray]) -> pd.DataFrame:
    """Put our weights beside the authors', person by person.

    Returns:
        Columns subject, condition, joint, authors, algorithm_1, maximum_likelihood; entries for
        single trials are left out.
    """
    rows = []
    for labels, values in authors.items():
        if labels.trial is not None or labels.condition is None:
            continue
        here = (table["subject"] == labels.subject) & (table["condition"] == labels.condition)
        part = table.loc[here]
        for joint, value in zip(dict.fromkeys(part["joint"]), values, strict=False):
            one = part.loc[part["joint"] == joint]
            rows.append(
                {
                    "subject": labels.subject,
                    "condition": labels.condition,
                    "joint": joint,
                    "authors": float(value),
                    "algorithm_1": _weight(one, "paper"),
                    "maximum_likelihood": _weight(one, "ml"),
                }
            )
    return pd.DataFrame(rows)


def _weight(rows: pd.DataFrame, method: str) -> float:
    found: Sequence[float] = rows.loc[rows["method"] == method, "full_weight"].tolist()
    return float(found[0]) if len(found) else float("nan")
