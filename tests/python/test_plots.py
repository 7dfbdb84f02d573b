"""The pictures: what is drawn, with which names and units."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import steadyarm as sa
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.text import Text
from steadyarm import plots
from steadyarm._look import LOOKS
from steadyarm.comparison import Comparison, Row


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


@pytest.fixture(scope="module")
def seven():
    arm = sa.Serial.shipped("panda")
    basis = sa.FuzzyBasis("per_joint", centers=(-1.0, 0.0, 1.0), width=0.5, inputs="reference")
    tracker = sa.ComputedTorque(arm, 100, 20, compensator=sa.FuzzyCompensator(basis, gain=10.0))
    reference = sa.Quintic([0.0] * 7, [0.5] * 7, 0.5)
    return sa.simulate(sa.Plant(arm.with_payload(2.0)), tracker, reference, 0.5, 1e-3)


def labels(figure):
    return [axes.get_ylabel().replace("\n", " ") for axes in figure.axes if axes.get_ylabel()]


def bottom_labels(figure):
    return [axes.get_xlabel() for axes in figure.axes if axes.get_xlabel()]


def legends(figure):
    assert not any(axes.get_legend() for axes in figure.axes)
    return [text.get_text() for box in figure.legends for text in box.get_texts()]


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
    assert labels(figure) == ["position [rad]", "error [mrad]", "torque [N·m]"]
    assert bottom_labels(figure) == ["time [s]"] * 2
    assert len(figure.axes) == 6
    assert figure.get_suptitle() == ""


def test_overview_with_a_compensator_shows_what_was_learnt(adaptive):
    figure = adaptive.plot()
    assert labels(figure)[3:] == ["model error [rad/s²]"]
    whole = [axes.get_title("right") for axes in figure.axes[-2:]]
    assert whole == ["weights, |W| [rad/s²]", "Lyapunov function V [1]"]
    assert len(figure.axes) == 10
    said = legends(figure)
    assert {"actual", "desired", "from the model", "from the compensator"} < set(said)
    assert len(said) == len(set(said))


def test_overview_draws_the_record(adaptive):
    position, error, torque, model_error = adaptive.plot().axes[1:8:2]
    actual, desired = position.get_lines()
    assert np.array_equal(actual.get_ydata(), adaptive.q[:, 1])
    assert np.array_equal(desired.get_ydata(), adaptive.q_d[:, 1])
    assert np.array_equal(error.get_lines()[0].get_ydata(), 1e3 * adaptive.e[:, 1])
    total, model, compensation = (line.get_ydata() for line in torque.get_lines()[:3])
    assert np.allclose(total, model + compensation, atol=1e-12)
    assert np.array_equal(model_error.get_lines()[1].get_ydata(), adaptive.rho_hat[:, 1])


def test_a_diverged_run_says_so_and_stays_readable(diverged):
    for figure in (diverged.plot(), plots.paper_figure(diverged, "figure")):
        assert f"diverged at t = {diverged.status.t:.6g} s" in figure.get_suptitle()
        low, high = figure.axes[0].get_ylim()
        assert high - low < 100.0 < np.ptp(diverged.q[:, 0])


def test_an_interrupted_run_says_so(plain):
    stopped = replace(plain, status=sa.Status("interrupted", 2.0, "it was stopped"))
    assert "interrupted at t = 2 s" in stopped.plot().get_suptitle()


@pytest.mark.parametrize("gap", [slice(5, 20), slice(None)])
def test_what_is_not_finite_is_a_gap(plain, gap):
    e = plain.e.copy()
    e[gap, 0] = np.nan
    figure = replace(plain, e=e).plot("e", joints=1)
    low, high = figure.axes[0].get_ylim()
    assert np.isfinite([low, high]).all() and low < high
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_run_of_one_row_can_be_drawn(plain):
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
    assert labels(figure) == ["error [mrad]"]
    for name, run in (("without", plain), ("with", adaptive)):
        rms = 1e3 * np.hypot(*run.metrics((1.0, 2.0)).rms_e)
        assert f"{name}: {rms:.3g} mrad" in legends(figure)
    part = plots.errors({"without": plain}, joints=2, window=(0.5, 1.0))
    assert legends(part) == [f"without: {1e3 * plain.metrics((0.5, 1.0)).rms_e[1]:.3g} mrad"]


def test_errors_shows_the_sane_run_beside_a_diverged_one(plain, diverged):
    figure = plots.errors({"wild": diverged, "sane": plain})
    low, high = figure.axes[0].get_ylim()
    assert high - low < 5e3
    assert f"wild: diverged at {diverged.status.t:.4g} s" in legends(figure)


def test_errors_of_arms_of_other_joint_counts_are_refused(plain, seven):
    with pytest.raises(ValueError, match=r"^runs: got 'arm' of 7 joints, wants 2"):
        plots.errors({"paper": plain, "arm": seven})


def test_approximation_is_logarithmic_with_the_rule_counts_on_the_axis():
    figure = plots.approximation([(4, 1.0), (100, 0.01)])
    (axes,) = figure.axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["4", "100"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "number of rules [1]",
        "largest error, sup |g − f| [unit of g]",
    )


@pytest.mark.parametrize(
    "draw",
    [
        lambda: plots.errors({}),
        lambda: plots.approximation([]),
        lambda: plots.pareto(Comparison([Row("refused", status="refused")])),
    ],
)
def test_nothing_to_draw_is_refused(draw):
    with pytest.raises(ValueError, match="got none"):
        draw()


ROWS = [
    Row("quiet", steady_rms_e=2e-3, torque_variation=100.0),
    Row("precise", steady_rms_e=1e-4, torque_variation=900.0),
    Row("worse", steady_rms_e=3e-3, torque_variation=950.0),
    Row("refused", status="refused"),
]


def test_the_pareto_picture_joins_those_that_no_other_beats():
    (axes,) = plots.pareto(Comparison(ROWS)).axes
    every, best = (np.transpose(line.get_data()).tolist() for line in axes.get_lines())
    assert sorted(every) == [[100.0, 2.0], [900.0, 0.1], [950.0, 3.0]]
    assert best == [[100.0, 2.0], [900.0, 0.1]]
    assert [text.get_text() for text in axes.texts] == ["precise", "quiet", "worse"]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "torque variation [N·m/s]",
        "steady RMS of the error [mrad]",
    )


def test_names_in_the_pareto_picture_do_not_meet_and_stay_within():
    rows = [Row(f"controller {k}", steady_rms_e=0.1 / k, torque_variation=k) for k in range(1, 40)]
    figure = plots.pareto(Comparison(rows), width=3.5, style="dark")
    renderer = drawn(figure)
    (axes,) = figure.axes
    boxes = [text.get_window_extent(renderer) for text in axes.texts]
    assert len(boxes) >= 3
    for k, box in enumerate(boxes):
        assert axes.bbox.x0 < box.x0 and box.x1 < axes.bbox.x1 + 1
        assert not any(box.overlaps(other) for other in boxes[:k])


def test_the_pareto_picture_wants_one_scenario():
    rows = [replace(row, scenario=name) for row in ROWS for name in "ab"]
    with pytest.raises(ValueError, match=r"^comparison: got the scenarios 'a', 'b', wants rows"):
        plots.pareto(Comparison(rows))


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


# Many joints, a page of a journal.


def panels(figure, label):
    """The panels of a block, by the name of its axis."""
    named = [k for k, axes in enumerate(figure.axes) if axes.get_ylabel().startswith(label)]
    ends = [k for k, axes in enumerate(figure.axes) if axes.get_ylabel() and k > named[-1]]
    return figure.axes[named[0] : min(ends, default=len(figure.axes))]


def drawn(figure):
    canvas = FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    return canvas.get_renderer()


@pytest.mark.parametrize("width", [7.16, 3.5])
def test_seven_joints_have_letters_of_print_and_no_panel_in_another(seven, width):
    figure = seven.plot(width=width)
    assert len(figure.axes) == 7 * 4 + 2
    size = figure.get_size_inches()
    assert size[0] == width and size[1] <= (9.5 if width > 5 else 12.0)
    renderer = drawn(figure)
    texts = [text for axes in figure.axes for text in axes.findobj(Text) if text.get_text()]
    assert {text.get_fontsize() for text in texts if text.get_visible()} <= {7.0, 8.0}
    boxes = [axes.get_window_extent(renderer) for axes in figure.axes]
    assert min(box.width for box in boxes) > 0.5 * figure.dpi
    assert min(box.height for box in boxes) > 0.35 * figure.dpi
    for k, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[:k])
    whole = figure.get_tightbbox(renderer)
    assert whole.x0 >= 0 and whole.x1 <= size[0] and whole.y0 >= 0 and whole.y1 <= size[1]


def test_what_a_controller_adds_is_drawn_and_what_sensors_add_is_not():
    scene = sa.Scenario.read("paper_sensors")
    plain, learning = (scene.simulate(name, duration=0.2) for name in ("pid", "recommended"))
    assert {channel.name for channel in plain.own} == set(plots.OF_EFFECTS)
    assert len(plain.plot().axes) == len(learning.plot().axes) == 3 * 2
    torque = learning.plot().axes[4]
    for line, name in zip(torque.get_lines(), ("tau", "tau_learned", "tau_observed"), strict=False):
        assert np.array_equal(line.get_ydata(), getattr(learning, name)[:, 0])
    assert {"applied", "learned", "observed"} < set(legends(learning.plot()))
    assert labels(plain.plot("q_measured", "sample_age")) == ["q_measured [rad]", "sample_age [s]"]


def test_joints_have_their_names_and_are_chosen_by_them(seven):
    names = [axes.get_title("right") for axes in panels(seven.plot("q", "e"), "e ")]
    assert names == [f"panda_joint{n}" for n in range(1, 8)]
    for joints in (["panda_joint6", 2], [6, "panda_joint2"], (np.int64(6), 2, 2)):
        error = panels(seven.plot("e", joints=joints), "e ")
        assert [axes.get_title("right") for axes in error] == ["panda_joint6", "panda_joint2"]
        for axes, joint in zip(error, (5, 1), strict=True):
            assert np.array_equal(axes.get_lines()[0].get_ydata(), 1e3 * seven.e[:, joint])
    assert len(seven.plot("e", joints="panda_joint3").axes) == 1


def test_joints_without_names_are_numbered_from_one(plain):
    for joints in (2, "2", [2]):
        (axes,) = plain.plot("q", joints=joints).axes
        assert axes.get_title("right") == "joint 2"


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"joints": 0}, ValueError, r"^joints: got 0, wants 1 to 7, or a name: panda_joint1, "),
        ({"joints": [8]}, ValueError, r"^joints: got 8, wants 1 to 7"),
        ({"joints": "panda_joint8"}, ValueError, r"^joints: got 'panda_joint8', wants 1 to 7"),
        ({"joints": []}, ValueError, r"^joints: got none, wants 1 to 7"),
        ({"joints": [True]}, TypeError, r"^joints: got True, wants 1 to 7"),
        ({"joints": 1.5}, TypeError, r"^joints: got 1.5, wants 1 to 7"),
        ({"window": (1.0, 2.0)}, ValueError, r"^window: got \(1.0, 2.0\), wants one with a row"),
        ({"window": (0.3, 0.1)}, ValueError, r"^window: got \(0.3, 0.1\), wants one with a row"),
        ({"window": 3.0}, TypeError, r"^window: got 3.0, wants one with a row"),
        ({"width": 1.0}, ValueError, r"^width: got 1, wants 2 to 40 inches"),
        ({"width": float("nan")}, ValueError, r"^width: got nan, wants 2 to 40 inches"),
        ({"width": "3.5"}, TypeError, r"^width: got '3.5', wants inches"),
        ({"style": "black"}, ValueError, r"^style: got 'black', wants light or dark"),
    ],
)
def test_what_cannot_be_drawn_is_refused(seven, options, error, message):
    with pytest.raises(error, match=message):
        seven.plot(**options)


def test_the_window_is_what_is_drawn(seven):
    figure = seven.plot(window=(0.1, 0.3))
    inside = (seven.t >= 0.1) & (seven.t <= 0.3)
    line = figure.axes[0].get_lines()[0]
    assert np.array_equal(line.get_xdata(), seven.t[inside])
    assert all(axes.get_xlim() == (seven.t[inside][0], seven.t[inside][-1]) for axes in figure.axes)


def test_panels_of_a_signal_have_one_scale_and_what_is_enlarged_says_so(seven):
    figure = seven.plot("tau")
    spans, factors = [], []
    for axes, values in zip(figure.axes, seven.tau.T, strict=True):
        low, high = axes.get_ylim()
        assert low < values.min() and high > values.max()
        told = [text.get_text() for text in axes.texts]
        factors.append(int(told[0].removeprefix("×")) if told else 1)
        spans.append(high - low)
    assert 1 in factors and max(factors) >= 5
    np.testing.assert_allclose(np.array(spans) * factors, spans[factors.index(1)], rtol=1e-9)
    # None is so small that its next factor would have fitted too.
    sizes = [max(*column, 0.0) - min(*column, 0.0) for column in seven.tau.T]
    assert min(np.array(sizes) * factors) > 0.15 * max(sizes)
    assert legends(figure) == ["×n: enlarged n times"]


def test_numbers_stand_at_the_first_panel_of_a_scale(seven):
    figure = seven.plot("tau")
    rows = {}
    for axes in figure.axes:
        numbered = axes.yaxis.get_tick_params()["labelleft"]
        row = axes.get_subplotspec().rowspan.start
        assert numbered == (axes.get_ylim() not in rows.setdefault(row, []))
        rows[row].append(axes.get_ylim())


def test_time_has_its_numbers_below_every_column_alone(seven):
    figure = seven.plot("q", "e")
    numbered = [axes.xaxis.get_tick_params()["labelbottom"] for axes in figure.axes]
    assert numbered == [False] * 7 + [False] * 3 + [True] * 4


def test_a_prismatic_joint_has_millimetres_and_newtons(tmp_path):
    arm = sa.Serial.from_dh(
        [0.0, 0.3], 0.0, 0.0, kind=["prismatic", "revolute"], mass=2.0, inertia=[[0.1] * 3] * 2
    )
    tracker = sa.ComputedTorque(arm, 100, 20)
    run = sa.simulate(sa.Plant(arm), tracker, sa.Quintic([0, 0], [0.1, 0.2], 0.1), 0.1, 1e-3)
    run.save(tmp_path / "run.npz")
    for one in (run, sa.Run.load(tmp_path / "run.npz")):
        figure = one.plot()
        assert labels(figure) == ["position [m]", "error [mm]", "force [N]"]
        turning = [axes.get_title("right") for axes in figure.axes[1::2]]
        assert turning == ["joint2 [rad]", "[mrad]", "[N·m]"]
        assert legends(plots.errors({"it": one}))[0].count(" m") == 2


def test_curves_keep_their_peaks_on_few_points(plain):
    figure = sa.paper.simulation(2).run().plot("q", width=3.5)
    run = sa.paper.simulation(2).run()
    for axes, values in zip(figure.axes, run.q.T, strict=True):
        t, shown = axes.get_lines()[0].get_data()
        assert len(t) <= 3.5 * 300 + 2 < len(run.t)
        assert (shown.min(), shown.max()) == (values.min(), values.max())
        assert (t[0], t[-1]) == (run.t[0], run.t[-1])
        assert np.array_equal(shown, values[np.searchsorted(run.t, t)])


def test_vector_files_are_small_and_keep_letters(tmp_path, seven):
    seven.plot().savefig(tmp_path / "run.pdf")
    seven.plot("e", joints=4).savefig(tmp_path / "run.svg")
    pdf = (tmp_path / "run.pdf").read_bytes()
    assert b"/Type42" in pdf or b"/CIDFontType2" in pdf
    assert b"/Type3" not in pdf
    assert ">panda_joint4</text>" in (tmp_path / "run.svg").read_text(encoding="utf-8")
    assert len(pdf) < 1e6


@pytest.mark.parametrize("style", ["light", "dark"])
def test_letters_and_curves_stand_out_in_both_styles(seven, style):
    figure = seven.plot(style=style, joints=[1, 2])
    drawn(figure)
    paper = luminance(figure.get_facecolor())
    assert (paper > 0.9) == (style == "light")
    for text in figure.findobj(Text):
        if text.get_text():
            assert contrast(luminance(text.get_color()), paper) > 7.0, text
    curves = [line for axes in figure.axes for line in axes.get_lines()]
    assert all(contrast(luminance(line.get_color()), paper) > 1.9 for line in curves)


def test_curves_that_are_compared_differ_without_colours():
    for look in LOOKS.values():
        lines = [str(line) for _, line in look.cycle]
        hatches = [hatch for _, hatch in look.areas]
        assert len(set(lines)) == len(lines) and len(set(hatches)) == len(hatches)


BLINDNESS = {
    "deutan": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "protan": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "tritan": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}
"""What is seen of linear red, green and blue (Machado, Oliveira, Fernandes 2009)."""


@pytest.mark.parametrize("kind", BLINDNESS)
@pytest.mark.parametrize("style", LOOKS)
def test_colours_that_are_compared_differ_for_the_colour_blind(kind, style):
    seen = [perceived(BLINDNESS[kind] @ linear(colour)) for colour, _ in LOOKS[style].cycle]
    assert min(np.linalg.norm(a - b) for k, a in enumerate(seen) for b in seen[:k]) > 10.0


def perceived(rgb):
    """CIE L*a*b* of linear red, green and blue."""
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = to_xyz @ rgb.clip(0, 1) / to_xyz.sum(axis=1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def linear(colour):
    channels = np.array(to_rgb(colour))
    return np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)


def luminance(colour):
    """Of WCAG 2."""
    return float(linear(colour) @ (0.2126, 0.7152, 0.0722))


def contrast(one, other):
    return (max(one, other) + 0.05) / (min(one, other) + 0.05)


def test_a_name_is_no_mathematics(plain):
    figure = plots.errors({"$k_p$ = 8": plain})
    drawn(figure)
    assert legends(figure)[0].startswith(r"\$k_p\$ = 8")
