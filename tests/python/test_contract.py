"""The names and calls that users build on."""

from __future__ import annotations

import importlib.util
import inspect
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa
from hypothesis import given
from hypothesis import strategies as st
from scenes import CENTERS, ZERO, actual, nominal, plant, run, tracker

A = np.block([[np.zeros((2, 2)), np.eye(2)], [-8 * np.eye(2), -5.5 * np.eye(2)]])
B = np.vstack([np.zeros((2, 2)), np.eye(2)])
Q = 10 * np.eye(4)


def test_the_pieces_fit_together_as_documented(tmp_path: Path) -> None:
    basis = sa.FuzzyBasis(
        form="grid",
        centers=(-1.5, -0.5, 0.0, 0.5, 1.5),
        width=0.5**0.5,
        normalized=True,
        inputs="error",
    )
    compensator = sa.FuzzyCompensator(basis, q=10, gain=7.0, gamma=1.0)
    tracker = sa.ComputedTorque(nominal(), kp=8, kv=5.5, compensator=compensator)
    q, dq, q_d, dq_d, ddq_d = ZERO, ZERO, ZERO, ZERO, np.ones(2)
    tau = tracker.step(q, dq, q_d, dq_d, ddq_d, 1e-3)
    assert tau.shape == (2,)
    assert tau.dtype == np.float64
    tracker.reset()
    plant = sa.Plant(actual(), disturbance=sa.paper.disturbance())
    run = sa.simulate(
        plant,
        tracker,
        sa.paper.reference(),
        duration=2.0,
        dt=1e-3,
        method="rk4",
        q0=0.1,
        dq0=(0, 0),
    )
    assert run.status.finished
    assert run.t.shape == (2001,)
    for name in ("q", "dq", "q_d", "dq_d", "ddq_d", "e", "de", "tau", "rho", "rho_hat"):
        array = getattr(run, name)
        assert array.shape == (2001, 2)
        assert array.dtype == np.float64
    assert run.metrics(window=(1, 2)).rms_e.shape == (2,)
    run.save(tmp_path / "run.npz")
    assert np.array_equal(sa.Run.load(tmp_path / "run.npz").q, run.q)


def test_dp54_and_sampled_control_are_options_of_simulate() -> None:
    assert run(tracker(), method="dp54").status.finished
    sampled = run(tracker(), control_period=1e-3)
    assert sampled.status.finished
    assert sampled.certificate is None


def test_every_public_name_exists_and_is_documented() -> None:
    for name in sa.__all__:
        value = getattr(sa, name)
        if name != "__version__":
            assert inspect.getdoc(value), name


@pytest.mark.parametrize(
    "kind",
    [
        sa.TwoLink,
        sa.FuzzyBasis,
        sa.FuzzyCompensator,
        sa.FuzzyApproximator,
        sa.ComputedTorque,
        sa.Plant,
        sa.Sines,
        sa.Quintic,
        sa.Table,
        sa.Waypoints,
        sa.Pulses,
        sa.Noise,
        sa.Wrench,
        sa.RiccatiSolution,
    ],
)
def test_every_public_member_of_a_class_is_documented(kind: type) -> None:
    for name, member in vars(kind).items():
        if not name.startswith("_"):
            assert inspect.getdoc(member), f"{kind.__name__}.{name}"
    assert inspect.getdoc(kind)


@pytest.mark.skipif(
    importlib.util.find_spec("steadyarm.plots") is None, reason="the plots are not there yet"
)
def test_plot_returns_a_figure() -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib.figure import Figure

    assert isinstance(run(tracker()).plot(), Figure)


def test_riccati_solution_has_its_certificate() -> None:
    solution = sa.bounded_real_riccati(A, B, Q, gamma=1.0)
    assert solution.P.shape == (4, 4)
    assert solution.residual <= 1e-12
    assert solution.max_real < 0
    assert solution.gamma == 1.0
    assert solution.gamma_opt == pytest.approx(0.6143205381, rel=1e-9)
    assert solution.max_scale == pytest.approx(2.64978068488, rel=1e-9)
    lqr = sa.care(A=A, B=B, Q=Q, R=np.eye(2))
    assert lqr.P.shape == (4, 4)
    assert lqr.gamma is lqr.gamma_opt is lqr.max_scale is None


