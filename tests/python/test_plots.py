"""The pictures: what is drawn, with which names and units."""

import subprocess
import sys

import numpy as np
import pytest
import steadyarm as sa
from steadyarm import plots


@pytest.fixture(scope="module")
def plain():
    return sa.paper.simulation(2, duration=2.0).run()


@pytest.fixture(scope="module")
def adaptive():
    return sa.paper.simulation(3, "claimed", duration=2.0).run()


@pytest.fixture(scope="module")
def diverged():
    run = sa.paper.simulation(3, "claimed").run(control_period=0.4)
    assert run.status.kind == "diverged"
    return run


def labels(figure):
    return [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]


def bottom_labels(figure):
    return [axes.get_xlabel() for axes in figure.axes if axes.get_xlabel()]


def legends(figure):
    boxes = [axes.get_legend() for axes in figure.axes]
    return [text.get_text() for box in boxes if box for text in box.get_texts()]


def test_importing_the_package_does_not_import_matplotlib():
    script = "import sys, steadyarm, steadyarm.cli; sys.exit('matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", script], check=True)


@pytest.mark.parametrize("use", ["sa.plots.overview(run)", "sa.animation.joint_points(arm)"])
def test_drawing_needs_no_import_of_its_own(use):
    script = (
        "import sys, steadyarm as sa; assert {'plots', 'animation'} <= set(dir(sa));"
        "run = sa.paper.simulation(2, duration=0.1).run(); arm = sa.paper.nominal();"
        f"assert 'matplotlib' not in sys.modules; {use}; sys.exit('matplotlib' not in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    with pytest.raises(AttributeError, match="module 'steadyarm' has no attribute 'plot'"):
        sa.plot  # noqa: B018
    assert sa.plots is plots


def test_drawing_does_not_import_pyplot():
    script = (
        "import sys, steadyarm as sa; sa.paper.simulation(2, duration=1.0).run().plot();"
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_overview_without_a_compensator_has_three_rows(plain):
    figure = plain.plot()
    assert labels(figure) == ["position [rad]", "error [rad]", "torque [N·m]"]
    assert bottom_labels(figure) == ["time [s]"] * 2
    assert len(figure.axes) == 6
    assert figure.get_suptitle() == ""


def test_overview_with_a_compensator_shows_what_was_learnt(adaptive):
    figure = adaptive.plot()
    assert labels(figure)[3:] == [
        "model error [rad/s²]",
        "weights, |W| [rad/s²]",
        "Lyapunov function V [1]",
    ]
    assert len(figure.axes) == 10
    assert {"actual", "desired", "from the model", "from the compensator"} < set(legends(figure))


def test_overview_draws_the_record(adaptive):
    position, error, torque, model_error = adaptive.plot().axes[4:8]
    actual, desired = position.get_lines()
    assert np.array_equal(actual.get_ydata(), adaptive.q[:, 1])
    assert np.array_equal(desired.get_ydata(), adaptive.q_d[:, 1])
    assert np.array_equal(error.get_lines()[0].get_ydata(), adaptive.e[:, 1])
    total, model, compensation = (line.get_ydata() for line in torque.get_lines())
    assert np.allclose(total, model + compensation, atol=1e-12)
    assert np.array_equal(model_error.get_lines()[1].get_ydata(), adaptive.rho_hat[:, 1])


def test_a_diverged_run_says_so_and_stays_readable(diverged):
    for figure in (diverged.plot(), plots.paper_figure(diverged, "figure")):
        assert f"diverged at t = {diverged.status.t:.6g} s" in figure.get_suptitle()
        low, high = figure.axes[0].get_ylim()
        assert high - low < 100.0 < np.ptp(diverged.q[:, 0])


def test_an_interrupted_run_says_so(plain):
    from dataclasses import replace

    stopped = replace(plain, status=sa.Status("interrupted", 2.0, "it was stopped"))
    assert "interrupted at t = 2 s" in stopped.plot().get_suptitle()


def test_a_run_of_one_row_can_be_drawn(plain):
    from dataclasses import replace

    arrays = {name: value for name, value in vars(plain).items() if isinstance(value, np.ndarray)}
    one = replace(plain, **{name: value[:1] for name, value in arrays.items()})
    assert one.plot()._repr_png_().startswith(b"\x89PNG")


def test_paper_figure_has_one_joint_a_column_desired_dotted_actual_solid(plain):
    figure = plots.paper_figure(plain, "Figure 2")
    left, right = figure.axes
    assert [left.get_title("right"), right.get_title("right")] == ["joint 1", "joint 2"]
    assert labels(figure) == ["position [rad]"]
    assert bottom_labels(figure) == ["time [s]"] * 2
    actual, desired = left.get_lines()
    assert actual.get_linestyle() == "-"
    assert desired.get_linestyle() != "-"
    assert figure.get_suptitle() == "Figure 2"


def test_errors_names_every_run_with_its_rms(plain, adaptive):
    figure = plots.errors({"without": plain, "with": adaptive})
    assert labels(figure) == ["joint 1, error [rad]", "joint 2, error [rad]"]
    for joint, name, run in ((0, "without", plain), (1, "with", adaptive)):
        rms = run.metrics((1.0, 2.0)).rms_e[joint]
        assert f"{name}: {rms:.3g} rad" in legends(figure)


def test_errors_shows_the_sane_run_beside_a_diverged_one(plain, diverged):
    figure = plots.errors({"wild": diverged, "sane": plain})
    low, high = figure.axes[0].get_ylim()
    assert high - low < 5.0
    assert f"wild: diverged at {diverged.status.t:.4g} s" in legends(figure)


def test_approximation_is_logarithmic_with_the_rule_counts_on_the_axis():
    figure = plots.approximation([(4, 1.0), (100, 0.01)])
    (axes,) = figure.axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["4", "100"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "number of rules [1]",
        "largest error, sup |g − f| [unit of g]",
    )


@pytest.mark.parametrize("draw", [lambda: plots.errors({}), lambda: plots.approximation([])])
def test_nothing_to_draw_is_refused(draw):
    with pytest.raises(ValueError, match="got none"):
        draw()


def test_a_notebook_shows_the_picture(plain):
    assert plain.plot()._repr_png_().startswith(b"\x89PNG")


def test_show_hands_the_figure_to_pyplot(plain, monkeypatch):
    import matplotlib

    if matplotlib.__version_info__ < (3, 11):
        pytest.skip("pyplot takes foreign figures from matplotlib 3.11 on")
    monkeypatch.setenv("MPLBACKEND", "agg")
    from matplotlib import pyplot

    shown = []
    monkeypatch.setattr(pyplot, "show", lambda: shown.append(pyplot.get_fignums()))
    figure = plain.plot()
    figure.show()
    pyplot.close(figure)
    assert shown == [[1]]


def test_a_film_shows_every_moment_of_a_run(tmp_path):
    from PIL import Image

    scene = sa.paper.simulation(1)
    run = sa.simulate(scene.plant, scene.tracker, scene.reference, 1.0, 1e-3)
    path = run.animate(sa.paper.nominal(), tmp_path / "arm.gif", speed=5.0)
    with Image.open(path) as film:
        assert film.n_frames == 6


def test_a_film_of_a_serial_arm_has_depth(tmp_path):
    arm = sa.Serial.shipped("panda")
    reference = sa.Quintic([0.0] * 7, [0.5] * 7, 0.5)
    run = sa.simulate(sa.Plant(arm), sa.ComputedTorque(arm, 100, 20), reference, 0.5, 1e-3)
    assert run.status.finished
    assert run.animate(arm, tmp_path / "arm.gif", speed=5.0).stat().st_size > 1000


@pytest.mark.parametrize(
    ("path", "arguments", "error", "message"),
    [
        ("arm.avi", {}, ValueError, "wants a name that ends in .gif or .mp4"),
        ("arm.gif", {"speed": 0.0}, ValueError, "speed: got 0.0, wants a number > 0"),
        ("arm.gif", {"speed": 1e-4}, ValueError, "wants at most 2000"),
    ],
)
def test_a_film_that_cannot_be_made_is_refused(tmp_path, path, arguments, error, message):
    scene = sa.paper.simulation(1)
    run = sa.simulate(scene.plant, scene.tracker, scene.reference, 0.1, 1e-3)
    with pytest.raises(error, match=message):
        run.animate(sa.paper.nominal(), tmp_path / path, **arguments)
    with pytest.raises(TypeError, match="arm: got int"):
        run.animate(3, tmp_path / "arm.gif")


def test_an_arm_of_seven_joints_fits_one_page(tmp_path):
    arm = sa.Serial.shipped("panda")
    basis = sa.FuzzyBasis("per_joint", centers=(-1.0, 0.0, 1.0), width=0.5, inputs="reference")
    tracker = sa.ComputedTorque(arm, 100, 20, compensator=sa.FuzzyCompensator(basis, gain=10.0))
    reference = sa.Quintic([0.0] * 7, [0.5] * 7, 0.5)
    picture = sa.simulate(sa.Plant(arm), tracker, reference, 0.5, 1e-3).plot()
    picture.savefig(tmp_path / "run.png")
    assert len(picture.axes) == 7 * 4 + 2
    assert [legend.get_texts()[0].get_text() for legend in picture.legends] == ["actual"]
