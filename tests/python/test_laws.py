"""Laws by name: they build, say what they are, refuse in words, and track in a loop."""

from __future__ import annotations

import copy
import inspect
import pickle
import re
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import (
    CHAIN,
    EVERY,
    GAINS,
    LEARNING,
    SAMPLED_ONLY,
    TWO,
    UNCERTAIN,
    UNSURE,
    H,
    by_gains,
    driven,
    extras,
    made,
    nominal,
    plant,
    reference,
    rows,
    simulated,
    start,
)  # fmt: skip
from steadyarm import laws

each = pytest.mark.parametrize(("name", "arm"), EVERY)
names = pytest.mark.parametrize("name", laws.__all__)


@each
def test_a_law_builds_from_a_bandwidth_and_from_gains(name: str, arm: str) -> None:
    joints = nominal(arm).joints
    for controller in (made(name, arm), by_gains(name, arm)):
        assert type(controller) is sa.Controller and controller.law["law"] == name
        assert controller.arm == nominal(arm) and controller.steps == 0
        assert controller.learns == (name in LEARNING)
        tau = controller.step(*rows(arm, 1)[0], H)
        assert tau.shape == (joints,) and np.isfinite(tau).all()


@each
def test_a_number_an_array_and_a_list_of_each_joint_are_the_same_gains(name: str, arm: str) -> None:
    samples = rows(arm, 5)
    once = driven(made(name, arm), samples)
    one = (10.0, np.float32(10.0), np.array(10), np.int64(10))
    each = (np.full(nominal(arm).joints, 10.0), [10.0] * nominal(arm).joints)
    for bandwidth in one + each:
        assert (driven(made(name, arm, bandwidth=bandwidth), samples) == once).all()


@each
def test_repr_pickle_copies_and_replace(name: str, arm: str) -> None:
    controller = made(name, arm, hand_over=3.0, velocity_filter=100.0, delay=1)
    driven(controller, rows(arm, 7))
    twins = [
        pickle.loads(pickle.dumps(controller)), copy.copy(controller), copy.deepcopy(controller)
    ]  # fmt: skip
    tau = driven(controller, rows(arm, 5, seed=1))
    for twin in twins:
        assert twin.steps == 7 and twin.law == controller.law and repr(twin) == repr(controller)
        assert (driven(twin, rows(arm, 5, seed=1)) == tau).all()
    assert f"'law': '{name}'" in repr(controller) and "hand_over=3.0" in repr(controller)
    # A copy with other arguments is new: before its first step.
    other = controller.__replace__(delay=2)
    assert other.steps == 0 and "delay=2" in repr(other) and other.law == controller.law
    new = made(name, arm, hand_over=3.0, velocity_filter=100.0, delay=2)
    assert (driven(other, rows(arm, 9)) == driven(new, rows(arm, 9))).all()


@names
def test_the_words_of_a_law_say_its_equation_its_gains_and_when_to_take_it(name: str) -> None:
    law = getattr(laws, name)
    words = inspect.getdoc(law)
    assert words and len(words.splitlines()) > 3 and "bandwidth" in words
    own = [p for p in inspect.signature(law).parameters if p not in ("arm", "common")]
    assert set(own) >= {"bandwidth", *GAINS[name]}
    assert f"`{name}`" in laws.__doc__, "the module says which law to take when"


@names
def test_gains_beside_a_bandwidth_and_missing_gains_are_refused(name: str) -> None:
    for gain, value in GAINS[name].items():
        with pytest.raises(ValueError, match=rf"^{gain}: .*no value beside a bandwidth"):
            made(name, CHAIN, **{gain: value})
        place, named = extras(name, nominal(CHAIN).joints)
        left = {key: it for key, it in GAINS[name].items() if key != gain}
        with pytest.raises(ValueError, match=rf"^{gain}: .*wants"):
            getattr(laws, name)(nominal(CHAIN), *place, **left, **named)


@names
@pytest.mark.parametrize("bad", [np.nan, -1.0, 0.0, np.inf, [10.0], "10", None, [[10.0] * 6]])
def test_bandwidths_that_make_no_sense_are_refused(name: str, bad: Any) -> None:
    with pytest.raises((ValueError, TypeError)):
        made(name, CHAIN, bandwidth=bad)


