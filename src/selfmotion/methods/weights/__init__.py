"""The parts of weight identification and of the split of velocities ([Khoramshahi2022]).

The verbs are in `identification` and `velocity_split`.
"""
