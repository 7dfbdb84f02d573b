"""Controllers of one's own: objects with a method ``step``, in a loop, a guard and a file."""

from __future__ import annotations

import copy
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import CHAIN, TWO, H, driven, made, nominal, plant, reference, rows, simulated


class Springs:
    """PD with an integral of its own, which tells what it saw."""

    def __init__(self, joints: int = 2) -> None:
        self.pushed, self.told = np.zeros(joints), []

    def step(self, q: Any, dq: Any, q_d: Any, dq_d: Any, ddq_d: Any, dt: float) -> np.ndarray:
        self.told.append(dt)
        self.pushed = self.pushed + (q - q_d) * 1e-3
        return -200.0 * (q - q_d) - 30.0 * (dq - dq_d) - 50.0 * self.pushed


class Breaks(Springs):
    """Raises, or returns nonsense, at a step."""

    def __init__(self, at: int, what: Any) -> None:
        super().__init__()
        self.at, self.what, self.count = at, what, 0

    def step(self, *sample: Any) -> Any:
        self.count += 1
        if self.count > self.at:
            if isinstance(self.what, BaseException):
                raise self.what
            return self.what
        return super().step(*sample)


@pytest.mark.parametrize("arm", [TWO, CHAIN])
def test_it_is_stepped_as_by_hand_and_told_the_period(arm: str) -> None:
    own = Springs(nominal(arm).joints)
    run = simulated(own, arm, q0=reference(arm)(0.0)[0] + 0.1)
    assert own.told == [], "it was copied deeply"
    twin, (q, dq) = Springs(nominal(arm).joints), (run.q[0], run.dq[0])
    for k in range(60):
        tau = twin.step(q, dq, *reference(arm)(k * H), H)
        assert (run.tau[k] == tau).all() and (run.q[k] == q).all()
        q, dq = plant(arm).step(q, dq, tau, k * H, H)
    own = run.tracker.law
    assert own.told == [H] * 60 and (own.pushed == twin.pushed).all()


def test_a_controller_has_the_object_and_hands_it_the_samples() -> None:
    own = Springs()
    controller = sa.Controller(nominal(TWO), own, effort_limit=4.0, control_period=H)
    assert controller.law is own
    tau, twin = driven(controller, rows(TWO, 5)), Springs()
    wanted = np.array([twin.step(*sample, H) for sample in rows(TWO, 5)])
    assert (tau == np.clip(wanted, -4.0, 4.0)).all() and controller.steps == 5


def test_it_is_told_the_dt_of_the_step() -> None:
    own = Springs()
    controller = sa.Controller(nominal(TWO), own)
    controller.step(*rows(TWO, 1)[0], 2e-3)
    assert own.told == [2e-3]


def test_copies_are_kept_apart() -> None:
    controller = sa.Controller(nominal(TWO), Springs(), control_period=H)
    driven(controller, rows(TWO, 4))
    twins = [copy.deepcopy(controller), pickle.loads(pickle.dumps(controller))]
    tau = driven(controller, rows(TWO, 4, seed=2))
    for twin in twins:
        assert twin.law is not controller.law and len(twin.law.told) == 4
        assert (driven(twin, rows(TWO, 4, seed=2)) == tau).all()


def test_a_run_goes_on_with_it() -> None:
    whole, half = simulated(Springs(), TWO), simulated(Springs(), TWO, steps=30)
    tracker, (q, dq) = half.tracker, (half.q[-1], half.dq[-1])
    for k in range(30, 60):
        tau = tracker.step(q, dq, *reference(TWO)(k * H), H)
        assert (tau == whole.tau[k]).all()
        q, dq = plant(TWO).step(q, dq, tau, k * H, H)


def test_what_it_raises_comes_out_with_the_time_and_the_run_so_far() -> None:
    error = RuntimeError("no more")
    with pytest.raises(RuntimeError, match="no more") as caught:
        simulated(Breaks(20, error), TWO)
    assert any("t = 0.02 s, step 20" in note for note in caught.value.__notes__)
    run = caught.value.run
    good = simulated(Springs(), TWO)
    assert 20 <= len(run.t) <= 21 and (run.q[:20] == good.q[:20]).all()


def test_a_keyboard_interrupt_in_it_ends_the_run_as_ctrl_c_does() -> None:
    run = simulated(Breaks(5, KeyboardInterrupt()), TWO)
    assert run.status.kind == "interrupted" and run.status.t == pytest.approx(5 * H)


@pytest.mark.parametrize("what", [SystemExit(3), StopIteration(), MemoryError(), GeneratorExit()])
def test_whatever_it_raises_comes_out(what: BaseException) -> None:
    with pytest.raises(type(what)):
        simulated(Breaks(5, what), TWO)
    controller = sa.Controller(nominal(TWO), Breaks(0, what), control_period=H)
    with pytest.raises(type(what)):
        controller.step(*rows(TWO, 1)[0], H)


WRONG = [
    np.zeros(3), np.zeros((2, 2)), 3.0, None, "ab", [1.0, "x"], np.array([1j, 0]), object(),
]  # fmt: skip


@pytest.mark.parametrize("what", WRONG, ids=lambda what: type(what).__name__)
def test_torques_of_another_kind_are_refused_by_its_name(what: Any) -> None:
    with pytest.raises((ValueError, TypeError), match="step"):
        simulated(Breaks(3, what), TWO)
    controller = sa.Controller(nominal(TWO), Breaks(0, what), control_period=H)
    with pytest.raises((ValueError, TypeError), match="step"):
        controller.step(*rows(TWO, 1)[0], H)
    assert controller.steps == 0


