"""Signatures with types and defaults, and links, for the reference of the Python package.

The core's classes carry no annotations at run time: theirs are read in its stub, the package's own
in the package. Both are shown in short words: ``array_like`` is anything that numpy makes an array
of, ``array`` what comes back.
"""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path

import steadyarm
from docutils import nodes
from sphinx import addnodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.nodes import make_refnode
from steadyarm._documented import FieldWords

LOG = logging.getLogger(__name__)

STUB = ast.parse(Path(steadyarm.__file__).with_name("_core.pyi").read_text(encoding="utf-8"))
CORE = {it.name: it for it in STUB.body if isinstance(it, ast.ClassDef | ast.FunctionDef)}

GIVEN = {"Comparison", "Job", "Scenario", "Scene"}
"""The records that a user makes; all others are results, whose constructor nobody calls."""

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
    "Window": "tuple[float, float]",
    "SupportsIndex": "int",
}
"""What a type is called here; the arguments of what is no container are left out."""

CONTAINERS = {"dict", "list", "tuple", "type"}
SHAPE = re.compile(r"\((?:\d*[nTKS]|\d+|rules|inputs|outputs|sets)(?:, \w+)*,?\)")


SHAPES: dict[str, str] = {}
"""What callables return, where that is an array, by name."""


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


def signature(app, what, name, thing, options, given, result):
    """The signature of a callable, with types and defaults."""
    if given is None or what not in ("class", "exception", "function", "method"):
        return None
    if what == "exception" or (what == "class" and issubclass(thing, Exception)):
        return "", None
    owner = name.split(".")[-1 if what == "class" else -2]
    node = of_core(name)
    python = inspect.isfunction(inspect.unwrap(getattr(thing, "__func__", thing)))
    if node is not None and not python:
        if isinstance(node, ast.ClassDef):
            node = of_core(f"{name}.__new__")
            return ("", None) if node is None else (written(arguments(node), "", owner), None)
        SHAPES[name] = shaped("array", ast.get_docstring(node))
        return written(arguments(node), "", owner), short(node.returns, "", owner) or None
    if what == "class" and owner not in GIVEN:
        return "", None
    seen = inspect.signature(thing)
    parameters = [it for it in seen.parameters.values() if it.name not in ("self", "cls")]
    module = getattr(thing, "__module__", "") or ""
    result = "" if what == "class" else short(seen.return_annotation, module, owner)
    SHAPES[name] = shaped("array", thing.__doc__)
    return written(parameters, module, owner), result or None


def attribute_type(name: str) -> str:
    """The type of an attribute or property, in short words."""
    node = of_core(name)
    if node is not None:
        return shaped(short(node.returns, ""), ast.get_docstring(node))
    module, kind, attribute = name.rsplit(".", 2)
    owner = getattr(steadyarm, kind, None)
    if module != "steadyarm":
        owner = getattr(inspect.importlib.import_module(module), kind, None)
    if not inspect.isclass(owner):
        return ""
    thing = inspect.getattr_static(owner, attribute, None)
    getter = getattr(thing, "fget", None) or getattr(thing, "func", None)
    if getter is not None:
        type_ = inspect.signature(getter).return_annotation
        return shaped(short(type_, owner.__module__, kind), getter.__doc__)
    for base in owner.__mro__:
        if attribute in vars(base).get("__annotations__", {}):
            type_ = vars(base)["__annotations__"][attribute]
            return short(type_, base.__module__, kind) if isinstance(type_, str) else ""
    return ""


def show_type(app, domain, objtype, content):
    """Write the type behind the name of an attribute or property, and the shape of an array.

    Sphinx would take the brackets of a shape for those of the arguments.
    """
    if domain != "py":
        return
    for line in content.parent.findall(addnodes.desc_signature):
        if line.parent is not content.parent or not line.get("module"):
            continue
        name = f"{line['module']}.{line['fullname']}"
        for result in line.findall(addnodes.desc_returns):
            if result.astext() == "array":
                result.children = [nodes.Text(SHAPES.get(name, "array"))]
        type_ = attribute_type(name) if objtype in ("attribute", "property") else ""
        if type_:
            line += addnodes.desc_annotation("", "", nodes.Text(": "), *linked(type_, line))


