"""The parts of joint-limited inverse kinematics and of the workspace ([DeBoon])."""
