"""Write .mat files as MATLAB lays them out, and the two published layouts with known content."""

from itertools import count
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import savemat

NUMBERS = count()  # names of what cells refer to
CONDITIONS_1 = ("Natural", "Viscous")
CONDITIONS_2 = ("Natural", "Locked", "Coupled", "Assistive")


def cell(items: list[Any]) -> np.ndarray:
    """Make a 1 x N cell array, as savemat takes it."""
    out = np.empty((1, len(items)), dtype=object)
    for i, item in enumerate(items):
        out[0, i] = item
    return out


def write_mat(path: Path, variables: dict[str, Any], version: str) -> Path:
    """Write variables (numbers, text, dicts for structs, cell(...) for cells).

    Versions: "v5" (compressed, MATLAB's -v7), "v6" (the same, not compressed) and "v7.3".
    """
    if version != "v7.3":
        savemat(path, variables, do_compression=version == "v5")
        return path
    with h5py.File(path, "w", userblock_size=512) as file:
        store = file.create_group("#refs#")
        for name, value in variables.items():
            _write_v73(file, file, store, name, value)
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: some day HDF5 schema 1.00 ."
    with open(path, "r+b") as stream:
        stream.write(header.ljust(116) + bytes(8) + b"\x00\x02IM")
    return path


def _write_v73(file: Any, parent: Any, store: Any, name: str, value: Any) -> Any:
    if isinstance(value, dict):
        item = parent.create_group(name)
        for key, inner in value.items():
            _write_v73(file, item, store, key, inner)
        return _mark(item, "struct")
    if isinstance(value, str):
        units = np.frombuffer(value.encode("utf-16-le"), dtype="<u2")
        return _mark(parent.create_dataset(name, data=units.reshape(-1, 1)), "char")
    array = np.atleast_2d(np.asarray(value))
    if array.dtype != object:
        return _mark(parent.create_dataset(name, data=array.astype(float).T), "double")
    references = np.empty(array.T.shape, dtype=h5py.ref_dtype)
    for at in np.ndindex(*array.shape):
        made = _write_v73(file, store, store, f"r{next(NUMBERS)}", array[at])
        references[at[::-1]] = made.ref
    return _mark(parent.create_dataset(name, data=references, dtype=h5py.ref_dtype), "cell")


def _mark(item: Any, kind: str) -> Any:
    item.attrs["MATLAB_class"] = np.bytes_(kind)
    return item


def trial_1(rng: np.random.Generator, samples: int = 100) -> dict[str, np.ndarray]:
    """One trial of experiment 1 with time along axis 0."""
    q = np.cumsum(rng.normal(size=(samples, 4)), axis=0) * 0.01
    qd = rng.normal(size=(samples, 4))
    jacobian = rng.normal(size=(samples, 3, 4))
    return {"q": q, "qd": qd, "jacobian": jacobian, "xd": np.einsum("kij,kj->ki", jacobian, qd)}


def experiment_1(people: int = 2, trials: int = 2, samples: int = 100) -> list[dict[str, Any]]:
    """Truth: people -> condition -> target -> list of trials, and weights per condition."""
    rng = np.random.default_rng(10)
    return [
        {
            c: {
                "trials": [
                    [trial_1(rng, samples) for _ in range(trials + t % 2)] for t in range(3)
                ],
                "weights": rng.uniform(0.1, 1, 4),
            }
            for c in CONDITIONS_1
        }
        for _ in range(people)
    ]


def as_structs_1(people: list[dict[str, Any]]) -> dict[str, Any]:
    """Layout A: structs named Target1, cells of trials, Jacobian m x n x K, IK_data."""
    out = []
    for person in people:
        top: dict[str, Any] = {"Gender": "f"}
        for condition, content in person.items():
            every = [trial for target in content["trials"] for trial in target]
            structs: dict[str, Any] = {
                f"Target{i + 1}": cell(
                    [
                        {
                            "JointPosition": t["q"],
                            "JointVelocity": t["qd"],
                            "EndEffectorVelocity": np.pad(t["xd"], ((0, 0), (0, 1))),
                            "Jacobian": t["jacobian"].transpose(1, 2, 0),
                            "NullVelocity_WI": t["qd"],
                        }
                        for t in target
                    ]
                )
                for i, target in enumerate(content["trials"])
            }  # fmt: skip
            pooled = {k: np.concatenate([t[k] for t in every]) for k in ("qd", "xd", "jacobian")}
            structs["IK_data"] = {
                "dQ": pooled["qd"].T,
                "dX": pooled["xd"].T,
                "J": pooled["jacobian"].transpose(1, 2, 0),
            }
            structs["IK_weights"] = content["weights"].reshape(-1, 1)
            top[condition] = structs
        out.append(top)
    return {"S1_data": cell(out)}


