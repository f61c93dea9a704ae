"""Kinematic redundancy of the human arm."""
