"""Keep the step of the recommended controller on a Panda: ``benches/results/<processor>.csv``.

Usage: python benches/recommended.py (runs ``cargo bench --bench recommended``). Ends with 1 where
99.99 % of the steps take more than 10 µs.
"""

import json
import subprocess
import sys
from pathlib import Path

from results import write

MOST = 10_000.0
"""[ns]"""

FIGURES = ("median_ns", "p9999_ns", "worst_ns")


def main():
    """Run the bench, keep its figures and say whether the goal holds."""
    command = ["cargo", "bench", "--locked", "--bench", "recommended"]
    run = subprocess.run(
        command, cwd=Path(__file__).parent.parent, check=True, capture_output=True, text=True
    )
    found = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    rows = []
    for row in found:
        print(f"{row['figure']}: {', '.join(f'{name} {row[name]:.0f}' for name in FIGURES)}")
        rows += [(f"{row['figure']}, {name}", row[name], None, None, None) for name in FIGURES]
    print(f"see {write('recommended', rows)}")
    return int(any(row["p9999_ns"] > MOST for row in found))


if __name__ == "__main__":
    sys.exit(main())
