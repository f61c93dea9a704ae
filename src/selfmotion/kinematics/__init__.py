"""Kinematics: chains, arms, frames, Jacobians, gravity torque and inertia, swivel angle."""