@names
@pytest.mark.parametrize("bad", [np.nan, -1.0, np.inf, [1.0, 2.0], "2", {"a": 1.0}])
def test_gains_that_make_no_sense_are_refused_by_their_name(name: str, bad: Any) -> None:
    for gain in GAINS[name]:
        with pytest.raises((ValueError, TypeError), match=gain if isinstance(bad, float) else None):
            by_gains(name, CHAIN, **{gain: bad})


@names
def test_words_that_no_law_has_are_refused(name: str) -> None:
    with pytest.raises(TypeError, match="bandwith"):
        made(name, CHAIN, bandwith=3.0)
    with pytest.raises(ValueError, match="bandwith"):
        sa.Controller(nominal(CHAIN), {"law": name, "bandwith": 3.0})


@pytest.mark.parametrize("law", [{}, {"law": "magic"}, {"law": 3}, {"bandwidth": 3.0}, 3, "pid"])
def test_laws_that_are_none_are_refused(law: Any) -> None:
    with pytest.raises((ValueError, TypeError), match="law"):
        sa.Controller(nominal(TWO), law)


@names
@pytest.mark.parametrize("period", [0.05, 0.9])
def test_a_period_that_is_too_long_is_refused_with_what_to_do(name: str, period: float) -> None:
    # 40 rad/s are beyond any loop of 20 Hz.
    with pytest.raises(ValueError, match=r"got .*, wants .*period"):
        made(name, CHAIN, bandwidth=40.0, control_period=period)


@each
def test_a_filter_that_makes_velocities_too_late_is_refused_before_the_loop_diverges(
    name: str, arm: str
) -> None:
    accepted = []
    for cut_off in (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0):
        try:
            accepted.append(made(name, arm, velocity_filter=cut_off))
        except ValueError as refusal:
            words = rf"velocity_filter: got {cut_off:g}, wants a cut-off \[Hz\] above the loop's"
            assert re.match(words, str(refusal)) and not accepted
    assert 1 <= len(accepted) <= 8
    slowest, measured = (simulated(it, arm, steps=4000) for it in (accepted[0], made(name, arm)))
    late = [np.abs(run.e[-1500:]).max() for run in (slowest, measured)]
    # What switches goes the farther to and fro the later its velocities are.
    assert slowest.status.finished and late[0] < 2.0 * late[1] + 0.05, late


@pytest.mark.parametrize("name", ["pid", "robust", "sliding_mode", "time_delay"])
def test_gains_that_do_not_cover_the_uncertainty_are_refused(name: str) -> None:
    few = {"pid": {"ki": 500.0}, "robust": {"bound": 1.0}, "sliding_mode": {"gain": 1.0}}
    wide = {"inertia": 0.9, "acceleration": 50.0, "disturbance": 20.0}
    given = few.get(name, {"share": 1.95}) | {"uncertainty": wide}
    (gain,) = few.get(name, {"share": 0})
    with pytest.raises(ValueError, match=rf"^{gain}.*: got .*, wants"):
        by_gains(name, TWO, **given)


@pytest.mark.parametrize("name", UNCERTAIN)
@pytest.mark.parametrize("key", list(UNSURE))
@pytest.mark.parametrize("bad", [np.nan, -1.0, np.inf])
def test_uncertainties_that_make_no_sense_are_refused(name: str, key: str, bad: Any) -> None:
    with pytest.raises((ValueError, TypeError), match=key):
        made(name, TWO, uncertainty=UNSURE | {key: bad})
    with pytest.raises((ValueError, TypeError), match=key):
        made(name, TWO, uncertainty={k: v for k, v in UNSURE.items() if k != key})
    with pytest.raises((ValueError, TypeError), match="inertia"):
        made(name, TWO, uncertainty=UNSURE | {"inertia": 1.0})
    with pytest.raises(ValueError, match="uncertainty"):
        made(name, TWO, uncertainty=None)


WRONG_TYPES = [
    ("rise", {"uncertainty": UNSURE | {"inertia": "x"}}, "uncertainty.inertia"),
    ("rise", {"uncertainty": UNSURE | {"disturbance": None}}, "uncertainty.disturbance"),
    ("rise", {"uncertainty": 3.0}, "uncertainty"),
    ("rbf_network", {"width": [1.0, 2.0]}, "width"),
    ("robust", {"gamma": [1.0], "bandwidth": None}, "gamma"),
    ("pid", {"bandwidth": {"a": 1.0}}, "bandwidth"),
    ("pid", {"bandwidth": "ten"}, "bandwidth"),
]


