"""What pages of one file share: no network, no library, and text that stays text."""

from __future__ import annotations

import json
from collections.abc import Iterable
from importlib.resources import files
from typing import Any

from ._html import text


def document(title: str, styles: Iterable[str], body: Iterable[str]) -> str:
    """A whole page, with these files as its style."""
    sheets = "".join(part(name) for name in ("_page.css", *styles))
    head = [
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        f"<title>{text(title)}</title>",
        f"<style>\n{sheets}</style>",
    ]
    parts = [
        '<!DOCTYPE html>\n<html lang="en">\n<head>', *head, "</head>\n<body>\n<main>", *body,
        "</main>\n</body>\n</html>\n",
    ]  # fmt: skip
    return "\n".join(parts)


def script(*names: str) -> str:
    """These files as a script, after what all pages share."""
    return f"<script>\n{''.join(part(name) for name in ('_page.js', *names))}</script>"


def data(values: Any) -> str:
    """What the script draws: JSON that no text in it can end."""
    content = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        content = content.replace(character, f"\\u{ord(character):04x}")
    return f'<script type="application/json" id="data">{content}</script>'


def part(name: str) -> str:
    """The content of a file of the package."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
