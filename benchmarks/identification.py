"""Identification of IK weights against a plain NumPy version of the published algorithm.

Run `python benchmarks/identification.py` (about three minutes; `--quick` leaves out K = 10⁶). Each
size runs in a process of its own, so that peak memory is that of one method. Both methods of a size
see the same inputs, on one thread; times are of the processor, and their ratio is what counts on a
busy machine.

    NumPy   Algorithm 1 (γ = 0.6) as published, samples in chunks of 20,000, diagonal QP by clipping
    paper   the library's Algorithm 1, same γ, same iterates (at K = 10⁶ 20 iterations only)
    ml      the library's default estimator (with standard errors and without a first guess)
"""

import argparse
import os
import platform
import resource
import subprocess
import sys
import time

import numpy as np

from rows import Row, add_rows_option, version_of, write_rows

SIZES = (500, 50_000, 1_000_000)
TASKS = ((7, 3), (7, 6))
CHUNK = 20_000
RATIO = 0.6
ONE_THREAD = os.environ | {"NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
CLOSE = 1e-4
TIME_LIMIT = 60.0
TRUE = np.array([1.0, 0.8, 0.6, 0.4, 0.2, 0.5, 0.1])


def make(K, n, m):
    """Noise-free motion with known weights: q̇ = J#J q₀."""
    rng = np.random.default_rng(0)
    J, qd = rng.standard_normal((K, m, n)), np.empty((K, n))
    for at in range(0, K, CHUNK):
        some = slice(at, at + CHUNK)
        right = np.swapaxes(J[some], 1, 2) / TRUE[:n, None]
        xd = J[some] @ rng.standard_normal((len(J[some]), n, 1))
        qd[some] = (right @ np.linalg.solve(J[some] @ right, xd))[..., 0]
    return qd, J


def numpy_iteration(qd, J, w, moment):
    """One iteration of Algorithm 1 in NumPy: lines 3 to 21."""
    cross = np.zeros_like(moment)
    for at in range(0, len(qd), CHUNK):
        v, Jc = qd[at : at + CHUNK, :, None], J[at : at + CHUNK]
        right = np.swapaxes(Jc, 1, 2) / w[:, None]
        null = v - right @ np.linalg.solve(Jc @ right, Jc @ v)
        cross += null[..., 0].T @ v[..., 0]
    psi, omega = moment - RATIO * cross, w[:, None] * (moment - cross)
    w = np.clip((psi * omega).sum(axis=1) / (psi**2).sum(axis=1), 1e-9, 1.0)
    return w / w.max()


def numpy_until_close(qd, J, limit):
    """Iterate until the error is below CLOSE, or for `limit` seconds: weights, iterations, time."""
    start, w, moment, iterations = time.process_time(), np.ones(qd.shape[1]), qd.T @ qd, 0
    while np.linalg.norm(w - TRUE[: len(w)]) > CLOSE and time.process_time() - start < limit:
        w = numpy_iteration(qd, J, w, moment)
        iterations += 1
    return w, iterations, time.process_time() - start


def identify(qd, J, method, **options):
    """Call the library from W = I."""
    from selfmotion.methods.identification import (
        IdentificationOptions,
        MotionArrays,
        identify_weights_from_arrays,
    )

    trial = np.arange(len(qd)) * 50 // len(qd)
    return identify_weights_from_arrays(
        MotionArrays(qd, J, trial=trial),
        method=method,
        null_ratio=RATIO,
        options=IdentificationOptions(start="ones", **options),
    )


def timed(run, repeats):
    """Best time of several runs, and the last result."""
    best, results = float("inf"), []
    for _ in range(repeats):
        start = time.process_time()
        results.append(run())
        best = min(best, time.process_time() - start)
    return best, results[-1]


def peak_mb():
    """Peak resident memory of this process so far, MB."""
    scale = 1024**2 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / scale


def one_size(method, K, n, m):
    """Time one method at one size; prints one line of results."""
    qd, J = make(K, n, m)
    inputs = peak_mb()
    repeats = 3 if K < 1_000_000 else 1
    if method == "numpy":
        moment = qd.T @ qd
        each, _ = timed(lambda: numpy_iteration(qd, J, np.ones(n), moment), repeats)
        w, iterations, total = numpy_until_close(qd, J, TIME_LIMIT)
    else:
        identify(qd[:400], J[:400], method)  # compile
        few, _ = timed(lambda: identify(qd, J, method, max_iterations=1), repeats)
        cap = 20 if method == "paper" and K >= 1_000_000 else None  # minutes otherwise
        total, found = timed(
            lambda: identify(qd, J, method, tolerance=1e-5, max_iterations=cap), repeats
        )
        w, iterations = found.weights, found.iterations
        each = max(total - few, 0.0) / max(iterations - 1, 1)
    error = np.linalg.norm(w - TRUE[:n])
    print(method, K, n, m, each, iterations, total, error, inputs, peak_mb(), sep="\t")


def hardware():
    """Name processor, cores and versions."""
    import numba
    import scipy

    import selfmotion

    name = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        with open("/proc/cpuinfo", encoding="utf-8") as stream:
            names = [line.split(":")[1].strip() for line in stream if "model name" in line]
        name = names[0] if names else name
    print(f"{name}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; Python ", end="")
    print(
        f"{platform.python_version()}, NumPy {np.__version__}, SciPy {scipy.__version__}, ", end=""
    )
    print(f"numba {numba.__version__}, selfmotion {selfmotion.__version__}")


def rows_of(case, totals, note):
    """Give the two ratios of one size: until close to the truth, and of one iteration."""
    title, peer = "Identification of weights", "Algorithm 1 in NumPy"
    numpy, paper, ml = (totals[name] for name in ("numpy", "paper", "ml"))
    found = f"{note or 'to 1e-4'}; error of theirs {numpy[1]:.0e}, of ours {ml[1]:.0e}"
    return [
        Row(title, f"{case}: fit", peer, version_of("numpy"), ml[0], numpy[0], "s", found),
        Row(
            title,
            f"{case}: an iteration",
            peer,
            version_of("numpy"),
            paper[2],
            numpy[2],
            "s",
            "same iterates",
        ),
    ]


def main():
    """Run all sizes in fresh processes and print the table with ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--one", nargs=4, metavar=("METHOD", "K", "N", "M"))
    add_rows_option(parser)
    asked = parser.parse_args()
    compared: list[Row] = []
    if asked.one:
        one_size(asked.one[0], *(int(word) for word in asked.one[1:]))
        return
    hardware()
    print(f"{'K':>9} (n, m)  method  s/iteration  iterations  s to fit    error  MB data  MB peak")
    for K in SIZES[: 2 if asked.quick else 3]:
        for n, m in TASKS:
            totals = {}
            for method in ("numpy", "paper", "ml"):
                command = [sys.executable, __file__, "--one", method, str(K), str(n), str(m)]
                line = subprocess.run(
                    command, check=True, capture_output=True, text=True, env=ONE_THREAD
                ).stdout
                each, iterations, total, error, data, peak = map(float, line.split("\t")[4:])
                totals[method] = total, error, each
                print(
                    f"{K:>9} ({n}, {m})  {method:<6}  {each:11.5f}  {iterations:10.0f}  "
                    f"{total:8.3f}  {error:7.1e}  {data:7.0f}  {peak:7.0f}",
                    flush=True,
                )
            note = (
                ""
                if totals["numpy"][1] <= CLOSE
                else f" at least (NumPy stopped at {TIME_LIMIT:g} s)"
            )
            compared += rows_of(f"K = {K:,}, n = {n}, m = {m}", totals, note.strip())
            print(
                f"{'':>9} NumPy/ml to 1e-4: {totals['numpy'][0] / totals['ml'][0]:.1f}x{note}; "
                f"NumPy/paper per iteration: {totals['numpy'][2] / totals['paper'][2]:.1f}x"
            )
    write_rows(asked.rows, compared)


if __name__ == "__main__":
    main()
