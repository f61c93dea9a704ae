import numpy as np
import pytest

from selfmotion.arms import load_arm
from selfmotion.errors import RangeError, UnknownNameError
from selfmotion.kinematics.forward import tip_positions
from selfmotion.motion.labels import Labels
from selfmotion.motion.recording import Recording
from selfmotion.studies.splint_change import splint_change

ARM = load_arm("upper_limb_anatomical")
ALIKE = np.ones(ARM.n_joints)


def reach(flexion: tuple[float, float], trial: int = 1) -> Recording:
    """Flex shoulder and elbow evenly; each trial a little farther to the side."""
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 50))
    q = np.tile(ARM.middle(), (50, 1))
    q[:, ARM.joints.index("shoulder_flexion")] = 0.3 + 0.5 * share
    q[:, ARM.joints.index("shoulder_adduction")] += 0.05 * trial * share
    low, high = flexion
    q[:, ARM.joints.index("elbow_flexion")] = low + (high - low) * share
    labels = Labels(condition="reach", trial=str(trial))
    return Recording(np.arange(50) / 50, q=q, joints=ARM.joints, labels=labels)


def test_a_path_inside_the_splint_changes_nothing():
    change = splint_change(ARM, [reach((1.4, 1.6), k) for k in range(3)], ALIKE)
    assert change.reached == 1.0
    np.testing.assert_allclose(change.excursion_after, change.excursion_before, atol=1e-6)
    assert change.compensation == ()
    assert "no joint moves more" in change.sentence()


def test_other_joints_do_what_the_elbow_cannot():
    movements = [reach((0.9, 1.9), k) for k in range(3)]
    change = splint_change(ARM, movements, ALIKE, splint={"elbow_flexion": (1.3, 1.5)})
    i = ARM.joints.index("elbow_flexion")
    assert change.excursion_after[i] <= 0.2 + 1e-9 < change.excursion_before[i]
    assert change.compensation and "elbow_flexion" not in change.compensation
    if change.before is not None and change.after is not None:
        # A joint that hardly moves looks dear, although its cost is the same.
        other = ARM.joints.index("shoulder_flexion")
        looks = [e.weights[i] / e.weights[other] for e in (change.before, change.after)]
        assert not np.isfinite(looks).all() or looks[1] > looks[0]


def test_what_cannot_be_reached_is_counted():
    movements = [reach((0.1, 1.5), k) for k in range(2)]
    change = splint_change(ARM, movements, ALIKE, splint={"elbow_flexion": (2.0, 2.2)})
    wrist = tip_positions(ARM.chain, movements[0].array("q"), [ARM.tip("wrist")])[:, 0]
    shoulder = tip_positions(ARM.chain, movements[0].array("q"), [ARM.tip("shoulder")])[:, 0]
    # Stretched farther than a bent elbow allows, girdle at its best: an upper bound by geometry.
    lengths = ARM.lengths
    bent = np.sqrt(
        lengths["upper_arm"] ** 2
        + lengths["forearm"] ** 2
        + 2 * lengths["upper_arm"] * lengths["forearm"] * np.cos(2.0)
    )
    beyond = np.linalg.norm(wrist - shoulder, axis=1) > bent + 2 * np.linalg.norm(shoulder[0])
    assert change.reached <= 1.0 - beyond.mean()
    assert change.by_condition["reach"] == pytest.approx(change.reached)


def test_bad_input_is_refused():
    with pytest.raises(UnknownNameError, match="knee"):
        splint_change(ARM, [reach((1.4, 1.6))], ALIKE, splint={"knee": (0.0, 1.0)})
    with pytest.raises(RangeError, match="leaves nothing"):
        splint_change(ARM, [reach((1.4, 1.6))], ALIKE, splint={"elbow_flexion": (4.0, 5.0)})
    with pytest.raises(RangeError, match="positive numbers"):
        splint_change(ARM, [reach((1.4, 1.6))], np.zeros(ARM.n_joints))
    with pytest.raises(RangeError, match="there is none"):
        splint_change(ARM, [], ALIKE)
