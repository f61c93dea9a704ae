"""Options of the identification of IK weights that rarely need changing."""

from dataclasses import dataclass
from typing import Literal

from selfmotion.errors import RangeError, unknown_name
from selfmotion.methods.weights import kernels

Method = Literal["ml", "paper", "feedback"]
METHODS = ("ml", "paper", "feedback")
STDERR = ("auto", "sandwich", "jackknife")
TERMS = {"posture": kernels.POSTURE, "constant": kernels.CONSTANT}


@dataclass(frozen=True)
class IdentificationOptions:
    """What rarely needs changing.

    Attributes:
        tolerance: largest last step of a log-weight; None: 1e-10 (ml, feedback), 1e-8 (paper,
            there in units of 1 - γ).
        max_iterations: None: 100 (ml, feedback), 5000 (paper).
        start: first guess of w: ``"eigenvector"`` (of the linear problem), ``"ones"``, or numbers
            (ml, feedback; the paper starts at ones).
        feedback_terms: what drives the null-space motion: ``"posture"``, ``"constant"``, or both.
        stderr: ``"sandwich"``, ``"jackknife"``, or ``"auto"``: the jackknife below 15 clusters,
            where the sandwich is too narrow (ml, feedback).
        max_stderr: log-ratios with a larger standard error are not reported.
        hash_inputs: whether the provenance holds a hash of the data.
    """

    tolerance: float | None = None
    max_iterations: int | None = None
    start: Literal["eigenvector", "ones"] | tuple[float, ...] = "eigenvector"
    feedback_terms: tuple[str, ...] = ("posture", "constant")
    stderr: Literal["auto", "sandwich", "jackknife"] = "auto"
    max_stderr: float = 1.0
    hash_inputs: bool = True

    def __post_init__(self) -> None:
        """Refuse unknown names and impossible numbers."""
        for term in self.feedback_terms:
            if term not in TERMS:
                raise unknown_name("feedback term", term, tuple(TERMS))
        if self.stderr not in STDERR:
            raise unknown_name("stderr", self.stderr, STDERR)
        if isinstance(self.start, str) and self.start not in ("eigenvector", "ones"):
            raise unknown_name("start", self.start, ("eigenvector", "ones"))
        if not isinstance(self.start, str) and not all(w > 0.0 for w in self.start):
            raise RangeError(f"start = {self.start}: allowed are positive weights")
        if self.max_iterations is not None and self.max_iterations < 1:
            raise RangeError(f"max_iterations = {self.max_iterations}: allowed is 1 or more")
        if not self.max_stderr > 0.0:
            raise RangeError(f"max_stderr = {self.max_stderr:g}: allowed is more than 0")


DEFAULT_OPTIONS = IdentificationOptions()
