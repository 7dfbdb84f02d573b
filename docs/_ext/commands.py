"""The directive ``commands``: every command of steadyarm, from the parser that reads them."""

import re
import textwrap

from docutils import nodes
from docutils.parsers.rst import Directive
from steadyarm import cli


class Commands(Directive):
    """Write the description, the commands and their options as sections."""

    def run(self):
        """Return the nodes of all commands."""
        parser = cli._parser()
        parts = texts(parser.description) + texts(parser.epilog) + options(parser)
        for name, command in subcommands(parser).items():
            section = nodes.section(ids=[f"steadyarm-{name}"], names=[name])
            section += nodes.title("", "", nodes.literal("", f"steadyarm {name}"))
            usage = textwrap.dedent(command.format_usage().removeprefix("usage: ")).rstrip()
            section += [code(usage), *texts(command.description)]
            section += [*options(command), *texts(command.epilog)]
            parts.append(section)
        return parts


def subcommands(parser):
    """Return the commands of a parser by name."""
    return next(it.choices for it in parser._actions if isinstance(it.choices, dict))


def code(text):
    """Return a block to be read as it stands."""
    return nodes.literal_block(text, text, language="text")


def texts(text):
    """Return a help text as paragraphs; what is indented in it stands as it is."""
    found = []
    for part in re.split(r"\n\s*\n", (text or "").strip("\n")):
        lines = part.splitlines()
        plain = [line for line in lines if line and not line.startswith(" ")]
        if len(plain) == len(lines):
            found.append(nodes.paragraph("", "", *words(" ".join(lines))))
            continue
        if lines and not lines[0].startswith(" ") and len(plain) == 1:
            found.append(nodes.paragraph("", "", *words(lines.pop(0))))
        found.append(code(textwrap.dedent("\n".join(lines))))
    return [part for part in found if part.astext()]


def words(text):
    """Return a line of text; what stands in backquotes is code, and so are options."""
    pieces = re.split(r"`([^`]+)`|(?<![\w-])(--[\w-]+)", text)
    return [
        nodes.Text(piece) if number % 3 == 0 else nodes.literal("", piece)
        for number, piece in enumerate(pieces)
        if piece
    ]


def options(parser):
    """Return the arguments as lists, one for each group with its title."""
    found = []
    for group in parser._action_groups:
        shown = [action for action in group._group_actions if shows(action)]
        if not shown:
            continue
        if group.description or group.title not in ("options", "positional arguments"):
            found.append(nodes.rubric("", group.title))
        found += texts(group.description)
        items = nodes.definition_list(classes=["options"])
        for action in shown:
            items += nodes.definition_list_item(
                "",
                nodes.term("", "", nodes.literal("", heading(action))),
                nodes.definition("", nodes.paragraph("", "", *words(explained(parser, action)))),
            )
        found.append(items)
    return found


def shows(action):
    """Say whether an argument has a place of its own: a command and --help have not."""
    hidden = action.help == "==SUPPRESS==" or "--help" in action.option_strings
    return not hidden and not isinstance(action.choices, dict)


def heading(action):
    """Return an argument as it is typed."""
    if not action.option_strings:
        return str(action.metavar or action.dest)
    names = ", ".join(action.option_strings)
    if action.nargs == 0:
        return names
    if isinstance(action.metavar, tuple):
        return f"{names} {' '.join(action.metavar)}"
    many = " ..." if action.nargs in ("+", "*") else ""
    if action.choices and not action.metavar:
        return f"{names} {{{','.join(map(str, action.choices))}}}"
    return f"{names} {action.metavar or action.dest.upper()}{many}"


def explained(parser, action):
    """Return what an argument does, its choices and its default."""
    text = parser._get_formatter()._expand_help(action) if action.help else ""
    if action.choices and action.metavar:
        text += f" One of {', '.join(map(str, action.choices))}."
    plain = action.default not in (None, False, True, "==SUPPRESS==", [], ())
    if plain and "default" not in text:
        text += f" (default: {action.default})"
    return text.strip() or "One of these."


def setup(app):
    """Register the directive."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
