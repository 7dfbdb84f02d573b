"""Looking at a run: size and time of its page, and the time of its film, new and frame by frame.

python benches/view.py

The page: 12 s at 1 kHz of a Panda with a load, beside another controller. The films: that run, and
the paper's 40 s of two links. "Whole frames" is what matplotlib's own writer does: every frame is
drawn from nothing, and gets a palette of its own. Times are of the processor. The figures go to
``results/<processor>.csv``; ends with 1 where a claim falls short.
"""

import sys
import tempfile
import time
import warnings
from io import BytesIO
from pathlib import Path

import steadyarm as sa
from claims import Claim, report
from matplotlib.animation import PillowWriter
from PIL import Image
from steadyarm import animation
from steadyarm.plots import Picture

REPEATS = 5

FASTER, SMALLER = 9, 2
"""How many times a film is to be as fast, and as small, as one of whole frames."""


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
    """Return time [s] and size [B] of a film, as it is made and with whole frames."""
    made = taken(lambda: run.animate(arm, path)), path.stat().st_size
    usual = animation._writer
    animation._writer = lambda path, fps: WholeFrames(fps=fps)
    try:
        return made, (taken(lambda: run.animate(arm, path)), path.stat().st_size)
    finally:
        animation._writer = usual


def main():
    """Measure everything, and say what falls short."""
    warnings.simplefilter("ignore", sa.DesignWarning)
    arm, run, other = pair()
    with tempfile.TemporaryDirectory() as folder:
        page, film = Path(folder, "run.html"), Path(folder, "run.gif")
        best = min(taken(lambda: run.to_html(page, against=other)) for _ in range(REPEATS))
        rows = [Claim("page of two runs, time", 1e9 * best)]
        rows.append(Claim("page of two runs, size", page.stat().st_size, unit="B"))
        notebook = len(run._repr_html_().encode())
        rows.append(Claim("one run in a notebook, size", notebook, unit="B"))
        paper = sa.paper.simulation(3, preset="claimed").run()
        films = {"Panda, 12 s": (run, arm), "two links, 40 s": (paper, sa.paper.nominal())}
        for name, (shown, of) in films.items():
            (new, small), (old, large) = filmed(shown, of, film)
            times, sizes = (1e9 * new, 1e9 * old), (small, large)
            figure = f"film, {name}: whole frames"
            rows.append(Claim(f"{figure}, time", *times, cpu=old / new, wanted=FASTER))
            # Of bytes there is one ratio; it stands in the first column.
            ratio = large / small
            rows.append(Claim(f"{figure}, size", *sizes, ratio, wanted=SMALLER, unit="B"))
    return report("view", rows)


if __name__ == "__main__":
    sys.exit(main())