def as_lists_1(people: list[dict[str, Any]]) -> dict[str, Any]:
    """Layout B: conditions{c}.targets{t}.trials{k}, a cell a Jacobian, weights (2, 4)."""
    out = []
    for person in people:
        conditions = [
            {
                "name": condition,
                "targets": cell(
                    [
                        {
                            "trials": cell(
                                [
                                    {
                                        "q": t["q"].T,
                                        "dq": t["qd"].T,
                                        "dx": t["xd"].T,
                                        "J": cell(list(t["jacobian"])),
                                        "dt": 0.009,
                                    }
                                    for t in target
                                ]
                            )
                        }
                        for target in content["trials"]
                    ]
                ),
            }
            for condition, content in person.items()
        ]
        weights = np.stack([content["weights"] for content in person.values()])
        out.append({"conditions": cell(conditions), "weights": weights})
    return {"data": cell(out)}


LENGTHS, OFFSETS, BASE = (
    np.array([0.5, 0.3, 0.28]),
    np.array([1.5, 0.1, 0.0]),
    np.array([0.2, -0.1]),
)


def chain_2(q: np.ndarray, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Hand and Jacobian of the planar chain with relative angles, written out by components."""
    angle = np.cumsum(q, axis=1) + OFFSETS
    length = LENGTHS * scale
    x = BASE + np.stack([(length * np.cos(angle)).sum(1), (length * np.sin(angle)).sum(1)], axis=1)
    jacobian = np.zeros((len(q), 2, 3))
    for j in range(3):
        jacobian[:, 0, j] = -(length * np.sin(angle))[:, j:].sum(axis=1)
        jacobian[:, 1, j] = (length * np.cos(angle))[:, j:].sum(axis=1)
    return x, jacobian


def motion_2(condition: str, samples: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Smooth angles of one condition: a locked elbow, an elbow that follows the shoulder, ..."""
    time = np.arange(samples) / 60.0
    f, p = rng.uniform(0.05, 0.3, size=(3, 3)), rng.uniform(0, 6, size=(3, 3))
    q = 0.3 * np.sin(2 * np.pi * f[None] * time[:, None, None] + p[None]).sum(axis=1)
    q += [0.0, -1.5, 1.2]
    human = q[:, 2].copy()
    if condition == "Locked":
        q[:, 2] = 1.0
    elif condition == "Coupled":
        q[:, 2] = q[:, 1] + 2.5
    elif condition == "Assistive":
        q[:, 2] = 0.5 * human + 0.3 * q[:, 1] ** 2
    return {"time": time, "q": q, "human": human}


def experiment_2(people: int = 2, samples: int = 240) -> list[dict[str, Any]]:
    """Truth of experiment 2: people -> condition -> time, q, human elbow, x, jacobian, weights."""
    rng = np.random.default_rng(11)
    out = []
    for i in range(people):
        person = {}
        for condition in CONDITIONS_2:
            motion = motion_2(condition, samples, rng)
            x, jacobian = chain_2(motion["q"], 1.0 + 0.1 * i)
            weights = rng.uniform(0.1, 1, 3)
            person[condition] = motion | {"x": x, "jacobian": jacobian, "weights": weights}
        out.append(person)
    return out


def as_structs_2(people: list[dict[str, Any]]) -> dict[str, Any]:
    """Each condition a struct with time, human joints, virtual elbow, hand and targets."""
    return {
        "S2_data": cell(
            [
                {
                    condition: {
                        "time": m["time"].reshape(-1, 1),
                        "humanJoints": np.column_stack([m["q"][:, :2], m["human"]]),
                        "virtualElbow": m["q"][:, 2:],
                        "endEffector": m["x"],
                        "target": m["x"] + 0.01,
                        "IK_data": {"dq": m["q"], "dx": m["x"], "J": m["jacobian"]},
                        "IK_weights": m["weights"],
                    }
                    for condition, m in person.items()
                }
                for person in people
            ]
        )
    }
