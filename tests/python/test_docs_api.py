"""The Python reference has every public name once, with its types, shapes and defaults."""

import ast
import importlib
import importlib.util
import inspect
import re
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest
import steadyarm as sa

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs/api").glob("*.md"))
TEXTS = {page.stem: page.read_text(encoding="utf-8") for page in PAGES}

WHOLE = ("laws", "paper")
"""Modules of which the reference has all."""

HELPERS = {"plots.frame", "animation.joint_points"}
"""What other modules of the package take, and nobody else."""


def signatures() -> ModuleType:
    """The extension of the manual that knows the types."""
    spec = importlib.util.spec_from_file_location("signatures", ROOT / "docs/_ext/signatures.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


EXTENSION = signatures()


def listed() -> Counter[str]:
    """How often each name is in the reference."""
    text = "\n".join(TEXTS.values())
    names = re.findall(r"auto(?:class|function|exception):: steadyarm\.([\w.]+)", text)
    modules = re.findall(r"automodule:: steadyarm\.(\w+)\n +:members:(.*)", text)
    for module, members in modules:
        names += [f"{module}.{name}" for name in re.findall(r"\w+", members)] or [module]
    return Counter(names)


def test_every_public_name_is_on_exactly_one_page() -> None:
    names = listed()
    wanted = [name for name in sa.__all__ if name != "__version__"]
    assert {name: names[name] for name in wanted if names[name] != 1} == {}


@pytest.mark.parametrize("module", ["plots", "animation"])
def test_every_function_of_a_public_module_is_on_exactly_one_page(module: str) -> None:
    named = vars(importlib.import_module(f"steadyarm.{module}"))
    own = [
        f"{module}.{name}"
        for name, it in named.items()
        if inspect.isfunction(it) or inspect.isclass(it)
        if not name.startswith("_") and it.__module__ == f"steadyarm.{module}"
    ]
    assert own
    names = listed()
    assert {name: names[name] for name in {*own} - HELPERS if names[name] != 1} == {}


def test_every_name_of_the_table_of_tasks_is_there() -> None:
    for name in re.findall(r"`sa\.([\w.]+)`", TEXTS["index"] + TEXTS["files"]):
        thing = sa
        for part in name.split("."):
            thing = getattr(thing, part)


def test_every_page_of_the_reference_is_in_its_contents() -> None:
    assert [name for name in TEXTS if name != "index" and f"\n{name}\n" not in TEXTS["index"]] == []


def test_long_pages_have_a_table_of_contents() -> None:
    long = [name for name, text in TEXTS.items() if text.count("\n## ") > 1 and name != "index"]
    assert len(long) > 5
    assert [name for name in long if "{contents}" not in TEXTS[name]] == []


@pytest.mark.parametrize(
    ("name", "parameter", "shown"),
    [
        ("TwoLink.__new__", "gravity", "gravity: float | None = None"),
        ("Serial.from_dh", "kind", "'revolute' | 'continuous' | 'prismatic' | list["),
        ("Controller.step", "applied", "applied: array_like | None = None"),
        ("Plant.__new__", "disturbance", "Curve | Disturbance | callable | list["),
        ("Guard.__new__", "*", "*, position_limits: array_like | None = None"),
    ],
)
def test_signature_of_the_core_has_types_and_defaults(
    name: str, parameter: str, shown: str
) -> None:
    node = EXTENSION.of_core(name)
    parameters = EXTENSION.arguments(node)
    assert parameter in [it.name for it in parameters] + ["*"]
    assert shown in EXTENSION.written(parameters, "", name.split(".")[0])


def test_signature_of_the_package_has_types_and_defaults() -> None:
    parameters = [*inspect.signature(sa.simulate).parameters.values()]
    written = EXTENSION.written(parameters, "steadyarm.simulation", "")
    assert "plant: Plant, tracker: Controller | Guard, reference: Curve | callable," in written
    assert "method: 'rk4' | 'dp54' = 'rk4', *, control_period: float | None = None," in written
    path = EXTENSION.short("Path | None", "steadyarm.centers")
    assert path == "Curve | callable | array_like | None"


@pytest.mark.parametrize(
    ("name", "type_"),
    [
        ("ComputedTorque.kp", "array (n,)"),
        ("ComputedTorque.tau_model", "array (n,) | None"),
        ("RiccatiSolution.P", "array (S, S)"),
        ("Run.q", "array (T, n)"),
        ("Run.t", "array (T,)"),
        ("Run.status", "Status"),
        ("Run.joints", "int"),
        ("Attribution.error_shares", "dict[str, array]"),
        ("comparison.Row.rms_e", "float | None"),
    ],
)
def test_attribute_has_type_and_shape(name: str, type_: str) -> None:
    assert EXTENSION.attribute_type(f"steadyarm.{name}") == type_


def test_every_attribute_of_the_core_has_a_type_or_may_be_anything() -> None:
    properties = [
        f"{kind}.{it.name}"
        for kind, node in EXTENSION.CORE.items()
        if isinstance(node, ast.ClassDef) and hasattr(sa, kind)
        for it in node.body
        if isinstance(it, ast.FunctionDef) and "property" in map(ast.unparse, it.decorator_list)
    ]
    assert len(properties) > 50
    free = [name for name in properties if not EXTENSION.attribute_type(f"steadyarm.{name}")]
    assert set(free) == {"Controller.law", "FuzzyBasis.width"}
