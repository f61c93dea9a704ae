"""The two numerical examples of [Khoramshahi2022] section 4.1 (Figs 1 to 3), and noise.

DOI 10.1371/journal.pone.0278228. The samples come from `synthetic_samples`, which says how the
paper's recipe is read; here Algorithm 1 runs on them. The error against the level of null-space
noise, which the paper mentions, is shown for each estimator and for both readings of the noise.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from selfmotion.methods.identification import (
    DEFAULT_OPTIONS,
    IdentificationOptions,
    Method,
    identify_weights,
)
from selfmotion.motion.recording import Recording
from selfmotion.studies.results import Convergence, NoiseSweep, Sweep
from selfmotion.studies.synthetic_samples import (
    EXAMPLE_1_WEIGHTS,
    EXAMPLE_2_WEIGHTS,
    random_samples,
    two_joint_run,
)

EXAMPLE_1_GAMMA, EXAMPLE_1_SIGMA = 0.6, 0.2
FIG_2_GAMMAS = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0)
FIG_3_GAMMAS = (0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 0.9)
SCHEDULE_START = 0.6
# So many iterations that γ = 0.9 has settled, several times over.
FIG_1_ITERATIONS, FIG_2_ITERATIONS, FIG_3_ITERATIONS = 60, 300, 400
# Algorithm 1 at γ = 0.6 is within 0.01 of its end after some 30 iterations.
SETTLED_ITERATIONS = 150
# Run all iterations asked for: figures compare runs of one length.
NEVER_STOP = 1e-300


def example_1(*, rng: np.random.Generator, repeats: int = 100) -> Convergence:
    """Run Algorithm 1 on random chains (Fig 1): five joints, three task rows, 500 samples.

    Args:
        rng: source of randomness.
        repeats: how often data are drawn anew; the paper's 100.

    Returns:
        The weights at each iteration; `final_error` stands beside the paper's 0.07.
    """
    runs = [
        paper_history(
            random_samples(rng=rng, sigma=EXAMPLE_1_SIGMA), EXAMPLE_1_GAMMA, FIG_1_ITERATIONS
        )
        for _ in range(repeats)
    ]
    label = f"γ = {EXAMPLE_1_GAMMA:g}, σ = {EXAMPLE_1_SIGMA:g}"
    return Convergence(label, np.array(runs), np.array(EXAMPLE_1_WEIGHTS))


def gamma_sweep(
    *,
    rng: np.random.Generator,
    repeats: int = 5,
    gammas: Sequence[float] = FIG_2_GAMMAS,
    iterations: int = FIG_2_ITERATIONS,
) -> Sweep:
    """Run Algorithm 1 with different γ on the same random data (Fig 2)."""
    data = [random_samples(rng=rng, sigma=EXAMPLE_1_SIGMA) for _ in range(repeats)]
    runs = []
    for gamma in gammas:
        histories = [paper_history(one, gamma, iterations) for one in data]
        truth = np.array(EXAMPLE_1_WEIGHTS)
        runs.append(Convergence(f"γ = {gamma:g}", np.array(histories), truth))
    return Sweep(tuple(gammas), tuple(runs))


def example_2(
    *, gammas: Sequence[float] = FIG_3_GAMMAS, iterations: int = FIG_3_ITERATIONS
) -> Sweep:
    """Run Algorithm 1 with different γ on two joints with a busy null space (Fig 3).

    The last run has the paper's schedule, γ ← γ + 0.6(1 - γ) from 0.6 on.
    """
    recording, truth = two_joint_run(), np.array(EXAMPLE_2_WEIGHTS)
    runs = [
        Convergence(f"γ = {gamma:g}", paper_history(recording, gamma, iterations)[None], truth)
        for gamma in gammas
    ]
    scheduled = identify_weights(
        recording,
        method="paper",
        null_ratio=SCHEDULE_START,
        null_schedule="printed",
        options=_options(iterations),
    )
    history = _padded(scheduled.history, iterations)
    runs.append(Convergence("γ rises from 0.6", history[None], truth))
    return Sweep((*gammas, float("nan")), tuple(runs))


def noise_sweep(
    *,
    rng: np.random.Generator,
    sigmas: Sequence[float] = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5),
    repeats: int = 10,
    n_samples: int = 500,
    methods: Sequence[Method] = ("ml", "paper"),
) -> NoiseSweep:
    """Measure each estimator's error against the null-space noise, projected and not.

    With noise that is projected (eq. 15 holds) maximum likelihood is consistent and Algorithm 1
    is not; with noise that is not, as in the paper's example, neither is.
    """
    rows = []
    for projected in (True, False):
        for sigma in sigmas:
            data = [
                random_samples(rng=rng, sigma=sigma, projected=projected, n_samples=n_samples)
                for _ in range(repeats)
            ]
            for method in methods:
                errors = [_error(one, method) for one in data]
                rows.append(
                    {
                        "sigma": float(sigma),
                        "noise": "projected" if projected else "not projected",
                        "method": method,
                        "error": float(np.mean(errors)),
                        "sd": float(np.std(errors)),
                    }
                )
    return NoiseSweep(pd.DataFrame(rows))


def paper_history(recording: Recording, gamma: float, iterations: int) -> np.ndarray:
    """Give the weights of Algorithm 1 after each iteration (iterations + 1, n)."""
    estimate = identify_weights(
        recording, method="paper", null_ratio=gamma, options=_options(iterations)
    )
    return _padded(estimate.history, iterations)


def _options(iterations: int) -> IdentificationOptions:
    return replace(
        DEFAULT_OPTIONS, max_iterations=iterations, tolerance=NEVER_STOP, hash_inputs=False
    )


def _padded(history: np.ndarray, iterations: int) -> np.ndarray:
    """Keep the last weights of a run that stopped early."""
    missing = iterations + 1 - len(history)
    return np.concatenate([history, np.repeat(history[-1:], missing, axis=0)])


def _error(recording: Recording, method: Method) -> float:
    options = replace(
        DEFAULT_OPTIONS,
        hash_inputs=False,
        max_iterations=SETTLED_ITERATIONS if method == "paper" else None,
    )
    found = identify_weights(
        recording, method=method, null_ratio=EXAMPLE_1_GAMMA, options=options
    ).full_weights
    return float(np.linalg.norm(found - np.array(EXAMPLE_1_WEIGHTS)))
