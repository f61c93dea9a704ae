"""The option --recording of `selfmotion workspace`: recorded hand positions against the arms."""

from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.workspace_document import Recorded, Regions
from selfmotion.errors import FileFormatError

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.kinematics.arm import Arm
    from selfmotion.methods.workspace import Workspace

# Recorded positions that are held against the workspace: at most so many, evenly chosen.
MOST_RECORDED = 5000


def recorded_of(space: "Workspace", name: str, path: Path) -> Recorded:
    """Hold recorded positions against the arms of a workspace.

    Raises:
        FileFormatError: the recordings hold neither hand positions nor angles of this arm.
    """
    import numpy as np

    from selfmotion.methods.joint_limited_ik import IkOptions, solve_ik
    from selfmotion.methods.reaching.ik_tasks import HandRows

    points = recorded_points(space.arm, path)
    inside, farthest = {}, {}
    arms = {name: space.arm}
    if space.limited_arm is not None:
        arms["limited"] = space.limited_arm
    for key, arm in arms.items():
        task = HandRows(arm, ("x", "y", "z"))
        found = solve_ik(task, points, options=IkOptions(position_tolerance=1e-5))
        inside[key] = 100.0 * float(found.solved.mean())
        farthest[key] = 1e3 * float(np.where(found.solved, 0.0, found.position_error).max())
    return Recorded(
        points=len(points), inside_percent=Regions(**inside), farthest_mm=Regions(**farthest)
    )


def recorded_points(arm: "Arm", path: Path) -> "np.ndarray":
    """Give recorded hand positions (K, 3) in the ground, gaps left out."""
    import numpy as np

    from selfmotion.kinematics.forward import forward_kinematics
    from selfmotion.motion.files import load

    parts = []
    for recording in load(path):
        if recording.x is not None and recording.x.shape[1] == 3:
            x = recording.x
        elif recording.q is not None and set(arm.joints) <= set(recording.joints):
            order = [recording.joints.index(joint) for joint in arm.joints]
            q = recording.q[:, order]
            whole = np.isfinite(q).all(axis=1)
            x = forward_kinematics(arm.chain, q[whole], arm.tip("hand"))[:, :3, 3]
        else:
            raise FileFormatError(
                f"{recording.name}: holds {', '.join(recording.held)}; hand positions x, y, z, or "
                f"the angles of {arm.name} are needed"
            )
        parts.append(x[np.isfinite(x).all(axis=1)])
    points = np.concatenate(parts)
    if not len(points):
        raise FileFormatError(f"{path}: no hand position without gap")
    step = -(-len(points) // MOST_RECORDED)
    return points[::step]
