"""How figures look, and how a matplotlib figure becomes inline SVG whose ids do not collide "
"with another's."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito: told apart with every common colour vision, and by lightness in grey print.
BLUE, ORANGE, GREEN, RED, VIOLET, SKY = "#0072B2", "#D55E00", "#009E73", "#B2182B", "#6A51A3", "#56B4E9"
INK, MUTED, FAINT = "#1c2128", "#5d6873", "#c9d0d6"
# Marker, colour and line of each element, in every figure.
ELEMENT_MARKS = {
    "3333": ("o", BLUE, "-"),
    "3243": ("s", ORANGE, "--"),
    "3363": ("^", VIOLET, "-"),
    "3343": ("v", RED, "-"),
    "cable": ("P", SKY, "-"),
}
AXES = {"r_x": ORANGE, "r_y": GREEN, "r_z": BLUE}

SETTINGS: Any = {
    "svg.fonttype": "none",  # text stays text: small files, searchable, the page's own font
    "svg.hashsalt": "ancf-report",
    "font.family": "sans-serif",
    "font.sans-serif": ["Helvetica", "Arial", "DejaVu Sans"],
    "font.size": 10,
    "axes.titlesize": 10.5,
    "axes.labelsize": 10,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "grid.color": "#e3e7eb",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.8,
    "lines.markersize": 5.5,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
}


@contextmanager
def styled() -> Iterator[None]:
    """Figures made inside share one look; matplotlib is loaded here, without a display."""
    import matplotlib

    matplotlib.use("svg")
    with matplotlib.rc_context(SETTINGS):
        yield


def new_figure(width: float, height: float) -> Figure:
    """A figure of a size in inches that belongs to no window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def to_svg(figure: Figure, name: str, title: str) -> Markup:
    """Inline SVG that scales with the page; `title` is what a screen reader says."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = own_ids(text, name)
    opening = text[: text.index(">") + 1]
    width, height = (float(v) for v in re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', opening).groups())  # type: ignore[union-attr]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" class="plot" '
        f'viewBox="0 0 {width:g} {height:g}" width="{width * 4 / 3:.0f}" role="img" '
        f'aria-label="{Markup.escape(title)}">'
    )
    return Markup(head + text[len(opening) :])


def own_ids(svg: str, name: str) -> str:
    """Put a prefix before every id of a drawing, so that many can share one page."""
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{name}-\1)", svg)
    return re.sub(r'href="#([^"]+)"', rf'href="#{name}-\1"', svg)
