"""The four methods: one file a verb, its parts in a folder beside it.

| verbs | parts | paper |
| --- | --- | --- |
| `identification`, `velocity_split`, `hotelling` | `weights/` | [Khoramshahi2022] |
| `passive_motion`, `donders`, `curvature` | `passive/`, `elasticity/` | [Tommasino2017] |
| `joint_limited_ik`, `constrained_path`, `hand_circle`, `reach` | `reaching/` | [DeBoon] |
| `workspace`, `workspace_maps`, `workspace_mapping` | `reaching/` | [DeBoon] |
| `hand_constraints`, `reach_clouds` | `reaching/` | [DeBoon] |
| `natural_posture`, `hybrid_ik` | `effort/` | [Li2022] |

Beside them, to compare with: `coordination` and `uncontrolled_manifold` for the weights, and
`predictors/` of the swivel angle for the natural posture.
"""
