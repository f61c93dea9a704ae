"""Arms with muscles: the default one, or a user's own model."""

from pathlib import Path

from selfmotion.errors import FileFormatError
from selfmotion.muscles.geometry import MusculoskeletalArm


def load_musculoskeletal_arm(
    model: str | Path = "myoarm", *, convention: str | None = None
) -> MusculoskeletalArm:
    """Load an arm with muscles.

    Args:
        model: ``myoarm``, or the path of a model with muscles: .xml (MJCF) or .osim (needs the
            extra `opensim`).
        convention: how effort is computed (see `muscles.static_optimization`); left out: opensim
            for an .osim, plain otherwise.

    Raises:
        FileFormatError: the file does not exist, cannot be read, or is of another kind.
        ModelError: the model has no muscles, or something that cannot be represented.
        MissingExtraError: an .osim is given and OpenSim is not installed.

    Example:
        >>> arm = load_musculoskeletal_arm()
        >>> len(arm.muscles.names), arm.convention
        (63, 'plain')
    """
    suffix = Path(model).suffix.lower()
    if str(model) == "myoarm":
        from selfmotion.arms._myoarm import myoarm
        from selfmotion.muscles.mujoco_bridge import load_myo_sim, muscles_from_mujoco

        arm = myoarm()
        parts = muscles_from_mujoco(load_myo_sim("myoarm"), arm.chain)
        return MusculoskeletalArm(arm, *parts, convention or "plain")
    if suffix == ".osim":
        from selfmotion.muscles.opensim_bridge import read_osim

        return read_osim(model, convention=convention or "opensim")
    if suffix == ".xml":
        import mujoco

        from selfmotion.arms.mjcf_urdf import read_model
        from selfmotion.muscles.mujoco_bridge import muscles_from_mujoco

        arm = read_model(model)
        compiled = mujoco.MjSpec.from_file(str(model)).compile()
        return MusculoskeletalArm(
            arm, *muscles_from_mujoco(compiled, arm.chain), convention or "plain"
        )
    raise FileFormatError(f"{model}: expected myoarm, an .osim or an .xml (MJCF) with muscles")
