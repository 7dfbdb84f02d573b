"""References: called on arrays, motions through poses, start times."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa

POSES = [[0.0, 0.0], [1.0, -0.5], [0.2, 0.3]]


def waypoints(**change: Any) -> sa.Waypoints:
    given: dict[str, Any] = {"velocity": 1.0, "acceleration": 5.0, "jerk": 50.0}
    return sa.Waypoints(**({"poses": POSES} | given | change))


CURVES = [
    sa.Sines((1, 3), ((0, 1), (2, 0)), offset=0.5, start_time=0.25),
    sa.Quintic(0, (1, 2), 3),
    sa.Table((0, 1, 2), ((0, 0), (1, 2), (0, 1)), start_time=0.5),
    waypoints(pause=0.5, start_time=1.0),
]


@pytest.mark.parametrize("curve", CURVES, ids=lambda curve: type(curve).__name__)
def test_times_in_an_array_give_the_rows_of_single_times(curve: sa.Sines) -> None:
    t = np.linspace(-1.0, 6.0, 41)
    whole = curve(t)
    assert [column.shape for column in whole] == [(41, 2)] * 3
    for k, time in enumerate(t):
        row = curve(time)
        assert [entry.shape for entry in row] == [(2,)] * 3
        assert all(np.array_equal(row[n], whole[n][k]) for n in range(3))
    assert [column.shape for column in curve([])] == [(0, 2)] * 3
    with pytest.raises(ValueError, match=r"t: got shape \(1, 2\), wants a scalar or \(T,\)"):
        curve([[1, 2]])
    with pytest.raises(ValueError, match=r"t\[1\]: got NaN, wants a finite number"):
        curve([0.0, np.nan])
    with pytest.raises(TypeError, match="t: got an array of dtype"):
        curve(["a", "b"])


def test_waypoints_have_the_duration_of_the_closed_form() -> None:
    # d/V + V/A + A/J of the joint that moves 1 rad, then of the one that moves 0.8 rad.
    path = waypoints(pause=0.5, start_time=1.0)
    assert path.duration == pytest.approx(1.3 + 0.5 + 1.1, abs=1e-9)
    assert path.arrivals == pytest.approx([1.0, 2.3, 3.9], abs=1e-9)
    for time, pose in zip(path.arrivals, POSES, strict=True):
        assert path(time)[0] == pytest.approx(pose, abs=1e-12)
    for t in (-10.0, 0.99, path.arrivals[1] + 0.25, 1e9):
        assert not np.any(path(t)[1:])


def test_waypoints_keep_the_limits_of_every_joint() -> None:
    velocity, acceleration, jerk = np.array([0.4, 2.0]), np.array([5.0, 1.0]), np.array([50.0, 9.0])
    path = waypoints(velocity=velocity, acceleration=acceleration, jerk=jerk)
    t = np.linspace(-0.5, path.duration + 0.5, 20001)
    q, dq, ddq = path(t)
    assert np.all(np.abs(dq) <= velocity * (1 + 1e-12))
    assert np.all(np.abs(ddq) <= acceleration * (1 + 1e-12))
    assert np.all(np.abs(np.diff(ddq, axis=0)) / np.diff(t)[:, None] <= jerk * (1 + 1e-9) + 1e-9)
    assert np.abs(dq).max(axis=0)[0] == pytest.approx(0.4)
    # Trapezoids, whose error is that of the jerk's steps.
    assert np.abs(np.diff(q, axis=0) - 0.5 * (dq[1:] + dq[:-1]) * (t[1] - t[0])).max() < 1e-10


def test_a_run_along_waypoints_is_saved_and_made_again(tmp_path: Path) -> None:
    arm = sa.paper.nominal()
    path = waypoints(pause=[0.1])
    run = sa.simulate(sa.Plant(arm), sa.ComputedTorque(arm, 8, 5.5), path, duration=1.0)
    assert np.abs(run.e).max() < 1e-9
    run.save(tmp_path / "run.npz")
    again = sa.replay(tmp_path / "run.npz")
    assert np.array_equal(again.q, run.q)


def test_waypoints_come_from_a_scenario() -> None:
    text = """
        [reference.waypoints]
        poses = [[0, 0], [1, -0.5], [0.2, 0.3]]
        velocity = 1
        acceleration = 5
        jerk = [50, 50]
        pause = 0.5
    """
    path = sa.read_scenario(text)["reference"]
    assert path == waypoints(jerk=[50, 50], pause=0.5)
    with pytest.raises(ValueError, match=r"reference.waypoints.jerk\[1\]: got 0, wants a number >"):
        sa.read_scenario(text.replace("[50, 50]", "[50, 0]"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"poses": [[1, 2]]}, "poses: got 1, wants at least 2 poses"),
        ({"poses": [1, 2]}, r"poses: got shape \(2,\), wants \(K, n\)"),
        ({"poses": [[0, 0], [np.nan, 1]]}, r"poses\[1, 0\]: got NaN, wants a finite"),
        ({"poses": np.zeros((2, 13))}, r"poses: got shape \(2, 13\)"),
        ({"velocity": 0}, r"velocity\[0\]: got 0, wants a number > 0"),
        ({"acceleration": (1, -1)}, r"acceleration\[1\]: got -1, wants a number > 0"),
        ({"jerk": (1, 2, 3)}, "jerk: got values for 3 joints, wants 2"),
        ({"pause": (1, 2)}, "pause: got 2 entries, wants 1"),
        ({"pause": -1}, "pause: got -1, wants a number >= 0"),
        ({"start_time": np.inf}, "start_time: got inf, wants a finite number"),
    ],
)
def test_waypoints_that_cannot_be_are_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        waypoints(**change)


def test_a_reference_that_starts_stands_still_before_it() -> None:
    sines, table = CURVES[0], CURVES[2]
    for t in (-3.0, 0.2):
        assert np.array_equal(sines(t), [[0.5, 0.5], [0, 0], [0, 0]])
        assert np.array_equal(table(t), np.zeros((3, 2)))
    free = sa.Sines((1, 3), ((0, 1), (2, 0)), offset=0.5)
    assert np.array_equal(sines(1.0), free(0.75))
    assert np.array_equal(table(1.5)[0], [1, 2])


def test_sines_are_no_disturbance_before_they_start() -> None:
    arm = sa.paper.nominal()
    plant = sa.Plant(arm, sa.Sines(0.0, offset=2.0, start_time=0.5))
    q, zero = np.array([0.3, 0.4]), np.zeros(2)
    assert np.array_equal(plant.step(q, zero, zero, 0.1, 0.2), [q, zero])
    assert np.all(plant.step(q, zero, zero, 0.5, 0.2)[1] != 0)


def test_the_design_takes_a_path_through_poses_to_its_end() -> None:
    arm = sa.paper.nominal()
    tracker = sa.ComputedTorque(arm, 8, 5.5)
    path = waypoints(start_time=0.5)
    given = sa.design(tracker, control_period=1e-3, path=path, duration=path.duration + 0.5)
    assert str(sa.design(tracker, control_period=1e-3, path=path)) == str(given)
