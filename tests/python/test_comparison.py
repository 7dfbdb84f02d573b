"""Rows and tables of controllers: figures, aggregation, files, words."""

from __future__ import annotations

import dataclasses
import functools
import math
import random
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa
from comparisons import HOSTILE, VALUES, diverged, fake, row, run
from hypothesis import given
from hypothesis import strategies as st
from steadyarm.comparison import FIGURES, STATUSES, Comparison, Line, Row

INF = math.inf


def test_figures_are_those_of_plain_numpy() -> None:
    ran = run()
    made = row(window=(1.0, 3.0), band=0.05, effort_limit=(5.0, 2.0))
    t, e, tau = ran.t, np.abs(ran.e), ran.tau
    inside = (t >= 1.0) & (t <= 3.0)
    moved = np.abs(np.diff(tau[inside], axis=0)).sum(axis=0) / 2.0
    at = np.abs(tau) >= np.array([5.0, 2.0])
    for joint in range(2):
        want = {
            "rms_e": np.sqrt(np.mean(e[:, joint] ** 2)),
            "max_abs_e": e[:, joint].max(),
            "steady_rms_e": np.sqrt(np.mean(e[inside, joint] ** 2)),
            "itae": np.trapezoid(t * e[:, joint], t),
            "max_abs_tau": np.abs(tau[:, joint]).max(),
            "rms_tau": np.sqrt(np.mean(tau[inside, joint] ** 2)),
            "torque_variation": moved[joint],
            "saturated": at[:, joint].mean(),
        }
        got = {name: made.by_joint[name][joint] for name in want}
        assert got == pytest.approx(want, rel=1e-9)
    assert 0 < made.saturated < 1
    assert made.saturated == at.any(axis=1).mean()
    # Over all joints the error is the length of its vector: sum of squares under the root.
    assert made.rms_e == pytest.approx(np.sqrt(np.mean((e**2).sum(axis=1))), rel=1e-12)
    assert made.torque_variation == pytest.approx(moved.sum(), rel=1e-12)
    assert made.max_abs_e == pytest.approx(np.sqrt((e**2).sum(axis=1)).max(), rel=1e-12)
    # That of the torque is of the joint that works hardest.
    assert made.max_abs_tau == np.abs(tau).max() and made.rms_tau == max(made.by_joint["rms_tau"])
    assert made.settling_time == max(made.by_joint["settling_time"])
    assert made.itae == pytest.approx(np.trapezoid(t * e.sum(axis=1), t), rel=1e-9)


def test_computed_torque_on_the_papers_plant_has_the_published_error() -> None:
    # Two programs written apart give 0.1931 and 0.4479 rad for the second half of simulation 2.
    made = Row.of(sa.paper.simulation(2).run(), controller="computed torque")
    assert made.by_joint["steady_rms_e"] == pytest.approx((0.1931, 0.4479), abs=1e-4)
    assert made.steady_rms_e == pytest.approx(math.hypot(0.1931, 0.4479), abs=1e-4)


def signals(error: list[float], torque: list[float] | None = None) -> sa.Run:
    """A run of one joint, a sample a second."""
    e = np.array(error)[:, None]
    tau = np.zeros_like(e) if torque is None else np.array(torque)[:, None]
    return fake(np.arange(len(e), dtype=float), e, tau, e)


@pytest.mark.parametrize(
    ("error", "torque", "events", "want"),
    [
        ([1, 0, 0, 0, 0], [0, 0, 0, 0, 0], (), None),  # nothing to recover from
        ([1, 0, 0, 0, 0], [9, 0, 0, 0, 0], (), 1.0),
        ([1, 0, 0, 0, 0], [0, 0, 9, 0, 0], (), 0.0),  # it stayed in the band
        ([1, 0, 0, 1, 0], [9, 0, 9, 0, 0], (), 2.0),
        ([1, 0, 0, 1, 1], [9, 0, 9, 0, 0], (), INF),
        ([0, 0, 1, 1, 0], [0, 0, 0, 0, 0], (1.5,), 2.5),
        ([0, 0, 1, 1, 0], [0, 9, 0, 0, 0], (0.5,), 3.0),  # the last of both
        ([0, 0, 1, 1, 0], [0, 0, 0, 0, 0], (99.0,), None),  # after the end
    ],
)
def test_recovery_is_from_the_last_saturation_or_event(
    error: list[float], torque: list[float], events: tuple[float, ...], want: float | None
) -> None:
    made = Row.of(signals(error, torque), controller="x", band=0.5, effort_limit=9.0, events=events)
    assert made.recovery == want


