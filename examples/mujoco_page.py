"""The tables of the page "Which controller?", and its pictures: mujoco_bench.py --page FOLDER.

Every controller on the Panda under the usual conditions; then three that are quick, and the
recommended one, on all robots and in all cases.
"""

from mujoco_report import brief, errors, pareto, scene, value

COMPARED = ("recommended", "momentum_observer_fast", "super_twisting")
"""Controllers of the table of cases."""

WORDS = {
    "base": "as above",
    "ideal": "ideal sensors, no delay",
    "jitter": "periods that jitter by 20 %",
    "drop": "2 % of samples lost",
    "gain": "actuators off by 10 %, each its own way",
    "noise": "position noise of 1e-4 rad, told",
    "12 bits": "12-bit encoders",
    "19 bits": "19-bit encoders",
    "250 Hz": "a loop of 250 Hz",
    "4 kHz": "a loop of 4 kHz",
    "push": "1 N·m at 2.9 rad/s on the wrist",
    "pick-up": "the payload picked up in the middle",
    "offset": "a payload 5 cm to the side",
    "lag 2 ms": "motors with a lag of 2 ms",
    "lag 5 ms": "motors with a lag of 5 ms",
    "gears": "gears that give .6° at full torque, encoders at the motors",
    "gears, light rotors": "the same with light rotors: they swing against the links",
    "rotors": "rotors known",
    "no rotors": "no rotors anywhere",
    "unstated": "rotors that the model lacks",
}
"""Cases in words."""


def wanted(cases, robots):
    """Return the runs of the page: (robot, case, controllers), None for all of them."""
    pairs = [("panda", "base", None)]
    pairs += [("panda", case, COMPARED) for case in cases if case not in ("base", "no rotors")]
    others = [robot for robot in robots if robot != "panda"]
    return pairs + [
        (robot, case, COMPARED) for robot in others for case in ("rotors", "no rotors", "unstated")
    ]


def write(rows, folder):
    """Write tables.md, errors.png and pareto.png."""
    folder.mkdir(parents=True, exist_ok=True)
    first = [row for row in rows if scene(row) == ("panda", "base")]
    rest = [row for row in rows if row.job.controller in COMPARED]
    text = f"{rivals(first)}\n\n{cases(rest)}\n"
    (folder / "tables.md").write_text(text, encoding="utf-8")
    errors(first, folder / "errors.png")
    pareto(first, folder / "pareto.png")


def rivals(rows):
    """Return the table of all controllers, the smallest error first."""
    head = ("controller", "RMS error", "torque variation", "largest torque", "frozen", "other path")
    figures = (("rms", 1e3), ("variation", 1.0), ("peak", 1.0), ("frozen", 1e3), ("other", 1e3))
    lines = []
    for controller in dict.fromkeys(row.job.controller for row in rows):
        runs = [row for row in rows if row.job.controller == controller]
        cells = [pair(runs, figure, scale) for figure, scale in figures]
        if cells[0] == "–":
            cells[0] = "refused at this rate"
        lines.append((max(row.rms or 1e9 for row in runs), [f"`{runs[0].job.controller}`", *cells]))
    return table(head, [cells for _, cells in sorted(lines, key=lambda line: line[0])])


def cases(rows):
    """Return the table of cases: RMS of each controller, and what the recommended one said."""
    head = ("robot", "case", *(controller.replace("_", " ") for controller in COMPARED))
    lines = []
    for robot, case in dict.fromkeys(scene(row) for row in rows):
        cells = []
        for controller in COMPARED:
            runs = [
                row
                for row in rows
                if scene(row) == (robot, case) and row.job.controller == controller
            ]
            refused = any(row.note.startswith("refused") for row in runs)
            cells.append("asked for" if refused else pair(runs, "rms", 1e3))
        lines.append([robot, WORDS[case], *cells])
    return table(head, lines)


def pair(rows, figure, scale):
    """Return a figure of both motions."""
    found = [value([row], figure) for row in rows]
    if not any(x is not None for x in found):
        return "–"
    return " / ".join("lost" if x is None else brief(scale * x) for x in found)


def table(head, lines):
    """Return a table in Markdown."""
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)
