"""Attribution: its parts add up, each planted cause is found, and it says so."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attribution_scenes as scenes
import numpy as np
import pytest
import steadyarm as sa
from attribution_scenes import (
    PANDA,
    PERIOD,
    PLANTED,
    assert_adds_up,
    follow,
    robot,
    small,
    two_link,
    waves,
)
from steadyarm.attribution import WORDS


@pytest.mark.parametrize("scene", PLANTED, ids=lambda scene: scene.__name__)
def test_a_planted_cause_has_the_largest_share(scene: Callable[[], sa.Run]) -> None:
    run, cause = scene(), PLANTED[scene]
    found = sa.attribution(run)
    assert_adds_up(found, run)
    worst = int(np.argmax(np.sqrt((found.mismatch**2).mean(axis=0))))
    torque = {name: share[worst] for name, share in found.torque_shares.items()}
    assert max(torque, key=lambda name: abs(torque[name])) == cause
    assert torque[cause] > 0.85
    farthest = int(np.argmax(found.rms_of_error))
    error = {name: share[farthest] for name, share in found.error_shares.items()}
    assert max(error, key=lambda name: abs(error[name])) == cause
    assert WORDS[cause] in found.sentence().split(";")[0]


def test_a_start_off_the_path_is_the_error_without_any_torque() -> None:
    run = scenes.start()
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert (found.error_shares["start"] > 0.99).all()
    # Only the last row has a torque of the row before it: no sample is taken at the end.
    assert np.abs(found.whole[:-1]).max() < 1e-9


# What runs there are.


def test_a_run_from_a_file_has_the_same_attribution(tmp_path: Path) -> None:
    run = scenes.panda_payload()
    run.save(tmp_path / "run.npz")
    fresh, loaded = sa.attribution(run), sa.attribution(sa.Run.load(tmp_path / "run.npz"))
    assert list(fresh.torque) == list(loaded.torque)
    for name in fresh.torque:
        np.testing.assert_array_equal(fresh.torque[name], loaded.torque[name])
    assert str(fresh) == str(loaded)


def test_a_callable_disturbance_is_given_anew_to_a_run_from_a_file(tmp_path: Path) -> None:
    def push(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        return 0.5 * np.array([np.sin(t), 1.0])

    run = follow(two_link(), sa.Plant(two_link(), push), waves(2, 0.5), duration=1.0)
    run.save(tmp_path / "run.npz")
    loaded = sa.Run.load(tmp_path / "run.npz")
    with pytest.raises(ValueError, match=r"disturbance: it was a callable, .*; give disturbance="):
        sa.attribution(loaded)
    given, known = sa.attribution(loaded, disturbance=push), sa.attribution(run)
    np.testing.assert_array_equal(given.torque["disturbance"], known.torque["disturbance"])


class Spring:
    """A controller of one's own: a stiff spring on a constant inertia."""

    def step(self, q: Any, dq: Any, q_d: Any, dq_d: Any, ddq_d: Any, dt: float) -> Any:
        return 2.0 * ddq_d - 400.0 * (q - q_d) - 60.0 * (dq - dq_d)


def test_a_law_of_ones_own_is_feedback_as_a_whole(tmp_path: Path) -> None:
    run = sa.simulate(
        sa.Plant(two_link(coulomb=0.5)), Spring(), waves(2, 0.5), 2.0, control_period=PERIOD
    )
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert found.notes[0].startswith("the law is your own")
    assert not found.torque["sampling"].any() and not found.torque["cancelled"].any()
    run.save(tmp_path / "run.npz")
    again = sa.attribution(sa.Run.load(tmp_path / "run.npz"))
    np.testing.assert_array_equal(found.whole, again.whole)


def test_runs_that_do_not_say_enough_are_refused() -> None:
    run = scenes.gain()
    other = dataclasses.replace(run, notes=("another",))
    with pytest.raises(ValueError, match=r"^run: got one that does not say what it was made with"):
        sa.attribution(other)
    motion = sa.paper.simulation(2, duration=0.1).run(record="motion")
    with pytest.raises(ValueError, match=r'with 0 rows of torques, .* record="motion" keeps none'):
        sa.attribution(motion)
    with pytest.raises(
        ValueError, match=re.escape("window: got (9.0, 10.0), wants one with a row")
    ):
        sa.attribution(run, window=(9.0, 10.0))
    with pytest.raises(ValueError, match=r"^unloaded: got 7 joints, wants 2"):
        sa.attribution(run, unloaded=robot("panda"))
    with pytest.raises(TypeError, match=r"^unloaded: got 2.0, wants an Arm"):
        sa.attribution(run, unloaded=2.0)  # type: ignore[arg-type]
    guard = sa.Guard(sa.ComputedTorque(two_link(), 100, 20), PERIOD, effort_limit=100.0)
    guarded = sa.simulate(sa.Plant(two_link()), guard, waves(2, 0.1), 0.1, control_period=PERIOD)
    with pytest.raises(ValueError, match="wants one of `simulate` without a guard"):
        sa.attribution(guarded)


# Words and pictures.


