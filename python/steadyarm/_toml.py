"""Values and sections as TOML."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

BARE = re.compile(r"[A-Za-z0-9_-]+")
"""A key that wants no quotes."""


def lines(sections: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """The lines of a file, without what is not said; the section "" has no head."""
    for name, section in sections.items():
        said = {key: value for key, value in section.items() if value is not None}
        if not said:
            continue
        if name:
            yield f"\n[{name}]"
        for key, value in said.items():
            yield f"{_key(key)} = {inline(value)}"


def inline(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {inline(it)}' for key, it in value.items())} }}"
    if isinstance(value, list | tuple | np.ndarray):
        return f"[{', '.join(map(inline, value))}]"
    if isinstance(value, bool | str):
        return json.dumps(value, ensure_ascii=False)
    return repr(int(value) if isinstance(value, int | np.integer) else float(value))


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)
