"""Tables in a notebook: what they show, with which units, and that nothing in them is markup."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import steadyarm as sa
from steadyarm.comparison import Row

TURNS = sa.Serial.shipped("panda")
SLIDES = sa.Serial.from_dh(
    [0.0, 0.3], 0.0, 0.0, kind=["prismatic", "revolute"], mass=2.0, inertia=[[0.1] * 3] * 2
)
PANDA = np.array((0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8))


def parsed(shown: Any) -> ElementTree.Element:
    """What a notebook is given, which is well-formed."""
    return ElementTree.fromstring(f"<all>{shown._repr_html_()}</all>")


def texts(element: ElementTree.Element) -> str:
    return "".join(element.itertext())


def rows(shown: Any) -> dict[str, list[str]]:
    """The rows of all tables by their heads."""
    found = {}
    for line in parsed(shown).iter("tr"):
        head, *cells = [texts(cell) for cell in line]
        found[head] = cells
    return found


def run_of(arm: sa.Serial, start: Any = 0.0) -> sa.Run:
    q = np.zeros(arm.joints) + start
    loop = {"control_period": 1e-3, "q0": q}
    path = sa.Quintic(q, q + 0.2, 0.3)
    return sa.simulate(sa.Plant(arm.with_payload(1.0)), tracker(arm), path, 0.3, 1e-3, **loop)


def tracker(arm: sa.Serial) -> sa.ComputedTorque:
    basis = sa.FuzzyBasis("per_joint", centers=(-1.0, 0.0, 1.0), width=0.5, inputs="reference")
    return sa.ComputedTorque(arm, 100, 20, compensator=sa.FuzzyCompensator(basis, gain=10.0))


@pytest.fixture(scope="module")
def run() -> sa.Run:
    return run_of(TURNS, PANDA)


@pytest.fixture(scope="module")
def report() -> sa.DesignReport:
    path = sa.Sines(1.0, [0.2] * 7, offset=PANDA)
    return sa.design(tracker(TURNS), path=path, plant=sa.Plant(TURNS.with_payload(1.0)))


@pytest.fixture(scope="module")
def learned() -> sa.Learned:
    path = sa.Quintic(PANDA, PANDA + 0.2, 0.3)
    return sa.learned(sa.recommended(TURNS.without_friction(), path=path))


@pytest.fixture(scope="module")
def all_of_them(run: sa.Run, report: sa.DesignReport, learned: sa.Learned) -> list[Any]:
    return [run.metrics(), report, report.learnable, learned, sa.attribution(run)]


def test_every_table_has_a_column_a_joint_by_its_name(all_of_them: list[Any]) -> None:
    for shown in all_of_them:
        tables = list(parsed(shown).iter("table"))
        assert tables
        for table in tables:
            head, *body = [[texts(cell) for cell in line] for line in table.iter("tr")]
            assert head == ["", *(f"panda_joint{n}" for n in range(1, 8))]
            assert body and all(len(line) == 8 for line in body)


def test_metrics_are_in_the_units_of_their_rows(run: sa.Run) -> None:
    figures, found = run.metrics(), rows(run.metrics())
    for joint in range(7):
        told = float(found["RMS error [mrad]"][joint])
        assert told == pytest.approx(1e3 * figures.rms_e[joint], rel=6e-3)
        torque = float(found["peak torque [N·m]"][joint])
        assert torque == pytest.approx(figures.max_abs_tau[joint], rel=6e-3)
    cell = next(cell for cell in parsed(figures).iter("td"))
    assert cell.attrib["title"] == f"{1e3 * figures.rms_e[0]:.6g}"


def test_a_prismatic_joint_has_metres_and_newtons() -> None:
    run = run_of(SLIDES)
    found = rows(run.metrics())
    assert found["RMS error [mm]"][1].endswith(" mrad") and "rad" not in found["RMS error [mm]"][0]
    assert found["peak torque [N]"][1].endswith(" N·m")
    assert rows(sa.attribution(run))["RMS error [mm]"][1].endswith(" mrad")
    report = rows(sa.design(tracker(SLIDES), path=sa.Quintic([0, 0], [0.1, 0.2], 1.0)))
    assert report["stiffness [N/m]"][1].endswith(" N·m/rad")


def test_what_is_not_recorded_or_not_known_is_left_out() -> None:
    short = sa.paper.simulation(2, duration=0.1)
    still = sa.simulate(short.plant, short.tracker, short.reference, 0.1, record="motion")
    assert "RMS error [mrad]" in rows(still.metrics())
    assert not any("torque" in head for head in rows(still.metrics()))
    alone = sa.design(short.tracker)
    assert "P: p11" not in rows(alone) and "nan" not in alone._repr_html_()


def test_a_report_has_its_figures_poles_verdict_and_findings(report: sa.DesignReport) -> None:
    found, words = rows(report), texts(parsed(report))
    for head, values in report._rows().items():
        assert not np.isnan(values).all() and len(found[head]) == 7
    assert float(found["spectral radius when sampled"][0]) == pytest.approx(
        report.sampled_radius[0], rel=1e-5
    )
    assert found["poles [1/s]"][3].count(", ") == 2
    assert f"Verdict: {report.verdict}" in words
    assert report.learnable is not None
    for sentence in (*report.findings, *report.learnable.sentences, *report.left_out):
        assert sentence in words


def test_shares_add_up_in_the_table_of_causes(run: sa.Run) -> None:
    found = sa.attribution(run)
    tables = [table for table in parsed(found).iter("table") if "Shares" in texts(table)]
    assert len(tables) == 2
    for table in tables:
        body = [[texts(cell) for cell in line][1:] for line in table.iter("tr")][1:]
        sums = np.array([[float(cell) for cell in line] for line in body]).sum(axis=0)
        np.testing.assert_allclose(sums, 100.0, atol=1.0)
    assert texts(parsed(found)).startswith(found.sentence())


def test_what_was_learnt_has_deviations_and_the_load(learned: sa.Learned) -> None:
    found = rows(learned)
    torque, deviation = learned.friction(1.0)
    assert found["friction at 1 rad/s [N·m]"][6] == f"{torque[6]:.3g} ± {deviation[6]:.2g}"
    assert "load at the tip" in texts(parsed(learned))


HOSTILE = '<b onload="x">&\x1b'


def hostile(shown: Any) -> Iterator[Any]:
    names = (HOSTILE, *shown.joint_names[1:])
    yield replace(shown, joint_names=names)
    if hasattr(shown, "findings"):
        yield replace(shown, findings=(HOSTILE,), left_out=(HOSTILE,))
    if hasattr(shown, "notes"):
        yield replace(shown, notes=(HOSTILE,))


def test_no_text_is_markup(all_of_them: list[Any]) -> None:
    comparison = sa.Comparison([Row(HOSTILE, reason=HOSTILE, status="diverged")])
    for shown in [comparison, *(it for one in all_of_them for it in hostile(one))]:
        page = parsed(shown)
        assert '<b onload="x">&\\x1b' in texts(page)
        assert not list(page.iter("b"))


def test_a_comparison_and_a_joint_table_are_made_alike(run: sa.Run) -> None:
    comparison = sa.Comparison([Row.of(run, controller="one")])
    frames: list[Callable[[], str]] = [comparison._repr_html_, run.metrics()._repr_html_]
    for frame in frames:
        html = frame()
        assert 'style="overflow-x:auto"><table>' in html and "<caption" in html
        assert "color:" not in html and "background" not in html