def test_settling_is_never_where_the_error_leaves_the_band_at_the_end() -> None:
    assert Row.of(signals([1, 0, 0]), controller="x", band=0.5).settling_time == 1.0
    assert Row.of(signals([1, 0, 1]), controller="x", band=0.5).settling_time == INF


def test_no_rms_is_more_than_its_peak() -> None:
    for number in (1, 2, 3):
        made = Row.of(run(number), controller="x", window=(0.0, 4.0))
        assert made.steady_rms_e == made.rms_e < made.max_abs_e
        assert made.rms_tau < made.max_abs_tau


def test_frozen_and_transfer_are_steady_errors_of_their_runs() -> None:
    other, third = run(2), run(1)
    made = row(window=(2.0, 4.0), frozen=other, transfer=third, transfer_window=(3.0, 4.0))
    for name, ran, start in (("frozen_rms_e", other, 2.0), ("transfer_rms_e", third, 3.0)):
        want = np.sqrt(np.mean((ran.e[ran.t >= start] ** 2).sum(axis=1)))
        assert getattr(made, name) == pytest.approx(want, rel=1e-12)
    assert row().frozen_rms_e is None and row().transfer_rms_e is None


def test_a_run_that_diverges_when_learning_stops_says_so() -> None:
    assert row(frozen=diverged()).frozen_rms_e == INF


def test_a_run_that_did_not_reach_its_duration_has_reason_and_curves_and_no_figures() -> None:
    ran = diverged()
    made = Row.of(ran, controller="x", step_time=1e-6)
    assert made.status == "diverged"
    assert made.reason == f"at t = {ran.status.t:.6g} s because {ran.status.reason}"
    assert {name for name, value in made.figures().items() if value is not None} == {"step_time"}
    assert made.curves is not None and np.isfinite(made.curves.tau).all()
    assert "diverged: at t = " in str(Comparison([made]))


def test_a_record_of_the_motion_has_the_figures_of_the_error_alone() -> None:
    made = Row.of(run(record="motion"), controller="x", effort_limit=1.0)
    assert made.rms_e == row().rms_e
    assert made.max_abs_tau is None and made.saturated is None and "rms_tau" not in made.by_joint


def test_curves_are_short_and_keep_every_peak() -> None:
    t = 0.001 * np.arange(40001)
    noise = np.random.default_rng(1)
    e, tau = noise.normal(size=(40001, 3)) * 1e-3, noise.normal(size=(40001, 3))
    peaks = noise.integers(0, 40001, size=3)
    for joint, peak in enumerate(peaks):
        e[peak, joint], tau[(peak + 77) % 40001, joint] = -5.5, (-1) ** joint * 44.5
    curves = Row.of(fake(t, e, tau, tau), controller="x").curves
    assert curves is not None and curves.t.shape == (400,) and curves.e.shape == (400, 3)
    for joint, peak in enumerate(peaks):
        assert curves.e[:, joint].max() == 5.5
        assert abs(curves.t[curves.e[:, joint].argmax()] - t[peak]) <= 40.0 / 200
        assert np.abs(curves.tau[:, joint]).max() == 44.5
    assert (np.diff(curves.t) > 0).all()
    assert set(curves.q[:, 0]) <= {float(f"{value:.6g}") for value in tau[:, 0]}


@pytest.mark.parametrize("length", [1, 2, 3, 399, 400, 401, 799, 801])
def test_curves_of_short_runs_are_the_runs(length: int) -> None:
    t = np.arange(length, dtype=float)
    curves = Row.of(fake(t, t[:, None], t[:, None], t[:, None]), controller="x").curves
    assert curves is not None and len(curves.t) == min(length, 400)
    assert curves.e.max() == length - 1 and (np.diff(curves.t) > 0).all()


def test_lines_have_median_and_worst_over_the_seeds_and_the_worst_status() -> None:
    made = [Row("a", "s", k, rms_e=value) for k, value in enumerate((3.0, 1.0, INF, 2.0))]
    made += [Row("a", "s", 4, "unresolved", "dt", rms_e=9.0), Row("a", "s", 5, "diverged", "boom")]
    (line,) = Comparison(made).table()
    assert (line.runs, line.finished, line.status, line.reason) == (6, 4, "diverged", "boom")
    assert line.median["rms_e"] == 3.0 and line.worst["rms_e"] == INF
    assert line.median["itae"] is None and line.worst["itae"] is None


