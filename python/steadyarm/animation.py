"""An arm in motion: a stick figure of a run, with the desired pose as a ghost, as GIF or MP4."""

from __future__ import annotations

import errno
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from subprocess import CalledProcessError
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from . import _files
from ._gif import GifWriter
from ._look import LIGHT
from ._picture import DPI, Picture
from ._places import Points, is_flat
from ._places import joint_points as joint_points
from ._progress import Progress
from .run import Run

Array = NDArray[np.float64]

FRAMES_PER_SECOND = 25
MOST_FRAMES = 2000
"""A longer film is refused: it would take minutes to draw, and nobody watches it."""


def save_animation(
    run: Run,
    arm: Any,
    path: str | Path,
    *,
    speed: float = 1.0,
    fps: int = FRAMES_PER_SECOND,
    progress: bool = False,
) -> Path:
    """Write the film of a run to ``path``: ``.gif``, or ``.mp4`` where ffmpeg is installed.

    ``arm`` gives the kinematics: a `TwoLink` or a `Serial`. ``speed`` 2 shows two seconds of the
    run in one second; ``progress`` shows a bar. Returns the path. The file is replaced as a whole:
    if filming fails or is stopped, what was there stays. Raises OSError if it cannot be written.
    """
    path = Path(path)
    writer = _writer(path, fps)
    if not speed > 0.0:
        raise ValueError(f"speed: got {speed}, wants a number > 0")
    points = joint_points(arm)
    film = _Film(run, points, _frames(run, speed, fps))

    def write(part: Path) -> None:
        bar = Progress(len(film.frames), "frames", shown=progress)
        with _shooting(writer, film.picture, part), bar:
            for frame in range(len(film.frames)):
                film.draw(frame)
                writer.grab_frame()
                bar.to(frame + 1)

    _files.replace(path, write)
    return path


