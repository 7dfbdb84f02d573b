"""Tables for notebooks and pages: heads, units, names of joints, and text below.

Everything is escaped. Colours are those of the notebook or page, light or dark.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

from ._comparison_words import plain, rounded
from ._joints import in_length, title

WIDE = "overflow-x:auto"
"""A table wider than the page moves by itself."""


WHOLE = 1e6
"""Smaller whole numbers are counts, and shown as they are."""


class Entry(NamedTuple):
    """A row of a table: a figure, one a joint."""

    name: str
    unit: str
    values: Iterable[object]
    """Numbers, or texts."""


def text(words: str) -> str:
    """Text that a page shows as it stands, on one line."""
    return escape(plain(words))


def head(words: str, unit: str = "", attributes: str = "") -> str:
    """The head of a column."""
    return f'<th scope="col"{attributes}>{_with_unit(words, unit)}</th>'


def table(caption: str, heads: Iterable[str], rows: Iterable[str], name: str = "") -> str:
    """A table of heads and rows; one with a ``name`` is called by its caption."""
    region = f' class="wide" tabindex="0" role="region" aria-labelledby="{name}"' if name else ""
    label = f' id="{name}"' if name else ""
    parts = [
        f'<div{region} style="{WIDE}"><table>',
        f"<caption{label}><span>{escape(caption)}</span></caption>",
        "<thead><tr>", *heads, "</tr></thead>",
        "<tbody>", *rows, "</tbody></table></div>",
    ]  # fmt: skip
    return "\n".join(parts)


def by_joint(
    caption: str, names: Sequence[str], figures: Iterable[Entry], lengths: Sequence[str] = ()
) -> str:
    """A table with a column a joint.

    ``names``: of the joints; ``lengths``: what each moves in, "rad" or "m", which units of figures
    follow. A joint that has another unit than the first says so in its cells.
    """
    heads = [head(""), *(head(title(name)) for name in names)]
    lengths = lengths or ("rad",) * len(names)
    return table(caption, heads, (_row(figure, lengths) for figure in figures))


def listed(heading: str, sentences: Iterable[str]) -> str:
    """Sentences below a table; nothing where there are none."""
    items = "".join(f"<li>{text(sentence)}</li>" for sentence in sentences)
    return f"<p><strong>{text(heading)}</strong></p>\n<ul>{items}</ul>" if items else ""


def joined(parts: Iterable[str]) -> str:
    """Parts of a page, without those that are empty."""
    return "\n".join(part for part in parts if part)


def _row(figure: Entry, lengths: Sequence[str]) -> str:
    units = [in_length(figure.unit, length) for length in lengths]
    cells = []
    for value, unit in zip(figure.values, units, strict=True):
        shown, whole = _number(value, figure.unit)
        beside = f" {escape(unit)}" if unit != units[0] else ""
        cells.append(f'<td style="text-align:right"{whole}>{shown}{beside}</td>')
    first = _with_unit(figure.name, units[0])
    return f'<tr><th scope="row" style="text-align:left">{first}</th>{"".join(cells)}</tr>'


def _with_unit(words: str, unit: str) -> str:
    known = f" <small>[{escape(unit)}]</small>" if unit not in ("", "1") else ""
    return text(words) + known


def _number(value: object, unit: str) -> tuple[str, str]:
    """A number in three digits, and all of them as the title of its cell."""
    if isinstance(value, str):
        return text(value), ""
    number = float(value)  # type: ignore[arg-type]
    if math.isnan(number):
        return "–", ""
    if math.isinf(number):
        return ("never" if unit == "s" else rounded(number)), ""
    shown = f"{number:.0f}" if number.is_integer() and abs(number) < WHOLE else rounded(number)
    return shown, f' title="{number:.6g}"'
