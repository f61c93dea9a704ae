"""Bones of a musculoskeletal arm as triangles, and where each is in a posture.

Meshes come from the model that MuJoCo compiled; nothing of it is kept. A model without meshes (an
.osim) is drawn as lines between its landmarks by `scene`.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float, Int

from selfmotion.muscles.geometry import MusculoskeletalArm
from selfmotion.muscles.mujoco_bridge import MujocoMuscles

# Group of a model's geoms that are there to be looked at; others are for contact and wrapping.
VISIBLE = 0
# Vertices closer together than about this are one (m): finger bones come in thousands of triangles.
DETAIL = 0.003


@dataclass(frozen=True, eq=False)
class Bone:
    """One mesh, in the frame of its own body.

    Attributes:
        name: of the mesh.
        body: to which body of the model it belongs.
        vertices: (V, 3) in the body's frame (m).
        faces: (F, 3) indices of vertices.
    """

    name: str
    body: int
    vertices: Float[np.ndarray, "vertices 3"]
    faces: Int[np.ndarray, "faces 3"]


@dataclass(frozen=True, eq=False)
class Skeleton:
    """All bones of a model.

    Attributes:
        bones: those that are to be seen.
        muscles: the model they belong to.
        data: MuJoCo's work space, of this skeleton alone.
    """

    bones: tuple[Bone, ...]
    muscles: MujocoMuscles
    data: mujoco.MjData

    def place(
        self, q: Float[np.ndarray, " coords"]
    ) -> tuple[Float[np.ndarray, "bones 3"], Float[np.ndarray, "bones 4"]]:
        """Give position (m) and quaternion (w, x, y, z) of each bone in the ground.

        Args:
            q: (n,) posture (rad).
        """
        model, data = self.muscles.model, self.data
        joints = self.muscles.chain.coupling.value(np.asarray(q, dtype=float)[None])[0]
        data.qpos[model.jnt_qposadr[self.muscles.joint_ids]] = joints
        mujoco.mj_kinematics(model, data)
        bodies = [bone.body for bone in self.bones]
        return data.xpos[bodies].copy(), data.xquat[bodies].copy()


def skeleton_of(arm: MusculoskeletalArm) -> Skeleton | None:
    """Give the bones of an arm; None where its model has no meshes.

    Example:
        >>> from selfmotion.arms.with_muscles import load_musculoskeletal_arm
        >>> skeleton = skeleton_of(load_musculoskeletal_arm())
        >>> "humerus_r" in [bone.name for bone in skeleton.bones]
        True
    """
    if not isinstance(arm.geometry, MujocoMuscles):
        return None
    model = arm.geometry.model
    meshes = np.flatnonzero(
        (model.geom_type == int(mujoco.mjtGeom.mjGEOM_MESH))
        & (model.geom_group == VISIBLE)
        & (model.geom_bodyid > 0)
    )
    bones = tuple(_bone(model, int(g)) for g in meshes)
    return Skeleton(bones, arm.geometry, mujoco.MjData(model)) if bones else None


def _bone(model: mujoco.MjModel, geom: int) -> Bone:
    mesh = int(model.geom_dataid[geom])
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    vertices = model.mesh_vert[first : first + count] @ rotation.reshape(3, 3).T
    return Bone(
        model.mesh(mesh).name,
        int(model.geom_bodyid[geom]),
        *simplified(
            np.asarray(vertices + model.geom_pos[geom], dtype=float),
            np.asarray(model.mesh_face[start : start + faces], dtype=np.int64),
            DETAIL,
        ),
    )


def simplified(
    vertices: Float[np.ndarray, "vertices 3"], faces: Int[np.ndarray, "faces 3"], cell: float
) -> tuple[Float[np.ndarray, "fewer 3"], Int[np.ndarray, "few 3"]]:
    """Merge the vertices of each cell of a grid into their mean; drop faces that lose their area.

    Args:
        vertices: (V, 3) (m).
        faces: (F, 3) indices.
        cell: edge of a cell (m).

    Example:
        >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1.001, 0, 0]])
        >>> v, f = simplified(corners, np.array([[0, 1, 2], [1, 3, 2]]), 0.1)
        >>> len(v), f.tolist()
        (3, [[0, 2, 1]])
    """
    cells = np.floor(vertices / cell).astype(np.int64)
    _, group, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    merged = np.zeros((len(count), 3))
    np.add.at(merged, group.ravel(), vertices)
    kept = group.ravel()[faces]
    corners = np.sort(kept, axis=1)
    solid = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
    _, once = np.unique(corners[solid], axis=0, return_index=True)
    return merged / count[:, None], kept[solid][np.sort(once)]
