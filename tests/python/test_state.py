"""State: a reset tracker is a new one and a loaded one is the one that was saved, to the bit.

Both are compared after random histories, with trackers that have not lived through them.
"""

from __future__ import annotations

import contextlib
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scenes import ZERO, nominal, run, samples, tracker

PULLS: list[dict[str, float]] = [
    {},
    {"leak_rate": 0.1},
    {"error_modification": 0.1},
    {"projection_radius": 50.0},
]
FORMS = ("grid", "shared", "concat", "per_joint")

Act = Callable[[sa.ComputedTorque], None]


def steps(seed: int, count: int, dt: float) -> Act:
    def act(controller: sa.ComputedTorque) -> None:
        for sample in samples(count, seed):
            controller.step(*sample, dt)

    return act


def refused(place: int, value: float) -> Act:
    def act(controller: sa.ComputedTorque) -> None:
        sample = [ZERO.copy() for _ in range(5)]
        sample[place][1] = value
        with pytest.raises(ValueError):
            controller.step(*sample, 1e-3)
        with pytest.raises(ValueError):
            controller.step(*[ZERO] * 5, -1.0)

    return act


def weights(seed: int, size: float, prior: bool) -> Act:
    def act(controller: sa.ComputedTorque) -> None:
        # No compensator, or a dictionary: there are no weights to set.
        with contextlib.suppress(TypeError):
            shape = getattr(controller.weights, "shape", None)
            if shape is not None:
                chosen = size * np.random.default_rng(seed).normal(size=shape)
                if prior:
                    controller.warm_start(chosen)
                else:
                    # Beyond the projection's radius they are refused.
                    with contextlib.suppress(ValueError):
                        controller.weights = chosen

    return act


def told(seed: int, share: float) -> Act:
    """Steps that are told what acted: this share of what was commanded."""

    def act(controller: sa.ComputedTorque) -> None:
        applied = None
        for sample in samples(5, seed):
            applied = share * controller.step(*sample, 1e-3, applied=applied)

    return act


def looked_at(controller: sa.ComputedTorque) -> None:
    with contextlib.suppress(TypeError):
        controller.weights  # noqa: B018
    controller.dictionary  # noqa: B018


def taken_over(tau: float | None) -> Act:
    return lambda controller: controller.reset(last_tau=tau)


def frozen(on: bool) -> Act:
    def act(controller: sa.ComputedTorque) -> None:
        if controller.compensator is not None:
            (controller.freeze if on else controller.unfreeze)()

    return act


def again(controller: sa.ComputedTorque) -> None:
    controller.__setstate__(controller.__getstate__())


acts = st.one_of(
    st.builds(
        steps, st.integers(0, 99), st.integers(1, 40), st.sampled_from([1e-9, 1e-3, 0.05, 1.0])
    ),
    st.builds(refused, st.integers(0, 4), st.sampled_from([np.nan, np.inf, -1e11])),
    st.builds(
        weights, st.integers(0, 99), st.sampled_from([0.0, 1e-310, 0.1, 10.0]), st.booleans()
    ),
    st.builds(frozen, st.booleans()),
    st.builds(told, st.integers(0, 99), st.sampled_from([0.0, 0.5, 1.0])),
    st.just(looked_at),
    st.builds(taken_over, st.sampled_from([None, 3.0])),
    st.just(again),
    st.just(sa.ComputedTorque.reset),
)
histories = st.lists(acts, max_size=10)
limits = st.sampled_from(
    [
        {},
        {"effort_limit": 30.0},
        {"effort_limit": 30.0, "effort_rate_limit": 1e3},
        {"effort_rate_limit": 1e3, "last_tau": (4.0, -2.0)},
    ]
)
laws = st.fixed_dictionaries(
    {"gain": st.sampled_from([1.0, 100.0])},
    optional={
        "leak_rate": st.just(0.5),
        "error_modification": st.just(0.1),
        "projection_radius": st.just(0.5),
        "dead_zone": st.just(0.01),
        "normalization": st.just(0.1),
    },
)


@st.composite
def makers(draw: st.DrawFn) -> Callable[[], sa.ComputedTorque]:
    """Ways to build a tracker: without compensator, written out, as a dictionary."""
    bounds, law = draw(limits), draw(laws)
    kind = draw(st.sampled_from(("plain", "dictionary", *FORMS)))
    if kind == "plain":
        return lambda: sa.ComputedTorque(nominal(), 8, 5.5, **bounds)
    if kind == "dictionary":
        law["dictionary"] = draw(st.integers(1, 30))
        kind = "grid"
    normalized = draw(st.booleans())
    return lambda: tracker(kind, normalized, limits=bounds, **law)


def live(controller: sa.ComputedTorque, history: list[Act]) -> None:
    for act in history:
        act(controller)


