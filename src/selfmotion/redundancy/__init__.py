"""Redundancy: tasks, the weighted pseudo-inverse and the null space."""
