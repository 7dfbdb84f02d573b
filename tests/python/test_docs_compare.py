"""What the pages on comparisons and scenarios say of laws, keys and figures is so."""

import inspect
import re
from dataclasses import replace

import pytest
import steadyarm as sa
from steadyarm._comparison_words import rounded
from test_docs import ROOT, TEXTS, blocks

COMPARE = ROOT / "docs/compare.md"
SENSORS = ROOT / "docs/sensors.md"
SCENARIOS = ROOT / "docs/scenarios.md"
PAPER = ROOT / "docs/paper.md"

ELSEWHERE = {"arm", "common", "bandwidth", "compensator"}
"""Arguments of laws that no row has to repeat."""


def rows(page, first: str) -> list[list[str]]:
    """Cells of the table whose head begins with these words."""
    text = page.read_text(encoding="utf-8")
    table = text[text.index(f"| {first} |") :].split("\n\n")[0]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]


def ticked(cell: str) -> list[str]:
    return re.findall(r"`([\w.]+)`", cell)


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: page.name)
def test_toml_of_the_manual_is_read(page) -> None:
    for text in blocks(page, "toml"):
        assert any(value is not None for value in sa.read_scenario(text).values())


def test_the_whole_scenario_runs() -> None:
    scene = sa.Scenario.of(sa.read_scenario(blocks(SCENARIOS, "toml")[0]))
    table = sa.compare(scene, freeze=False)
    assert {row.controller for row in table.rows} == {"computed_torque", "observer"}
    assert all(row.finished for row in table.rows)


def test_every_law_is_in_both_tables_with_its_arguments() -> None:
    laws = sorted(sa.laws.__all__)
    assert sorted(row[0].strip("`") for row in rows(COMPARE, "law")) == laws
    keys = {
        law: gains + beside
        for name, gains, beside in rows(SCENARIOS, "law")
        for law in ticked(name)
    }
    assert sorted(keys) == laws
    for law in laws:
        wanted = set(inspect.signature(getattr(sa.laws, law)).parameters) - ELSEWHERE
        assert set(ticked(keys[law])) - ELSEWHERE == wanted, law


def test_every_effect_is_in_the_page_on_sensors() -> None:
    effects = set(inspect.signature(sa.Effects).parameters)
    words = " ".join(SENSORS.read_text(encoding="utf-8").split())
    assert not [name for name in effects - {"seed"} if name not in words]


@pytest.mark.parametrize("section", ["robot", "actual", "effects", "front", "run", "metrics"])
def test_every_key_of_a_section_is_described(section) -> None:
    """With a key that is none the reader says which ones there are."""
    with pytest.raises(ValueError, match=f"{section}.x: unknown field") as refused:
        sa.read_scenario(f"[{section}]\nx = 1")
    known = re.findall(r"`(\w+)`", str(refused.value).split("expected")[1])
    text = SCENARIOS.read_text(encoding="utf-8")
    assert known
    assert not [key for key in known if not re.search(rf"`({section}\.)?{key}[`.]", text)]


def test_the_library_is_listed_whole() -> None:
    listed = [name for row in rows(SCENARIOS, "name") for name in ticked(row[0])]
    assert sorted(listed) == sa.scenario_names()


def figures(line) -> list[str]:
    """RMS [mrad], peak [N·m], variation [N·m/s], frozen [mrad] of a line of a table."""
    names = ("steady_rms_e", "max_abs_tau", "torque_variation", "frozen_rms_e")
    values = [line.median[name] for name in names]
    scaled = zip(values, (1e3, 1.0, 1.0, 1e3), strict=True)
    return ["–" if value is None else rounded(scale * value) for value, scale in scaled]


def test_the_table_of_rivals_is_what_the_scenarios_give() -> None:
    ideal, sensors = (
        {line.controller: figures(line) for line in sa.compare(name).table()}
        for name in ("paper_rivals", "paper_sensors")
    )
    told = {row[0].strip("`"): row[1:] for row in rows(PAPER, "controller")}
    assert told == {name: ideal[name][:3] + sensors[name] for name in told}
    assert set(told) == set(ideal)


CHANGED = {
    "as it is: 16 bits, difference, a sample late": {},
    '`velocity` "measured"': {"velocity": "measured"},
    '`velocity` "tracking"': {"velocity": "tracking"},
    '`velocity` "kalman"': {"velocity": "kalman"},
    "`joint_stiffness`, `rotor_inertia`": {"joint_stiffness": 1e4, "rotor_inertia": 0.5},
    "`backlash`, with these": {"joint_stiffness": 1e4, "rotor_inertia": 0.5, "backlash": 1e-3},
}
"""Effects of rows that say no name with its value."""


def test_what_effects_do_is_what_the_pid_gives() -> None:
    told = rows(SENSORS, "effect")
    assert len(told) == 15
    for effect, _, _, value, *shown in told:
        changes = CHANGED.get(effect)
        if changes is None:
            name = effect.strip("`")
            changes = {name: int(value) if name in ("encoder_bits", "delay") else float(value)}
        assert figures(pid(changes))[:3] == shown, effect


def test_what_the_front_does_is_what_the_pid_gives() -> None:
    text = " ".join(SENSORS.read_text(encoding="utf-8").split())
    plain, off_path, slow = pid({}), pid({}, hand_over=None), pid({}, velocity_filter=30.0)
    peaks = [rounded(line.median["max_abs_tau"]) for line in (plain, off_path)]
    assert f"is {peaks[0]} N·m with it and {peaks[1]} without" in text
    varied = [rounded(line.median["torque_variation"]) for line in (slow, plain)]
    assert f"varies by {varied[0]} N·m/s, not {varied[1]}" in text
    symptoms = " ".join((ROOT / "docs/symptoms.md").read_text(encoding="utf-8").split())
    assert f"by {varied[1]} N·m/s with 100 Hz and by {varied[0]} with 30" in symptoms


def pid(changes: dict, **front):
    """The line of the PID in `paper_sensors` with other effects and another front."""
    scene = sa.Scenario.read("paper_sensors")
    front = {key: value for key, value in {**scene.front, **front}.items() if value is not None}
    if changes.get("velocity"):
        front.pop("velocity_filter")
    if "delay" in changes:
        front["delay"] = changes["delay"]
    scene = replace(scene, effects=scene.effects.__replace__(**changes), front=front)
    (line,) = sa.compare(scene, only=["pid"]).table()
    return line
