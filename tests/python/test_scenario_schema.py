"""The JSON Schema of scenario files: it knows the keys that the reader knows, and no others."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import steadyarm as sa
from scenario_files import ALL, SCHEMA, example, least, resolved, text, within
from steadyarm import laws
from steadyarm._core import read_scenario
from steadyarm.bench import LIBRARY, scenario_names
from steadyarm.cli import main

jsonschema = pytest.importorskip("jsonschema")
VALID = jsonschema.Draft4Validator(SCHEMA)

objects = pytest.mark.parametrize(
    ("path", "schema"), ALL, ids=[".".join(path) or "file" for path, _ in ALL]
)
Path_ = tuple[str, ...]


def content(schema: dict[str, Any], key: str) -> dict[str, Any]:
    """The least object with a key; one of a choice alone."""
    if "minProperties" in schema:
        return {key: example(schema["properties"][key])}
    return least(schema, key)


def test_it_is_a_schema() -> None:
    jsonschema.Draft4Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("name", scenario_names())
def test_every_shipped_scenario_is_valid(name: str) -> None:
    file = (LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    assert file.startswith("#:schema ./schema.json\n"), "editors look for it there"
    assert [error.message for error in VALID.iter_errors(tomllib.loads(file))] == []


@objects
def test_the_reader_accepts_every_key_of_the_schema(path: Path_, schema: dict[str, Any]) -> None:
    for key in schema["properties"]:
        file = within(path, content(schema, key))
        read_scenario(text(file))
        assert VALID.is_valid(file), key


@objects
def test_both_refuse_an_unknown_key_and_know_the_same_ones(
    path: Path_, schema: dict[str, Any]
) -> None:
    choice = "minProperties" in schema
    file = within(path, {"unknown": {}} if choice else least(schema) | {"unknown": 1})
    assert not VALID.is_valid(file)
    with pytest.raises(ValueError) as caught:
        read_scenario(text(file))
    # The reader's own words list what it knows.
    known = set(re.findall(r"`(\w+)`", str(caught.value))) - {"unknown"}
    tag = {"law"} if path[:1] == ("controllers",) and len(path) == 2 else set()
    nested = {"wrench"} if path[-2:] == ("wrench", "curve") else set()
    assert known == set(schema["properties"]) - tag | nested


@pytest.mark.parametrize(
    "section",
    [
        "reference",
        "transfer",
        "disturbance",
    ],
)
def test_both_refuse_two_of_a_choice(section: str) -> None:
    file = {
        section: {"sines": {"frequency": 1.0}, "quintic": {"start": 0, "goal": 1, "duration": 1}}
    }
    assert not VALID.is_valid(file)
    with pytest.raises(ValueError, match=section):
        read_scenario(text(file))


@objects
def test_both_miss_what_is_required(path: Path_, schema: dict[str, Any]) -> None:
    for key in schema.get("required", ()):
        file = within(path, {k: v for k, v in least(schema).items() if k != key})
        assert not VALID.is_valid(file), key
        with pytest.raises(ValueError, match=key):
            read_scenario(text(file))


def test_it_has_every_law_and_says_what_each_key_is() -> None:
    chosen = [resolved(law) for law in SCHEMA["definitions"]["law"]["oneOf"]]
    assert sorted(law["properties"]["law"]["enum"][0] for law in chosen) == sorted(
        [*laws.__all__, "recommended"]
    )
    for path, schema in ALL:
        for key, part in schema["properties"].items():
            assert resolved(part)["description"], (path, key)


def test_the_defaults_are_those_of_the_reader() -> None:
    run = read_scenario("[run]")["run"]
    for key, part in SCHEMA["definitions"]["run"]["properties"].items():
        assert run[key] == part.get("default"), key
    effects = sa.Effects().__reduce__()[1]
    names = SCHEMA["definitions"]["effects"]["properties"]
    for (key, part), value in zip(names.items(), effects, strict=True):
        if key != "effort_rate_limit":
            assert value == part.get("default"), key


def test_the_command_prints_it(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["scenario", "--schema"]) == 0
    assert capsys.readouterr().out == (LIBRARY / "schema.json").read_text(encoding="utf-8")
    assert main(["scenario", "paper_1", "--schema"]) == 2
