"""A comparison in words: tables of three digits for terminals, Markdown and pages."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ._figures import FIGURES, Figure, Value

if TYPE_CHECKING:
    from .comparison import Comparison, Line

DIGITS = 3
WIDTH = 100
"""Columns of a terminal that a table fits."""

NAME = 26
"""Columns for the name of a controller."""

LESS = ("itae", "rms_tau", "rms_e", "recovery", "settling_time", "transfer_rms_e", "step_time")
"""What a table leaves out where it is too wide, first what is missed least."""


def digits(value: Value, figure: Figure) -> str:
    """A figure in the unit of its column: three digits, – if it does not apply."""
    if value is None:
        return "–"
    if math.isinf(value):
        return "never" if figure.unit == "s" else "∞"
    return rounded(value * figure.scale)


def rounded(value: float) -> str:
    """Three digits, without a power of ten where that is as short."""
    if value == 0.0 or math.isinf(value):
        return "0" if value == 0.0 else "∞"
    short = f"{value:.{DIGITS - 1}e}"
    exponent = int(short.split("e")[1])
    if not -3 <= exponent <= 5:
        return f"{short.split('e')[0]}e{exponent}"
    return f"{float(short):.{max(0, DIGITS - 1 - exponent)}f}"


def plain(text: str) -> str:
    """The text on one line, what a terminal would act on as an escape."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def used(lines: Sequence[Line]) -> list[Figure]:
    """The figures that some controller has, in order, the steady error first."""
    known = [
        figure
        for name, figure in FIGURES.items()
        if any(line.median[name] is not None for line in lines)
    ]
    return sorted(known, key=lambda figure: figure.name != "steady_rms_e")


def explained(line: Line) -> str:
    """What is to be said of a line beside its figures; empty if all of its runs finished."""
    if line.status == "finished":
        return ""
    share = "" if line.runs == 1 else f" ({line.finished} of {line.runs} finished)"
    reason = f": {plain(line.reason)}" if line.reason else ""
    return f"{line.status}{share}{reason}"


def done(line: Line) -> str:
    """How many of the runs finished."""
    return f"{line.finished}/{line.runs}"


def text(comparison: Comparison, sort: str | None) -> str:
    """The table for a terminal: medians, and of the steady error the worst too."""
    lines = comparison.table(sort)
    if not lines:
        return "no rows"
    figures = used(lines)
    several = any(line.runs > 1 for line in lines)
    names = min(NAME, max(_width(plain(line.controller)) for line in lines))
    dropped: list[Figure] = []
    for name in ("", *LESS):
        dropped += [figure for figure in figures if figure.name == name]
        figures = [figure for figure in figures if figure.name != name]
        body, head = _grid(lines, figures, several), _heads(figures, several)
        widths = [max(map(_width, column)) for column in zip(*head, *body, strict=True)]
        if names + sum(width + 2 for width in widths) <= WIDTH:
            break
    out = [_cells(" " * names, cells, widths) for cells in head]
    scenario = None
    for line, cells in zip(lines, body, strict=True):
        if line.scenario != scenario and (line.scenario or scenario is not None):
            out += ["", plain(line.scenario)]
        scenario = line.scenario
        out.append(_cells(_fit(plain(line.controller), names), cells, widths))
        out += _wrapped(explained(line))
    if several:
        out += ["", "Medians over the seeds."]
    if dropped:
        named = ", ".join(figure.head for figure in dropped)
        out += ["", f"Not shown: {named}; they are in the files."]
    for note in comparison.notes:
        out += ["", *_wrapped(plain(note), "")]
    return "\n".join(line.rstrip() for line in out)


