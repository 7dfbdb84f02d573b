"""Signatures with types and defaults, and links, for the reference of the Python package.

The core's classes carry no annotations at run time: theirs are read in its stub, the package's own
in the package; `signatures` says how.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator

import steadyarm
from docutils import nodes
from signatures import CORE, arguments, attribute_type, of_core, shaped, short, written
from sphinx import addnodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.nodes import make_refnode
from steadyarm._documented import FieldWords

LOG = logging.getLogger(__name__)

GIVEN = {"Comparison", "Job", "LatinHypercube", "Scenario", "Scene"}
"""The records that a user makes; all others are results, whose constructor nobody calls."""

SHAPES: dict[str, str] = {}
"""What callables return, where that is an array, by name."""


KEPT: dict[str, list[str]] = {}
"""Docstrings as they were, by name."""


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
            place = line.index(next(iter(line.findall(addnodes.desc_name)))) + 1
            shown = addnodes.desc_annotation("", "", nodes.Text(": "), *linked(type_, line))
            line.insert(place, shown)


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
    KEPT[name] = list(lines)
    own = vars(thing).get("__doc__") if inspect.isclass(thing) else None
    if isinstance(own, FieldWords):
        lines[:] = [*inspect.cleandoc(own.own or "").splitlines(), ""]
        for field, words in own.told.items():
            lines += [f".. py:attribute:: {field}", "", f"   {words}", ""]


def spread(lines: list[str]) -> Iterator[str]:
    """Write ``name: text`` of a section as napoleon wants it, which would take text for a type."""
    within = False
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if below.startswith("---"):
            within = line in ("Parameters", "Attributes")
        field = re.match(r"([\w, ]+): (.+)", line) if within else None
        yield from [field[1], "    " + field[2]] if field else [line]


def plain_bars(line: str) -> str:
    """|W| is a norm, which reStructuredText takes for a substitution, but in literals."""
    return re.sub(r"(``.*?``)|\|", lambda match: match[1] or r"\|", line)


def house_docstring(app, what, name, thing, options, lines):
    """Prepare a docstring as this package writes them."""
    lines[:] = map(plain_bars, spread(lines))


def whole_docstring(app, what, name, thing, options, lines):
    """Words of an attribute as they were: napoleon takes those before a colon for its type."""
    if what in ("attribute", "property", "data"):
        lines[:] = map(plain_bars, KEPT.pop(name, lines))


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
        shown = {}
        for it in kind.body:
            if isinstance(it, ast.FunctionDef) and not it.name.startswith("_"):
                shown.setdefault(it.name, "attribute" if "property" in decorators(it) else "method")
        lines = (f"   .. auto{what}:: {match[1]}.{name}\n" for name, what in shown.items())
        return f".. autoclass:: {match[1]}\n\n{''.join(lines)}"

    text[0] = re.sub(r"\.\. autoclass:: (steadyarm\.(\w+))\n +:members:\n", members, text[0])


def decorators(node: ast.FunctionDef) -> list[str]:
    """The names of what decorates a function."""
    return [ast.unparse(it) for it in node.decorator_list]


def setup(app):
    """Connect all that to Sphinx."""
    app.connect("source-read", in_order)
    app.connect("autodoc-process-signature", signature)
    app.connect("autodoc-process-docstring", plain_docstring, priority=50)
    app.connect("autodoc-process-docstring", house_docstring, priority=100)
    app.connect("autodoc-process-docstring", whole_docstring, priority=900)
    app.connect("object-description-transform", show_type)
    app.connect("missing-reference", refer)
    app.add_post_transform(LinkNames)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