@pytest.mark.parametrize(("name", "given", "path"), WRONG_TYPES)
@pytest.mark.xfail(strict=True, reason="the settings of a law tell no path of a wrong type")
def test_a_wrong_type_is_refused_by_the_path_of_its_key(
    name: str, given: dict[str, Any], path: str
) -> None:
    with pytest.raises((ValueError, TypeError), match=path.replace(".", "[.]")):
        made(name, TWO, **given)


def test_natural_adaptation_wants_a_chain_of_bodies() -> None:
    with pytest.raises(ValueError, match="chain of bodies"):
        laws.natural_slotine_li(nominal(TWO), bandwidth=10.0)


@each
def test_simulate_is_a_loop_by_hand_to_the_bit(name: str, arm: str) -> None:
    for front in ({}, {"hand_over": 3.0, "velocity_filter": 100.0, "bumpless": 20.0}):
        controller = made(name, arm, **front)
        run = simulated(controller, arm)
        assert run.status.finished and controller.steps == 0
        q, dq = start(arm)["q0"], start(arm)["dq0"]
        for k in range(60):
            assert (run.q[k] == q).all() and (run.dq[k] == dq).all()
            tau = controller.step(q, dq, *reference(arm)(k * H), H)
            assert (run.tau[k] == tau).all()
            q, dq = plant(arm).step(q, dq, tau, k * H, H)
        assert (run.q[60] == q).all()


@each
def test_a_run_goes_on_with_its_tracker(name: str, arm: str) -> None:
    whole, half = simulated(made(name, arm), arm), simulated(made(name, arm), arm, steps=30)
    tracker = half.tracker
    assert tracker.steps == 30
    q, dq = half.q[-1], half.dq[-1]
    for k in range(30, 60):
        tau = tracker.step(q, dq, *reference(arm)(k * H), H)
        assert (tau == whole.tau[k]).all()
        q, dq = plant(arm).step(q, dq, tau, k * H, H)


@each
def test_continuous_time_is_sampled_with_a_short_period(name: str, arm: str) -> None:
    controller = by_gains(name, arm)
    if name in SAMPLED_ONLY:
        with pytest.raises(ValueError, match="control_period"):
            simulated(controller, arm, control_period=None)
        return
    fine = {"duration": 0.1, "dt": 2.5e-4} | start(arm)
    ideal = sa.simulate(plant(arm), controller, reference(arm), **fine)
    off = []
    for period in (1e-3, 2.5e-4):
        run = sa.simulate(plant(arm), controller, reference(arm), control_period=period, **fine)
        off.append(np.abs(run.q - ideal.q).max())
    # A held torque is late by half a period: of order 1, so a quarter of it; not less than
    # twice where a sign switches.
    assert off[0] < 2e-3 and off[1] < 0.5 * off[0]


@each
def test_a_guard_lets_a_calm_loop_through_to_the_bit(name: str, arm: str) -> None:
    n = nominal(arm).joints
    guard = sa.Guard(
        made(name, arm), H, velocity_limit=500.0, effort_limit=1e5, position_limits=[(-9, 9)] * n
    )
    tau = driven(made(name, arm), rows(arm, 8))
    assert all((guard.step(*sample) == tau[k]).all() for k, sample in enumerate(rows(arm, 8)))
    assert not any(guard.events.values()) and guard.tracker.steps == 8
    broken = [np.full(n, np.nan), *rows(arm, 1)[0][1:]]
    assert np.isfinite(guard.step(*broken)).all() and guard.events["not_finite"] == 1
    assert guard.tracker.steps == 8


@each
def test_a_guarded_run_is_the_bare_one_where_nothing_happens(name: str, arm: str) -> None:
    ends = [(-9, 9)] * nominal(arm).joints
    limits = {"velocity_limit": 50.0, "effort_limit": 1e5, "position_limits": ends}
    run = simulated(sa.Guard(made(name, arm), H, **limits), arm)
    assert (run.tau == simulated(made(name, arm), arm).tau).all()
    assert run.guard is not None and not any(run.guard.events.values())


def test_messages_name_the_argument_first() -> None:
    with pytest.raises(ValueError) as caught:
        made("momentum_observer", TWO, bandwidth=400.0)
    assert re.match(r"^\w+(\[\d\])?: got .+, wants .+", str(caught.value))
