"""Keep the worst step of each controller beside its usual one: ``benches/results/<processor>.csv``.

Usage: python benches/worst_case.py (runs ``cargo bench --bench worst_case``: 1400 kinds of samples
and histories). Ends with 1 where the worst takes more than 1.5 times the usual.
"""

import json
import subprocess
import sys
from pathlib import Path

from claims import Claim, report, within

MOST = 1.5
"""The worst over the usual, at most."""


def main():
    """Run the bench, keep its figures and say what was worst."""
    command = ["cargo", "bench", "--locked", "--bench", "worst_case"]
    run = subprocess.run(
        command, cwd=Path(__file__).parent.parent, check=True, capture_output=True, text=True
    )
    found = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    rows = []
    for name in dict.fromkeys(row["figure"].split(": ")[0] for row in found):
        own = [row for row in found if row["figure"].split(": ")[0] == name]
        usual, worst = own[0]["ns"], max(own, key=lambda row: row["ns"])
        rows.append(Claim(f"{name}: usual", usual))
        rows.append(within(f"{name}: worst", worst["ns"], MOST * usual))
        print(f"{worst['figure']}: {worst['ns'] / usual:.2f} times the usual")
    return report("worst_case", rows)


if __name__ == "__main__":
    sys.exit(main())
