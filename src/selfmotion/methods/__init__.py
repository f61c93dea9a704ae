"""The four methods: one file a verb, its parts in a folder beside it.

| verb | parts | paper |
| --- | --- | --- |
| `identification`, `velocity_split`, `uncontrolled_manifold` | `weights/` | [Khoramshahi2022] |
| `passive_motion`, `donders`, `curvature` | `passive/`, `elasticity/` | [Tommasino2017] |
| `joint_limited_ik`, `constrained_path`, `workspace` | `reaching/` | [DeBoon] |
| `natural_posture`, `hybrid_ik` | `effort/` | [Li2022] |
"""