class _Screen(Picture):
    """A picture of which some artists alone move: all else is drawn once."""

    def __init__(self, width: float, height: float) -> None:
        super().__init__(width=width, height=height)
        self.set_dpi(0.6 * DPI)
        self.agg: Any = FigureCanvasAgg(self)

    def fix(self, moving: Sequence[Artist]) -> None:
        """Draw and keep what does not move; the others go above it, in their order."""
        self.draw_without_rendering()
        self.set_layout_engine("none")  # laid out once, not for every frame
        self._moving = moving
        for artist in moving:
            artist.set_animated(True)
        self.agg.draw()
        self._still = self.agg.copy_from_bbox(self.bbox)

    def pixels(self) -> NDArray[np.uint8]:
        """What is to be seen now, (height, width, 4)."""
        self.agg.restore_region(self._still)
        for artist in self._moving:
            artist.draw(self.agg.get_renderer())
        return np.array(self.agg.buffer_rgba())

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write a file as any picture does; to a stream that is open, the pixels."""
        if hasattr(fname, "write"):
            fname.write(self.pixels().tobytes())
        else:
            super().savefig(fname, **options)


class _Film:
    """The picture whose lines are moved from frame to frame."""

    def __init__(self, run: Run, points: Points, frames: NDArray[np.intp]) -> None:
        self.t, self.frames = run.t[frames], frames
        self.actual = np.array([points(run.q[k]) for k in frames])
        self.desired = np.array([points(run.q_d[k]) for k in frames])
        everything = np.concatenate([self.actual, self.desired]).reshape(-1, 3)
        self.flat = is_flat(everything)
        self.picture = _Screen(width=6.0, height=6.2)
        axes = self._axes(everything)
        thick = {"linewidth": 5, "solid_capstyle": "round", "marker": "o"}
        thin = {"linewidth": 1.3, "linestyle": (0, (4, 2.5)), "marker": "o", "markersize": 3}
        (self.trace,) = axes.plot(
            *self._sides(self.actual[:1, -1]), color=LIGHT.orange, linewidth=1.2
        )
        (self.arm,) = axes.plot(*self._sides(self.actual[0]), color=LIGHT.blue, **thick)
        (self.ghost,) = axes.plot(*self._sides(self.desired[0]), color=LIGHT.ink, **thin)
        self.ghost.set_path_effects([withStroke(linewidth=3.2, foreground="white")])
        self.ghost.set_label("desired")
        self.arm.set_label("actual")
        self.trace.set_label("way of the tip")
        axes.legend(loc="upper right", frameon=False, fontsize=9)
        self.title = axes.set_title("t = 0.00 s", fontsize=11, color=LIGHT.ink)
        self.picture.fix([self.trace, self.arm, self.ghost, self.title])

    def draw(self, frame: int) -> None:
        """Show frame number ``frame``."""
        self._move(self.ghost, self.desired[frame])
        self._move(self.arm, self.actual[frame])
        self._move(self.trace, self.actual[: frame + 1, -1])
        self.title.set_text(f"t = {self.t[frame]:.2f} s")

    def _axes(self, everything: Array) -> Any:
        low, high = everything.min(axis=0), everything.max(axis=0)
        middle, reach = 0.5 * (low + high), 0.55 * float(np.max(high - low)) or 1.0
        if self.flat:
            axes: Any = self.picture.add_subplot(aspect="equal")
        else:
            axes = self.picture.add_subplot(projection="3d", aspect="equal")
            axes.set_zlim(middle[2] - reach, middle[2] + reach)
            axes.set_zlabel("z [m]")
        axes.set_xlim(middle[0] - reach, middle[0] + reach)
        axes.set_ylim(middle[1] - reach, middle[1] + reach)
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        return axes

    def _sides(self, points: Array) -> tuple[Array, ...]:
        return tuple(points[:, : 2 if self.flat else 3].T)

    def _move(self, line: Any, points: Array) -> None:
        if self.flat:
            line.set_data(*self._sides(points))
        else:
            line.set_data_3d(*self._sides(points))


def _frames(run: Run, speed: float, fps: int) -> NDArray[np.intp]:
    """The rows nearest to the times of the frames."""
    duration = float(run.t[-1] - run.t[0])
    count = int(duration / speed * fps) + 1
    if count > MOST_FRAMES:
        raise ValueError(
            f"speed: got {speed:g}, which makes {count} frames; wants at most {MOST_FRAMES}, "
            f"a speed of {duration * fps / MOST_FRAMES:.3g} or more"
        )
    times = run.t[0] + np.arange(count) * speed / fps
    rows: NDArray[np.intp] = np.clip(np.searchsorted(run.t, times), 0, len(run.t) - 1)
    return rows


@contextmanager
def _shooting(writer: AbstractMovieWriter, picture: Picture, part: Path) -> Iterator[None]:
    """Frames that are grabbed herein make the film; what ffmpeg complains of is an OSError.

    Unlike `AbstractMovieWriter.saving`, what stops the frames is what is raised, and no film is
    made of those that there are.
    """
    try:
        with rc_context({"savefig.bbox": None}):  # "tight" would give each frame its own size
            writer.setup(picture, str(part), dpi=picture.dpi)
            try:
                yield
            except BrokenPipeError:
                writer.finish()  # ffmpeg has gone, and this tells why
                raise
            except BaseException:
                if isinstance(writer, FFMpegWriter):
                    with suppress(CalledProcessError):
                        writer.finish()
                raise
            writer.finish()
    except CalledProcessError as error:
        said = (error.stderr or "").strip().splitlines()
        why = said[-1] if said else f"ended with exit code {error.returncode}"
        raise OSError(errno.EIO, f"ffmpeg: {why}") from error


def _writer(path: Path, fps: int) -> AbstractMovieWriter:
    if path.suffix.lower() == ".gif":
        return GifWriter(fps=fps)
    if path.suffix.lower() == ".mp4":
        if FFMpegWriter.isAvailable():
            return FFMpegWriter(fps=fps)
        raise RuntimeError(f"{path}: an .mp4 wants ffmpeg, which is not installed; use .gif")
    raise ValueError(f"path: got {str(path)!r}, wants a name that ends in .gif or .mp4")