def test_no_stabilizing_solution_is_a_value_error_with_figures() -> None:
    assert issubclass(sa.NoStabilizingSolution, ValueError)
    with pytest.raises(sa.NoStabilizingSolution, match=r"^gamma: got 1, wants more than") as caught:
        sa.bounded_real_riccati(A, B, 30 * np.eye(4))
    assert caught.value.gamma == 1.0
    assert caught.value.gamma_opt > 1.0
    assert 0 < caught.value.max_scale < 1


@pytest.mark.parametrize("preset", ["printed", "claimed"])
def test_scene_of_the_paper_has_its_pieces_and_runs(preset: str) -> None:
    scene = sa.paper.simulation(3, preset=preset, duration=0.1)
    assert isinstance(scene.plant, sa.Plant)
    assert isinstance(scene.tracker, sa.ComputedTorque)
    assert isinstance(scene.reference, sa.Sines)
    assert scene.run().status.finished
    assert scene.run(method="dp54").status.finished


def test_overrides_reach_controller_basis_and_compensator() -> None:
    overrides = {"gain": 70, "form": "concat", "kp": 9, "inputs": "state", "leak_rate": 0.1}
    controller = sa.paper.simulation(3, **overrides).tracker
    assert np.array_equal(controller.kp, [9, 9])
    assert controller.compensator is not None
    assert np.array_equal(controller.compensator.gain, [70, 70])
    assert controller.compensator.basis.form == "concat"
    assert controller.compensator.basis.inputs == [("q", 1.0), ("dq", 1.0)]


def test_scalars_stand_for_both_joints() -> None:
    arm = sa.TwoLink(4, 0.5, 0.2, viscous=1, coulomb=2, smoothing=0.1)
    pair = sa.TwoLink((4, 4), [0.5, 0.5], (0.2, 0.2), 0, (1, 1), (2, 2), (0.1, 0.1))
    assert arm.parameters == pair.parameters
    controller = sa.ComputedTorque(arm, 8, 5.5, effort_limit=30)
    assert np.array_equal(controller.kp, [8, 8])
    assert np.array_equal(controller.kv, [5.5, 5.5])
    assert np.array_equal(sa.Plant(arm, effort_limit=3).effort_limit, [3, 3])
    assert np.array_equal(sa.Plant(arm).effort_limit, [np.inf, np.inf])
    assert np.array_equal(tracker(q=10).compensator.q, [10, 10, 10, 10])
    assert np.array_equal(tracker(q=np.diag([1, 2, 3, 4])).compensator.q, [1, 2, 3, 4])


def test_one_array_may_be_every_argument() -> None:
    x = np.array([0.1, 0.2])
    separate = [x.copy() for _ in range(5)]
    assert np.array_equal(tracker().step(x, x, x, x, x, 1e-3), tracker().step(*separate, 1e-3))
    a = -np.eye(3)
    one = sa.bounded_real_riccati(a, a, a @ a, gamma=10.0)
    assert np.array_equal(one.P, sa.bounded_real_riccati(a.copy(), a.copy(), np.eye(3), 10.0).P)


def test_result_is_not_the_argument() -> None:
    x = np.array([0.1, 0.2])
    tau = tracker().step(x, x, x, x, x, 1e-3)
    tau[:] = 0
    assert np.array_equal(x, [0.1, 0.2])
    controller = tracker()
    weights = controller.weights
    assert weights is not None
    weights[:] = 1
    assert not controller.weights.any()


def read_only(x: np.ndarray) -> np.ndarray:
    x.flags.writeable = False
    return x


def misaligned(x: np.ndarray) -> np.ndarray:
    raw = np.zeros(x.nbytes + 1, dtype=np.uint8)
    view = raw[1:].view(np.float64)
    view[:] = x
    return view


VECTORS = {
    "list": lambda x: x.tolist(),
    "tuple": lambda x: tuple(x.tolist()),
    "ints": lambda x: [int(v) for v in x],
    "numpy ints": lambda x: x.astype(np.int8),
    "unsigned": lambda x: abs(x).astype(np.uint16),
    "float32": lambda x: x.astype(np.float32),
    "float16": lambda x: x.astype(np.float16),
    "long double": lambda x: x.astype(np.longdouble),
    "big-endian": lambda x: x.astype(">f8"),
    "strided": lambda x: np.repeat(x, 3)[::3],
    "reversed": lambda x: x[::-1].copy()[::-1],
    "column": lambda x: np.column_stack([x, x])[:, 1],
    "read-only": lambda x: read_only(x.copy()),
    "misaligned": misaligned,
    "bools": lambda x: x.astype(bool),
    "list of numpy scalars": lambda x: list(x),
    "memoryview": lambda x: memoryview(x.copy()),
}


