"""Formulas as MathML, written when the manual is built: browsers draw it without a script.

A formula that cannot be converted whole is a warning with its page and line, which -W makes an
error. ``\\tag{6}`` numbers a formula; Sphinx numbers those with a label.
"""

import re
from html import escape, unescape
from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.converter import convert_to_element
from sphinx.util import logging

TAG = re.compile(r"\s*\\tag\{([^}]*)\}")
DOTS = ("\u02d9", "\u00a8")
# Operators that stand close to what is beside them.
CLOSE = (
    "|",
    "\u2016",
    "\u2223",
    "\u2225",
    "/",
)
logger = logging.getLogger(__name__)


def mathml(formula, display):
    """Return the markup of a formula; raise ValueError if something in it is not understood."""
    bare = re.sub(r"\\.", "", formula)
    if bare.count("{") != bare.count("}"):
        raise ValueError("its braces do not match")  # the converter would guess
    try:
        tree = convert_to_element(formula, display=display)
    except Exception as error:  # latex2mathml has a dozen kinds
        raise ValueError(f"{type(error).__name__} {error}".strip()) from error
    for part in tree.iter():
        part.text = unescape(part.text or "")  # it writes entities
    for part in tree.iter():
        if part.tag == "mover" and part[1].text in DOTS:
            part[1].attrib.update(stretchy="false", style="font-size: 1.2em")
        if part.tag == "mo" and part.text in CLOSE:
            part.attrib.update(stretchy="false", lspace="0", rspace="0")
    unknown = [part.text for part in tree.iter() if part.text.startswith("\\")]
    if unknown:
        raise ValueError(f"does not know {' '.join(unknown)}")
    return ElementTree.tostring(tree, encoding="unicode")


def written(node, formula, display):
    """Return the markup of a node's formula; tell where the formula stands if there is none."""
    try:
        return mathml(formula, display)
    except ValueError as error:
        logger.warning("formula %r: %s", formula, error, location=node, type="mathml")
        return f"<code>{escape(formula)}</code>"


def inline(translator, node):
    """Write a formula within a line."""
    translator.body.append(written(node, node.astext(), "inline"))
    raise nodes.SkipNode


def block(translator, node):
    """Write a formula on lines of its own, with its number if it has one."""
    formula = node.astext()
    tag = TAG.search(formula)
    number = tag[1] if tag else node["number"]
    translator.body.append(translator.starttag(node, "div", CLASS="math-block"))
    translator.body.append(written(node, TAG.sub("", formula).strip(), "block"))
    if number:
        translator.body.append(f'<span class="eqno">({number}')
        if node["number"]:
            translator.add_permalink_ref(node, "Link to this equation")
        translator.body.append(")</span>")
    translator.body.append("</div>")
    raise nodes.SkipNode


def setup(app):
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
