"""Films as GIF: one palette for all frames, and of each frame what has changed since the last."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import AbstractMovieWriter
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image

from ._look import LIGHT

Bytes = NDArray[np.uint8]

SEEN, SHADES = 96, 10
"""Colours that the first frame gives the palette, and shades of each that comes later."""

SAME, KEEP = 0, 1
"""The place in the palette of a pixel that stays as it is, and how a frame says so."""


class GifWriter(AbstractMovieWriter):
    """Writes the frames of a picture that draws its own pixels (`animation.Screen`)."""

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Begin a film of the picture."""
        super().setup(fig, outfile, dpi)
        self._parts: list[bytes] = []
        self._last: NDArray[np.uint32] | None = None
        self._frames = 0

    def grab_frame(self, **savefig_kwargs: Any) -> None:
        """Add what has changed in the picture."""
        pixels = self.fig.pixels()  # type: ignore[attr-defined]
        now = pixels.view(np.uint32)[..., 0]
        if self._last is None:
            self._begin(pixels)
            differs = np.ones(now.shape, bool)
        else:
            differs = now != self._last
        self._last, box = now, _box(differs)
        # In hundredths of a second, rounded so that the film keeps its length.
        ends = [round(100 * (self._frames + k) / self.fps) for k in (0, 1)]
        self._frames += 1
        self._parts += GifImagePlugin.getdata(
            self._image(pixels[box], differs[box]),
            (box[1].start, box[0].start),
            duration=10 * (ends[1] - ends[0]),
            transparency=SAME,
            disposal=KEEP,
        )

    def finish(self) -> None:
        """Write the file."""
        Path(self.outfile).write_bytes(b"".join([*self._parts, b";"]))

    def _begin(self, pixels: Bytes) -> None:
        self._palette = _palette(pixels)
        self._nearest = _nearest(self._palette)
        image = self._image(pixels, np.ones(pixels.shape[:2], bool))
        header, _ = GifImagePlugin.getheader(image, info={"loop": 0})
        self._parts += header

    def _image(self, pixels: Bytes, differs: NDArray[np.bool_]) -> Image.Image:
        """The pixels in the colours of the palette, those that do not differ as `SAME`."""
        red, green, blue = (pixels[..., k].astype(np.uint16) >> 3 for k in range(3))
        places = self._nearest[red << 10 | green << 5 | blue]
        image = Image.fromarray(np.where(differs, places, np.uint8(SAME)))
        image.putpalette(self._palette.tobytes())
        return image


def _box(differs: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Rows and columns of all that differs; one pixel if nothing does."""
    if not differs.any():
        return slice(0, 1), slice(0, 1)
    (rows,), (columns,) = (np.nonzero(differs.any(axis=side)) for side in (1, 0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _palette(pixels: Bytes) -> Bytes:
    """The colours of the first frame, and shades on paper of what is drawn later, (…, 3).

    Before them `SAME`, and paper.
    """
    seen = Image.fromarray(np.ascontiguousarray(pixels[..., :3])).quantize(SEEN)
    colours = np.array(seen.getpalette(), np.uint8).reshape(-1, 3)[:SEEN]
    share = np.linspace(1.0 / SHADES, 1.0, SHADES)[:, None]
    shades = [
        255 * (1 - share + share * np.array(to_rgb(name)))
        for name in (LIGHT.blue, LIGHT.orange, LIGHT.ink)
    ]
    first = [[0, 0, 0], [255, 255, 255]]
    return np.concatenate([first, colours, *shades]).round().astype(np.uint8)


def _nearest(palette: Bytes) -> Bytes:
    """The place in the palette of each colour of five bits a channel."""
    levels = np.arange(32) * (255.0 / 31.0)
    grid = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3)
    known = palette[SAME + 1 :].astype(float)
    apart = (known**2).sum(axis=1) - 2.0 * grid @ known.T
    nearest: Bytes = (apart.argmin(axis=1) + SAME + 1).astype(np.uint8)
    return nearest
