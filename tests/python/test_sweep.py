"""Sweeps: plans, rows, resuming, refusals, pictures."""

from __future__ import annotations

import functools
import json
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.dataset
import pytest
import steadyarm as sa
import sweep_jobs as jobs
from steadyarm import _sweep_folder
from steadyarm._sweep_plan import plan_of
from steadyarm._sweep_pools import Processes
from steadyarm._sweep_source import source_of

GRID = {"scale": np.linspace(1.0, 2.0, 3), "kp": [8.0, 16.0]}


def same(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """To the bit, NaN too."""
    return one.keys() == other.keys() and all(
        one[it].tobytes() == other[it].tobytes() for it in one
    )


def rows_of(folder: Path) -> list[int]:
    """The numbers of all rows in all files, as any program reads them."""
    table = pyarrow.dataset.dataset(folder, format="parquet")
    return sorted(table.to_table(columns=["index"])["index"].to_pylist())


def test_a_grid_has_all_combinations_the_last_input_fastest_and_seeds_fastest_of_all() -> None:
    plan = plan_of({"a": [1, 2], "b": ["x", "y", "z"]}, [7, 9])
    points = plan.points(np.arange(plan.rows))
    wanted = [{"a": a, "b": b, "seed": s} for a in (1, 2) for b in "xyz" for s in (7, 9)]
    assert points == wanted
    assert [type(value) for value in points[0].values()] == [int, str, int]


def test_a_hypercube_has_a_point_in_every_part_of_each_range() -> None:
    cube = sa.LatinHypercube(50, {"a": (0.0, 1.0), "b": (-5.0, 5.0)}, seed=3)
    columns = plan_of(cube, None).columns(np.arange(50))
    for values, (low, high) in zip(columns.values(), cube.ranges.values(), strict=True):
        parts = np.floor(50 * (values - low) / (high - low)).astype(int)
        assert sorted(parts) == list(range(50))
    again = plan_of(sa.LatinHypercube(50, cube.ranges, seed=3), None)
    assert same(again.columns(np.arange(50)), columns)


def test_a_list_has_its_points_in_its_order() -> None:
    given = [{"a": 1, "b": "x"}, {"b": "y", "a": 2.5}]
    points = plan_of(given, None).points(np.arange(2))
    assert points == [{"a": 1.0, "b": "x"}, {"a": 2.5, "b": "y"}]


@pytest.mark.parametrize(
    ("over", "seeds", "words"),
    [
        ({"a": []}, None, "over['a']: got []"),
        ({"a": [1, "x"]}, None, "int and str, wants values of one kind"),
        ({"a": [np.nan]}, None, "got NaN"),
        ({"a": "abc"}, None, "wants a list of values"),
        ({"status": [1]}, None, "got the name 'status'"),
        ({"a": [[1, 2]]}, None, "wants numbers or words"),
        ([{"a": 1}, {"b": 1}], None, "over[1]: got b, wants a as the first"),
        ([], None, "wants lists of values by name"),
        ({"a": [2**53 + 1, 0.5]}, None, "beyond 2^53 beside others"),
        ({"a": [1]}, 0, "seeds"),
        ({"a": [1]}, [4, 4], "seeds: got [4, 4], wants each once"),
        ({"a": np.arange(10**5), "b": np.arange(10**5)}, None, "at most 1000000000"),
    ],
)
def test_plans_that_make_no_sense_are_refused(over: Any, seeds: Any, words: str) -> None:
    with pytest.raises((ValueError, TypeError)) as refused:
        plan_of(over, seeds)
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("points", "ends", "words"),
    [
        (0, (0.0, 1.0), "points: got 0"),
        (True, (0.0, 1.0), "points: got True"),
        (4, ("low", "high"), "ranges['a']: got ('low', 'high'), wants (from, to)"),
        (4, (1.0, 1.0), "from < to"),
    ],
)
def test_a_hypercube_that_is_none_is_refused(points: Any, ends: Any, words: str) -> None:
    with pytest.raises(ValueError) as refused:
        sa.LatinHypercube(points, {"a": ends})
    assert words in str(refused.value)
    assert plan_of(sa.LatinHypercube(np.int64(4), {"a": (0.0, 1.0)}), None).rows == 4


