"""A run as a page of one file: the arm in motion, its errors and torques, its figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core, _html, _page, _view_data
from ._comparison_words import digits
from ._figures import FIGURES, Figure
from ._joints import in_length, title
from ._places import joint_points
from .metrics import UNITS

if TYPE_CHECKING:
    from .run import Run

HIGH, LOW = 830, 420
"""How high a notebook shows the page [px], with an arm and without."""


def page(run: Run, arm: Any, against: Any) -> str:
    """The whole page."""
    runs = _named(run, against)
    arms = _arms(runs, arm)
    data = _view_data.collected(runs, arms)
    figures = ["<h2>In figures</h2>", _table(runs, data["joints"])]
    return _document(runs, arms, data, figures)


def fragment(run: Run) -> str:
    """The figures, and the rest of the page in a frame of its own, for a notebook."""
    runs = _named(run, None)
    arms = _arms(runs, None)
    data = _view_data.collected(runs, arms)
    high = LOW if arms[0] is None else HIGH
    style = f"width:100%;height:{high}px;border:1px solid #8886;border-radius:6px;resize:vertical"
    return (
        f'<iframe title="A run in motion" sandbox="allow-scripts" style="{style}" '
        f'srcdoc="{escape(_document(runs, arms, data, []))}"></iframe>\n'
        f"{_table(runs, data['joints'])}"
    )


def _document(
    runs: Mapping[str, Run], arms: Sequence[Any], data: dict[str, Any], below: list[str]
) -> str:
    title = _title(next(iter(runs.values())), next((one for one in arms if one is not None), None))
    body = [f"<h1>{_html.text(title)}</h1>", _told(runs, arms), _page.part("_view.html")]
    body += [_page.data(data), *below, _page.script("_view.js")]
    return _page.document(title, ["_view.css"], body)


def _named(run: Run, against: Any) -> dict[str, Run]:
    """All runs of a page by name, the first one first."""
    from .run import Run

    first, other = _called(run), {}
    if isinstance(against, Run):
        name = _called(against)
        other = {f"{name} (2)" if name == first else name: against}
    elif isinstance(against, Mapping):
        other = {str(name): one for name, one in against.items()}
    elif against is not None:
        raise TypeError(f"against: got {type(against).__name__}, wants a Run, or Runs by name")
    for name, one in other.items():
        if not isinstance(one, Run):
            raise TypeError(f"against[{name!r}]: got {type(one).__name__}, wants a Run")
        if one.joints != run.joints:
            raise ValueError(f"against: got a run of {one.joints} joints, wants {run.joints}")
    while first in other:
        first = f"{first} (1)"
    return {first: run, **other}


def _called(run: Run) -> str:
    """What the controller of a run is called."""
    if run._made is None:
        return "run"
    ((kind, said),) = run._made.parts["tracker"].items()
    if kind == "ComputedTorque":
        return "computed torque" + " and compensator" * (said["compensator"] is not None)
    law = said["law"]
    name = law.get("law", law.get("callable", kind)) if isinstance(law, Mapping) else law
    return str(name if isinstance(name, str) else type(name).__name__).replace("_", " ")


def _arms(runs: Mapping[str, Run], arm: Any) -> list[Any]:
    """The arm of each run: the one given, or its plant's; None where nobody knows it."""
    if arm is not None:
        joint_points(arm)
        joints = next(iter(runs.values())).joints
        if arm.joints != joints:
            raise ValueError(f"arm: got {arm.joints} joints, wants {joints}")
        return [arm] * len(runs)
    made = [run._made for run in runs.values()]
    return [None if scene is None else scene.plant(disturbance=[]).arm for scene in made]


def _title(run: Run, arm: Any) -> str:
    """The robot and how long it moved."""
    robot = "Two-link arm" if isinstance(arm, _core.TwoLink) else getattr(arm, "name", "")
    robot = robot or f"Arm of {run.joints} joints"
    return f"{robot}, {run.t[-1] - run.t[0]:.4g} s"


def _told(runs: Mapping[str, Run], arms: Sequence[Any]) -> str:
    """What each run is: how it ended, what was recorded of it, and its notes."""
    items = []
    for (name, run), arm in zip(runs.items(), arms, strict=True):
        said = [
            f"{run.status}".rstrip("."),
            f"{len(run.t)} row{'s' * (len(run.t) != 1)} of {run.joints} joints",
        ]
        if not len(run.tau):
            said.append("the motion alone was recorded, and no torque")
        if arm is None:
            said.append("the run does not say which arm moved: give arm= to see it")
        kind = "" if run.status.finished else ' class="bad"'
        notes = "".join(f"<li>{_html.text(note)}</li>" for note in run.notes)
        items.append(
            f"<li{kind}><strong>{_html.text(name)}</strong>: "
            f"{'; '.join(map(_html.text, said))}.{f'<ul>{notes}</ul>' if notes else ''}</li>"
        )
    return "\n".join(['<ul class="told">', *items, "</ul>"])


def _table(runs: Mapping[str, Run], joints: list[dict[str, str]]) -> str:
    """The metrics of every run, joint by joint."""
    several = len(runs) > 1
    heads = [_html.head("figure"), *(_html.head(title(joint["name"])) for joint in joints)]
    rows = []
    measured = {name: run.metrics() for name, run in runs.items()}
    for name in UNITS:
        figure = FIGURES[name]
        for run, metrics in measured.items():
            values = getattr(metrics, name)
            if not len(values):
                continue
            whose = f'<small class="whose">{_html.text(run)}</small>' if several else ""
            unit = f"<small>[{escape(_unit(figure, joints))}]</small>"
            cells = "".join(_cell(value, figure) for value in values.tolist())
            rows.append(f'<tr><th scope="row">{figure.head} {unit}{whose}</th>{cells}</tr>')
    caption = "Over the whole run, joint by joint: the less, the better."
    return _html.table(caption, heads, rows)


def _cell(value: float, figure: Figure) -> str:
    known = None if np.isnan(value) else value
    return f'<td title="{value * figure.scale:.6g}">{digits(known, figure)}</td>'


def _unit(figure: Figure, joints: list[dict[str, str]]) -> str:
    """The unit of a row; those of prismatic joints too, if there are any."""
    lengths = sorted({joint["length"] for joint in joints}, reverse=True)
    return " or ".join(dict.fromkeys(in_length(figure.shown, length) for length in lengths))
