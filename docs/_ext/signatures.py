"""Types and defaults of the package's names, in short words, from its stub and its annotations.

``array_like`` is anything that numpy makes an array of, ``array`` what comes back.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from pathlib import Path

import steadyarm
from steadyarm.run import CHANNELS

STUB = ast.parse(Path(steadyarm.__file__).with_name("_core.pyi").read_text(encoding="utf-8"))
CORE = {it.name: it for it in STUB.body if isinstance(it, ast.ClassDef | ast.FunctionDef)}

OF_PATHS = {f"steadyarm.{name}" for name in ("centers", "design", "learnable", "paths")}
OF_PATHS |= {"steadyarm.recommended"}
"""Modules in which a Path is a motion, not a file."""

WORDS = {
    "ArrayLike": "array_like",
    "Array": "array",
    "_Array": "array",
    "NDArray": "array",
    "Callable": "callable",
    "_ReferenceCallable": "callable",
    "_DisturbanceCallable": "callable",
    "Reference": "Curve | callable",
    "_Push": "Curve | Disturbance | callable",
    "_Inputs": "str | list[str] | dict[str, float]",
    "_Signal": "str",
    "_JointKind": "'revolute' | 'continuous' | 'prismatic'",
    "_Stepping": "object",
    "_Dictionary": "dict",
    "_Limits": "dict[str, array]",
    "Mapping": "dict",
    "Sequence": "list",
    "Iterable": "list",
    "PathLike": "Path",
    "Value": "float | None",
    "Window": "tuple[float, float] | None",
    "Joints": "int | str | list[int | str] | None",
    "Style": "'light' | 'dark'",
    "SupportsIndex": "int",
}
"""What a type is called here; the arguments of what is no container are left out."""

CONTAINERS = {"dict", "list", "tuple", "type"}
SHAPE = re.compile(r"\((?:\d*[nMTKS]|\d+|rules|inputs|outputs|sets)(?:, \w+)*,?\)")


class Short(ast.NodeTransformer):
    """A type in short words."""

    def __init__(self, module: str, owner: str) -> None:
        self.words = WORDS | {"Self": owner}
        if module in OF_PATHS:
            self.words["Path"] = "Curve | callable | array_like"

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """``_core.Arm`` is an ``Arm``."""
        return self.visit(ast.Name(node.attr))

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """Its word."""
        return ast.parse(self.words.get(node.id, node.id), mode="eval").body

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        """A type in quotes."""
        return self.visit(parsed(node.value)) if isinstance(node.value, str) else node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        """A literal is its values; what is no container loses its arguments."""
        kind = self.visit(node.value)
        inner = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        name = ast.unparse(kind)
        if name == "Literal":
            return parsed(" | ".join(map(ast.unparse, inner)))
        if name not in CONTAINERS or "Any" in map(ast.unparse, inner):
            return kind
        inner = [self.visit(it) for it in inner]
        return ast.Subscript(kind, ast.Tuple(inner) if len(inner) > 1 else inner[0])


def parsed(text: str) -> ast.expr:
    """The expression."""
    return ast.parse(text, mode="eval").body


def short(type_: ast.expr | str | None, module: str, owner: str = "") -> str:
    """A type in short words; empty where it says nothing."""
    if type_ is None or type_ is inspect.Parameter.empty:
        return ""
    node = parsed(type_) if isinstance(type_, str) else type_
    words = ast.unparse(Short(module, owner).visit(node))
    alternatives = list(dict.fromkeys(words.split(" | ")))
    return "" if "Any" in alternatives else " | ".join(alternatives)


def of_core(name: str) -> ast.ClassDef | ast.FunctionDef | None:
    """What the stub says of a name of the package, or of what its class extends."""
    first, *rest = name.removeprefix("steadyarm.").split(".")
    thing = CORE.get(first)
    if thing is None or not rest:
        return thing
    if not isinstance(thing, ast.ClassDef) or len(rest) > 1:
        return None
    for it in thing.body:
        if isinstance(it, ast.FunctionDef) and it.name == rest[0]:
            return it
    bases = (of_core(f"{ast.unparse(base)}.{rest[0]}") for base in thing.bases)
    return next(filter(None, bases), None)


def arguments(node: ast.FunctionDef) -> list[inspect.Parameter]:
    """The parameters of a function in the stub."""
    kinds, given = inspect.Parameter, node.args
    empty = inspect.Parameter.empty
    plain = given.posonlyargs + given.args
    defaults = [empty] * (len(plain) - len(given.defaults)) + given.defaults
    found = [
        (arg, kinds.POSITIONAL_OR_KEYWORD, value)
        for arg, value in zip(plain, defaults, strict=True)
    ]
    found += [
        (arg, kinds.KEYWORD_ONLY, empty if value is None else value)
        for arg, value in zip(given.kwonlyargs, given.kw_defaults, strict=True)
    ]
    return [
        kinds(arg.arg, kind, default=value, annotation=arg.annotation or empty)
        for arg, kind, value in found
        if arg.arg not in ("self", "cls")
    ]


def written(parameters: list[inspect.Parameter], module: str, owner: str) -> str:
    """The parameters as a signature has them, types in short words."""
    words, keywords = [], False
    for it in parameters:
        if it.kind is it.KEYWORD_ONLY and not keywords:
            words.append("*")
        keywords |= it.kind in (it.KEYWORD_ONLY, it.VAR_POSITIONAL)
        stars = {it.VAR_POSITIONAL: "*", it.VAR_KEYWORD: "**"}.get(it.kind, "")
        type_ = "" if stars else short(it.annotation, module, owner)
        word = stars + it.name + (f": {type_}" if type_ else "")
        if it.default is not it.empty:
            value = it.default
            shown = ast.unparse(value) if isinstance(value, ast.expr) else repr(value)
            shown = "..." if "<" in shown else shown
            word += f" = {shown}" if type_ else f"={shown}"
        words.append(word)
    return f"({', '.join(words)})"


def shaped(type_: str, words: str | None) -> str:
    """A type with the shape that the words tell, if it is an array."""
    shape = SHAPE.search((words or "").split("\n\n")[0])
    return (
        type_.replace("array", f"array {shape[0]}", 1) if type_[:5] == "array" and shape else type_
    )


def attribute_type(name: str) -> str:
    """The type of an attribute or property, in short words."""
    node = of_core(name)
    if isinstance(node, ast.FunctionDef):
        return shaped(short(node.returns, ""), ast.get_docstring(node))
    module, kind, attribute = name.rsplit(".", 2)
    owner = getattr(steadyarm, kind, None)
    if module != "steadyarm":
        owner = getattr(importlib.import_module(module), kind, None)
    if not inspect.isclass(owner):
        return ""
    thing = inspect.getattr_static(owner, attribute, None)
    getter = getattr(thing, "fget", None) or getattr(thing, "func", None)
    if getter is not None:
        type_ = inspect.signature(getter).return_annotation
        return shaped(short(type_, owner.__module__, kind), getter.__doc__)
    if owner is steadyarm.Run and attribute in CHANNELS:
        return "array (T, n)" if CHANNELS[attribute][1] else "array (T,)"
    for base in owner.__mro__:
        if attribute in vars(base).get("__annotations__", {}):
            type_ = vars(base)["__annotations__"][attribute]
            return short(type_, base.__module__, kind) if isinstance(type_, str) else ""
    return ""