def test_a_function_that_wants_to_leave_loses_its_row_alone(tmp_path: Path) -> None:
    found = sa.sweep(jobs.leaving, {"row": range(3)}, out=tmp_path).table()
    assert found["status"].tolist() == ["finished", "raised", "finished"]
    assert found["reason"][1] == "SystemExit: 3"


def test_another_function_without_a_name_is_another_sweep(tmp_path: Path) -> None:
    sa.sweep(lambda a: {"b": a + 1}, {"a": [1]}, out=tmp_path)
    with pytest.raises(ValueError, match="function"):
        sa.sweep(lambda a: {"b": a + 2}, {"a": [1]}, out=tmp_path)
    for wraps in (lambda it: it, functools.cache):
        steps = [wraps(lambda a, *, step=step: {"b": a + step}) for step in (1, 2)]
        held = [wraps(_adds(step)) for step in (1, 2)]
        for folder, (one, other) in (("defaults", steps), ("held", held)):
            out = tmp_path / folder / str(wraps is functools.cache)
            sa.sweep(one, {"a": [1]}, out=out)
            sa.sweep(one, {"a": [1]}, out=out)
            with pytest.raises(ValueError, match="function"):
                sa.sweep(other, {"a": [1]}, out=out)


def _adds(step: int) -> Any:
    return lambda a: {"b": a + step}


def test_a_row_is_what_the_function_returns_and_what_raises_loses_its_row_alone(
    tmp_path: Path,
) -> None:
    found = sa.sweep(jobs.product, {"a": range(6), "b": [0.5, 2.0]}, out=tmp_path)
    columns = found.table()
    assert columns["index"].tolist() == list(range(12))
    bad = columns["a"] == 3
    assert (columns["status"] == np.where(bad, "raised", "finished")).all()
    assert (columns["reason"] == np.where(bad, "ValueError: three is bad", "")).all()
    product = columns["a"] * columns["b"]
    assert np.array_equal(columns["product"], np.where(bad, np.nan, product), equal_nan=True)
    assert columns["word"].tolist()[:2] == ["0", "0"] and columns["word"][6] == ""
    assert np.isnan(columns["even"][:8]).all() and columns["even"][8:].tolist() == [1, 1, 0, 0]
    assert set(columns["version"]) == {sa.__version__}
    first, *_, last = found.worst(3, by="product")
    assert (first.index, first.status, last.value) == (6, "raised", 10.0)
    assert last.again == "sweep_jobs.product(a=5, b=2.0)"


def test_rows_are_the_runs_of_simulate_to_the_bit(tmp_path: Path) -> None:
    found = sa.sweep(jobs.arguments, GRID, seeds=2, out=tmp_path)
    columns = found.table()
    for row in (1, 11):
        point = {name: columns[name][row].item() for name in ("scale", "kp", "seed")}
        made = jobs.arguments(**point)
        window = made.pop("window")
        metrics = sa.simulate(**made).metrics(window=window)
        for name in ("rms_e", "max_abs_tau", "torque_variation"):
            assert [columns[f"{name}_{n}"][row] for n in (1, 2)] == getattr(metrics, name).tolist()
        assert columns["rms_e"][row] == pytest.approx(np.hypot(*metrics.rms_e), rel=1e-15)
    assert found.units["rms_e_1"] == "rad" and found.units["max_abs_tau"] == "N·m"
    assert found.figures[0] == "rms_e"
    assert found.to_pandas().loc[11, "rms_e_1"] == columns["rms_e_1"][11]


