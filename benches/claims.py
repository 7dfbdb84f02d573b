"""What the benches claim and whether it holds: one table for all programs, kept for each processor.

Usage: python benches/claims.py (lists every claim with the smallest ratio seen on any machine)

A claim is our figure beside another: a peer's, whose ratio theirs : ours is to reach what is
wanted, or a limit, which is a ratio of 1. Ratios are of the clock and of processor time; a claim
holds if each that was measured reaches what is wanted. Figures without a claim stand beside them.

``report`` prints a program's table and writes it to ``results/<processor>.csv``, where it replaces
that program's rows alone.
"""

import csv
import os
import platform
import re
import statistics
from dataclasses import dataclass, field
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
COLUMNS = (
    "program", "figure", "unit", "ours", "theirs", "clock_ratio", "cpu_ratio", "wanted", "verdict",
)  # fmt: skip
HOLDS, FALLS_SHORT = "holds", "falls short"

SCALES = {
    "ns": ((1e9, "s"), (1e6, "ms"), (1e3, "us"), (1, "ns")),
    "B": ((1e6, "MB"), (1e3, "kB"), (1, "B")),
}
"""Units of the figures, and what they are written in."""


@dataclass(frozen=True)
class Claim:
    """A figure [unit], what it is compared with, and the ratio wanted, if any."""

    figure: str
    ours: float
    theirs: float | None = None
    clock: float | None = None
    """theirs : ours, or the limit : ours, of the clock."""
    cpu: float | None = None
    """The same of processor time."""
    wanted: float | None = None
    unit: str = "ns"

    @property
    def ratio(self):
        """The smaller of the ratios measured, or None."""
        return min((x for x in (self.clock, self.cpu) if x is not None), default=None)

    @property
    def verdict(self):
        """Whether it holds; empty where nothing is wanted."""
        if self.wanted is None:
            return ""
        return HOLDS if self.ratio >= self.wanted else FALLS_SHORT

    def row(self):
        """Return the row of the file, without the program."""
        numbers = (self.ours, self.theirs, self.clock, self.cpu)
        wanted = "" if self.wanted is None else f"{self.wanted:g}"
        return [
            self.figure,
            self.unit,
            *("" if x is None else f"{x:.2f}" for x in numbers),
            wanted,
            self.verdict,
        ]


def within(figure, ours, most, *, of="clock"):
    """A claim that our figure is at most ``most`` [ns]; ``of``: "clock" or "cpu"."""
    return Claim(figure, ours, most, wanted=1.0, **{of: most / ours})


@dataclass
class Paired:
    """A claim while it is timed: (clock, processor) [s] of ours and of theirs, round by round.

    ``of``: the ratios that count, "clock" or "cpu" or both; the times shown are of the first.
    """

    figure: str
    wanted: float | None = None
    of: tuple[str, ...] = ("clock", "cpu")
    ours: list[tuple[float, float]] = field(default_factory=list)
    theirs: list[tuple[float, float]] = field(default_factory=list)

    def claim(self):
        """Return the claim: medians, and ratios of medians."""
        ours, theirs = (
            dict(zip(("clock", "cpu"), medians(times), strict=True))
            for times in (self.ours, self.theirs)
        )
        ratios = {name: theirs[name] / ours[name] for name in self.of}
        shown = (1e9 * times[self.of[0]] for times in (ours, theirs))
        return Claim(self.figure, *shown, wanted=self.wanted, **ratios)


def medians(times):
    """Return the median clock and processor time."""
    return [statistics.median(column) for column in zip(*times, strict=True)]


def written(number, unit):
    """Write a figure with three digits."""
    fits = (pair for pair in SCALES[unit] if abs(number) >= pair[0])
    scale, name = next(fits, SCALES[unit][-1])
    return f"{number / scale:.3g} {name}"


def report(program, claims, *, keep=True):
    """Print the table of a program; return 1 if a claim falls short, and 0 otherwise.

    It goes to the file of this processor too. Without ``keep`` there is neither a verdict nor a
    file: the figures of a run that only shows that all works.
    """
    width = max(len(claim.figure) for claim in claims)
    print(f"\n{platform.machine()}, {os.cpu_count()} cores")
    print(f"{'claim: against':<{width}} {'ours':>9} {'theirs':>9} {'clock':>8} {'cpu':>8}  wanted")
    for claim in claims:
        print(line(claim, width, keep))
    if not keep:
        return 0
    print(f"see {write(program, claims)}")
    return int(any(claim.verdict == FALLS_SHORT for claim in claims))


def line(claim, width, judged):
    """Return the line of a claim."""
    theirs = "" if claim.theirs is None else written(claim.theirs, claim.unit)
    ratios = ("" if x is None else f"{x:.2f}" for x in (claim.clock, claim.cpu))
    text = f"{claim.figure:<{width}} {written(claim.ours, claim.unit):>9} {theirs:>9}"
    text += "".join(f" {ratio:>8}" for ratio in ratios)
    if claim.wanted is not None:
        text += f"  {claim.wanted:6g}" + f"  {claim.verdict}" * judged
    return text.rstrip()


def processor():
    """Return the name of this processor in small letters and hyphens."""
    name = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        found = re.search(r"^model name\s*:\s*(.+)$", cpuinfo.read_text(), re.MULTILINE)
        name = found.group(1) if found else name
    return re.sub(r"[^a-z0-9]+", "-", re.sub(r"\(\w+\)", "", name.lower())).strip("-")


def write(program, claims, folder=RESULTS):
    """Replace the rows of a program in the file of this processor; return the file."""
    path = folder / f"{processor()}.csv"
    found = read(path) if path.exists() else []
    if found is None:
        raise SystemExit(f"{path}: not written, for it has other columns than {', '.join(COLUMNS)}")
    kept = [row for row in found if row[0] != program]
    new = [[program, *claim.row()] for claim in claims]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *sorted(kept + new)])
    return path


def read(path):
    """Return the rows of a file, or None if it has other columns."""
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return rows if tuple(head) == COLUMNS else None


def smallest(folder=RESULTS):
    """Return {(program, figure): (ratio, wanted, verdict, machine)}, the smallest of each claim."""
    found = {}
    for path in sorted(folder.glob("*.csv")):
        for program, figure, _, _, _, *ratios, wanted, verdict in read(path) or ():
            if wanted:
                ratio = min(float(x) for x in ratios if x)
                seen = (ratio, float(wanted), verdict, path.stem)
                found[program, figure] = min(seen, found.get((program, figure), seen))
    return found


def main():
    """List every claim with its smallest ratio."""
    found = smallest()
    width = max((len(f"{program}, {figure}") for program, figure in found), default=0)
    for (program, figure), (ratio, wanted, verdict, machine) in sorted(found.items()):
        name = f"{program}, {figure}"
        print(f"{name:<{width}} {ratio:8.2f}  wanted {wanted:4g}  {verdict:<11}  {machine}")


if __name__ == "__main__":
    main()
