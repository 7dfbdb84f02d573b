"""Every rival on the paper's plant: one table, and what it shows in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from statistics import median

from ._comparison_words import rounded
from .bench import compare
from .comparison import Comparison, Row
from .reproduction import INERT, WORKS

IDEAL, SENSORS = "paper_rivals", "paper_sensors"
"""Scenarios: ideal sensors and the arm's start as it is; sensors, a late sample and hand-over."""

ALONE, PRINTED, PD = "computed_torque", "fuzzy_printed", "pd"
"""The controllers that the sentences are about."""

CHATTERS = 10.0
"""A torque that varies so many times as much as that of computed torque chatters."""

FAR = 2.0
"""A peak of so many times the median of all is far above the others."""

Rows = Mapping[str, Row]


def rivals() -> Comparison:
    """Run both scenarios, and say what they show."""
    rows = [row for scenario in (IDEAL, SENSORS) for row in compare(scenario).rows]
    return Comparison(rows, "Every rival on the paper's plant", sentences(rows))


def sentences(rows: list[Row]) -> list[str]:
    """What the table shows about the paper's claim, and at what torque."""
    ideal, sensors = (
        {row.controller: row for row in rows if row.scenario == scenario and row.finished}
        for scenario in (IDEAL, SENSORS)
    )
    said = [
        _working("Ideal sensors, from the arm's own start", ideal),
        _working("With sensors, a sample late, and hand-over", sensors),
        _printed(ideal),
        _starts(ideal, sensors),
        _chatter(sensors),
        _learnt(sensors),
        _refused(rows),
    ]
    return [sentence for sentence in said if sentence]


def _working(where: str, rows: Rows) -> str:
    """Who takes the error away, and with what peak."""
    if ALONE not in rows:
        return ""
    alone = rows[ALONE]
    working = [row for row in rows.values() if _steady(row) <= _steady(alone) / WORKS]
    working.sort(key=_peak)
    usual = FAR * median(map(_peak, rows.values()))
    near = _listed([row for row in working if _peak(row) <= usual], _at_peak)
    far = [row for row in working if _peak(row) > usual]
    also = f"; at peaks far above those, {_listed(far, _at_peak)}" if far else ""
    return (
        f"{where}: computed torque leaves {_mrad(alone)} mrad at a peak of {_at_peak(alone)}. "
        f"The paper claims that the error goes away; to 1/{WORKS:g} and less it does with "
        f"{near}{also}."
    )


def _printed(rows: Rows) -> str:
    """What the printed method does, and that a PD does more."""
    if not {ALONE, PRINTED} <= set(rows):
        return ""
    alone, printed = rows[ALONE], rows[PRINTED]
    change = _steady(printed) / _steady(alone) - 1.0
    effect = "is inert" if abs(change) < INERT else f"changes the error by {100 * change:.0f} %"
    said = f"The printed method {effect}: {_mrad(printed)} mrad at {_at_peak(printed)}."
    if PD not in rows:
        return said
    pd = rows[PD]
    beats = "beats" if _steady(pd) < _steady(printed) else "does not beat"
    return f"{said} A PD without a model {beats} it: {_mrad(pd)} mrad at {_at_peak(pd)}."


def _starts(ideal: Rows, sensors: Rows) -> str:
    """That large peaks are the start."""
    if not ideal or not sensors:
        return ""
    begun, handed = (sorted(map(_peak, rows.values())) for rows in (ideal, sensors))
    middle = rounded(median(begun)), rounded(median(handed))
    return (
        "The arm starts far off its path, and the largest torques are those of its start: "
        f"{middle[0]} N·m in the median of all controllers, {rounded(begun[-1])} at the most. With "
        f"hand-over the median is {middle[1]} N·m."
    )


def _chatter(rows: Rows) -> str:
    """Whose torque chatters."""
    if ALONE not in rows:
        return ""
    usual = _variation(rows[ALONE])
    chatter = [row for row in rows.values() if _variation(row) >= CHATTERS * usual]
    chatter.sort(key=_variation)
    return (
        "Chatter is the price of laws that switch, and of high gains on a velocity made of "
        f"encoder steps: torque varies by {rounded(usual)} N·m/s with computed torque, by "
        f"{CHATTERS:g} times that and more with "
        f"{_listed(chatter, lambda row: rounded(_variation(row)))}."
    )


def _learnt(rows: Rows) -> str:
    """What survives when learning stops."""
    if ALONE not in rows:
        return ""
    learning = [row for row in rows.values() if row.frozen_rms_e is not None]
    keeps = [row for row in learning if (row.frozen_rms_e or 0.0) <= _steady(rows[ALONE]) / WORKS]
    kept = _listed(keeps, lambda row: f"{_mrad(row, 'frozen_rms_e')} mrad")
    return f"Of the {len(learning)} that adapt these still work when learning stops: {kept}."


def _refused(rows: list[Row]) -> str:
    """Who is refused by a condition of its own."""
    refused = [row for row in rows if row.status == "refused"]
    if not refused:
        return ""
    names = ", ".join(f"{row.controller} in {row.scenario}" for row in refused)
    return f"Refused by a condition of their own: {names}."


def _listed(rows: list[Row], told: Callable[[Row], str]) -> str:
    return ", ".join(f"{row.controller} ({told(row)})" for row in rows) or "none"


def _steady(row: Row) -> float:
    return float("inf") if row.steady_rms_e is None else row.steady_rms_e


def _variation(row: Row) -> float:
    return row.torque_variation or 0.0


def _peak(row: Row) -> float:
    return row.max_abs_tau or 0.0


def _at_peak(row: Row) -> str:
    return f"{rounded(_peak(row))} N·m"


def _mrad(row: Row, figure: str = "steady_rms_e") -> str:
    return rounded(1e3 * (getattr(row, figure) or 0.0))
