"""Scenario files out of the schema: the least of a section, with what a test puts into it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import steadyarm as sa

SCHEMA: dict[str, Any] = json.loads(
    (Path(sa.__file__).parent / "scenarios" / "schema.json").read_text(encoding="utf-8")
)
Object = tuple[tuple[str, ...], dict[str, Any]]


def inline(value: Any) -> str:
    """A value in TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value) if isinstance(value, str | bool) else repr(value)


def text(sections: dict[str, Any]) -> str:
    """Sections as a file."""
    return "".join(f"{name} = {inline(value)}\n" for name, value in sections.items())


def resolved(schema: dict[str, Any]) -> dict[str, Any]:
    while "$ref" in schema:
        schema = SCHEMA["definitions"][schema["$ref"].rsplit("/", 1)[1]]
    return schema


def example(schema: dict[str, Any]) -> Any:
    """A value that the schema gives, or the least object."""
    schema = resolved(schema)
    if "examples" in schema:
        return schema["examples"][0]
    if schema.get("type") == "array":
        return [example(schema["items"])]
    if "anyOf" in schema or "oneOf" in schema:
        return example(schema.get("anyOf", schema.get("oneOf"))[0])
    return least(schema)


def least(schema: dict[str, Any], *keys: str) -> dict[str, Any]:
    """The least object that has these keys."""
    wanted = [*schema.get("required", ()), *keys]
    if not wanted and schema.get("minProperties"):
        wanted = [next(iter(schema["properties"]))]
    for key in wanted:
        wanted += [one for one in schema.get("dependencies", {}).get(key, ()) if one not in wanted]
    return {key: example(schema["properties"][key]) for key in wanted}


def objects() -> Iterator[Object]:
    """Every object that has keys of its own, with its path; the whole file first."""
    yield (), SCHEMA
    sections = SCHEMA["properties"]
    for name in sections:
        found = resolved(sections[name])
        if name == "disturbance":
            yield from below((name,), resolved(found["anyOf"][0]))
        elif name == "controllers":
            for law in resolved(found["additionalProperties"])["oneOf"]:
                law = resolved(law)
                yield from below((name, law["properties"]["law"]["enum"][0]), law)
        elif "properties" in found:
            yield from below((name,), found)


def below(path: tuple[str, ...], schema: dict[str, Any]) -> Iterator[Object]:
    yield path, schema
    for key, part in schema["properties"].items():
        part = resolved(part)
        if "properties" in resolved(part.get("items", {})):
            yield from below((*path, f"{key}[0]"), resolved(part["items"]))
        # A curve of a wrench has six columns; its keys are those of any other.
        if "properties" in part and path[-1] != "wrench":
            yield from below((*path, key), part)


def within(path: tuple[str, ...], content: Any) -> dict[str, Any]:
    """The least file with this content at a path."""
    sections: dict[str, Any] = {}
    at, schema = sections, SCHEMA
    for place, key in enumerate(path):
        if place == 1 and path[0] == "controllers":
            laws = [resolved(law) for law in resolved(SCHEMA["definitions"]["law"])["oneOf"]]
            schema = next(law for law in laws if law["properties"]["law"]["enum"][0] == key)
        else:
            schema = resolved(schema["properties"][key.removesuffix("[0]")])
        if "items" in schema:
            schema = resolved(schema["items"])
        if path[: place + 1] == ("disturbance",):
            schema = resolved(schema["anyOf"][0])
        last = place == len(path) - 1
        only = "minProperties" in schema or schema.get("additionalProperties")
        found = content if last else {} if only else least(schema)
        at[key.removesuffix("[0]")] = [found] if key.endswith("[0]") else found
        at = found
    return sections if path else content


ALL = list(objects())
