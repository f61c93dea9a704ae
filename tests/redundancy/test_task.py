"""Task Jacobians against central differences, on every arm."""

import numpy as np
import pytest
from tests.arms.mujoco_oracle import NAMES, arm_called

from selfmotion.arms import load_arm
from selfmotion.errors import NotFiniteError, RangeError, ShapeError
from selfmotion.redundancy.task import Planar, Pointing, Pose, Position, RowMask, Task
from selfmotion.spatial import exp_rotation

STEP = 1e-6
TASKS = {
    "position": Position,
    "pose": Pose,
    "pointing": Pointing,
    "planar": lambda arm: Planar(arm, axes=(2, 0)),
    "elbow": lambda arm: Position(arm, "elbow"),
    "rows_of_pose": lambda arm: RowMask(Pose(arm), (0, 4, 2)),
    "rows_of_rows": lambda arm: RowMask(RowMask(Pose(arm), (0, 4, 2)), (1,)),
}
# Those of a pose are angular velocities, which `error` measures.
BY_VALUE = ("position", "pointing", "planar", "elbow")


def whole_value(task: Task, q: np.ndarray) -> np.ndarray:
    """What `error` takes as a target: the value of the innermost task."""
    while isinstance(task, RowMask):
        task = task.task
    return task.value(q)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", TASKS)
def test_jacobian_by_central_differences(name, kind):
    arm = arm_called(name)
    task: Task = TASKS[kind](arm)
    q = arm.random_postures(3, np.random.default_rng(9))
    J = task.jacobian(q)
    assert J.shape == (3, len(task.units), arm.n_joints)
    for i in range(arm.n_joints):
        step = STEP * np.eye(arm.n_joints)[i]
        if kind in BY_VALUE:
            change = task.value(q + step) - task.value(q - step)
        else:
            ahead, behind = whole_value(task, q + step), whole_value(task, q - step)
            change = task.error(q, ahead) - task.error(q, behind)
        np.testing.assert_allclose(J[:, :, i], change / (2 * STEP), rtol=0, atol=2e-8)


@pytest.mark.parametrize("kind", TASKS)
def test_nothing_is_missing_at_the_value_itself(kind):
    arm = load_arm("upper_limb_anatomical")
    task: Task = TASKS[kind](arm)
    q = arm.random_postures(4, np.random.default_rng(1))
    target = whole_value(task, q)
    np.testing.assert_allclose(task.error(q, target), np.zeros((4, len(task.units))), atol=1e-12)
    assert task.row_scale.shape == (len(task.units),)


def test_pose_error_turns_the_frame_to_the_target():
    arm = load_arm("srs7")
    q, goal = arm.random_postures(2, np.random.default_rng(2))
    task = Pose(arm)
    here, there = task.value(q)[0], task.value(goal)[0]
    missing = task.error(q, there)[0]
    turned = exp_rotation(missing[None, 3:])[0] @ exp_rotation(here[None, 3:])[0]
    np.testing.assert_allclose(turned, exp_rotation(there[None, 3:])[0], atol=1e-12)
    np.testing.assert_allclose(missing[:3], there[:3] - here[:3], atol=1e-15)
    assert np.linalg.norm(missing[3:]) <= np.pi + 1e-12


def test_units_and_scales():
    arm = load_arm("srs7")
    assert Pose(arm, rotation_scale=0.2).row_scale.tolist() == [1, 1, 1, 0.2, 0.2, 0.2]
    mask = RowMask(Pose(arm, rotation_scale=0.2), (5, 0))
    assert mask.units == ("rad", "m")
    assert mask.row_scale.tolist() == [0.2, 1.0]


def test_pointing_is_an_orthographic_projection():
    arm = load_arm("wrist")
    task = Pointing(arm, distance=2.0)
    for angle in (0.1, 0.7, 1.3):
        point = task.value([0.0, -angle, 0.0])[0]
        np.testing.assert_allclose(point, [2.0 * np.sin(angle), 0.0], atol=1e-15)


def test_one_target_serves_all_postures():
    arm = load_arm("srs7")
    q = arm.random_postures(3, np.random.default_rng(2))
    target = [0.1, 0.2, 0.3]
    np.testing.assert_allclose(
        Position(arm).error(q, target), np.array(target) - Position(arm).value(q), atol=1e-15
    )


@pytest.mark.parametrize("rows", [(), (0, 0), (6,), (-1,)])
def test_rows_that_do_not_exist(rows):
    with pytest.raises(RangeError, match="rows = "):
        RowMask(Pose(load_arm("srs7")), rows)


def test_bad_targets():
    task = Position(load_arm("wrist"))
    with pytest.raises(ShapeError, match=r"target has shape \(1, 2\); expected \(samples, 3\)"):
        task.error([0.0, 0.0, 0.0], [1.0, 2.0])
    with pytest.raises(NotFiniteError, match="target"):
        task.error([0.0, 0.0, 0.0], [1.0, 2.0, np.inf])
