"""Many items through one function, in this process, on all cores, or on a cluster."""

from selfmotion.batch.item import Item, Outcome
from selfmotion.batch.run import Runner, iterate_batch, run_batch

__all__ = ["Item", "Outcome", "Runner", "iterate_batch", "run_batch"]
