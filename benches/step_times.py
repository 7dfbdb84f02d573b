"""Keep the times of steps timed one by one: ``benches/results/<processor>.csv``.

Usage: python benches/step_times.py (runs ``cargo bench --bench step_times``)
"""

import json
import subprocess
import sys
from pathlib import Path

from claims import Claim, report


def main():
    """Run the bench and keep its figures: p50, p99.99 and the maximum over the steps of a run."""
    command = ["cargo", "bench", "--locked", "--bench", "step_times"]
    run = subprocess.run(
        command, cwd=Path(__file__).parent.parent, check=True, capture_output=True, text=True
    )
    rows = []
    for found in map(json.loads, (x for x in run.stdout.splitlines() if x.startswith("{"))):
        figure = found.pop("figure")
        rows += [Claim(f"{figure}: {name}", ns) for name, ns in found.items()]
    return report("step_times", rows)


if __name__ == "__main__":
    sys.exit(main())
