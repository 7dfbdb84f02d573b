"""Films: what is drawn in every frame, and how ffmpeg and the file are dealt with."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from matplotlib.animation import AbstractMovieWriter
from steadyarm import animation

LENGTH = (0.5, 0.3)
TWO_LINK = sa.TwoLink(mass=(4, 4), length=LENGTH, inertia=(0.2, 0.2))
PANDA = sa.Serial.shipped("panda")


def as_serial() -> sa.Serial:
    """The two links as a chain of any kind: its poses come from another code."""
    return sa.Serial.from_dh(
        a=LENGTH, alpha=(0, 0), d=(0, 0), mass=(4, 4), com=((-0.25, 0, 0), (-0.15, 0, 0)),
        inertia=0.2, gravity=(0, -9.81, 0),
    )  # fmt: skip


def wrong_run(arm: Any, start: Any, goal: Any) -> sa.Run:
    """A run whose arm is far from where it should be: it starts elsewhere, and gains are low."""
    tracker = sa.ComputedTorque(arm, 1.0, 2.0)
    reference = sa.Quintic(start, goal, 0.6)
    q0 = np.asarray(start) + 0.4 + 0.1 * np.arange(len(start))
    return sa.simulate(sa.Plant(arm), tracker, reference, 1.0, 1e-2, q0=q0)


RUNS = {
    "two links": (TWO_LINK, wrong_run(TWO_LINK, (0.3, 0.7), (1.2, -0.9))),
    "seven joints": (
        PANDA,
        wrong_run(
            PANDA, (0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8), (0.5, -0.2, 0.4, -1.5, 0.3, 2.0, 1.0)
        ),
    ),
}
each = pytest.mark.parametrize("which", RUNS)


class Recorder(AbstractMovieWriter):
    """Keeps what the picture shows whenever a frame is grabbed."""

    def __init__(self) -> None:
        super().__init__(fps=animation.FRAMES_PER_SECOND)
        self.frames: list[dict[str, Any]] = []

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        super().setup(fig, outfile, dpi)

    def grab_frame(self, **options: Any) -> None:
        self.fig.savefig(os.devnull, format="raw")  # lines must be drawable, and are then as drawn
        (axes,) = self.fig.axes
        frame: dict[str, Any] = {"t": float(re.findall(r"[\d.]+", axes.get_title())[0])}
        for line in axes.get_lines():
            data = line.get_data_3d() if hasattr(line, "get_data_3d") else line.get_data()
            points = np.zeros((len(data[0]), 3))
            points[:, : len(data)] = np.transpose(data)
            frame[line.get_label()] = points
            assert line.get_visible()
        frame["limits"] = [axes.get_xlim(), axes.get_ylim()]
        frame["aspect"] = axes.get_aspect()
        self.frames.append(frame)

    def finish(self) -> None:
        Path(self.outfile).write_bytes(b"film")


def film(which: str, path: Path, monkeypatch: pytest.MonkeyPatch, **options: Any) -> list[Any]:
    arm, run = RUNS[which]
    recorder = Recorder()
    monkeypatch.setattr(animation, "_writer", lambda path, fps: recorder)
    animation.save_animation(run, arm, path, **options)
    return recorder.frames


def places(arm: Any, q: np.ndarray) -> np.ndarray:
    """Base, joints and tip, by the poses of the links."""
    chain = as_serial() if isinstance(arm, sa.TwoLink) else arm
    joints = np.asarray(chain.link_poses(q))[:, :3, 3]
    return np.vstack([np.zeros(3), joints, np.asarray(chain.pose(q))[:3, 3]])


def distinct(points: np.ndarray) -> np.ndarray:
    """The places in order, without those that repeat the one before."""
    moved = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9
    return points[np.concatenate([[True], moved])]


@each
def test_every_frame_shows_the_arm_where_it_is_and_its_ghost_where_it_should_be(
    which: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The lines against `link_poses` and `pose`, which the dynamics' tests hold to Pinocchio."""
    arm, run = RUNS[which]
    assert np.abs(run.e).max() > 0.3  # or the two could not be told apart
    frames = film(which, tmp_path / "arm.gif", monkeypatch)
    assert len(frames) == 26  # 1 s at 25 frames a second, both ends
    for number, frame in enumerate(frames):
        k = round(frame["t"] / 1e-2)
        assert frame["t"] == pytest.approx(number / 25, abs=0.51e-2)
        actual, desired = places(arm, run.q[k]), places(arm, run.q_d[k])
        assert np.allclose(distinct(frame["actual"]), distinct(actual), atol=1e-12)
        assert np.allclose(distinct(frame["desired"]), distinct(desired), atol=1e-12)
        assert np.allclose(frame["way of the tip"][-1], actual[-1], atol=1e-12)
        assert len(frame["way of the tip"]) == number + 1
        for (low, high), column in zip(frame["limits"], (0, 1), strict=True):
            assert low < min(actual[:, column].min(), desired[:, column].min())
            assert high > max(actual[:, column].max(), desired[:, column].max())
        assert frame["aspect"] in ("equal", 1.0)


