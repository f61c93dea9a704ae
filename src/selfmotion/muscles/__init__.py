"""Muscles: paths and moment arms, forces, the activations that hold a posture; model files."""
