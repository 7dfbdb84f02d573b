"""Keep the step of the recommended controller on a Panda: ``benches/results/<processor>.csv``.

Usage: python benches/recommended.py (runs ``cargo bench --bench recommended``). Ends with 1 where
99.99 % of the steps take more than 10 µs.
"""

import json
import subprocess
import sys
from pathlib import Path

from claims import Claim, report, within

MOST = 10_000.0
"""[ns]"""


def main():
    """Run the bench, keep its figures and say whether the claim holds."""
    command = ["cargo", "bench", "--locked", "--bench", "recommended"]
    run = subprocess.run(
        command, cwd=Path(__file__).parent.parent, check=True, capture_output=True, text=True
    )
    found = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    rows = []
    for row in found:
        rows.append(within(f"{row['figure']}, p9999_ns", row["p9999_ns"], MOST))
        rows += [Claim(f"{row['figure']}, {name}", row[name]) for name in ("median_ns", "worst_ns")]
    return report("recommended", rows)


if __name__ == "__main__":
    sys.exit(main())
