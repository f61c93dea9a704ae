"""Every picture has labelled axes with units, finite data, and colours that keep their meaning."""

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from selfmotion.methods.velocity_split import VelocityBands
from selfmotion.report import convergence_figures, theme, velocity_figures, weights_figures
from selfmotion.studies.results import Convergence, NoiseSweep, NullSpeeds, SplitBands, Sweep

JOINTS = ("shoulder_flexion", "elbow_flexion", "wrist_flexion")
CONDITIONS = ("Natural", "Viscous")


def bands(scale=1.0, n_trials=4):
    phase = np.linspace(0, 1, 21)
    profile = np.sin(np.pi * phase)[:, None] * np.array([1.0, -0.5, 0.0])
    mean = {"total": scale * profile, "task": 0.8 * scale * profile, "null": 0.2 * scale * profile}
    spread = {k: np.full_like(v, np.nan if n_trials == 1 else 0.1) for k, v in mean.items()}
    return VelocityBands(JOINTS, phase, mean, spread, n_trials)


def convergence(label="γ = 0.6"):
    path = np.exp(-np.arange(12) / 3)[None, :, None] * np.ones((3, 1, 2)) + [0.5, 0.1]
    return Convergence(label, path, np.array([0.5, 0.1]))


def people(unknown=()):
    rows = [
        {
            "subject": f"P{i}",
            "condition": condition,
            "joint": joint,
            "weight": np.nan if joint in unknown else 0.5 / (j + 1) * 1.1**i,
            "stderr_log": 0.1,
            "contribution": 1 / 3,
            "identified": joint not in unknown,
        }
        for i in range(5)
        for condition in CONDITIONS
        for j, joint in enumerate(JOINTS)
    ]
    return pd.DataFrame(rows)


def null_speeds():
    panels = {(c, kind): bands() for c in CONDITIONS for kind in ("identified", "identity")}
    rows = [
        {"subject": s, "condition": c, "weights": w, "rms": 0.1 + 0.1 * (w == "identity")}
        for s in ("P1", "P2")
        for c in CONDITIONS
        for w in ("identified", "identity")
    ]
    return NullSpeeds(panels, pd.DataFrame(rows))


def noise():
    rows = [
        {"sigma": s, "noise": n, "method": m, "error": s, "sd": 0.01}
        for s in (0.0, 0.5)
        for n in ("projected", "not projected")
        for m in ("ml", "paper")
    ]
    return NoiseSweep(pd.DataFrame(rows))


SWEEP = Sweep((0.0, 0.6), (convergence("γ = 0"), convergence()))
PICTURES = {
    "convergence": lambda: convergence_figures.convergence_figure(convergence()),
    "gamma": lambda: convergence_figures.gamma_figure(SWEEP),
    "two_joint": lambda: convergence_figures.two_joint_figure(SWEEP),
    "noise": lambda: convergence_figures.noise_figure(noise()),
    "history": lambda: convergence_figures.fit_history_figure(
        convergence().weights[0], JOINTS[:2], method="ml"
    ),
    "velocity": lambda: velocity_figures.velocity_figure(
        {(t, c): bands() for t in ("high", "inward") for c in CONDITIONS}, CONDITIONS
    ),
    "null": lambda: velocity_figures.null_velocity_figure(null_speeds(), CONDITIONS),
    "null_share": lambda: velocity_figures.null_share_figure(null_speeds(), CONDITIONS),
    "split": lambda: velocity_figures.split_figure(SplitBands(bands(), bands(0.5))),
    "weights": lambda: weights_figures.weights_figure(people()),
    "contribution": lambda: weights_figures.contribution_figure(people()),
}


@pytest.mark.parametrize("name", PICTURES)
def test_axes_are_labelled_and_data_finite(name):
    figure = PICTURES[name]()
    shown = [ax for ax in figure.axes if ax.get_visible()]
    labels = [ax.get_ylabel() or ax.get_xlabel() for ax in shown]
    assert any(labels)
    for ax in shown:
        for drawn in ax.get_lines():
            assert np.isfinite(np.asarray(drawn.get_ydata(), dtype=float)).all()
    figure.canvas.draw()


@pytest.mark.parametrize("name", ["velocity", "null", "split", "null_share"])
def test_velocities_have_units(name):
    texts = [ax.get_ylabel() for ax in PICTURES[name]().axes]
    assert any("rad/s" in text for text in texts)


def test_drawing_leaves_no_global_state():
    before = dict(matplotlib.rcParams)
    PICTURES["weights"]()
    assert dict(matplotlib.rcParams) == before


def test_unidentified_joints_are_words_and_not_numbers():
    figure = weights_figures.weights_figure(people(unknown=("elbow_flexion",)))
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert weights_figures.NOT_IDENTIFIED in texts
    places = np.concatenate([line.get_xdata() for line in figure.axes[0].get_lines()])
    assert not ((places > 0.5001) & (places < 1.4999)).any()


def test_some_people_without_a_weight_are_counted():
    table = people()
    hidden = (table["subject"] == "P0") & (table["joint"] == "elbow_flexion")
    table.loc[hidden, ["weight", "identified"]] = [np.nan, False]
    texts = [t.get_text() for t in weights_figures.weights_figure(table).axes[0].texts]
    assert texts.count("1/5 not\nidentified") == 2


def test_centre_of_people_is_the_geometric_mean():
    table = people()
    here = (table["joint"] == "shoulder_flexion") & (table["condition"] == "Natural")
    rows = table.loc[np.asarray(here)].copy()
    assert isinstance(rows, pd.DataFrame)
    centre, low, high = weights_figures._centre(rows)
    assert centre == pytest.approx(np.exp(np.log(rows["weight"]).mean()))
    assert low < centre < high and high / centre == pytest.approx(centre / low)


def test_colours_keep_their_meaning():
    figure = velocity_figures.split_figure(SplitBands(bands(), bands(0.5)))
    task, null = figure.axes[0], figure.axes[1]
    assert theme.TASK == "#0072B2" and theme.NULL == "#E69F00"
    assert {to_hex(ln.get_color()).upper() for ln in task.get_lines()} >= {theme.TASK}
    assert {to_hex(ln.get_color()).upper() for ln in null.get_lines()} >= {theme.NULL}
    assert not {theme.TASK, theme.NULL} & {theme.joint_colour(i) for i in range(20)}


def test_one_trial_has_no_band_but_a_line():
    figure = velocity_figures.split_figure(SplitBands(bands(n_trials=1), None))
    figure.canvas.draw()


def test_ratio_errors_show_a_dash_where_nothing_is_known():
    errors = np.array([[0.0, 0.1, np.inf], [0.1, 0.0, np.inf], [np.inf, np.inf, 0.0]])
    figure = weights_figures.ratio_error_figure(errors, JOINTS)
    assert [t.get_text() for t in figure.axes[0].texts] == ["0.1", "–", "–"]
    with pytest.raises(ValueError, match=r"expected \(2, 2\)"):
        weights_figures.ratio_error_figure(errors, JOINTS[:2])


def test_a_table_without_weights_is_refused():
    with pytest.raises(ValueError, match=r"column\(s\) weight"):
        weights_figures.weights_figure(people().drop(columns="weight"))


def test_joints_beyond_the_colours_change_their_line():
    n = len(theme.JOINT_COLOURS)
    assert theme.joint_colour(n) == theme.joint_colour(0)
    assert theme.joint_dash(n) != theme.joint_dash(0)