@given(st.lists(st.floats(0, 1e308), min_size=1, max_size=9))
def test_median_is_that_of_numpy(values: list[float]) -> None:
    line = Line.of([Row("a", seed=k, itae=value) for k, value in enumerate(values)])
    assert line.median["itae"] == pytest.approx(np.median(np.array(values) / 2) * 2, rel=1e-12)
    assert line.worst["itae"] == max(values)


def test_lines_are_sorted_by_steady_error_and_failures_come_last() -> None:
    values = {"b": 2.0, "a": 1.0, "none": None, "c": INF}
    made = [Row(name, "s", steady_rms_e=value) for name, value in values.items()]
    made += [Row("at times", "s", 0, steady_rms_e=0.1), Row("at times", "s", 1, "diverged")]
    made += [Row("refused", "s", 0, "refused", "no")]
    made += [dataclasses.replace(each, scenario="r") for each in made]

    def names(sort: str | None) -> list[str]:
        lines = Comparison(made).table(sort)
        assert [line.scenario for line in lines] == ["s"] * 6 + ["r"] * 6
        assert [line.controller for line in lines[:6]] == [line.controller for line in lines[6:]]
        return [line.controller for line in lines[:6]]

    assert names("steady_rms_e") == ["a", "b", "c", "none", "at times", "refused"]
    assert names("controller") == ["a", "at times", "b", "c", "none", "refused"]
    assert names(None) == ["b", "a", "none", "c", "at times", "refused"]
    with pytest.raises(ValueError, match="sort: got 'speed', wants controller, None, or one of"):
        Comparison(made).table("speed")


def test_tables_of_a_joint_can_be_asked_for() -> None:
    made = [Row(n, by_joint={"rms_e": (v, 1 - v)}) for n, v in (("a", 0.9), ("b", 0.1))]
    assert [line.controller for line in Comparison(made).table("rms_e_1")] == ["b", "a"]
    assert [line.controller for line in Comparison(made).table("rms_e_2")] == ["a", "b"]


def test_time_of_a_step_and_curves_do_not_make_rows_unequal() -> None:
    assert row(step_time=1e-6) == row(step_time=2e-6, curves=False)
    assert row() != row(seed=1)
    assert row() != dataclasses.replace(row(), rms_e=row().rms_e * (1 + 1e-15))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"controller": ""}, "controller: got '', wants a name"),
        ({"controller": "\ud800"}, "controller: got .*, wants text that UTF-8 can hold"),
        ({"controller": 3}, "controller: got 3, wants text"),
        ({"reason": "\udcff"}, "reason: got .*, wants text that UTF-8 can hold"),
        ({"seed": True}, "seed: got True, wants an int"),
        ({"status": "ok"}, "status: got 'ok', wants one of finished"),
        ({"rms_e": "1"}, "rms_e: got '1', wants a number or None"),
        ({"itae": np.ones(2)}, "itae: got .*, wants a number or None"),
        ({"by_joint": {"step_time": (1.0,)}}, "by_joint: got 'step_time', wants rms_e"),
    ],
)
def test_rows_that_make_no_sense_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        Row(**({"controller": "x"} | arguments))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"effort_limit": (1, 2, 3)}, r"effort_limit: got \(1, 2, 3\), wants a number > 0, or 2"),
        ({"effort_limit": 0.0}, "effort_limit: got 0.0, wants a number > 0"),
        ({"effort_limit": math.nan}, "effort_limit: got nan"),
        ({"window": (50.0, 60.0)}, r"window: got \(50, 60\), wants at least one sample"),
        ({"band": -1.0}, "band: got -1"),
    ],
)
def test_rows_of_runs_refuse_what_makes_no_sense(options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        row(**options)


def test_comparisons_refuse_what_is_no_row_or_note() -> None:
    with pytest.raises(TypeError, match=r"rows\[1\]: got str, wants a Row"):
        Comparison([row(), "row"])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="notes: got 'one', wants a list"):
        Comparison([], notes="one")