@pytest.mark.parametrize("kind", VECTORS)
def test_vector_of_any_kind_counts_by_its_numbers(kind: str) -> None:
    for numbers in ([1.0, 0.0], [3.0, 2.0]):
        given = VECTORS[kind](np.array(numbers))
        plain = np.asarray(given).astype(np.float64)
        expected = tracker().step(plain, ZERO, ZERO, plain, ZERO, 1e-3)
        found = tracker().step(given, ZERO, ZERO, given, ZERO, 1e-3)
        assert np.array_equal(found, expected)
        assert np.array_equal(nominal().mass_matrix(given), nominal().mass_matrix(plain))


MATRICES = {
    "lists": lambda x: x.tolist(),
    "tuples": lambda x: tuple(map(tuple, x.tolist())),
    "Fortran": np.asfortranarray,
    "float32": lambda x: x.astype(np.float32),
    "ints": lambda x: (2 * x).astype(int),
    "big-endian": lambda x: x.astype(">f8"),
    "strided": lambda x: np.kron(x, np.ones((2, 3)))[::2, ::3],
    "read-only": lambda x: read_only(x.copy()),
}


@pytest.mark.parametrize("kind", MATRICES)
def test_matrix_of_any_kind_counts_by_its_numbers(kind: str) -> None:
    a, b, q = (MATRICES[kind](x) for x in (A, B, Q))
    expected = sa.care(*(np.array(x, dtype=float) for x in (a, b, q)), np.eye(2)).P
    assert np.array_equal(sa.care(a, b, q, np.eye(2)).P, expected)
    controller, other = tracker("shared"), tracker("shared")
    weights = np.arange(10.0).reshape(2, 5)
    controller.weights = MATRICES[kind](weights)
    other.weights = np.array(MATRICES[kind](weights), dtype=float)
    assert np.array_equal(controller.weights, other.weights)


def test_centers_and_widths_may_differ_between_inputs() -> None:
    centers = [(-1, 0, 1), (0, 1), [0.5], np.array([1.0, 2.0])]
    basis = sa.FuzzyBasis("grid", centers, (0.1, 0.2, 0.3, 0.4))
    assert basis.rules == 12
    assert sa.FuzzyBasis("concat", centers, [[0.1] * 3, [1, 2], [3], [4, 5]]).rules == 8
    assert sa.FuzzyBasis("grid", CENTERS, (1, 2, 3, 4, 5)).rules == 625


def test_inputs_may_be_presets_signals_lists_or_scales() -> None:
    def inputs(value: object) -> list[tuple[str, float]]:
        return sa.FuzzyBasis("shared", CENTERS, 1.0, inputs=value).inputs

    assert inputs("error") == [("e", 1), ("de", 1)]
    assert inputs("reference") == [("q_d", 1), ("dq_d", 1)]
    assert inputs("trajectory") == [("q_d", 1), ("dq_d", 1), ("ddq_d", 1)]
    assert inputs("q") == [("q", 1)]
    assert inputs(("q", "e")) == [("q", 1), ("e", 1)]
    assert inputs({"de": 0.5, "e": 2}) == [("de", 0.5), ("e", 2)]


def test_callable_reference_and_disturbance_equal_the_built_in_ones() -> None:
    reference, disturbance = sa.paper.reference(), sa.paper.disturbance()
    built_in = run(tracker(), duration=0.2)
    plant = sa.Plant(actual(), lambda q, dq, t: disturbance(t)[0])
    called = sa.simulate(plant, tracker(), lambda t: reference(t), duration=0.2)
    assert np.array_equal(called.q, built_in.q)
    assert np.array_equal(called.tau, built_in.tau)