@pytest.mark.parametrize("what", [[np.nan, 0.0], [0.0, np.inf], np.full(2, -np.inf)])
def test_torques_that_are_not_finite_end_the_run_and_refuse_the_step(what: Any) -> None:
    try:
        run = simulated(Breaks(3, what), TWO)
    except ValueError as error:
        assert "step" in str(error) or "tau" in str(error)
    else:
        assert run.status.kind == "diverged" and run.status.t == pytest.approx(3 * H)
    controller = sa.Controller(nominal(TWO), Breaks(0, what), control_period=H)
    with pytest.raises(ValueError):
        controller.step(*rows(TWO, 1)[0], H)


@pytest.mark.parametrize("what", [[1, -2], (1.0, -2.0), np.array([1, -2]), np.float32([1, -2])])
def test_torques_may_be_lists_tuples_and_arrays(what: Any) -> None:
    controller = sa.Controller(nominal(TWO), Breaks(0, what), control_period=H)
    assert (controller.step(*rows(TWO, 1)[0], H) == [1.0, -2.0]).all()


def test_it_may_write_to_what_it_is_given() -> None:
    class Scribbles(Springs):
        def step(self, q: Any, *rest: Any) -> np.ndarray:
            tau = super().step(q, *rest)
            for array in (q, *rest[:-1]):
                array[:] = 1e6
            return tau

    assert (simulated(Scribbles(), TWO).q == simulated(Springs(), TWO).q).all()


def test_objects_without_a_step_are_refused() -> None:
    class Still:
        step = 3

    for own in (Still(), object(), 3, None):
        with pytest.raises(TypeError, match=r"law: .*step"):
            sa.Controller(nominal(TWO), own)
        with pytest.raises((TypeError, ValueError)):
            simulated(own, TWO)


def test_a_guard_takes_over_when_it_raises() -> None:
    controller = sa.Controller(nominal(TWO), Breaks(3, [np.nan, np.nan]), control_period=H)
    guard = sa.Guard(
        controller, H, velocity_limit=500.0, effort_limit=1e5, position_limits=[(-9, 9)] * 2
    )
    for sample in rows(TWO, 6):
        assert np.isfinite(guard.step(*sample)).all()
    assert guard.events["controller"] >= 1


def test_a_run_is_replayed_from_the_controller_as_it_was(tmp_path: Path) -> None:
    own = sa.Controller(nominal(TWO), Springs(), control_period=H)
    driven(own, rows(TWO, 5))
    run = simulated(own, TWO)
    for again in (run.replay(), run.replay(), pickle.loads(pickle.dumps(run)).replay(law=own.law)):
        assert (again.tau == run.tau).all()
    run.save(tmp_path / "run.npz")
    loaded = sa.Run.load(tmp_path / "run.npz")
    assert (loaded.q == run.q).all()
    assert loaded.scene["tracker"]["Controller"]["law"] == {"callable": "Springs"}
    with pytest.raises(ValueError, match=r"law: it was a callable, Springs, .*; give law="):
        loaded.replay()
    assert (loaded.replay(law=own.law).tau == run.tau).all()
    assert (sa.replay(tmp_path / "run.npz", law=own.law).tau == run.tau).all()
    with pytest.raises(ValueError, match="law"):
        loaded.replay(law=3)


def test_front_and_limits_stand_before_it_too() -> None:
    front = {"hand_over": 5.0, "velocity_filter": 60.0}
    own = sa.Controller(nominal(TWO), Springs(), control_period=H, **front)
    seen: list[Any] = []

    class Sees(Springs):
        def step(self, *sample: Any) -> np.ndarray:
            seen.append(sample)
            return super().step(*sample)

    other = sa.Controller(nominal(TWO), Sees(), control_period=H, **front)
    assert (driven(own, rows(TWO, 5)) == driven(other, rows(TWO, 5))).all()
    q, dq, q_d, dq_d, _, dt = seen[0]
    assert (q == q_d).all() and np.allclose(dq, dq_d) and math.isclose(dt, H)


def test_it_does_not_learn_unless_it_says_so() -> None:
    controller = sa.Controller(nominal(TWO), Springs(), control_period=H)
    assert not controller.learns and not controller.frozen
    with pytest.raises(TypeError):
        controller.freeze()
    assert made("pid", TWO).law["law"] == "pid"


def test_it_is_reset_by_its_own_method_and_saved_by_nobody_else(tmp_path: Path) -> None:
    class Resets(Springs):
        def reset(self) -> None:
            self.__init__()

    own = Resets()
    controller = sa.Controller(nominal(TWO), own, control_period=H)
    tau = driven(controller, rows(TWO, 5))
    controller.reset()
    assert own.told == [] and controller.steps == 0
    assert (driven(controller, rows(TWO, 5)) == tau).all()
    with pytest.raises(TypeError, match=r"law: .*reset"):
        sa.Controller(nominal(TWO), Springs(), control_period=H).reset()
    for call in (controller.save, controller.load):
        with pytest.raises((TypeError, OSError)):
            call(tmp_path / "state")
    assert not (tmp_path / "state").exists()