def test_a_prismatic_joint_has_metres_and_newtons() -> None:
    """A carriage of 2 kg, pushed."""
    rail = sa.Serial.from_dh(
        [0.0], 0.0, 0.0, kind="prismatic", mass=2.0, inertia=[[0.1, 0.1, 0.1]], gravity=np.zeros(3)
    )
    plant = sa.Plant(rail, sa.Sines(0.0, offset=[4.0]))
    found = sa.attribution(follow(rail, plant, waves(1, 0.1), bandwidth=10.0, duration=2.0))
    # 4 N on 2 kg against k_p = 100: 20 mm in the end.
    assert np.isclose(found.e[-1, 0], -0.02, rtol=1e-3)
    assert " mm, 0 to 2 s) is the disturbance" in found.sentence()
    assert found.plot().axes[0].get_ylabel() == "force [N]"


def test_shares_are_projections_on_the_whole() -> None:
    found = sa.attribution(scenes.panda_payload(), window=(1.0, 3.0))
    rows = (found.t >= 1.0) & (found.t <= 3.0)
    whole = found.mismatch[rows]
    for name, share in found.torque_shares.items():
        part = found.torque[name][rows]
        np.testing.assert_allclose(share[1], part[:, 1] @ whole[:, 1] / (whole[:, 1] @ whole[:, 1]))
        np.testing.assert_allclose(found.rms_torque[name], np.sqrt((part**2).mean(axis=0)))


def test_the_sentence_names_joint_cause_and_what_is_cancelled() -> None:
    arm = robot("panda")
    plant = sa.Plant(arm.with_payload(2.0, (0.0, 0.0, 0.05)).with_friction(coulomb=0.5))
    run = follow(arm, plant, waves(7, 0.2, offset=PANDA), sa.laws.pid)
    found = sa.attribution(run)
    # The integral takes gravity off: what is left is friction.
    share = 100.0 * found.error_shares["friction"][1]
    rms = 1e3 * run.metrics().rms_e[1]
    said = found.sentence(2)
    assert said == found.sentence("panda_joint2")
    where = f"joint 2 (RMS {rms:.3g} mrad, 0 to 4 s)"
    assert said.startswith(f"About {share:.0f} % of the error of {where} is friction")
    assert (
        f"The controller cancels {100 * found.cancelled[1]:.0f} % of what its model lacks." in said
    )
    assert str(found).startswith(found.sentence())
    assert "of the missing torque [%]" in str(found)


def test_the_picture_has_a_row_a_joint_with_areas_on_one_another() -> None:
    run = follow(
        robot("panda"),
        sa.Plant(robot("panda").with_payload(2.0).with_friction(coulomb=0.5)),
        waves(7, 0.2, offset=PANDA),
        duration=0.5,
    )
    found = sa.attribution(run)
    figure = found.plot(joints=[2, "panda_joint4"])
    over_time, bars = figure.axes[0::2], figure.axes[1::2]
    assert [axes.get_title("right") for axes in over_time] == ["panda_joint2", "panda_joint4"]
    assert [axes.get_ylabel() for axes in over_time] == ["torque [N·m]"] * 2
    areas = over_time[0].collections
    assert {"gravity of the payload", "friction"} <= {area.get_label() for area in areas}
    # 501 rows are drawn as they are: areas end at the sums of what is above zero and below.
    parts = [part[:, 1] for name, part in found.torque.items() if name != "cancelled"]
    ends = np.concatenate([area.get_paths()[0].vertices[:, 1] for area in areas])
    for side, end in ((np.maximum, ends.max()), (np.minimum, ends.min())):
        sums = sum(side(part, 0.0) for part in parts)
        assert np.isclose(end, sums.max() if side is np.maximum else sums.min(), atol=1e-9)
    line = over_time[0].get_lines()[0].get_ydata()
    np.testing.assert_allclose(line, found.mismatch[:, 1], atol=1e-12)
    shares = {name: share[1] for name, share in found.error_shares.items()}
    largest = max(shares, key=lambda name: abs(shares[name]))
    first = bars[0].texts[0].get_text()
    assert first == f"{100 * shares[largest]:.0f} %  {WORDS[largest]}"
    whole = found.plot(width=3.5, style="dark")
    assert len(whole.axes) == 14 and whole.get_size_inches()[0] == 3.5
    later = found.plot(joints=2, window=(0.25, 0.5)).axes
    assert later[0].get_xlim() == (0.25, 0.5)
    rms = 1e3 * run.metrics((0.25, 0.5)).rms_e[1]
    assert later[1].get_title("left") == f"error, RMS {rms:.3g} mrad"


def test_a_joint_that_is_not_there_is_refused() -> None:
    found = sa.attribution(scenes.inertia())
    with pytest.raises(ValueError, match=r"^joints: got 3, wants 1 to 2"):
        found.plot(joints=[3])
    with pytest.raises(ValueError, match=r"^joint: got 0, wants 1 to 2"):
        found.sentence(0)


def test_samples_between_rows_are_noted() -> None:
    """With rows at every 5 ms and samples at every 2 ms."""
    options = {"control_period": 2e-3, "duration": 0.5}
    run = follow(*small(coulomb=0.5), waves(2, 0.5), record_every=5, **options)
    found = sa.attribution(run)
    assert_adds_up(found, run)
    assert found.notes[0].startswith("samples fall between the rows") and found.notes[0] in str(
        found
    )
    assert not sa.attribution(follow(*small(), waves(2, 0.5), record_every=2, **options)).notes
