"""What an installed wheel must do, on any system, with numpy alone: ``python tests/smoke.py``.

Runs the README's example, a file of each kind, and the commands, as a user would. The numbers of
the example must be those that the README prints, on every system.
"""

import contextlib
import importlib.util
import io
import os
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
import steadyarm as sa
from steadyarm.cli import main

ROOT = Path(__file__).resolve().parents[1]


def example() -> sa.Run:
    """Run the README's example; its error must be the one that the text prints."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.*?)```", text, re.DOTALL)[0]
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    run = names["run"]
    assert isinstance(run, sa.Run)
    error = 1e3 * float(np.linalg.norm(run.metrics(window=(8, 10)).rms_e))
    printed = re.search(r"([\d.]+) mrad with it", text)
    assert printed and f"{error:.3f}" == printed[1], (error, printed)
    return run


def files(run: sa.Run, folder: Path) -> None:
    """Write the run and its controller, and read them back."""
    run.save(folder / "run.npz")
    assert np.array_equal(sa.Run.load(folder / "run.npz").q, run.q)
    again = sa.recommended(sa.Serial.shipped("panda").without_friction())
    again.save(folder / "state.bin")
    again.load(folder / "state.bin")


def command(*arguments: str) -> str:
    """What a command prints; it must end with 0."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = main(arguments)
    assert code == 0, (arguments, code)
    return out.getvalue()


def extras() -> None:
    """Where matplotlib is missing, what draws says which extra brings it."""
    if importlib.util.find_spec("matplotlib") is not None:
        return
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        code = main(["reproduce"])
    assert code == 1 and 'pip install "steadyarm[plot]"' in said.getvalue(), said.getvalue()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)  # the example writes a page
        files(example(), Path(name))
        os.chdir(ROOT)
    assert sa.__version__ in command("--version")
    assert "finished" in command("simulate", "--duration", "1")
    assert "recommended" in command("compare", "paper_sensors", "--only", "recommended")
    extras()
    system = f"Python {sys.version.split()[0]} on {sys.platform}"
    print(f"steadyarm {sa.__version__} does what it must with {system}")