def test_the_table_is_the_same_from_threads_processes_and_any_chunks(tmp_path: Path) -> None:
    def swept(name: str, **given: Any) -> dict[str, Any]:
        return sa.sweep(jobs.arguments, GRID, seeds=3, out=tmp_path / name, **given).table()

    wanted = swept("here")
    with ThreadPoolExecutor(3) as threads:
        assert same(swept("threads", executor=threads, chunk_seconds=1e-3), wanted)
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        assert same(swept("pool", executor=pool, chunk_seconds=0.01), wanted)
    assert same(swept("processes", executor="processes"), wanted)


def test_a_second_call_computes_what_is_missing_and_nothing_else(tmp_path: Path) -> None:
    over, calls = {"a": range(20)}, []

    def counted(a: int) -> dict[str, int]:
        calls.append(a)
        if len(calls) == 9:
            raise KeyboardInterrupt
        return {"twice": 2 * a}

    first = sa.sweep(counted, over, out=tmp_path, chunk_seconds=1e-9)
    assert len(first) and first.missing == 20 - len(first)
    assert "call again" in str(first)
    (tmp_path / f".{'0123456789abcdef' * 2}.parquet").write_bytes(b"half of a file")
    there, before = set(first.table()["a"].tolist()), len(calls)
    second = sa.sweep(counted, over, out=tmp_path)
    assert sorted(calls[before:]) == sorted(set(range(20)) - there)
    assert second.missing == 0 and rows_of(tmp_path) == list(range(20))
    assert second.table()["twice"].tolist() == [2 * a for a in range(20)]
    assert not list(tmp_path.glob(".*.parquet"))
    third = sa.sweep(counted, over, out=tmp_path)
    assert len(calls) == before + 20 - len(there) and same(third.table(), second.table())


def test_a_row_that_ctrl_c_cut_short_is_not_kept(tmp_path: Path) -> None:
    found = sa.sweep(jobs.stopped, {"number": range(20)}, out=tmp_path)
    assert found.missing == 15
    assert (found.table()["square"] >= 0).all()


@pytest.mark.parametrize(
    ("function", "over", "seeds", "words"),
    [
        (jobs.product, {"a": range(3), "b": [2.0]}, None, "over['b']: there 1.0, here 2.0"),
        (jobs.product, {"a": range(4), "b": [1.0]}, None, "rows: there 3, here 4"),
        (jobs.product, {"b": [1.0], "a": range(3)}, None, "order, the slowest first"),
        (jobs.total, {"a": range(3), "b": [1.0]}, None, "function: there sweep_jobs.product"),
        (jobs.product, {"a": range(3), "b": [1.0]}, 1, "over['seed']: there none, here 0"),
    ],
)
def test_another_sweep_is_not_mixed_into_a_folder(
    function: Any, over: Any, seeds: Any, words: str, tmp_path: Path
) -> None:
    sa.sweep(jobs.product, {"a": range(3), "b": [1.0]}, out=tmp_path)
    before = sa.Sweep.read(tmp_path).table()
    with pytest.raises(ValueError) as refused:
        sa.sweep(function, over, seeds=seeds, out=tmp_path)
    assert words in str(refused.value)
    assert same(sa.Sweep.read(tmp_path).table(), before)


def test_rows_of_another_version_are_not_mixed_into_a_folder(tmp_path: Path) -> None:
    sa.sweep(jobs.product, {"a": range(3), "b": [1.0]}, out=tmp_path)
    plan = json.loads((tmp_path / _sweep_folder.PLAN).read_text(encoding="utf-8"))
    (tmp_path / _sweep_folder.PLAN).write_text(json.dumps(plan | {"steadyarm": "0.0.1"}))
    with pytest.raises(ValueError, match=r"steadyarm: there 0\.0\.1, here"):
        sa.sweep(jobs.product, {"a": range(3), "b": [1.0]}, out=tmp_path)


@pytest.mark.parametrize(
    ("one", "other"), [(["a, b", "c"], ["a", "b, c"]), ([1, 2], ["1", "2"]), ([True], ["True"])]
)
def test_plans_that_print_alike_are_told_apart(one: Any, other: Any, tmp_path: Path) -> None:
    sa.sweep(jobs.named, {"word": one}, out=tmp_path / "a")
    with pytest.raises(ValueError, match="has another sweep; over"):
        sa.sweep(jobs.named, {"word": other}, out=tmp_path / "a")


