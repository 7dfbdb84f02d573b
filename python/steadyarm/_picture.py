"""A figure of matplotlib that needs no pyplot, in a style, and as wide as a journal wants it."""

from __future__ import annotations

import textwrap
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import _files
from ._look import SMALL, TEXT, TITLE, look_of

WIDTH = 7.16
"""Two columns of a journal [in]."""

NARROWEST, WIDEST = 2.0, 40.0

DPI = 150
"""Dots per inch of pictures in files."""

NOTEBOOK = 120
"""Dots per inch in a notebook."""

TYPES = {"pdf.fonttype": 42, "ps.fonttype": 42, "svg.fonttype": "none", "hatch.linewidth": 0.5}
"""Files of vectors keep letters as text."""

LETTER, LINE = 0.053, 0.16
"""Width of a letter of a legend and height of its line [in]."""

HEAD = 12.5
"""Letters of a heading an inch."""


class Picture(Figure):
    """A matplotlib figure that needs no pyplot, and still shows itself in a notebook."""

    def __init__(
        self, width: float | None = None, height: float = 4.0, style: str = "light"
    ) -> None:
        self.look = look_of(style)
        size = (wide(width), height)
        super().__init__(figsize=size, dpi=DPI, layout="constrained", facecolor=self.look.paper)
        pads = {"w_pad": 0.03, "h_pad": 0.03, "wspace": 0.0, "hspace": 0.0}
        self.get_layout_engine().set(**pads)  # type: ignore[union-attr]

    @property
    def wide(self) -> float:
        """The width [in]."""
        return float(self.get_size_inches()[0])

    def head(self, words: str, alarm: bool = False) -> None:
        """Write above all panels."""
        lines = [textwrap.fill(line, int(HEAD * self.wide)) for line in words.splitlines()]
        told, look = literal("\n".join(lines)), self.look
        colour = look.orange if alarm else look.ink
        self.suptitle(told, color=colour, fontsize=TITLE + 1, fontweight="bold")
        self.higher(LINE * (told.count("\n") + 1))

    def frame(self, axes: Axes) -> None:
        """Draw a frame as all pictures have it."""
        look = self.look
        axes.set_facecolor(look.paper)
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set(color=look.gray, linewidth=0.6)
        axes.grid(color=look.faint, linewidth=0.5)
        axes.set_axisbelow(True)
        axes.tick_params(
            color=look.gray, labelcolor=look.ink, labelsize=SMALL, width=0.6, length=2.5, pad=2.0
        )
        for axis in (axes.xaxis, axes.yaxis):
            axis.label.set(color=look.ink, fontsize=TEXT)
            axis.labelpad = 2.0
            axis.get_offset_text().set_fontsize(SMALL)
        axes.margins(y=0.08)

    def explain(self, keys: dict[str, Artist]) -> None:
        """Put the legend below all panels, once."""
        if not keys:
            return
        longest = max(map(len, keys))
        columns = min(len(keys), max(1, int(self.wide / (0.42 + LETTER * longest))))
        self.legend(
            keys.values(), keys.keys(), loc="outside lower center", ncols=columns, frameon=False,
            fontsize=SMALL, labelcolor=self.look.ink, handlelength=2.4, columnspacing=1.2,
            borderpad=0.1, labelspacing=0.25,
        )  # fmt: skip
        self.higher(LINE * -(-len(keys) // columns))

    def higher(self, by: float) -> None:
        """Make room [in]."""
        self.set_figheight(self.get_figheight() + by)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write the picture, as any matplotlib figure does; a file is replaced as a whole."""
        with matplotlib.rc_context(TYPES):  # type: ignore[arg-type]
            if not isinstance(fname, str | PathLike):
                super().savefig(fname, **options)
                return
            path = Path(fname)
            form = options.pop("format", None) or path.suffix[1:].lower()
            if not form:
                form = matplotlib.rcParams["savefig.format"]
                path = path.with_name(f"{path.name}.{form}")
            drawn = BytesIO()
            super().savefig(drawn, format=form, **options)
        _files.content(path, drawn.getvalue())

    def _repr_png_(self) -> bytes:
        """The picture, for notebooks."""
        png = BytesIO()
        self.savefig(png, format="png", dpi=NOTEBOOK)
        return png.getvalue()

    def show(self, warn: bool = True) -> None:
        """Open a window and wait until it is closed (matplotlib 3.11 or newer, with a display)."""
        from matplotlib import pyplot

        if self.canvas.manager is None:
            if not hasattr(matplotlib, "__version_info__") or matplotlib.__version_info__ < (3, 11):
                raise RuntimeError(
                    f"show: matplotlib is {matplotlib.__version__}, a window wants 3.11 or newer; "
                    'use .savefig("run.png")'
                )
            pyplot.figure(self)
        pyplot.show()


def wide(width: float | None) -> float:
    """The width of a picture, that of two columns by default [in]."""
    if width is None:
        return WIDTH
    if isinstance(width, bool) or not isinstance(width, float | int):
        raise TypeError(f"width: got {width!r:.80}, wants inches")
    if not NARROWEST <= width <= WIDEST:
        raise ValueError(f"width: got {width:g}, wants {NARROWEST:g} to {WIDEST:g} inches")
    return float(width)


def literal(text: str) -> str:
    """Text in which matplotlib sees no mathematics."""
    return text.replace("$", r"\$")
