"""Error against torque variation of the controllers of a scenario, drawn without a script."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from ._comparison_words import digits, plain, rounded
from ._figures import FIGURES

if TYPE_CHECKING:
    from .comparison import Line

ERROR, EFFORT = FIGURES["steady_rms_e"], FIGURES["torque_variation"]

WIDTH, HEIGHT = 720, 380
LEFT, RIGHT, TOP, BOTTOM = 62, 16, 30, 52
LETTER = 6.6
"""Width of a letter of a label."""

Place = tuple[float, float]


def drawn(lines: Sequence[Line], number: int) -> str:
    """The plot; nothing where fewer than two controllers have both figures."""
    known = [line for line in lines if has_both(line)]
    if len(known) < 2:
        return ""
    x = Axis([value_of(line, EFFORT.name) for line in known], LEFT, WIDTH - RIGHT)
    y = Axis([value_of(line, ERROR.name) * ERROR.scale for line in known], HEIGHT - BOTTOM, TOP)
    places = [
        (x.place(value_of(line, EFFORT.name)), y.place(value_of(line, ERROR.name) * ERROR.scale))
        for line in known
    ]
    best = [not any(beats(other, line) for other in known) for line in known]
    front = sorted(place for place, is_best in zip(places, best, strict=True) if is_best)
    title, label = f"pareto-{number}", f"{ERROR.head} of the error [{ERROR.shown}]"
    parts = [
        f'<figure class="pareto"><svg viewBox="0 0 {WIDTH} {HEIGHT}" role="group" '
        f'aria-labelledby="{title}">',
        f'<title id="{title}">Steady error against torque variation</title>',
        *(_tick(x.place(v), HEIGHT - BOTTOM, brief(v), upright=True) for v in x.ticks()),
        *(_tick(LEFT, y.place(v), brief(v), upright=False) for v in y.ticks()),
        f'<text class="name" x="{(LEFT + WIDTH - RIGHT) / 2:.0f}" y="{HEIGHT - 8}" '
        f'text-anchor="middle">torque variation [{EFFORT.shown}]</text>',
        f'<text class="name" x="4" y="18">{label}</text>',
        f'<polyline class="front" points="{" ".join(f"{a:.1f},{b:.1f}" for a, b in front)}"/>',
        *_points(known, places, best),
        "</svg><figcaption>Down and to the left is better. No other controller has both less "
        "error and less torque variation than those on the line. Point at a mark, or tap it, for "
        "its name and figures.</figcaption></figure>",
    ]
    return "\n".join(parts)


def _points(lines: Sequence[Line], places: Sequence[Place], best: Sequence[bool]) -> list[str]:
    """A mark for each controller; its name stands beside it where there is room."""
    taken = [(a - 6, b - 6, a + 6, b + 6) for a, b in places]
    parts = []
    order = sorted(range(len(lines)), key=lambda k: (not best[k], places[k]))
    for k in order:
        (a, b), line = places[k], lines[k]
        name = plain(line.controller)
        short = name if len(name) <= 30 else f"{name[:29]}…"
        width = LETTER * len(short)
        left = a + 12 + width > WIDTH - RIGHT
        box = (
            (a - 10 - width, b - 8, a - 8, b + 8) if left else (a + 8, b - 8, a + 10 + width, b + 8)
        )
        free = box[0] >= LEFT and not any(meet(box, other) for other in taken)
        if free:
            taken.append(box)
        kind = " ".join(["point", *["best"] * best[k], *["named"] * free])
        told = f"{name}: {_said(line)}"
        at = f'x="{a - 10:.1f}" text-anchor="end"' if left else f'x="{a + 10:.1f}"'
        parts.append(
            f'<g class="{kind}" tabindex="0" role="img" aria-label="{escape(told)}">'
            f'<title>{escape(told)}</title><circle cx="{a:.1f}" cy="{b:.1f}" r="5"/>'
            f'<text {at} y="{b + 4:.1f}">{escape(short)}</text></g>'
        )
    return parts


def brief(value: float) -> str:
    """The value of a tick."""
    digits, power, exponent = rounded(value).partition("e")
    digits = digits.rstrip("0").rstrip(".") if "." in digits else digits
    return digits + power + exponent


def _said(line: Line) -> str:
    error, effort = digits(line.median[ERROR.name], ERROR), digits(line.median[EFFORT.name], EFFORT)
    return f"{error} {ERROR.shown}, {effort} {EFFORT.shown}"


def value_of(line: Line, name: str) -> float:
    return line.median[name] or 0.0


def has_both(line: Line) -> bool:
    """Whether both figures are there, and have logarithms that a page can place."""
    values = (line.median[name] for name in (ERROR.name, EFFORT.name))
    return all(value is not None and 1e-30 < value < 1e30 for value in values)


def beats(one: Line, other: Line) -> bool:
    """Whether one has no more of error and variation than the other, and less of either."""
    pairs = [(value_of(one, name), value_of(other, name)) for name in (ERROR.name, EFFORT.name)]
    return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)


def meet(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


class Axis:
    """A logarithmic axis from one place on the page to another, with room at both ends."""

    def __init__(self, values: Sequence[float], start: float, end: float) -> None:
        low, high = math.log10(min(values)), math.log10(max(values))
        room = max(0.07 * (high - low), 0.08)
        self.low, self.high, self.start, self.end = low - room, high + room, start, end

    def place(self, value: float) -> float:
        """Where a value is on the page."""
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """Round values on the axis, some three to nine."""
        low, high = 10.0**self.low, 10.0**self.high
        if self.high - self.low < 0.6:
            unit = 10.0 ** math.floor(math.log10(high - low))
            step = next(
                k * unit for k in (0.1, 0.2, 0.5, 1.0, 2.0) if (high - low) / (k * unit) < 8
            )
            return [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
        span = self.high - self.low
        factors = (1,) if span > 2.5 else (1, 3) if span > 1.6 else (1, 2, 5)
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        values = [factor * 10.0**decade for decade in decades for factor in factors]
        found = [value for value in values if low <= value <= high]
        return found[:: max(1, math.ceil(len(found) / 9))]


def _tick(x: float, y: float, text: str, upright: bool) -> str:
    """A line across the plot, and its value."""
    if upright:
        line = f'x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"'
        place = f'x="{x:.1f}" y="{y + 16:.1f}" text-anchor="middle"'
    else:
        line = f'x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"'
        place = f'x="{x - 6:.1f}" y="{y + 4:.1f}" text-anchor="end"'
    return f'<line class="grid" {line}/><text class="tick" {place}>{text}</text>'