def assert_same(one: sa.ComputedTorque, other: sa.ComputedTorque) -> None:
    for k, sample in enumerate(samples(50, seed=7)):
        assert one.__getstate__() == other.__getstate__(), k
        assert one.step(*sample, 1e-3).tobytes() == other.step(*sample, 1e-3).tobytes(), k
        assert (one.limited, one.frozen, one.steps) == (other.limited, other.frozen, other.steps)
    assert one.__getstate__() == other.__getstate__()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(make=makers(), history=histories)
def test_a_reset_tracker_is_a_new_one(
    make: Callable[[], sa.ComputedTorque], history: list[Act]
) -> None:
    controller = make()
    live(controller, history)
    controller.reset()
    assert (controller.steps, controller.frozen, controller.limited) == (0, False, False)
    assert controller.tau_model is None
    assert controller.tau_compensation is None
    assert controller.rho_hat is None
    assert_same(controller, make())


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(make=makers(), history=histories, other=histories, way=st.integers(0, 3))
def test_a_loaded_tracker_is_the_saved_one(
    make: Callable[[], sa.ComputedTorque], history: list[Act], other: list[Act], way: int
) -> None:
    controller, loaded = make(), make()
    live(controller, history)
    live(loaded, other)
    if way == 0:
        loaded.__setstate__(controller.__getstate__())
    elif way == 1:
        with tempfile.TemporaryDirectory() as folder:
            controller.save(Path(folder) / "state")
            loaded.load(Path(folder) / "state")
    elif way == 2:
        loaded = pickle.loads(pickle.dumps(controller))
    else:
        # Through another one, which had a life of its own.
        loaded.__setstate__(controller.__getstate__())
        loaded = pickle.loads(pickle.dumps(loaded))
    assert not loaded.limited
    assert loaded.tau_model is None
    assert_same(controller, loaded)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("law", PULLS, ids=lambda law: "-".join(law) or "none")
@pytest.mark.parametrize("way", ["reset", "load", "setstate", "weights"])
def test_an_old_prior_is_forgotten(
    form: str, law: dict[str, float], way: str, tmp_path: Path
) -> None:
    """Without weights, a tracker at rest where it should be asks for no torque."""
    old, new = tracker(form, **law), tracker(form, **law)
    old.warm_start(np.ones_like(old.weights))
    assert np.abs(old.step(*[ZERO] * 5, 1e-3)).max() > 1.0
    if way == "reset":
        old.reset()
    elif way == "load":
        new.save(tmp_path / "new")
        old.load(tmp_path / "new")
    elif way == "setstate":
        old.__setstate__(new.__getstate__())
    else:
        old.weights = np.zeros_like(old.weights)
    np.testing.assert_array_equal(old.step(*[ZERO] * 5, 1e-3), ZERO)


@pytest.mark.parametrize("law", PULLS, ids=lambda law: "-".join(law) or "none")
def test_a_run_after_a_reset_is_the_first_run(law: dict[str, float]) -> None:
    """Nothing of a prior is in its weights, its torques, or V."""
    controller = tracker("grid", **law)
    first = run(controller, duration=0.2)
    controller.warm_start(np.ones_like(controller.weights))
    later = run(controller, duration=0.2).tracker
    assert later is not None
    later.reset()
    again = run(later, duration=0.2)
    for name in ("q", "tau", "V", "rho_hat", "weights_norm"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name


def test_weights_that_are_set_stay_frozen() -> None:
    """Setting weights is no reset: what was frozen stays so, the last torque limits the rate."""
    controller = tracker("shared", leak_rate=0.1, limits={"effort_rate_limit": 10.0})
    controller.step(*[ZERO] * 5, 1e-3)
    controller.freeze()
    controller.weights = np.ones((2, 5))
    assert controller.frozen
    assert controller.steps == 1
    assert np.abs(controller.step(*[ZERO] * 5, 1e-3)).max() <= 10.0 * 1e-3 * (1 + 1e-12)
    np.testing.assert_array_equal(controller.weights, np.ones((2, 5)))


def raising(name: str) -> Any:
    def at_half(*arguments: Any) -> Any:
        if arguments[-1] >= 0.05:
            raise RuntimeError(name)
        return (ZERO, ZERO, ZERO) if name == "reference" else ZERO

    return at_half


@pytest.mark.parametrize("method", ["rk4", "dp54"])
@pytest.mark.parametrize("period", [None, 0.01])
def test_an_error_of_one_run_does_not_end_the_next(method: str, period: float | None) -> None:
    """Both callables raise in the first run; the plant outlives it and must forget its share."""
    broken = [True]

    def disturbance(q: Any, dq: Any, t: float) -> Any:
        if broken[0] and t >= 0.05:
            raise RuntimeError("disturbance")
        return ZERO

    plant = sa.Plant(nominal(), disturbance)
    options: dict[str, Any] = {"duration": 0.1, "dt": 0.01, "method": method}
    options["control_period"] = period
    with pytest.raises(RuntimeError):
        sa.simulate(plant, tracker("shared"), raising("reference"), **options)
    broken[0] = False
    record = sa.simulate(plant, tracker("shared"), sa.paper.reference(), **options)
    assert record.status.finished
