"""What stands below the fields of a class, in its `help()`: Python keeps no such words itself."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from inspect import cleandoc
from typing import Any, TypeVar

Kind = TypeVar("Kind", bound=type)


class FieldWords:
    """A docstring that is completed by the words below the fields, when it is first read.

    It costs nothing at import: only who asks has the source read.
    """

    def __init__(self, own: str | None, told: Mapping[str, str]) -> None:
        self.own = own
        self.told = told
        self.whole: str | None = None

    def __get__(self, it: object, kind: type) -> str | None:
        from textwrap import indent

        if self.whole is None and self.own is not None:
            fields = _fields(kind)
            others = {name: ("", "") for name in self.told if name not in fields}
            listed = []
            for name, (type_, words) in (others | fields).items():
                head = f"{name}: {type_}" if type_ else name
                listed += [head, indent(words or self.told.get(name, ""), "    ")]
            self.whole = "\n".join([cleandoc(self.own), "", "Attributes", "-" * 10, *listed])
        return self.whole


def documented(kind: Kind, told: Mapping[str, str] | None = None) -> Kind:
    """Let `help()` of a class list its fields, with the type of each and the words below it.

    ``told`` has the words of fields that have none in the source, by name.
    """
    kind.__doc__ = FieldWords(kind.__doc__, told or {})  # type: ignore[assignment]
    return kind


def _fields(kind: type) -> dict[str, tuple[str, str]]:
    """Type of each public field, and the words below it; none where there is no source."""
    import ast

    try:
        body: Any = ast.parse(inspect.getsource(kind)).body[0]
    except (OSError, TypeError):
        return {}
    fields = {}
    for node, below in zip(body.body, [*body.body[1:], None], strict=True):
        if not isinstance(node, ast.AnnAssign) or not isinstance(node.target, ast.Name):
            continue
        if node.target.id.startswith("_"):
            continue
        said = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant)
        words = cleandoc(below.value.value) if said else ""
        fields[node.target.id] = (ast.unparse(node.annotation), words)
    return fields
