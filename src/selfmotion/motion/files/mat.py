"""The data sets of [Khoramshahi2022] (10.1371/journal.pone.0278228), and flat .mat files.

Experiment 1 (S1 Dataset): a cell for each participant, condition, target and trial below, each
trial with joint positions, velocities, task velocities and Jacobians. Experiment 2 (S2 Dataset): a
cell for each participant, four conditions, one trial each with time, joint angles, the virtual
elbow and the hand of a planar chain; velocities come from differentiation, Jacobians from the chain
that is fitted to the positions. Names of fields are not documented: they are matched by pattern
and shape, `matched` says how, and what is ambiguous is refused. The files themselves were not at
hand; the layouts are tested on generated files. Deviation: the first two angles of experiment 2
are taken for those of the virtual chain, as its section 4.3 says they are mapped directly.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from selfmotion.errors import FileFormatError
from selfmotion.motion.files.arrays_to_study import (
    naming,
    require_consistent,
    require_whole_gaps,
    study_from_arrays,
)
from selfmotion.motion.files.mat_fields import Motion, parts, planar, with_jacobian
from selfmotion.motion.files.mat_levels import ENTRIES, Node, labels_of, own_name, walk
from selfmotion.motion.files.matlab import Tree, read_matlab
from selfmotion.motion.filters import with_velocities
from selfmotion.motion.labels import LABEL_NAMES, Labels
from selfmotion.motion.planar_fit import PlanarChainFit, find_convention, fit_planar_chain
from selfmotion.motion.recording import FIELDS, Recording, Study, sample_numbers

# Section "S1 Dataset": 100 time steps with dt = 0.009 s.
DOCUMENTED_STEP = 0.009
# Section 4.2, q1 to q4, and section 4.3.
JOINTS_1 = ("shoulder_elevation", "shoulder_rotation", "shoulder_flexion", "elbow_flexion")
JOINTS_2 = ("hip", "shoulder", "elbow")


@dataclass(frozen=True, eq=False)
class PublishedDataset:
    """Recordings from a .mat file with what the authors computed from them, to compare with.

    Attributes:
        study: the recordings.
        layout: ``"experiment 1"``, ``"experiment 2"`` or ``"flat"``.
        matched: what was concluded about names, shapes and levels, one sentence each.
        authors_weights: the authors' IK weights (n,) by the labels under which they stand.
        ik_data: the authors' concatenated data, by labels; untimed recordings.
        chains: the planar chain fitted for each subject (experiment 2).
        targets: displayed target positions by labels, as in the file (experiment 2).
        human_elbow: the person's own elbow angle (K,), rad, by labels (experiment 2).
    """

    study: Study
    layout: str
    matched: tuple[str, ...]
    authors_weights: Mapping[Labels, np.ndarray] = field(default_factory=dict)
    ik_data: Mapping[Labels, Recording] = field(default_factory=dict)
    chains: Mapping[str, PlanarChainFit] = field(default_factory=dict)
    targets: Mapping[Labels, np.ndarray] = field(default_factory=dict)
    human_elbow: Mapping[Labels, np.ndarray] = field(default_factory=dict)


def read_mat(path: str | Path, *, cutoff: float | None = None) -> PublishedDataset:
    """Read a .mat file (v5 to v7.3): either published layout, or flat as the .npz.

    Args:
        path: the file.
        cutoff: low-pass (Hz) before experiment 2 is differentiated; None: none.

    Raises:
        SelfmotionError: one line that names file, place, value and what is allowed.

    Example:
        >>> import tempfile
        >>> from scipy.io import savemat
        >>> where = Path(tempfile.mkdtemp(), "reach.mat")
        >>> savemat(where, {"qd": np.ones((6, 3)), "jacobian": np.ones((6, 2, 3))})
        >>> read_mat(where).layout, read_mat(where).study.n_samples
        ('flat', 6)
    """
    source = str(path)
    variables = read_matlab(path)
    with naming(source):
        people = _people(variables)
    if people is None:
        return _flat(source, variables)
    with naming(source):
        nodes = [(name, node) for name, tree in people.items() for node in walk(tree)]
        motions = [(s, n) for s, n in nodes if n.kind == "motion"]
        if not motions:
            raise FileFormatError(
                "no movement found: fields for joint velocities and a Jacobian, or joint angles "
                f"and the hand's position, are needed (variables: {', '.join(variables)})"
            )
        with_jac = ["jacobian" in parts(n.value) for _, n in motions if isinstance(n.value, dict)]
        if any(with_jac) and not all(with_jac):
            raise FileFormatError("some movements have a Jacobian and others none: refused")
        reader = _experiment_1 if all(with_jac) else _experiment_2
        dataset = reader(source, motions, cutoff)
        return _with_extras(dataset, nodes, source)


def by_target(dataset: PublishedDataset) -> Study:
    """Cut each recording of experiment 2 where the displayed target changes, as views.

    The movements to the targets then serve as trials, over which standard errors are clustered.
    Recordings without a target for each sample stay whole.
    """
    pieces = []
    for recording in dataset.study:
        shown = dataset.targets.get(recording.labels, np.empty((0, 0)))
        shown = shown if len(shown) == recording.n_samples else shown.T
        if len(shown) != recording.n_samples:
            pieces.append(recording)
            continue
        changes = np.flatnonzero((shown[1:] != shown[:-1]).any(axis=1)) + 1
        edges = [0, *changes.tolist(), recording.n_samples]
        for number, (start, stop) in enumerate(zip(edges[:-1], edges[1:], strict=True), start=1):
            labels = replace(recording.labels, target=str(number), trial=str(number))
            pieces.append(replace(recording.window(start, stop), labels=labels))
    return Study(tuple(pieces))


def _people(variables: Mapping[str, Tree]) -> dict[str, Tree] | None:
    """Find the participants; None where the file is flat."""
    lists = {
        name: value
        for name, value in variables.items()
        if isinstance(value, list) and any(isinstance(_unwrapped(v), dict) for v in value)
    }
    structs = {name: value for name, value in variables.items() if isinstance(value, dict)}
    holding = {k for k, v in (lists | structs).items() if any(n.kind == "motion" for n in walk(v))}
    lists = {name: value for name, value in lists.items() if name in holding}
    structs = {name: value for name, value in structs.items() if name in holding}
    if len(lists) + bool(structs) > 1:
        raise FileFormatError(
            f"variables {', '.join((*lists, *structs))} all hold movements: keep one"
        )
    if lists:
        members = [_unwrapped(item) for item in next(iter(lists.values()))]
        names = [own_name(m) or f"P{i + 1:02d}" for i, m in enumerate(members)]
        if len(set(names)) < len(names):
            names = [f"P{i + 1:02d}" for i in range(len(members))]
        return dict(zip(names, members, strict=True))
    if any(ENTRIES["condition"].search(name.lower()) for name in structs):
        return {"P01": dict(structs)}
    if len(structs) == 1:
        inner = next(iter(structs.values()))
        return None if _is_flat(inner) else _people(inner)
    return dict(structs) or None


def _is_flat(struct: Mapping[str, Tree]) -> bool:
    return any(node.path == () and node.kind == "motion" for node in walk(dict(struct)))


def _unwrapped(value: Tree) -> Tree:
    while isinstance(value, list) and len(value) == 1:
        value = value[0]
    return value


def _flat(source: str, variables: Mapping[str, Tree]) -> PublishedDataset:
    """Read arrays that lie at the top, or in one struct, as in the .npz."""
    if not any(isinstance(v, np.ndarray) for v in variables.values()) and len(variables) == 1:
        inner = next(iter(variables.values()))
        variables = inner if isinstance(inner, dict) else variables
    found = {}
    with naming(source):
        found = parts(variables)
        if "jacobian" in found:
            motion = with_jacobian(variables)
        elif "q" in found:
            angles = np.asarray(variables[found["q"]])
            motion = Motion({"q": angles}, (f"q = {found['q']!r}",))
            if "time" in found:
                motion.arrays["time"] = np.ravel(np.asarray(variables[found["time"]]))
        else:
            raise FileFormatError(
                "no field looks like a Jacobian or joint angles (variables: "
                f"{', '.join(variables)})"
            )
    arrays = dict(motion.arrays)
    for label in (*LABEL_NAMES, "joints", "rows"):
        value = variables.get(label)
        if isinstance(value, str | list) or (isinstance(value, np.ndarray) and value.size):
            arrays[label] = np.asarray(value).squeeze()
    require_whole_gaps(source, arrays)
    return PublishedDataset(study_from_arrays(source, arrays), "flat", motion.said)


def _experiment_1(
    source: str, motions: list[tuple[str, Node]], _cutoff: float | None
) -> PublishedDataset:
    recordings, said = [], Counter()
    for subject, node in motions:
        with naming(f"{subject}/{'/'.join(node.path)}"):
            motion = with_jacobian(_struct(node.value))
            recordings.append(_recording(motion, labels_of(node.path, subject), source))
            require_consistent(recordings[-1])
            timed = {"time", "dt"} & motion.arrays.keys()
            step = f"time step {DOCUMENTED_STEP} s, as documented; not in the file"
            said.update(motion.said + (() if timed else (step,)))
    study = Study(tuple(recordings))
    _refuse_twice(study)
    if study[0].n_joints == len(JOINTS_1):
        said["joints named in the order of section 4.2"] += len(study)
    return PublishedDataset(study, "experiment 1", _sentences(said, study))


def _experiment_2(
    source: str, motions: list[tuple[str, Node]], cutoff: float | None
) -> PublishedDataset:
    people: dict[str, list[tuple[Labels, Motion]]] = {}
    said: Counter[str] = Counter()
    for subject, node in motions:
        with naming(f"{subject}/{'/'.join(node.path)}"):
            motion = planar(_struct(node.value))
            people.setdefault(subject, []).append((labels_of(node.path, subject), motion))
            said.update(motion.said)
    pooled = {subject: _pooled([m for _, m in pairs]) for subject, pairs in people.items()}
    convention = find_convention(list(pooled.values()))
    chains, recordings = {}, []
    for subject, pairs in people.items():
        chain = fit_planar_chain(*pooled[subject], convention)
        if chain is None:
            raise FileFormatError(f"{subject}: a joint hardly moves; no link lengths can be told")
        chains[subject] = chain
        for labels, motion in pairs:
            with naming(str(labels)):
                posture: dict[str, Any] = {k: motion.arrays[k] for k in ("q", "x", "time")}
                moving = with_velocities(
                    Recording(**posture, joints=JOINTS_2, labels=labels, source=source),
                    cutoff=cutoff,
                )
                recordings.append(replace(moving, jacobian=chain.jacobian(moving.array("q"))))
    study = Study(tuple(recordings))
    _refuse_twice(study)
    pairs = [pair for group in people.values() for pair in group]
    return PublishedDataset(
        study,
        "experiment 2",
        (*_sentences(said, study), *_chain_sentences(chains)),
        chains=chains,
        targets={lab: m.arrays["target"] for lab, m in pairs if "target" in m.arrays},
        human_elbow={lab: m.arrays["human_elbow"] for lab, m in pairs if "human_elbow" in m.arrays},
    )


def _pooled(motions: list[Motion]) -> tuple[np.ndarray, np.ndarray]:
    """Put all whole samples of a person together."""
    q = np.concatenate([m.arrays["q"] for m in motions])
    x = np.concatenate([m.arrays["x"] for m in motions])
    whole = ~(np.isnan(q).any(axis=1) | np.isnan(x).any(axis=1))
    return q[whole], x[whole]


def _chain_sentences(chains: Mapping[str, PlanarChainFit]) -> tuple[str, ...]:
    convention = next(iter(chains.values())).convention
    worst = max(chain.residual for chain in chains.values())
    lengths = np.array([chain.lengths for chain in chains.values()])
    low, high = lengths.min(axis=0), lengths.max(axis=0)
    ranges = ", ".join(f"{a:.4g} to {b:.4g}" for a, b in zip(low, high, strict=True))
    return (
        f"planar chain with {convention}; it misses the positions by at most {100 * worst:.2g} % "
        "of their spread",
        f"link lengths {ranges} (unit of the positions)",
        "velocities by differentiation, Jacobians from the fitted chain",
    )


def _recording(motion: Motion, labels: Labels, source: str) -> Recording:
    arrays = motion.arrays
    held: dict[str, Any] = {name: arrays[name] for name in FIELDS if name in arrays}
    samples = len(arrays["jacobian"])
    step = float(arrays["dt"][0]) if "dt" in arrays else DOCUMENTED_STEP
    time = arrays.get("time", sample_numbers(samples) * step)
    joints = JOINTS_1 if arrays["jacobian"].shape[2] == len(JOINTS_1) else ()
    require_whole_gaps("trial", held)
    return Recording(time, **held, joints=joints, labels=labels, source=source)


def _struct(value: Tree) -> dict[str, Tree]:
    if not isinstance(value, dict):
        raise FileFormatError("a struct is needed")
    return value


def _refuse_twice(study: Study) -> None:
    twice = [labels for labels, n in Counter(r.labels for r in study).items() if n > 1]
    if twice:
        raise FileFormatError(f"two movements both are {twice[0]}: the levels are ambiguous")


def _sentences(said: Counter[str], study: Study) -> tuple[str, ...]:
    counts = ", ".join(
        f"{len(study.values(label))} {label}s" for label in LABEL_NAMES if any(study.values(label))
    )
    found = (f"{text} ({n} of {len(study)} movements)" for text, n in said.items())
    return (f"{len(study)} movements: {counts}", *found)


def _with_extras(
    dataset: PublishedDataset, nodes: Iterable[tuple[str, Node]], source: str
) -> PublishedDataset:
    """Add the authors' weights and IK_data; what cannot be understood is said, not refused."""
    weights: dict[Labels, np.ndarray] = {}
    ik_data: dict[Labels, Recording] = {}
    aside: Counter[str] = Counter()
    n_joints = dataset.study[0].n_joints
    for subject, node in nodes:
        name = node.path[-1] if node.path else ""
        try:
            if node.kind == "ik_data":
                motion = with_jacobian(_struct(_unwrapped(node.value)))
                untimed: dict[str, Any] = {
                    k: motion.arrays[k] for k in FIELDS if k in motion.arrays
                }
                ik_data[labels_of(node.path, subject)] = Recording(
                    sample_numbers(len(motion.arrays["jacobian"])),
                    **untimed,
                    labels=labels_of(node.path, subject),
                    source=f"{source} (IK_data)",
                    timed=False,
                )
            elif node.kind == "weights":
                weights |= _weights(node, subject, n_joints, dataset.study)
        except (ValueError, TypeError, KeyError):
            aside[f"{name!r} left aside: its layout is not understood"] += 1
    words = [f"authors' weights found for {len(weights)} entries"] if weights else []
    words += [f"IK_data found for {len(ik_data)} entries"] if ik_data else []
    words += [f"{text} ({n} times)" for text, n in aside.items()]
    matched = (*dataset.matched, *words)
    return replace(dataset, matched=matched, authors_weights=weights, ik_data=ik_data)


def _weights(node: Node, subject: str, n_joints: int, study: Study) -> dict[Labels, np.ndarray]:
    """Read weights (n,) under their labels; (conditions, n) where they stand for a participant."""
    array = np.asarray(node.value, dtype=np.float64).squeeze()
    labels = labels_of(node.path, subject)
    if array.shape == (n_joints,):
        return {labels: array}
    if array.ndim != 2 or n_joints not in array.shape or array.shape[0] == array.shape[1]:
        raise FileFormatError(f"weights of shape {array.shape}")
    rows = array if array.shape[1] == n_joints else array.T
    for level in ("condition", "target", "trial"):
        values = study.select(subject=subject).values(level)
        if getattr(labels, level) is None and len(values) == len(rows):
            return {replace(labels, **{level: v}): row for v, row in zip(values, rows, strict=True)}
    raise FileFormatError(f"{len(rows)} rows of weights for no known level")