def test_files_that_are_not_of_the_sweep_stay(tmp_path: Path) -> None:
    mine = tmp_path / ".mine.parquet"
    mine.write_text("mine")
    sa.sweep(jobs.named, {"word": ["a"]}, out=tmp_path)
    assert mine.read_text() == "mine"


def test_inputs_with_the_names_of_figures_are_refused_row_by_row(tmp_path: Path) -> None:
    table = sa.sweep(jobs.misnamed, {"rms_e_1": [1.0, 2.0]}, out=tmp_path).table()
    assert table["rms_e_1"].tolist() == [1.0, 2.0]
    assert set(table["status"]) == {"raised"}
    assert "which a figure of the runs has" in table["reason"][0]


def test_runs_share_a_call_only_where_their_options_are_the_same_to_the_bit(tmp_path: Path) -> None:
    begins = [0.05, np.nextafter(0.05, 1.0)]
    together = sa.sweep(jobs.windowed, {"begin": begins}, out=tmp_path / "a").table()
    for place, begin in enumerate(begins):
        alone = sa.sweep(jobs.windowed, {"begin": [begin]}, out=tmp_path / f"{place}").table()
        assert together["rms_e_1"][place] == alone["rms_e_1"][0]
    assert together["rms_e_1"][0] != together["rms_e_1"][1]


@pytest.mark.parametrize(
    ("over", "seeds", "words"),
    [
        (
            {"a": [1.0], "c": [2.0]},
            None,
            "over: got a, c, wants the inputs of sweep_jobs.total(a: ",
        ),
        ({"a": [1.0]}, None, "missing a required argument: 'b'"),
        ({"a": [1.0], "b": [2.0]}, 2, "got an unexpected keyword argument 'seed'"),
        ({}, None, "over: got none, wants the inputs of sweep_jobs.total"),
    ],
)
def test_inputs_that_the_function_does_not_take_are_refused_at_once(
    over: Any, seeds: Any, words: str, tmp_path: Path
) -> None:
    with pytest.raises(TypeError) as refused:
        sa.sweep(jobs.total, over, seeds=seeds, out=tmp_path / "rows")
    assert words in str(refused.value)
    assert not (tmp_path / "rows").exists()


def test_a_plan_without_inputs_has_one_row(tmp_path: Path) -> None:
    assert sa.sweep(jobs.constant, {}, out=tmp_path).table()["y"].tolist() == [1.0]


def test_words_that_no_row_can_have_lose_their_row_alone(tmp_path: Path) -> None:
    table = sa.sweep(jobs.said, {"place": [0, 1, 2]}, out=tmp_path).table()
    assert table["status"].tolist() == ["raised", "raised", "well"]


def test_figures_that_make_no_sense_lose_their_row(tmp_path: Path) -> None:
    given = [{"a": 1.0}, 5, {"x": [1, 2]}, {"row": 1.0}, {"index": 1.0}, {"status": 3}, {"x": None}]
    found = sa.sweep(lambda row: given[row], {"row": range(len(given))}, out=tmp_path).table()
    assert found["status"].tolist() == ["finished"] + ["raised"] * 6
    assert "wants figures by name" in found["reason"][1]
    assert "which is no name of a figure" in found["reason"][3]


def test_a_run_that_is_refused_loses_its_row_and_not_its_chunk(tmp_path: Path) -> None:
    def some(row: int) -> dict[str, Any]:
        made = jobs.arguments(1.0, 16.0, row)
        return made | ({"q0": (1, 2, 3)} if row == 2 else {"rho": 1} if row == 3 else {})

    found = sa.sweep(some, {"row": range(5)}, out=tmp_path).table()
    assert found["status"].tolist() == [*["finished"] * 2, *["raised"] * 2, "finished"]
    assert "rho: is no argument" in found["reason"][3]
    alone = sa.sweep(some, {"row": [4]}, out=tmp_path / "alone").table()
    assert alone["rms_e"][0] == found["rms_e"][4]