def _heads(figures: Sequence[Figure], several: bool) -> list[list[str]]:
    """Two lines: name and unit."""
    names, units = [], []
    for figure in figures:
        worst = several and figure.name == "steady_rms_e"
        first, _, second = figure.head.rpartition(" ")
        names.append([first, second])
        units.append(f"[{figure.shown}]")
        if worst:
            names.append(["worst", "of it"])
            units.append(f"[{figure.shown}]")
    names.append(["", "done"])
    units.append("")
    return [[first for first, _ in names], [second for _, second in names], units]


def _grid(lines: Sequence[Line], figures: Sequence[Figure], several: bool) -> list[list[str]]:
    rows = []
    for line in lines:
        cells = []
        for figure in figures:
            cells.append(digits(line.median[figure.name], figure))
            if several and figure.name == "steady_rms_e":
                cells.append(digits(line.worst[figure.name], figure))
        rows.append([*cells, done(line)])
    return rows


def _cells(name: str, cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = (
        " " * (width - _width(cell)) + cell for cell, width in zip(cells, widths, strict=True)
    )
    return "  ".join([name, *padded])


def _wrapped(words: str, indent: str = "    ") -> list[str]:
    """Lines of at most `WIDTH` columns, set in by four."""
    lines: list[str] = []
    for word in words.split(" ") if words else ():
        while word:
            last = lines[-1] if lines else ""
            if lines and _width(last) + 1 + _width(word) <= WIDTH:
                lines[-1] = f"{last} {word}"
                break
            part = _clipped(word, WIDTH - len(indent))
            lines.append(f"{indent}{part}")
            word = word[len(part) :]
    return lines


def _fit(name: str, width: int) -> str:
    """The name in so many columns, its end cut off if need be."""
    if _width(name) > width:
        name = f"{_clipped(name, width - 1)}…"
    return name + " " * (width - _width(name))


def _clipped(text: str, width: int) -> str:
    """As much of the text as goes into so many columns, one character at the least."""
    taken = 0
    for place, character in enumerate(text):
        taken += _width(character)
        if taken > width and place:
            return text[:place]
    return text


def _width(text: str) -> int:
    """Columns of a terminal that a text takes."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return len(text) + wide - sum(unicodedata.combining(character) != 0 for character in text)


def markdown(comparison: Comparison, sort: str | None) -> str:
    """The table of `Comparison.to_markdown`."""
    lines = comparison.table(sort)
    figures = used(lines)
    out: list[str] = []
    if comparison.scenario and "\n" not in comparison.scenario:
        out += [f"**{_escaped(comparison.scenario)}**", ""]
    scenarios = list(dict.fromkeys(line.scenario for line in lines))
    for scenario in scenarios:
        if scenario:
            out += [f"### {_escaped(scenario)}", ""]
        heads = [f"{figure.head} [{figure.shown}]" for figure in figures]
        out += [f"| {' | '.join(['controller', *heads, 'finished'])} |"]
        out += [f"|{'|'.join(['---', *['---:'] * (len(heads) + 1)])}|"]
        group = [line for line in lines if line.scenario == scenario]
        for line in group:
            cells = [_both(line, figure) for figure in figures]
            out += [f"| {' | '.join([_escaped(line.controller), *cells, done(line)])} |"]
        told = [(line, explained(line)) for line in group]
        out += [""]
        out += [f"- {_escaped(line.controller)}: {_escaped(why)}" for line, why in told if why]
        out += [""] * any(why for _, why in told)
    if any(line.runs > 1 for line in lines):
        out += ["Medians over the seeds, in brackets the worst.", ""]
    out += [part for note in comparison.notes for part in (_escaped(note), "")]
    return "\n".join(out)


def _both(line: Line, figure: Figure) -> str:
    """The median, and the worst where it is another."""
    middle, worst = (digits(part[figure.name], figure) for part in (line.median, line.worst))
    return middle if middle == worst else f"{middle} ({worst})"


def _escaped(text: str) -> str:
    """Text that Markdown takes as it stands."""
    return "".join(f"\\{c}" if c in "\\`*_{}[]<>#|~$!&" else c for c in plain(text))
