"""Pictures as inline SVG: no external reference, no clashing names, readable on light and dark."""

import io
import re

import matplotlib
from matplotlib.figure import Figure

from selfmotion.report.theme import GRID, INK, STYLE

_FONT = "system-ui, -apple-system, 'Segoe UI', 'DejaVu Sans', sans-serif"


def inline_svg(figure: Figure, prefix: str, *, label: str) -> str:
    """Render a figure as an `<svg>` element to stand inside an HTML page.

    Text stays text. Ink and grid follow the colours of the page (`currentColor` and the custom
    property ``--grid``), so that the picture can be read on a dark page too.

    Args:
        figure: what to render.
        prefix: put before every id in the picture; unique within the page.
        label: what a screen reader says; plain text.
    """
    from html import escape

    buffer = io.StringIO()
    with matplotlib.rc_context(STYLE):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\sxmlns(?::\w+)?="[^"]*"', "", svg)
    svg = svg.replace("xlink:href", "href")
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", svg)
    svg = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', svg)
    svg = re.sub(re.escape(INK), "currentColor", svg, flags=re.IGNORECASE)
    svg = re.sub(re.escape(GRID), "var(--grid)", svg, flags=re.IGNORECASE)
    svg = svg.replace("'DejaVu Sans'", _FONT)
    width, height = figure.get_size_inches() * 96.0
    opening = (
        f'<svg role="img" aria-label="{escape(label, quote=True)}" '
        f'style="max-width: {width:.0f}px" viewBox="0 0 {width * 0.75:.3f} {height * 0.75:.3f}">'
    )
    return opening + svg[svg.index(">") + 1 :].strip()


def write_png(figure: Figure, path: str, *, dpi: int = 150) -> None:
    """Write a figure as a PNG file on white paper."""
    with matplotlib.rc_context(STYLE):
        figure.savefig(path, dpi=dpi, facecolor="white")