def test_nan_means_that_a_figure_does_not_apply() -> None:
    made = Row("x", itae=math.nan, rms_e=np.float64(2), by_joint={"itae": (1.0, math.nan)})
    assert made.itae is None and made.rms_e == 2.0 and made.by_joint == {"itae": (1.0,)}


@pytest.mark.parametrize("controllers", [1, 3])
def test_the_table_fits_a_terminal_whatever_the_names_and_numbers_are(controllers: int) -> None:
    made = [
        Row(name, name, seed, status, f"because {name}", **dict.fromkeys(FIGURES, value))
        for name in HOSTILE[: 3 * controllers]
        for seed, value in enumerate(VALUES)
        for status in STATUSES
    ]
    text = str(Comparison(made, notes=HOSTILE[3:4]))
    assert all(line.isprintable() for line in text.split("\n"))
    table = [line for line in text.split("\n") if "/54" in line or "[mrad]" in line]
    assert len(table) == 3 * controllers + 1 and max(map(len, table)) <= 100
    # What does not fit is said.
    assert "Not shown: " in text


def test_numbers_have_three_digits_where_people_read_them() -> None:
    made = [Row("a", steady_rms_e=0.487722, torque_variation=12345.6, saturated=0.5, itae=1e-9)]
    made += [Row("b", steady_rms_e=2.8e-4, settling_time=INF, frozen_rms_e=INF, step_time=7.3e-6)]
    first, second = str(Comparison(made)).splitlines()[3:5]
    assert second.split() == ["a", "488", "–", "1.00e-9", "12300", "50.0", "–", "–", "1/1"]
    assert first.split() == ["b", "0.280", "never", "–", "–", "–", "∞", "7.30", "1/1"]


def test_markdown_has_a_column_a_cell_whatever_the_names_are() -> None:
    made = [
        Row(name, "s", 0, status, name, rms_e=1.0) for name in HOSTILE for status in STATUSES[:2]
    ]
    text = Comparison(made, scenario="title", notes=["<b>"]).to_markdown()
    lines = [line for line in text.split("\n") if line.startswith("|")]
    bars = [line.replace("\\\\", "").replace("\\|", "").count("|") for line in lines]
    assert len(lines) == 2 + len(HOSTILE) and set(bars) == {4}
    assert "<script" not in text.replace("\\<", "")


def test_an_empty_comparison_is_a_comparison(tmp_path: Path) -> None:
    empty = Comparison([])
    assert str(empty) == "no rows" and empty.table() == [] and empty.to_markdown() == ""
    empty.to_csv(tmp_path / "a")
    assert Comparison.from_csv(tmp_path / "a") == empty
    empty.to_json(tmp_path / "a")
    assert Comparison.from_json(tmp_path / "a") == empty


def test_pandas_has_the_columns_of_the_csv(monkeypatch: pytest.MonkeyPatch) -> None:
    # pandas is not among the tests' packages: a class that keeps its arguments stands for it.
    class Frame:
        def __init__(self, lines: list[list[object]], columns: list[str]) -> None:
            self.lines, self.columns = lines, columns

    stand_in = type("pandas", (), {"DataFrame": Frame})
    monkeypatch.setattr("steadyarm._extras.import_module", lambda name: stand_in)
    frame: object = Comparison([row(seed=4)]).to_pandas()
    assert isinstance(frame, Frame)
    cells = dict(zip(frame.columns, frame.lines[0], strict=True))
    assert cells["seed"] == 4 and cells["rms_e_2"] == row().by_joint["rms_e"][1]
    assert frame.attrs["units"]["rms_e"] == "rad"


def test_the_order_of_seeds_does_not_change_the_numbers_of_a_table() -> None:
    made = [Row("a", "s", k, steady_rms_e=value) for k, value in enumerate((0.3, 0.1, 0.2, 0.15))]
    shuffled = random.Random(1).sample(made, 4)
    assert [str(Comparison(made))] == [str(Comparison(shuffled))]


def test_the_row_that_is_shown_is_that_of_the_median() -> None:
    curves = row().curves
    part = functools.partial(Row, "a", "s", curves=curves)
    made = [part(k, steady_rms_e=value) for k, value in enumerate((5.0, 1.0, 2.0))]
    assert Line.of(made).shown.seed == 2
    bare = [*made[:2], Row("a", "s", 2, steady_rms_e=2.0)]
    assert Line.of(bare).shown.curves is not None
    assert Line.of([part(0, "diverged"), Row("a", "s", 1)]).shown.seed == 0