def test_words_and_numbers_of_one_figure_are_words(tmp_path: Path) -> None:
    def either(row: int) -> dict[str, Any]:
        return {"x": "none" if row % 6 == 5 else row / 4}

    for seconds in (1e-9, 10.0):
        found = sa.sweep(
            either, {"row": range(12)}, out=tmp_path / str(seconds), chunk_seconds=seconds
        )
        assert found.table()["x"].tolist()[3:7] == ["0.75", "1.0", "none", "1.5"]


def test_who_computes_is_told_apart_from_what_cannot(tmp_path: Path) -> None:
    over = {"number": range(3)}
    for executor in ("thread", "dask://", 3):
        with pytest.raises(ValueError, match="executor: got"):
            sa.sweep(jobs.slow, over, executor=executor, out=tmp_path)
    with pytest.raises(ValueError, match="wants a function at the top of a module"):
        sa.sweep(lambda number: {}, over, executor="processes", out=tmp_path)
    with pytest.raises(ValueError, match="chunk_seconds: got 0"):
        sa.sweep(jobs.slow, over, chunk_seconds=0.0, out=tmp_path)
    with pytest.raises(TypeError, match="wants a function, a Scenario"):
        sa.sweep(3, over, out=tmp_path)  # type: ignore[arg-type]
    with pytest.raises(FileNotFoundError, match="no sweep is in it"):
        sa.Sweep.read(tmp_path / "nothing")


def test_a_broken_file_is_named(tmp_path: Path) -> None:
    sa.sweep(jobs.slow, {"number": range(3)}, out=tmp_path)
    file = next(tmp_path.glob("rows-*.parquet"))
    file.write_bytes(b"PAR1")
    with pytest.raises(ValueError, match=f"{file.name}: is no table of rows"):
        sa.sweep(jobs.slow, {"number": range(3)}, out=tmp_path)


# scenarios

