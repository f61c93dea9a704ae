"""Published numbers beside ours: one row a number, with a word on what may be compared."""

from dataclasses import dataclass

import pandas as pd

SAME = "same computation"
SAME_DATA = "same computation on the recordings given"
KIND = "same kind: recordings not at hand"
TREND = "same trend"
# Significant digits of our numbers; published ones are shown with all that are printed.
DIGITS, PRINTED_DIGITS = 3, 8


@dataclass(frozen=True)
class Published:
    """A number, or a few that belong together, as a paper prints it.

    Attributes:
        key: short name by which ours is filed.
        where: figure, table or section.
        quantity: what it is, in words.
        values: the printed numbers; True where the paper says that something is so.
        unit: their unit; empty for a pure number.
        needs: what ours would need, where it may be missing.
    """

    key: str
    where: str
    quantity: str
    values: tuple[float, ...]
    unit: str = ""
    needs: str = ""


@dataclass(frozen=True)
class Ours:
    """Our counterpart of a published number.

    Attributes:
        key: the published number that it stands beside.
        values: our numbers, in the same order.
        kind: `SAME`, `SAME_DATA`, `TREND` or `KIND`.
        note: a word on the difference.
    """

    key: str
    values: tuple[float, ...]
    kind: str
    note: str

    @property
    def comparable(self) -> bool:
        """Whether the two numbers ought to agree."""
        return self.kind in (SAME, SAME_DATA, TREND)


def beside(published: tuple[Published, ...], ours: tuple[Ours, ...]) -> pd.DataFrame:
    """Put each published number beside ours.

    Returns:
        Columns where, quantity, unit, published, ours (text: numbers parted by commas),
        comparable, kind, note; a number without counterpart has an empty `ours` and says so.
    """
    found = {o.key: o for o in ours}
    rows = []
    for p in published:
        o = found.get(p.key)
        rows.append(
            {
                "where": p.where,
                "quantity": p.quantity,
                "unit": p.unit,
                "published": as_text(p.values, PRINTED_DIGITS),
                "ours": as_text(o.values) if o else "",
                "comparable": o.comparable if o else False,
                "kind": o.kind if o else "not computed",
                "note": o.note if o else p.needs,
            }
        )
    return pd.DataFrame(rows)


def as_text(values: tuple[float, ...], digits: int = DIGITS) -> str:
    """Write numbers with significant digits, parted by commas; unknown ones as a dash.

    Example:
        >>> as_text((0.123456, True, float("nan")))
        '0.123, yes, –'
    """
    return ", ".join("–" if v != v else _short(v, digits) for v in values)


def _short(value: float, digits: int) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value == 0 or 1e-3 <= abs(value) < 1e4:
        return f"{value:.{digits}g}"
    return f"{value:.1e}"


KHORAMSHAHI2022 = (
    Published("split_equal", "eq. 13", "[0, 1] with W = I: task part", (0.5, 0.5)),
    Published("split_weighted", "eq. 14", "the same with W = diag(1, 1/9)", (0.1, 0.9)),
    Published("example_1_error", "Fig 1", "mean norm of the final weight error", (0.07,)),
    Published(
        "gamma_monotone", "Fig 2", "γ = 0 converges fastest; γ = 1 never updates", (True, True)
    ),
    Published("example_2_zero", "Fig 3", "weights found with γ = 0", (0.0, 1.0)),
    Published("example_2_high", "Fig 3", "weights found with γ = 0.9 (the true ones)", (1.0, 0.01)),
    Published("example_2_threshold", "Fig 3", "γ above which the weights converge", (0.5,)),
    Published("noise", "S1 File", "the final error grows with null-space noise σ", (True,)),
    Published("beta_natural", "Section 5", "β of q₁ to q₄, Natural", (0.04, 0.27, 0.65, 0.04)),
    Published("beta_viscous", "Section 5", "β of q₁ to q₄, Viscous", (0.09, 0.68, 0.14, 0.09)),
    Published("hotelling_t2", "Fig 6", "Hotelling's T², Natural against Viscous", (225.3,)),
    Published("hotelling_f", "Fig 6", "F (2, 15)", (105.6,)),
    # The paper prints "p = 0.000"; F(2, 15) = 105.6 gives this.
    Published("hotelling_p", "Fig 6", "p of F (2, 15) = 105.6 (printed: 0.000)", (1.5e-9,)),
    Published(
        "null_smaller",
        "Fig 7",
        "null-space velocity smaller with identified weights than with W = I, Natural and Viscous",
        (True, True),
    ),
    Published(
        "null_reversal",
        "Fig 7",
        "Viscous uses the null space more with identified weights; Natural with W = I",
        (True, True),
    ),
    Published(
        "table1_natural", "Table 1", "Natural: β of hip, shoulder, elbow", (0.01, 0.01, 0.98)
    ),
    Published("table1_locked", "Table 1", "Locked: β of hip, shoulder, elbow", (0.15, 0.72, 0.13)),
    Published(
        "table1_coupled", "Table 1", "Coupled: β of hip, shoulder, elbow", (0.62, 0.08, 0.30)
    ),
    Published(
        "table1_assistive", "Table 1", "Assistive: β of hip, shoulder, elbow", (0.05, 0.12, 0.83)
    ),
)