def test_tracker_may_be_used_inside_a_callback() -> None:
    controller = tracker()
    reference = sa.paper.reference()

    def stepping(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        controller.step(ZERO, ZERO, *reference(t), 1e-3)
        return reference(t)

    called = sa.simulate(plant(), controller, stepping, duration=0.1)
    assert controller.steps > 100
    assert np.array_equal(called.q, run(tracker(), duration=0.1).q)


def test_simulate_leaves_the_tracker_as_it_was() -> None:
    controller = tracker()
    controller.step(ZERO, ZERO, [1, 1], ZERO, ZERO, 1e-3)
    before = controller.__getstate__()
    run(controller, control_period=1e-3)
    run(controller)
    assert controller.__getstate__() == before


def test_parts_of_the_torque_add_up() -> None:
    controller = tracker("concat", gain=70)
    assert controller.tau_model is controller.tau_compensation is controller.rho_hat is None
    for _ in range(50):
        tau = controller.step([0.3, -0.2], ZERO, ZERO, ZERO, ZERO, 1e-3)
    assert controller.rho_hat.any()
    np.testing.assert_allclose(tau, controller.tau_model + controller.tau_compensation, rtol=1e-14)
    mass = nominal().mass_matrix([0.3, -0.2])
    np.testing.assert_allclose(controller.tau_compensation, -mass @ controller.rho_hat, rtol=1e-14)


def test_reset_forgets_everything() -> None:
    controller = tracker(limits={"effort_rate_limit": 10.0})
    fresh = controller.__getstate__()
    first = controller.step([0.3, -0.2], ZERO, ZERO, ZERO, ZERO, 1e-3)
    controller.step([0.3, -0.2], ZERO, ZERO, ZERO, ZERO, 1e-3)
    controller.reset()
    assert controller.__getstate__() == fresh
    assert controller.steps == 0
    assert np.array_equal(controller.step([0.3, -0.2], ZERO, ZERO, ZERO, ZERO, 1e-3), first)


def test_frozen_tracker_keeps_its_weights() -> None:
    controller = tracker("concat")
    controller.freeze()
    controller.step([1, 1], ZERO, ZERO, ZERO, ZERO, 1e-3)
    assert controller.frozen
    assert not controller.weights.any()
    controller.unfreeze()
    controller.step([1, 1], ZERO, ZERO, ZERO, ZERO, 1e-3)
    assert controller.weights.any()


@given(st.lists(st.floats(-1e10, 1e10), min_size=10, max_size=10), st.floats(1e-9, 1.0))
def test_limited_torque_is_finite_and_inside_its_limits(numbers: list[float], dt: float) -> None:
    controller = tracker("concat", limits={"effort_limit": 20.0, "effort_rate_limit": 1000.0})
    sample = np.array(numbers).reshape(5, 2)
    last = None
    for _ in range(2):
        try:
            tau = controller.step(*sample, dt)
        except ValueError as error:
            # Positions beyond 1e5 are refused.
            name = str(error).split("[")[0].split(":")[0]
            far = max(abs(sample[0]).max(), abs(sample[2]).max()) > 1e5
            assert name in (("q", "q_d") if far else ("tau", "weights"))
            continue
        assert np.isfinite(tau).all()
        assert (abs(tau) <= 20.0).all()
        if last is not None:
            assert (abs(tau - last) <= 1000.0 * dt * (1 + 1e-12) + 1e-12).all()
        last = tau


def test_basis_is_finite_at_any_finite_input() -> None:
    for form in ("grid", "shared", "concat", "per_joint"):
        basis = sa.FuzzyBasis(form, CENTERS, 0.5**0.5)
        xi = basis.evaluate(np.outer([0, 1, 15.15, 1e3, 1e100, 1e308, -1e308], np.ones(4)))
        assert np.isfinite(xi).all()
        sums = {"concat": 4, "per_joint": 2}.get(form, 1)
        np.testing.assert_allclose(xi.sum(axis=1), sums, rtol=1e-12)


def test_metrics_are_printed_with_their_units() -> None:
    figures = run(tracker("shared"), duration=0.1).metrics()
    units = {"rms_e": "rad", "max_abs_e": "rad", "itae": "rad·s²", "settling_time": "s"}
    units |= {"rms_tau": "N·m", "max_abs_tau": "N·m", "torque_variation": "N·m/s"}
    rows = {row.split()[0]: row.split()[1:] for row in str(figures).splitlines()[1:]}
    assert {name: unit for name, (unit, *_) in rows.items()} == {
        name: f"[{unit}]" for name, unit in units.items()
    }
    for name, unit in units.items():
        assert [float(value) for value in rows[name][1:]] == pytest.approx(
            getattr(figures, name), rel=1e-5
        )
        assert f"{name}={getattr(figures, name)} {unit}" in repr(figures)
    # What was not recorded is not shown.
    motion = run(tracker("shared"), duration=0.1, record="motion").metrics()
    assert "tau" not in str(motion) + repr(motion)
