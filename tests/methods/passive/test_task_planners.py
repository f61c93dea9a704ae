import numpy as np
import pytest

from selfmotion.errors import RangeError, ShapeError
from selfmotion.methods.passive.task_planners import ForceField, MinimumJerk, MovementPrimitive

START, GOAL = np.array([[0.1, 0.2, 0.0]]), np.array([[0.4, 0.0, 0.3]])
TIME = np.linspace(0.0, 0.8, 81)


def recorded():
    u = np.linspace(0.0, 1.0, 150)
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    return u, np.stack([0.3 * s, 0.1 * np.sin(np.pi * s) ** 2, 0.05 * s], axis=1)


@pytest.mark.parametrize(
    "planner", [MinimumJerk(), MinimumJerk(0.5), MovementPrimitive.from_path(*recorded())]
)
def test_references_begin_and_end_where_they_should(planner):
    points, speeds = planner.reference(TIME, START, GOAL)
    np.testing.assert_allclose(points[:, 0], START, atol=1e-15)
    np.testing.assert_allclose(points[:, -1], GOAL, atol=2e-3)
    np.testing.assert_allclose(speeds[:, 0], 0.0, atol=1e-12)
    between = np.gradient(points[0], TIME, axis=0)[1:-1]
    np.testing.assert_allclose(speeds[0, 1:-1], between, atol=0.01)


def test_minimum_jerk_has_its_peak_in_the_middle():
    _, speeds = MinimumJerk().reference(TIME, START, GOAL)
    size = np.linalg.norm(speeds[0], axis=1)
    way = np.linalg.norm(GOAL - START)
    assert size.argmax() == 40
    assert size.max() == pytest.approx(1.875 * way / 0.8)  # 15/8 of the mean speed
    with pytest.raises(RangeError, match="duration"):
        MinimumJerk(0.0)


def test_a_primitive_keeps_the_shape_of_the_path():
    u, path = recorded()
    planner = MovementPrimitive.from_path(3.0 * u, path)
    points, _ = planner.reference(0.8 * u, path[:1], path[-1:])
    np.testing.assert_allclose(points[0], path, atol=2e-3)
    far, _ = planner.reference(0.8 * u, 2.0 + 0.0 * path[:1], 2.0 + 3.0 * path[-1:])
    np.testing.assert_allclose(far[0] - 2.0, 3.0 * points[0], atol=1e-9)
    still, _ = planner.reference(0.8 * u, START, START)
    np.testing.assert_array_equal(still[0], np.repeat(START, len(u), axis=0))
    # Backwards: the way turns by half a circle and so does the path.
    back, _ = planner.reference(0.8 * u, path[:1], -path[-1:])
    bulge = np.abs(np.cross(back[0], -path[-1]) / np.linalg.norm(path[-1])).max()
    ahead = np.abs(np.cross(points[0], path[-1]) / np.linalg.norm(path[-1])).max()
    assert bulge == pytest.approx(ahead, rel=0.5)


def test_bad_paths_are_refused():
    u, path = recorded()
    with pytest.raises(RangeError, match="increase strictly"):
        MovementPrimitive.from_path(u[::-1], path)
    with pytest.raises(RangeError, match="ends where it starts"):
        MovementPrimitive.from_path(u, np.concatenate([path[:75], path[74::-1]]))
    with pytest.raises(ShapeError, match="at least 30"):
        MovementPrimitive.from_path(u[:10], path[:10])
    with pytest.raises(ShapeError, match="targets have 2 rows"):
        MovementPrimitive.from_path(u, path).reference(TIME, START[:, :2], GOAL[:, :2])


def test_stiffness_of_a_force_field():
    K = np.array([[3.0, 1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.5, 4.0]])
    field = ForceField(lambda t, x, goal: (goal - x) @ K.T)
    np.testing.assert_allclose(field.stiffness(0.0, START, GOAL)[0], K, atol=1e-6)
