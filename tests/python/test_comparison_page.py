"""The page of a comparison: one file that asks nobody, whatever the names and numbers are."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa
from comparisons import HOSTILE, VALUES, diverged, fake, row, rows
from hypothesis import given
from hypothesis import strategies as st
from steadyarm import _packed, _pareto
from steadyarm.comparison import STATUSES, Comparison, Row

VOID = {"meta", "input", "br", "link", "img", "hr"}


class Page(HTMLParser):
    """Elements of a page; tags must be closed in the order in which they were opened."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append((self.open[-1] if self.open else "", data))

    def of(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


def written(comparison: Comparison, folder: Path, **options: object) -> str:
    comparison.to_html(folder / "page.html", **options)  # type: ignore[arg-type]
    return (folder / "page.html").read_bytes().decode()


def usual() -> Comparison:
    made = [row(f"c{k}", scenario, k % 2) for k in range(4) for scenario in ("one", "two")]
    made += [Row.of(diverged(), controller="wild", scenario="one")]
    made += [Row("refused", "one", 0, "refused", "k₂ is too small")]
    return Comparison(made, scenario="A title", notes=["A note."])


def test_the_page_is_one_file_that_asks_nobody(tmp_path: Path) -> None:
    text = written(usual(), tmp_path, arm=sa.paper.nominal())
    page = Page(text)
    assert "http" not in text and "url(" not in text and "@import" not in text
    assert not page.of("link") and not page.of("img") and not page.of("iframe")
    for _, attributes in page.elements:
        assert not {"src", "href", "xlink:href", "action", "srcset"} & set(attributes)
        assert not [name for name in attributes if name.startswith("on")]
    for word in ("fetch(", "XMLHttpRequest", "import(", "WebSocket", "sendBeacon", "innerHTML"):
        assert word not in text


def test_the_table_is_plain_html_with_scopes_caption_and_order(tmp_path: Path) -> None:
    page = Page(written(usual(), tmp_path))
    assert len(page.of("table")) == len(page.of("caption")) == 2
    scopes = [attributes.get("scope") for attributes in page.of("th")]
    assert set(scopes) == {"col", "row"} and scopes.count("row") == 10
    ordered = [attributes for attributes in page.of("th") if "aria-sort" in attributes]
    assert [attributes["aria-sort"] for attributes in ordered] == ["ascending"] * 2
    assert page.of("html")[0]["lang"] == "en"
    assert len({each["id"] for _, each in page.elements if "id" in each}) == len(
        [each for _, each in page.elements if "id" in each]
    )
    told = "".join(text for _, text in page.texts)
    for words in ("A title", "A note.", "refused: k₂ is too small", "diverged: at t = ", "1/1"):
        assert words in told
    # What needs the script is hidden until it runs.
    assert [each["id"] for each in page.of("section") if "hidden" in each] == ["curves", "arms"]


def test_names_are_text_and_nothing_else(tmp_path: Path) -> None:
    made = [
        Row.of(
            row_run, controller=name, scenario=scenario, seed=seed, frozen=row_run, step_time=1e-6
        )
        for row_run in [fake(*(np.arange(3.0), *[np.arange(6.0).reshape(3, 2)] * 3))]
        for name in HOSTILE
        for scenario in HOSTILE[:2]
        for seed in (0, 1)
    ]
    made += [Row(name, HOSTILE[0], 7, status, name) for name in HOSTILE for status in STATUSES]
    for scenario in HOSTILE:
        text = written(Comparison(made, scenario=scenario, notes=HOSTILE), tmp_path)
        page = Page(text)
        assert len(page.of("script")) == 2
        assert sum(tag == "script" for tag, _ in page.texts) >= 2
        assert not [each for each in page.elements if each[0] in ("b", "x", "img")]
        assert "\x00" not in text and "\x1b" not in text and "\u202e" not in text
        data = next(text for tag, text in page.texts if tag == "script" and text.startswith("{"))
        names = {curve["name"] for scene in json.loads(data)["scenes"] for curve in scene["curves"]}
        assert len(names) == len(HOSTILE) and HOSTILE[0] in names


@given(st.lists(st.tuples(*[st.sampled_from(VALUES)] * 3), max_size=5))
def test_any_figures_make_a_page(values: list[tuple[float | None, ...]]) -> None:
    made = [
        Row(f"c{k}", steady_rms_e=a, torque_variation=b, step_time=c, itae=a)
        for k, (a, b, c) in enumerate(values)
    ]
    Page(Comparison(made)._repr_html_())
    page = Page(_pareto.drawn(Comparison(made).table(), 0))
    for attributes in (*page.of("circle"), *page.of("line")):
        numbers = [float(v) for k, v in attributes.items() if k in ("cx", "cy", "x1", "y1")]
        assert all(math.isfinite(number) and -1 <= number <= 721 for number in numbers)


@given(
    st.lists(
        st.tuples(st.floats(1e-6, 10), st.floats(0.1, 1e4)), min_size=2, max_size=9, unique=True
    )
)
def test_the_line_of_the_plot_joins_those_that_no_other_beats(
    values: list[tuple[float, float]],
) -> None:
    made = [Row(f"c{k}", steady_rms_e=a, torque_variation=b) for k, (a, b) in enumerate(values)]
    page = Page(_pareto.drawn(Comparison(made).table(), 0))
    points = [attributes for attributes in page.of("g")]
    best = {str(p["aria-label"]).split(":")[0] for p in points if "best" in str(p["class"])}
    assert best == {
        f"c{k}"
        for k, (a, b) in enumerate(values)
        if not any(x <= a and y <= b and (x, y) != (a, b) for x, y in values)
    }
    assert len(points) == len(values)
    assert 2 <= sum("grid" in str(each["class"]) for each in page.of("line")) <= 22


def unpacked(curve: list) -> np.ndarray:
    low, high, text = curve
    order = {letter: place for place, letter in enumerate(_packed.ALPHABET)}
    steps = np.array([64 * order[a] + order[b] for a, b in zip(text[::2], text[1::2], strict=True)])
    return np.where(steps == 4095, np.nan, low + (high - low) * steps / 4094)


def embedded(text: str) -> dict:
    data = next(words for tag, words in Page(text).texts if tag == "script" and words[0] == "{")
    return json.loads(data)


def test_curves_of_the_page_are_those_of_the_rows(tmp_path: Path) -> None:
    made = row()
    assert made.curves is not None
    (curve,) = embedded(written(Comparison([made]), tmp_path))["scenes"][0]["curves"]
    assert np.abs(unpacked(curve["t"]) - made.curves.t).max() < 4.0 / 4094
    for joint in range(2):
        error, torque = unpacked(curve["e"][joint]), unpacked(curve["tau"][joint])
        span = np.ptp(made.curves.tau[:, joint])
        assert np.abs(torque - made.curves.tau[:, joint]).max() <= 0.51 * span / 4094 + 1e-4
        ratio = 10**error / np.maximum(made.curves.e[:, joint], 1e-12)
        assert np.abs(ratio - 1).max() < 0.01


def test_gaps_stay_gaps_and_one_value_is_a_curve() -> None:
    assert np.isnan(unpacked(_packed.packed(np.array([1.0, np.nan, 3.0])))[1])
    assert np.isnan(unpacked(_packed.packed(np.full(3, np.nan)))).all()
    assert (unpacked(_packed.packed(np.full(3, 7.0))) == 7.0).all()


@pytest.mark.parametrize("joints", [2, 7, 12])
def test_a_page_of_16_controllers_is_small_and_keeps_the_peaks(joints: int, tmp_path: Path) -> None:
    made = rows(16, joints)
    text = written(Comparison(made), tmp_path)
    assert len(text.encode()) <= 300_000
    for curve in embedded(text)["scenes"][0]["curves"]:
        kept = next(each.curves for each in made if each.controller == curve["name"])
        assert kept is not None and len(curve["e"]) == joints
        for joint in range(joints):
            peak, most = unpacked(curve["tau"][joint]).max(), kept.tau[:, joint].max()
            assert peak == pytest.approx(most, rel=1e-3)


def test_an_arm_in_motion_fits_too_and_is_where_the_run_was(tmp_path: Path) -> None:
    arm, made = sa.paper.nominal(), [row(f"c{k}") for k in range(16)]
    text = written(Comparison(made), tmp_path, arm=arm)
    assert len(text.encode()) <= 300_000
    frames = embedded(text)["scenes"][0]["curves"][0]["arm"]
    places = np.array([unpacked(side) for side in frames["places"]])
    curves = made[0].curves
    assert curves is not None
    for frame, t in enumerate(unpacked(frames["t"])):
        q = curves.q[np.abs(curves.t - t).argmin()]
        assert places[-2:, frame] == pytest.approx(arm.pose(q)[:2, 3], abs=2e-3)
        assert places[:2, frame] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_an_arm_of_other_joints_moves_nothing(tmp_path: Path) -> None:
    comparison = Comparison(rows(2, 3))
    assert (
        embedded(written(comparison, tmp_path, arm=sa.paper.nominal()))["scenes"][0]["curves"][0][
            "arm"
        ]
        is None
    )
    with pytest.raises(TypeError, match="arm: got int, wants a TwoLink or a Serial"):
        comparison.to_html(tmp_path / "page.html", arm=3)


def test_the_same_rows_give_the_same_page(tmp_path: Path) -> None:
    first, second = (written(usual(), tmp_path, arm=sa.paper.nominal()) for _ in range(2))
    assert first == second


def test_a_page_without_curves_or_rows_is_a_page(tmp_path: Path) -> None:
    for made in ([], [Row("a", status="refused", reason="no")], [row(curves=False)]):
        page = Page(written(Comparison(made), tmp_path))
        assert not [each for each in page.of("script") if each.get("type")]


def test_a_scenario_of_many_lines_is_told_below(tmp_path: Path) -> None:
    text = written(Comparison([row()], scenario="[run]\nx = '<b>'\n"), tmp_path)
    assert "<pre>[run]\nx = &#x27;&lt;b&gt;&#x27;</pre>" in text
    assert "<h1>Comparison of controllers</h1>" in text


def test_notebooks_get_the_table_without_a_script() -> None:
    page = Page(usual()._repr_html_())
    assert len(page.of("table")) == 2 and not page.of("script")


def test_a_page_takes_the_place_of_another_as_a_whole(tmp_path: Path) -> None:
    written(usual(), tmp_path)
    before = (tmp_path / "page.html").read_bytes()
    with pytest.raises(ValueError, match="sort: got 'x'"):
        usual().to_html(tmp_path / "page.html", sort="x")
    assert (tmp_path / "page.html").read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["page.html"]


@pytest.mark.skipif(shutil.which("node") is None, reason="node reads the script")
def test_the_script_is_a_script(tmp_path: Path) -> None:
    parts = [Path(sa.__file__).with_name(f"_{name}.js") for name in ("page", "comparison")]
    source = "".join(part.read_text(encoding="utf-8") for part in parts)
    (tmp_path / "script.js").write_text(source, encoding="utf-8")
    subprocess.run(["node", "--check", tmp_path / "script.js"], check=True)
