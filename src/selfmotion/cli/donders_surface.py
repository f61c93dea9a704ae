"""`selfmotion donders ORIENTATIONS --axis X,Y,Z`: the quadratic surface of any one segment."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from selfmotion.cli.output import Document, Matrix, Number, Vector, finish, numbers, save
from selfmotion.errors import FileFormatError, RangeError
from selfmotion.provenance import Provenance

if TYPE_CHECKING:
    import numpy as np

    from selfmotion.methods.elasticity.orientations import Form


class DondersSurfaceDocument(
    Document, frozen=True, tag="selfmotion/donders-surface/1", kw_only=True
):
    """Torsion about the long axis as a quadratic function of the two other components.

    Rotation vectors are taken from `reference` (the mean orientation) and resolved along the
    columns of `frame`: long axis, a, b, in the segment's own frame (rad).
    """

    axis: Vector
    reference: Matrix
    frame: Matrix
    terms: list[str]
    coefficients: Vector
    stderr: Vector
    thickness_deg: Number
    torsion_deg: Number
    orientations: int
    form: str


def typed_axis(text: str) -> tuple[float, float, float]:
    """Give the direction that --axis means.

    Raises:
        RangeError: these are not three numbers of which one is not zero.
    """
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 or not all(map(math.isfinite, values)) or not any(values):
        raise RangeError(
            f"--axis {text!r}: three numbers are expected, the segment's long axis in its own "
            "frame, as in 0,1,0"
        )
    return values[0], values[1], values[2]


def fit_segment(
    path: Path,
    given: "tuple[np.ndarray, Form]",
    axis: tuple[float, float, float],
    *,
    json: bool,
    out: Path | None,
) -> int:
    """Fit the surface of a segment and print or write it."""
    import numpy as np

    from selfmotion.methods.elasticity.orientation_surface import fit_orientation_surface
    from selfmotion.methods.elasticity.surface import TERMS
    from selfmotion.provenance import hash_file

    values, form = given
    if form == "angles":
        raise FileFormatError(f"{path}: joint angles; --axis needs orientations")
    rotations = rotations_of(values, form)
    found = fit_orientation_surface(rotations, axis=axis)
    torsion = found.components(rotations)[:, 0]
    document = DondersSurfaceDocument(
        provenance=Provenance(
            "fit_orientation_surface", inputs={"postures": hash_file(path)}, choices={"form": form}
        ),
        axis=list(axis),
        reference=numbers(found.reference),
        frame=numbers(found.frame),
        terms=list(TERMS),
        coefficients=numbers(found.surface.coefficients),
        stderr=numbers(found.surface.stderr),
        thickness_deg=found.thickness_deg,
        torsion_deg=float(np.degrees(torsion.std())),
        orientations=len(rotations),
        form=form,
    )
    written = [] if out is None else [save(document, out, "donders-surface")]
    return finish(
        document, "\n".join([as_text(document), *(f"wrote {p}" for p in written)]), json=json
    )


def rotations_of(values: "np.ndarray", form: "Form") -> "np.ndarray":
    """Give matrices (K, 3, 3) from any form of orientation."""
    from selfmotion.motion.orientations import (
        matrices_from_quaternions,
        matrices_from_vectors,
        nearest_rotations,
    )

    if form == "quaternions":
        return matrices_from_quaternions(values)
    if form == "rotation vectors":
        return matrices_from_vectors(values)
    return nearest_rotations(values)


def as_text(document: DondersSurfaceDocument) -> str:
    """Write the surface as a person reads it."""
    lines = [
        f"{document.orientations} orientations ({document.form}), long axis {document.axis}",
        f"thickness {document.thickness_deg or 0.0:.2f} deg; torsion without a surface "
        f"{document.torsion_deg or 0.0:.2f} deg",
        "torsion (rad) over the two directions a, b (rad):",
    ]
    for term, value, error in zip(
        document.terms, document.coefficients, document.stderr, strict=True
    ):
        lines.append(f"  {term:3} {value or 0.0:9.4f} ± {error or 0.0:.4f}")
    return "\n".join(lines)
