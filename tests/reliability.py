"""Writes the table of `docs/reliability.md` from a run of its tests: ``make reliability``."""

import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

TESTS = Path(__file__).parent / "python"
PAGE = TESTS.parents[1] / "docs" / "reliability.md"
HEAD = "| # | row | promise | result |\n|---|---|---|---|\n"


def outcome(case: ET.Element) -> str:
    """How a test ended, in words, with the reason if it is no pass."""
    if case.find("failure") is not None or case.find("error") is not None:
        return "fails"
    skipped = case.find("skipped")
    if skipped is None:
        return "pass"
    kind = "falls short" if skipped.get("type") == "pytest.xfail" else "not had here"
    return f"{kind}: {skipped.get('message')}"


def results() -> dict[str, set[str]]:
    """Name of each test to the outcomes of its cases."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        command = [sys.executable, "-m", "pytest", "-q", "-c", "../../pyproject.toml"]
        command += [f"--junitxml={report}", "test_reliability.py"]
        subprocess.run(command, cwd=TESTS, check=False)
        found: dict[str, set[str]] = {}
        for case in ET.parse(report).iter("testcase"):
            found.setdefault(case.get("name", "").split("[")[0], set()).add(outcome(case))
    return found


def promises() -> dict[str, str]:
    """Name of each test to the first line of its docstring."""
    source = (TESTS / "test_reliability.py").read_text(encoding="utf-8")
    return dict(
        re.findall(r'^def (test_row_\w+)\(.*?\n    """(.+?)(?:"""|\n)', source, re.M | re.S)
    )


def row(name: str, promise: str, result: str) -> str:
    """A line of the table."""
    number, title = re.fullmatch(r"test_row_(\d+)_(\w+)", name).groups()  # type: ignore[union-attr]
    return f"| {int(number)} | {title.replace('_', ' ')} | {promise} | {result} |\n"


def main() -> int:
    """Write the table; 1 if a test failed."""
    found, wanted = results(), promises()
    rows = [row(name, wanted[name], "; ".join(sorted(found[name]))) for name in sorted(wanted)]
    before, _, after = re.split(
        r"(\| # \| row .*?)(?=\n\n)", PAGE.read_text(encoding="utf-8"), maxsplit=1, flags=re.S
    )
    PAGE.write_text(before + (HEAD + "".join(rows)).rstrip("\n") + after, encoding="utf-8")
    return int(any("fails" in result for result in found.values()))


if __name__ == "__main__":
    sys.exit(main())
