"""Figures of a report that answer to the mouse: plotly, its script inside the page.

A page with at least one of them is 5 MB larger, since it fetches nothing.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import plotly.graph_objects as go

# Text that can be read on light and dark pages.
TEXT = "#7a828c"
HEIGHT = 560


@dataclass(frozen=True, eq=False)
class Interactive:
    """An interactive figure with what stands below it.

    Attributes:
        figure: the drawing.
        caption: one or two sentences below it: also how to use it.
        alt: what it shows, in words, for people who do not see it.
    """

    figure: "go.Figure"
    caption: str
    alt: str


def interactive_html(chart: Interactive, name: str, *, with_script: bool) -> str:
    """Give a chart as a piece of HTML.

    Args:
        chart: what to show.
        name: id of its element, unique in the page.
        with_script: whether plotly's script comes with it: once in a page.
    """
    from html import escape

    chart.figure.update_layout(
        height=HEIGHT,
        margin={"l": 0, "r": 0, "t": 60, "b": 0},
        paper_bgcolor="rgba(0,0,0,0)",
        font={"color": TEXT, "size": 12},
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": TEXT},
    )
    text = chart.figure.to_html(
        full_html=False,
        include_plotlyjs=with_script,
        div_id=name,
        config={"displaylogo": False, "responsive": True},
    )
    label = escape(chart.alt, quote=True)
    return f'<div role="img" aria-label="{label}">{text}</div>'