SCENE = """
title = "Short"
[robot]
file = "ur5e"
armature = 0.1
[reference.sines]
frequency = 2.0
sin = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]
[effects]
noise = 1e-5
[run]
duration = 0.1
control_period = 0.001
[controllers.pid]
law = "pid"
bandwidth = 10.0
[controllers.computed_torque]
law = "computed_torque"
bandwidth = 10.0
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def test_inputs_of_a_scenario_are_keys_of_its_file(file: Path, tmp_path: Path) -> None:
    over = {"payload": [0, 1.5], "controller": ["pid", "computed_torque"], "noise": [1e-4]}
    found = sa.sweep(file, over, seeds=[5], out=tmp_path / "out")
    loaded = SCENE.replace("noise = 1e-5", "noise = 1e-4") + (
        "[actual.payload]\nmass = 1.5\ncom = [0.0, 0.0, 0.05]\n"
    )
    scene = sa.Scenario.of(sa.read_scenario(loaded))
    wanted = scene.simulate("pid", seed=5).metrics(window=(0.05, 0.1)).rms_e
    assert [found.table()[f"rms_e_{n}"][2] for n in range(1, 7)] == wanted.tolist()
    assert found.table()["controller"].tolist() == ["pid", "computed_torque"] * 2
    assert len(set(found.table()["rms_e"].tolist())) == 4


def test_inputs_of_a_scenario_as_an_object_are_its_fields(file: Path, tmp_path: Path) -> None:
    scene = sa.Scenario.read(file)
    over = {"controller": ["pid"], "effects.noise": [1e-4], "controllers.pid.bandwidth": [20.0]}
    found = sa.sweep(scene, over, seeds=[5], out=tmp_path / "object").table()
    over = {"controller": ["pid"], "noise": [1e-4], "bandwidth": [20.0]}
    assert found["rms_e"] == sa.sweep(file, over, seeds=[5], out=tmp_path / "file").table()["rms_e"]
    line = sa.Sweep.read(tmp_path / "object").worst(1)[0].again
    names = {"sa": sa, "scene": scene}
    again = eval(line.replace("'again'", repr(str(tmp_path / "again"))), names).table()
    assert again["rms_e"] == found["rms_e"]


@pytest.mark.parametrize(
    ("over", "words"),
    [
        ({"noize": [1.0]}, "over['noize']: wants controller, bandwidth, payload"),
        ({"effects.noize": [1.0]}, "effects.noize: unknown field"),
        ({"delay": [1]}, "over['delay']: wants effects.delay or front.delay"),
        ({"controller": ["nobody"]}, "over['controller']: got 'nobody', wants some of"),
        ({"noise": [-1.0, -2.0]}, "noise: got -1"),
        ({"controllers.pid.kp": [1.0]}, "computed_torque, has none; choose others"),
        ({"title.x": [1.0]}, "title.x: title is no section"),
    ],
)
def test_inputs_that_a_scenario_does_not_have_are_refused_before_the_work(
    over: Any, words: str, file: Path, tmp_path: Path
) -> None:
    with pytest.raises(ValueError) as refused:
        sa.sweep(file, over, out=tmp_path / "out")
    assert words in str(refused.value)
    assert not (tmp_path / "out").exists()
    with pytest.raises(ValueError, match="the scenario has name, nominal"):
        sa.sweep(sa.Scenario.read(file), {"noise": [1.0]}, out=tmp_path / "out")


def test_a_controller_that_its_condition_refuses_keeps_its_row(file: Path, tmp_path: Path) -> None:
    over = {"controller": ["pid"], "bandwidth": [10.0, 4000.0]}
    found = sa.sweep(file, over, out=tmp_path / "out").table()
    assert found["status"].tolist() == ["finished", "refused"]
    assert found["reason"][1]


def test_a_row_of_a_scenario_is_computed_again_from_the_folder_alone(
    file: Path, tmp_path: Path
) -> None:
    found = sa.sweep(file, {"payload": [0.5, 2.0]}, seeds=2, out=tmp_path / "out")
    file.unlink()
    worst = found.worst(1)[0]
    assert worst.again == f"steadyarm sweep {tmp_path / 'out'} --only {worst.index}"
    row, alike = found.repeated(worst.index)
    assert alike and row["rms_e"] == worst.value and row["payload"] == worst.inputs["payload"]


def test_one_thread_writes_to_a_folder_at_a_time(tmp_path: Path) -> None:
    with (
        _sweep_folder.Folder.opened(tmp_path, {}),
        ThreadPoolExecutor() as pool,
        pytest.raises(RuntimeError, match="another sweep writes"),
    ):
        pool.submit(sa.sweep, jobs.named, {"word": ["a"]}, out=tmp_path).result()


def test_one_call_writes_to_a_folder_at_a_time(tmp_path: Path) -> None:
    pytest.importorskip("fcntl")
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        with _sweep_folder._locked(tmp_path / ".lock"):
            refused = pool.submit(sa.sweep, jobs.slow, {"number": [1]}, out=tmp_path).exception()
        assert "another sweep writes" in str(refused)
        assert len(pool.submit(sa.sweep, jobs.slow, {"number": [1]}, out=tmp_path).result()) == 1


# pictures and tables


def test_pictures_show_the_medians_of_what_finished(tmp_path: Path) -> None:
    over = {"left": [1.0, 2.0, 4.0], "right": ["a", "b"]}
    found = sa.sweep(jobs.of_two, over, out=tmp_path)
    picture = found.plot("right", "left")
    mesh, *_ = picture.axes[0].collections
    drawn = np.ma.filled(mesh.get_array(), np.nan).reshape(3, 2)
    assert np.array_equal(drawn, [[10, 10], [100, 100], [1e4, np.nan]], equal_nan=True)
    assert "1 of 6 rows did not finish" in picture.get_suptitle()
    bands = found.plot("right").axes[0]
    assert [tick.get_text() for tick in bands.get_xticklabels()] == ["a", "b"]
    assert bands.lines[0].get_ydata().tolist() == [100.0, 55.0]
    for given in ({"x": "nobody"}, {"value": "nobody"}, {"y": "nobody"}):
        with pytest.raises(ValueError, match="got 'nobody', wants one of"):
            found.plot(**given)


def test_an_input_in_words_has_a_band_for_each_value(tmp_path: Path) -> None:
    over = {"number": [1.0, 2.0], "word": ["a", "b"]}
    found = sa.sweep(jobs.by_word, over, seeds=3, out=tmp_path)
    lines = {line.get_label(): line.get_ydata().tolist() for line in found.plot().axes[0].lines}
    assert lines["word a, median"] == [2.0, 3.0]
    assert lines["word b, median"] == [102.0, 103.0]


def test_points_that_are_no_grid_are_drawn_one_by_one(tmp_path: Path) -> None:
    cube = sa.LatinHypercube(20, {"a": (4.0, 5.0), "b": (1.0, 2.0)})
    found = sa.sweep(jobs.product, cube, out=tmp_path)
    points = found.plot().axes[0].collections[0]
    assert len(points.get_offsets()) == 20
    assert len(found.plot(x="a").axes[0].lines[0].get_ydata()) == 20


def test_text_and_notebook_say_how_it_went(tmp_path: Path) -> None:
    found = sa.sweep(jobs.arguments, GRID, seeds=1, out=tmp_path)
    assert str(found).startswith("6 rows: 6 finished; inputs scale, kp, seed; in ")
    assert "rms_e [rad]" in str(found) and "rms_e_1" not in str(found)
    page = found._repr_html_()
    assert "RMS error" in page and "mrad" in page and "sweep_jobs.arguments(scale=" in page


BAD: set[int] = set()
"""Where `faulty` raises."""


def faulty(x: int) -> dict[str, float]:
    if x in BAD:
        raise ArithmeticError(f"{x} is bad")
    return {"y": 0.1 * x}


@pytest.mark.parametrize("whole", [False, True])
def test_rows_that_raised_are_computed_again_where_one_asks(tmp_path: Path, whole: bool) -> None:
    """In files of 1 to 4 rows, where they are the first of a file, and all of it."""
    plan = {"x": range(13)}
    run = functools.partial(sa.sweep, faulty, plan, out=tmp_path / "rows", chunk_seconds=1e-6)
    BAD.update(range(13) if whole else {0, 3, 4, 7, 12})
    first = run()
    assert first.counts()["raised"] == len(BAD)
    BAD.intersection_update({4})
    assert same(run().table(), first.table())
    found = run(retry=True)
    assert rows_of(tmp_path / "rows") == list(range(13))
    assert found.counts() == {"finished": 12, "raised": 1}
    anew = sa.sweep(faulty, plan, out=tmp_path / "anew")
    assert same(found.table(), anew.table())
    BAD.clear()
    assert run(retry=True).counts() == {"finished": 13}
    assert rows_of(tmp_path / "rows") == list(range(13)) and not run(retry=True).missing


def test_processes_that_are_stopped_while_they_start_print_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As where Ctrl-C comes between: one that did not come up breaks the pool."""
    said: list[Any] = []
    monkeypatch.setattr(threading, "excepthook", said.append)
    workers = Processes()
    source = source_of(jobs.slow, ("number",), False)
    futures = [workers.submit(source, [{"number": k}]) for k in range(12)]
    while not futures[2].running():  # as many are under way as can be; the others wait
        time.sleep(0.01)
    for future in futures:
        workers.drop(future)
    pool: Any = workers.executor
    thread = pool._executor_manager_thread
    for process in list(pool._processes.values()):
        process.kill()
    thread.join(20.0)
    workers.close()
    assert not thread.is_alive() and not said
