"""Keep the medians that criterion left: ``benches/results/<processor>.csv``.

Usage: python benches/results.py (after cargo bench)
"""

import json
import sys
from pathlib import Path

from claims import Claim, report

CRITERION = Path(__file__).parent.parent / "target" / "criterion"


def criterion():
    """Return {(group, benchmark): median [ns]} of what criterion measured last."""
    found = {}
    for path in sorted(CRITERION.glob("**/new/estimates.json")):
        names = json.loads(path.with_name("benchmark.json").read_text())
        median = json.loads(path.read_text())["median"]["point_estimate"]
        found[names["group_id"], names["function_id"] or names["value_str"]] = median
    return found


def main():
    rows = [Claim(f"{group}: {name}", median) for (group, name), median in criterion().items()]
    if not rows:
        raise SystemExit(f"{CRITERION}: no results; run cargo bench")
    return report("criterion", rows)


if __name__ == "__main__":
    sys.exit(main())
