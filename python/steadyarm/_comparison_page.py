"""A comparison as a page of one file: a table that needs no script, and pictures that do."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from . import _comparison_data, _html, _page, _pareto
from ._comparison_words import digits, done, explained, plain, used
from ._figures import Figure, Value

if TYPE_CHECKING:
    from .comparison import Comparison, Line

TITLE = "Comparison of controllers"


def page(comparison: Comparison, arm: Any, sort: str | None) -> str:
    """The whole page."""
    lines = comparison.table(sort)
    groups = _groups(lines)
    title = comparison.scenario if _short(comparison.scenario) else TITLE
    body = [f"<h1>{_html.text(title)}</h1>", *_notes(comparison)]
    for number, (scenario, group) in enumerate(groups.items()):
        body += ["<section>"]
        body += [f"<h2>{_html.text(scenario)}</h2>"] * bool(scenario)
        body += [_table(group, f"caption-{number}", _caption(scenario, lines), sort)]
        body += [_told(group), _pareto.drawn(group, number), "</section>"]
    data = _comparison_data.collected(groups, arm)
    if any(scene["curves"] for scene in data["scenes"]):
        body += [_page.part("_comparison.html"), _page.data(data)]
    if comparison.scenario and not _short(comparison.scenario):
        told = _lines(comparison.scenario)
        body += [f"<details><summary>The scenario</summary><pre>{told}</pre></details>"]
    body += [_page.script("_comparison.js")]
    return _page.document(title, ["_comparison.css"], body)


def fragment(comparison: Comparison, sort: str | None) -> str:
    """The tables alone, for a notebook."""
    lines = comparison.table(sort)
    parts = []
    for number, (scenario, group) in enumerate(_groups(lines).items()):
        parts += [_table(group, f"caption-{number}", _caption(scenario, lines), sort)]
        parts += [_told(group)]
    return _html.joined([*parts, *_notes(comparison)])


def _groups(lines: Sequence[Line]) -> dict[str, list[Line]]:
    """The lines of each scenario."""
    groups: dict[str, list[Line]] = {}
    for line in lines:
        groups.setdefault(line.scenario, []).append(line)
    return groups


def _caption(scenario: str, lines: Sequence[Line]) -> str:
    where = f" in the scenario {plain(scenario)}" if scenario else ""
    seeds = "; medians over the seeds, below them the worst" if _several(lines) else ""
    return f"What each controller did{where}: the less, the better{seeds}."


def _several(lines: Sequence[Line]) -> bool:
    return any(line.runs > 1 for line in lines)


def _table(lines: Sequence[Line], name: str, caption: str, sort: str | None) -> str:
    """One scenario's table."""
    figures = used(lines)
    order = ' aria-sort="ascending"'
    heads = [
        _html.head("controller", attributes=order * (sort == "controller")),
        *(
            _html.head(
                figure.head,
                figure.shown,
                f'{order * (figure.name == sort)} title="{escape(figure.doc)}"',
            )
            for figure in figures
        ),
        _html.head("done", attributes=' title="how many of the runs finished"'),
    ]
    rows = []
    for line in lines:
        cells = [_cell(line, figure) for figure in figures]
        head = f'<th scope="row">{_html.text(line.controller)}</th>'
        end = f'<td data-value="{line.finished}">{done(line)}</td>'
        rows.append(f'<tr class="{line.status}">{head}{"".join(cells)}{end}</tr>')
    return _html.table(caption, heads, rows, name)


def _cell(line: Line, figure: Figure) -> str:
    """The median, and below it the worst where it is another; all digits are in the title."""
    middle, worst = line.median[figure.name], line.worst[figure.name]
    shown, beside = digits(middle, figure), digits(worst, figure)
    small = "" if shown == beside else f"<small>{beside}</small>"
    value = "" if middle is None else f' data-value="{middle!r}"'
    return f'<td{value} title="{escape(_all(line, figure))}">{shown}{small}</td>'


def _all(line: Line, figure: Figure) -> str:
    """All digits of the median, over all joints and of each."""
    parts = [f"{figure.head}: {_full(line.median[figure.name])} {figure.unit}"]
    joint = 1
    while f"{figure.name}_{joint}" in line.median:
        parts += [f"joint {joint}: {_full(line.median[f'{figure.name}_{joint}'])}"]
        joint += 1
    return "; ".join(parts)


def _full(value: Value) -> str:
    return "–" if value is None else f"{value:.6g}"


def _told(lines: Sequence[Line]) -> str:
    """What is to be said of lines that did not finish."""
    told = [(line.controller, explained(line)) for line in lines if explained(line)]
    if not told:
        return ""
    items = [f"<li><strong>{_html.text(name)}</strong> {escape(why)}</li>" for name, why in told]
    return "\n".join(['<ul class="told">', *items, "</ul>"])


def _notes(comparison: Comparison) -> list[str]:
    return [f"<p>{_html.text(note)}</p>" for note in comparison.notes]


def _short(text: str) -> bool:
    return bool(text) and "\n" not in text


def _lines(words: str) -> str:
    """Text of several lines that a page shows as it stands."""
    return "\n".join(_html.text(line) for line in words.splitlines())