def test_links_lie_where_trigonometry_says() -> None:
    """An angle of zero lies along x, and angles turn towards y: by hand, for two links."""
    points = animation.joint_points(TWO_LINK)
    for q, elbow, tip in (
        ((0.0, 0.0), (0.5, 0.0), (0.8, 0.0)),
        ((np.pi / 2, 0.0), (0.0, 0.5), (0.0, 0.8)),
        ((0.0, np.pi / 2), (0.5, 0.0), (0.5, 0.3)),
        (
            (np.pi / 6, np.pi / 6),
            (0.5 * 0.75**0.5, 0.25),
            (0.5 * 0.75**0.5 + 0.15, 0.25 + 0.3 * 0.75**0.5),
        ),
    ):
        drawn = points(np.array(q))
        assert np.allclose(distinct(drawn), [(0, 0, 0), (*elbow, 0), (*tip, 0)], atol=1e-15)


def test_what_falls_is_drawn_falling() -> None:
    """An undriven arm loses height: gravity and the picture agree on what is up."""
    arm = sa.TwoLink(mass=(4, 4), length=LENGTH, inertia=(0.2, 0.2), gravity=9.81)
    tracker = sa.ComputedTorque(arm, 1.0, 1.0, effort_limit=1e-9)
    run = sa.simulate(sa.Plant(arm), tracker, lambda t: (np.zeros(2),) * 3, 0.1)
    points = animation.joint_points(arm)
    drop = points(run.q[-1])[2, 1] - points(run.q[0])[2, 1]
    assert drop < -1e-3


def test_film_is_as_long_as_the_run_at_its_speed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = film("two links", tmp_path / "arm.gif", monkeypatch, speed=2.0, fps=10)
    assert [frame["t"] for frame in frames] == pytest.approx(
        [0.0, 0.2, 0.4, 0.6, 0.8, 1.0], abs=0.01
    )


FFMPEG = """#!/bin/sh
for last; do :; done
case "$last" in *.mp4) ;; *) echo "no such format: $last" >&2; exit 2;; esac
{body}
"""


