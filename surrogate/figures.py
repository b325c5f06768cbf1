"""Figures of the surrogate: written whole, with the stamp of data that no certificate vouches for."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

from surrogate.gate import UNVALIDATED
from surrogate.whole_file import write_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RED, GREY, BLUE = "#b2182b", "#777777", "#2166ac"
FRAME_COLOURS = ("#d62728", "#2ca02c", "#1f77b4")  # x, y, z axes of a section


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, in inches; no display and no global state."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, path: Path, certificate: str) -> None:
    """Write a figure; the stamp UNVALIDATED is printed on it. The suffix of the path chooses the format."""
    if certificate == UNVALIDATED:
        figure.text(0.5, 0.5, UNVALIDATED, ha="center", va="center", fontsize=40, color=RED, alpha=0.25)
    content = io.BytesIO()
    figure.savefig(content, format=path.suffix[1:], dpi=120)
    write_bytes(path, content.getvalue())
