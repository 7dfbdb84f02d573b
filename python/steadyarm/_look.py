"""Colours and letters of all pictures, for paper and for dark slides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Style = Literal["light", "dark"]

TITLE, TEXT, SMALL = 8.0, 8.0, 7.0
"""Sizes of letters [pt] at the width that a picture is made for."""

SOLID, DASHED, DOTTED, LONG = "-", (0, (3.5, 1.5)), (0, (1, 1.4)), (0, (7, 2))
DASH_DOT, DASH_DOT_DOT = (0, (6, 1.5, 1, 1.5)), (0, (5, 1.3, 1, 1.3, 1, 1.3))
LINES: tuple[Any, ...] = (SOLID, DASHED, DOTTED, DASH_DOT, LONG, DASH_DOT_DOT)
"""Lines that can be told apart without colours."""

HATCHES = ("", "///", "...", "\\\\\\", "xxx", "---", "|||", "+++")
"""Areas that can be."""


@dataclass(frozen=True)
class Look:
    """Colours that colour-blind readers can tell apart: Okabe and Ito's, and a few more."""

    paper: str
    ink: str
    gray: str
    pale: str
    faint: str
    blue: str
    orange: str
    green: str
    purple: str
    sky: str
    amber: str
    brown: str
    olive: str

    @property
    def cycle(self) -> tuple[tuple[str, Any], ...]:
        """Colour and line of what is compared."""
        colours = (self.blue, self.orange, self.ink, self.green, self.purple, self.sky)
        return tuple(zip(colours, LINES, strict=True))

    @property
    def areas(self) -> tuple[tuple[str, str], ...]:
        """Colour and hatch of areas."""
        colours = (
            self.blue, self.orange, self.green, self.amber, self.purple, self.sky, self.brown,
            self.olive,
        )  # fmt: skip
        return tuple(zip(colours, HATCHES, strict=True))


LIGHT = Look(
    paper="#FFFFFF", ink="#222222", gray="#767676", pale="#B8B8B8", faint="#E6E6E6",
    blue="#0072B2", orange="#D55E00", green="#009E73", purple="#882255", sky="#56B4E9",
    amber="#E69F00", brown="#8C564B", olive="#B2A100",
)  # fmt: skip

DARK = Look(
    paper="#14171A", ink="#E6E9EC", gray="#A2ABB4", pale="#69737D", faint="#2B3138",
    blue="#4AA8E0", orange="#FF8A3D", green="#2FC296", purple="#F2A6C8", sky="#8FD6FF",
    amber="#E0B93A", brown="#C98A6B", olive="#C4BC4A",
)  # fmt: skip

LOOKS = {"light": LIGHT, "dark": DARK}


def look_of(style: str) -> Look:
    """The look of a style."""
    if style not in LOOKS:
        raise ValueError(f"style: got {style!r:.80}, wants {' or '.join(LOOKS)}")
    return LOOKS[style]