@pytest.fixture
def ffmpeg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Puts a program in the place of ffmpeg, which gets frames and the name of the film."""
    import matplotlib

    def install(body: str) -> None:
        program = tmp_path / "bin" / "ffmpeg"
        program.parent.mkdir(exist_ok=True)
        program.write_text(FFMPEG.format(body=body))
        program.chmod(0o755)
        monkeypatch.setitem(matplotlib.rcParams, "animation.ffmpeg_path", str(program))

    return install


posix = pytest.mark.skipif(os.name != "posix", reason="needs a shell")


@posix
def test_ffmpeg_makes_the_film_beside_the_old_one(
    tmp_path: Path, ffmpeg: Callable[[str], None]
) -> None:
    arm, run = RUNS["two links"]
    path = tmp_path / "films" / "arm.mp4"
    path.parent.mkdir()
    path.write_bytes(b"old")
    ffmpeg(f'[ "$(cat {path})" = old ] && cat > "$last"')
    assert run.animate(arm, path, speed=5.0) == path
    assert len(path.read_bytes()) % (4 * 540) == 0  # frames of 540 pixels of four bytes a row
    assert os.listdir(path.parent) == ["arm.mp4"]


@posix
@pytest.mark.parametrize(
    ("body", "said"),
    [
        ('head -c 9 > "$last"; echo "av: No space left on device" >&2; exit 1', "No space left"),
        ('cat > "$last"; echo "could not close" >&2; exit 1', "could not close"),
        ("exit 3", "exit code 3"),
        ('cat > "$last"; kill -9 $$', "exit code -9"),
    ],
)
def test_ffmpeg_that_fails_keeps_the_old_film(
    body: str, said: str, tmp_path: Path, ffmpeg: Callable[[str], None]
) -> None:
    arm, run = RUNS["two links"]
    path = tmp_path / "films" / "arm.mp4"
    path.parent.mkdir()
    path.write_bytes(b"old")
    ffmpeg(body)
    with pytest.raises(OSError, match=rf"ffmpeg: .*{said}.*arm\.mp4"):
        run.animate(arm, path, speed=5.0)
    assert path.read_bytes() == b"old"
    assert os.listdir(path.parent) == ["arm.mp4"]


@posix
@pytest.mark.parametrize("ending", [".gif", ".mp4"])
@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError(28, "No space left"), ValueError])
def test_film_that_is_broken_off_keeps_the_old_one(
    stop: Any,
    ending: str,
    tmp_path: Path,
    ffmpeg: Callable[[str], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What stops the film is what is raised, though ffmpeg got the Ctrl-C too."""
    arm, run = RUNS["two links"]
    path = tmp_path / "films" / f"arm{ending}"
    path.parent.mkdir()
    path.write_bytes(b"old")
    ffmpeg('cat > "$last"; exit 255')

    def draw(self: Any, frame: int) -> None:
        if frame == 2:
            raise stop

    monkeypatch.setattr(animation._Film, "draw", draw)
    with pytest.raises(stop if isinstance(stop, type) else type(stop)):
        run.animate(arm, path)
    assert path.read_bytes() == b"old"
    assert os.listdir(path.parent) == [path.name]


@each
def test_a_gif_shows_the_pixels_that_were_drawn(
    which: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One palette serves all frames, and each adds what has changed since the one before."""
    from PIL import Image, ImageSequence

    drawn: list[np.ndarray] = []
    pixels = animation._Screen.pixels

    def kept(self: animation._Screen) -> Any:
        drawn.append(pixels(self))
        return drawn[-1]

    monkeypatch.setattr(animation._Screen, "pixels", kept)
    arm, run = RUNS[which]
    animation.save_animation(run, arm, tmp_path / "arm.gif", speed=2.0, fps=15)
    with Image.open(tmp_path / "arm.gif") as film:
        frames = [
            (np.asarray(frame.convert("RGB"), dtype=int), frame.info["duration"])
            for frame in ImageSequence.Iterator(film)
        ]
    assert len(frames) == len(drawn) == 8
    assert sum(duration for _, duration in frames) == 530  # 8/15 s, in hundredths
    for (shown, _), true in zip(frames, drawn, strict=True):
        off = np.abs(shown - true[..., :3])
        assert off.max() <= 64 and (off > 24).mean() < 0.005 and off.mean() < 3.0
    assert (np.abs(np.diff([shown for shown, _ in frames], axis=0)).max(axis=(1, 2, 3)) > 99).all()


def test_the_ghost_is_above_the_arm_that_would_hide_it(tmp_path: Path) -> None:
    """Where the two coincide, both colours are to be seen."""
    run = sa.simulate(
        sa.Plant(TWO_LINK), sa.ComputedTorque(TWO_LINK, 100, 20), lambda t: (np.full(2, 0.4),) * 3,
        0.1, 1e-2, q0=(0.4, 0.4),
    )  # fmt: skip
    film = animation._Film(run, animation.joint_points(TWO_LINK), np.array([0]))
    pixels = film.picture.pixels()[..., :3].astype(int)
    film.ghost.set_visible(False)
    without = film.picture.pixels()[..., :3].astype(int)
    hidden = np.abs(pixels - without).max(axis=2) > 60
    assert hidden.sum() > 300
