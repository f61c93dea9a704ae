"""Predictors of a person's swivel angle, one a file, behind the interface of `observation`."""
