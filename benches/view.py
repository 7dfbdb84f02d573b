"""Looking at a run: size and time of its page, and the time of its film, new and frame by frame.

python benches/view.py

The page: 12 s at 1 kHz of a Panda with a load, beside another controller. The films: that run, and
the paper's 40 s of two links. "Whole frames" is what matplotlib's own writer does: every frame is
drawn from nothing, and gets a palette of its own. Times are of the processor.
"""

import tempfile
import time
import warnings
from io import BytesIO
from pathlib import Path

import steadyarm as sa
from matplotlib.animation import PillowWriter
from PIL import Image
from steadyarm import animation
from steadyarm.plots import Picture

REPEATS = 5


class WholeFrames(PillowWriter):
    """Draws all of every frame."""

    def grab_frame(self, **savefig_kwargs):
        """Draw a frame and keep it."""
        drawn = BytesIO()
        Picture.savefig(self.fig, drawn, format="rgba", dpi=self.dpi)
        size = (*map(int, self.fig.bbox.size),)
        self._frames.append(Image.frombuffer("RGBA", size, drawn.getbuffer(), "raw", "RGBA", 0, 1))


def pair():
    """Return the arm and two runs of it, with the recommended controller and computed torque."""
    arm, start = sa.Serial.shipped("panda"), (0, -0.6, 0, -2, 0, 1.6, 0.8)
    path = sa.Quintic(start, goal=(0.3, 0, 0.3, -1, 0, 2, 1), duration=3.0)
    plant, believed = sa.Plant(arm.with_payload(2.0)), arm.without_friction()
    trackers = sa.recommended(believed, path=path), sa.ComputedTorque(believed, 100, 20)
    loop = {"control_period": 1e-3, "q0": start}
    return arm, *(sa.simulate(plant, tracker, path, 12.0, **loop) for tracker in trackers)


def taken(work):
    """Return the time of the processor that it takes [s]."""
    start = time.process_time()
    work()
    return time.process_time() - start


def filmed(run, arm, path):
    """Return time [s] and size [kB] of a film, as it is made and with whole frames."""
    made = taken(lambda: run.animate(arm, path)), path.stat().st_size / 1e3
    usual = animation._writer
    animation._writer = lambda path, fps: WholeFrames(fps=fps)
    try:
        return made, (taken(lambda: run.animate(arm, path)), path.stat().st_size / 1e3)
    finally:
        animation._writer = usual


def main():
    """Print everything."""
    warnings.simplefilter("ignore", sa.DesignWarning)
    arm, run, other = pair()
    with tempfile.TemporaryDirectory() as folder:
        page, film = Path(folder, "run.html"), Path(folder, "run.gif")
        best = min(taken(lambda: run.to_html(page, against=other)) for _ in range(REPEATS))
        print(f"page of two runs: {page.stat().st_size / 1e3:.0f} kB in {best:.3f} s")
        print(f"in a notebook:    {len(run._repr_html_().encode()) / 1e3:.0f} kB for one run")
        paper = sa.paper.simulation(3, preset="claimed").run()
        films = {"Panda, 12 s": (run, arm), "two links, 40 s": (paper, sa.paper.nominal())}
        for name, (shown, of) in films.items():
            (new, small), (old, large) = filmed(shown, of, film)
            print(f"film of {name:16} {new:6.2f} s, {small:5.0f} kB; ", end="")
            print(f"whole frames {old:6.2f} s, {large:5.0f} kB: {old / new:.1f} times as long")


if __name__ == "__main__":
    main()