def linked(type_: str, line: addnodes.desc_signature) -> list[nodes.Node]:
    """The words of a type, those of the package as references."""
    words: list[nodes.Node] = []
    for word in re.split(r"(\b[A-Z]\w+)", type_):
        text = nodes.Text(word)
        if word[:1].isupper() and word != "None":
            at = {"refdomain": "py", "reftype": "class", "reftarget": word}
            words.append(addnodes.pending_xref("", text, **at, refspecific=True))
            words[-1]["py:module"] = line["module"]
        elif word:
            words.append(text)
    return words


def plain_docstring(app, what, name, thing, options, lines):
    """The page lists fields below the class itself; those that have no words there are added."""
    own = vars(thing).get("__doc__") if inspect.isclass(thing) else None
    if isinstance(own, FieldWords):
        lines[:] = [*inspect.cleandoc(own.own or "").splitlines(), ""]
        for field, words in own.told.items():
            lines += [f".. py:attribute:: {field}", "", f"   {words}", ""]


def found(app, target: str, inside: str | None = None):
    """The object that a name stands for: a member of the class that it is said in, or of what that
    extends, a name of the package, or the only one that ends so."""
    objects = app.env.get_domain("py").objects
    owner, _, member = target.rpartition(".")
    kinds = getattr(getattr(steadyarm, owner or inside or "", None), "__mro__", ())
    members = [f"steadyarm.{kind.__name__}.{member}" for kind in kinds]
    for name in (*members, target, f"steadyarm.{target}"):
        if name in objects:
            return objects[name]
    ends = {it.node_id: it for name, it in objects.items() if name.endswith(f".{target}")}
    return next(iter(ends.values())) if len(ends) == 1 else None


def refer(app, env, node, content):
    """Resolve what the Python domain does not: names of the package from one of its modules."""
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"].removesuffix("()")
    at = found(app, target, node.get("py:class"))
    if at is None:
        if node["reftype"] == "obj" and target not in ("None", "True", "False"):
            LOG.warning("no such name in the reference: %s", target, location=node, type="api")
        return None
    return make_refnode(app.builder, node["refdoc"], at.docname, at.node_id, content, target)


class LinkNames(SphinxPostTransform):
    """``sa.name`` in the text of a page leads to the reference."""

    default_priority = 5

    def run(self, **options) -> None:
        """Make links of the names on this page."""
        for word in list(self.document.findall(nodes.literal)):
            name = re.fullmatch(r"(?:sa|steadyarm)\.([\w.]+?)(?:\(.*\))?", word.astext())
            inside = isinstance(word.parent, nodes.reference | nodes.title | addnodes.pending_xref)
            at = None if inside or name is None else found(self.app, name[1])
            if at is not None:
                link = make_refnode(
                    self.app.builder, self.env.docname, at.docname, at.node_id, word.deepcopy()
                )
                word.replace_self(link)


def in_order(app, page, text):
    """Name the members of the core's classes, which have no order at run time, in the stub's."""

    def members(match: re.Match[str]) -> str:
        kind = CORE.get(match[2])
        if not isinstance(kind, ast.ClassDef):
            return match[0]
        names = [it.name for it in kind.body if isinstance(it, ast.FunctionDef)]
        shown = dict.fromkeys(name for name in names if not name.startswith("_"))
        return f"{match[1]} {', '.join(shown)}\n" if shown else match[0]

    text[0] = re.sub(r"(\.\. autoclass:: steadyarm\.(\w+)\n +:members:)\n", members, text[0])


def setup(app):
    """Connect all that to Sphinx."""
    app.connect("source-read", in_order)
    app.connect("autodoc-process-signature", signature)
    app.connect("autodoc-process-docstring", plain_docstring, priority=50)
    app.connect("object-description-transform", show_type)
    app.connect("missing-reference", refer)
    app.add_post_transform(LinkNames)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
