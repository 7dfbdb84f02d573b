"""`help()` and the stub say the same of everything public in the core, and leave nothing out."""

from __future__ import annotations

import ast
import importlib
import inspect
import pydoc
import re
import sys
from itertools import pairwise
from pathlib import Path

import pytest
import steadyarm
import steadyarm._core as core
from steadyarm.comparison import FIGURES, Row

STUB = ast.parse(Path(core.__file__).with_name("_core.pyi").read_text(encoding="utf-8"))
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}


def public(names: list[str]) -> list[str]:
    return [name for name in names if not name.startswith("_")]


def words(text: str | None) -> str:
    """The text, whatever the lines are broken at."""
    return " ".join((text or "").split())


def member_of_stub(owner: str, name: str) -> ast.FunctionDef | None:
    """The getter or method `name` of a class, or of what it extends."""
    members = [node for node in CLASSES[owner].body if isinstance(node, ast.FunctionDef)]
    found = next((member for member in members if member.name == name), None)
    bases = (base.id for base in CLASSES[owner].bases if isinstance(base, ast.Name))
    inherited = (member_of_stub(base, name) for base in bases if base in CLASSES)
    return found or next((member for member in inherited if member), None)


def assert_same(said: str | None, stub: ast.Module | ast.ClassDef | ast.FunctionDef) -> None:
    assert words(said), "no docstring at run time"
    assert words(said) == words(ast.get_docstring(stub))


KINDS = public([name for name, value in vars(core).items() if inspect.isclass(value)])
PLAIN = public([name for name, value in vars(core).items() if inspect.isbuiltin(value)])
# What an exception inherits from Python is documented there; its attributes are in its class.
MEMBERS = [
    (kind, name)
    for kind in KINDS
    for name in public(dir(getattr(core, kind)))
    if not hasattr(ValueError, name)
]


def test_stub_and_core_have_the_same_classes_and_functions() -> None:
    assert sorted(KINDS) == sorted(public(list(CLASSES)))
    assert sorted(PLAIN) == sorted(public(list(FUNCTIONS)))
    assert len(MEMBERS) > 100


def test_module_has_the_docstring_of_the_stub() -> None:
    assert_same(core.__doc__, STUB)


@pytest.mark.parametrize("name", KINDS)
def test_class_has_the_docstring_of_the_stub(name: str) -> None:
    assert_same(getattr(core, name).__doc__, CLASSES[name])


@pytest.mark.parametrize("name", PLAIN)
def test_function_has_the_docstring_of_the_stub(name: str) -> None:
    assert_same(getattr(core, name).__doc__, FUNCTIONS[name])


@pytest.mark.parametrize(("kind", "name"), MEMBERS, ids=map(".".join, MEMBERS))
def test_member_has_the_docstring_of_the_stub(kind: str, name: str) -> None:
    stub = member_of_stub(kind, name)
    assert stub, "not in the stub"
    assert_same(inspect.getdoc(getattr(getattr(core, kind), name)), stub)


@pytest.mark.parametrize("kind", KINDS)
def test_stub_documents_no_member_that_is_not_there(kind: str) -> None:
    members = [node.name for node in CLASSES[kind].body if isinstance(node, ast.FunctionDef)]
    assert [name for name in public(members) if not hasattr(getattr(core, kind), name)] == []


@pytest.mark.parametrize("kind", KINDS)
def test_stub_documents_nothing_that_has_no_docstring_at_run_time(kind: str) -> None:
    """Python writes the docstrings of special methods itself: theirs stand in the class."""
    special = [node for node in CLASSES[kind].body if isinstance(node, ast.FunctionDef)]
    special = [node for node in special if node.name.startswith("__")]
    assert [node.name for node in special if ast.get_docstring(node)] == []


def documented_fields() -> list[tuple[type, str, str]]:
    """Class, field and the words below it, of every public class that is written in Python."""
    found = []
    for path in sorted(Path(core.__file__).parent.glob("[!_]*.py")):
        module = importlib.import_module(f"steadyarm.{path.stem}")
        module = sys.modules[module.__name__]
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in (it for it in tree.body if isinstance(it, ast.ClassDef)):
            for field, below in pairwise(node.body):
                if isinstance(field, ast.AnnAssign) and isinstance(below, ast.Expr):
                    words_below = ast.literal_eval(below.value)
                    name = ast.unparse(field.target)
                    found.append((getattr(module, node.name), name, words_below))
    return found


FIELDS = documented_fields()


def test_fields_are_found() -> None:
    assert len(FIELDS) > 100


@pytest.mark.parametrize(
    ("kind", "name", "below"), FIELDS, ids=[f"{kind.__name__}.{name}" for kind, name, _ in FIELDS]
)
def test_help_has_the_words_below_a_field_and_its_type(kind: type, name: str, below: str) -> None:
    shown = pydoc.plaintext.document(kind).replace("\n |", "\n")
    assert f" {name}: {' '.join(words(below).split())}" in words(
        re.sub(rf"(?m)^( +{name}): .+$", r"\1:", shown)
    )


def test_signals_and_figures_have_their_words_in_help() -> None:
    told = [(steadyarm.Run, name, unit, doc) for name, unit, _, doc in core.channels()]
    told += [(Row, figure.name, figure.unit, figure.doc[1:]) for figure in FIGURES.values()]
    for kind, name, unit, doc in told:
        assert re.search(
            rf"(?m)^{name}\b.*\n.*{re.escape(doc)} \[{re.escape(unit)}\]", kind.__doc__
        )
