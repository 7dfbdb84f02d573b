"""What the registries and a newcomer ask of a release: ``make release-check``.

Builds the source distribution, from it a wheel as pip does, and the wheel of the release, which
runs on older systems too (zig brings their C library). Then looks at each of them with the tools
of the registries, and uses the wheels in environments of their own. Everything is in target/dist.
"""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
from pathlib import Path
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "target" / "dist"
TOOLS = Path(sys.executable).parent

MANYLINUX = "manylinux_2_28"
"""The oldest system that the wheel is for, as its tag says it."""

VERSIONS = ("3.11", "3.12", "3.13", "3.14")
"""Pythons that one wheel serves: the stable ABI."""

IN_WHEEL = (
    "steadyarm/py.typed", "steadyarm/_core.pyi", "steadyarm/_core.abi3.so",
    "steadyarm/arms/panda.toml", "steadyarm/scenarios/paper_sensors.toml",
)  # fmt: skip
"""What a wheel must have, beside the licences and the list of what it is made of."""


def run(*command: str | Path, **options: object) -> str:
    """Run a command in the project's folder; what it said, or its failure."""
    print("$", *command, flush=True)
    found = {"PATH": f"{TOOLS}{os.pathsep}{os.environ['PATH']}"}  # zig is a module of this Python
    options = {"cwd": ROOT, "env": os.environ | found, **options}
    done = subprocess.run(command, stdout=-1, stderr=-2, text=True, **options)  # type: ignore[call-overload]
    if done.returncode:
        sys.exit(f"{done.stdout}\nrelease-check: {command[0]} ended with {done.returncode}")
    return str(done.stdout)


def crate() -> None:
    """The crate is packed and compiles by itself, and cargo has nothing to say of it."""
    said = run("cargo", "package", "--locked", "--allow-dirty")
    warnings = [line for line in said.splitlines() if line.startswith("warning")]
    assert not warnings, "\n".join(warnings)


def built() -> tuple[Path, Path]:
    """The source distribution, and the wheel of the release built with zig."""
    shutil.rmtree(DIST, ignore_errors=True)
    run(TOOLS / "maturin", "sdist", "--out", DIST)
    (source,) = DIST.glob("*.tar.gz")
    build = (TOOLS / "maturin", "build", "--release", "--locked", "--zig")
    run(*build, "--compatibility", MANYLINUX, "--out", DIST)
    (wheel,) = DIST.glob("*.whl")
    return source, wheel


def looked_at(source: Path, wheel: Path) -> None:
    """The tools of the registries have nothing to say; the files that must be there are."""
    run(TOOLS / "twine", "check", "--strict", source, wheel)
    run(TOOLS / "check-wheel-contents", wheel)
    run(TOOLS / "abi3audit", "--strict", wheel)
    said = " ".join(run(TOOLS / "auditwheel", "show", wheel).split())
    assert "consistent with the following platform tag" in said, said
    assert MANYLINUX in wheel.name, wheel.name
    with ZipFile(wheel) as files:
        names = files.namelist()
        folder = next(name.split("/")[0] for name in names if ".dist-info/" in name)
        metadata = files.read(f"{folder}/METADATA").decode()
    wanted = [*IN_WHEEL, f"{folder}/licenses/LICENSE-MIT", f"{folder}/licenses/LICENSE-APACHE"]
    assert not [name for name in wanted if name not in names], names
    assert any(re.fullmatch(rf"{folder}/sboms/.+\.json", name) for name in names), names
    assert re.findall(r"^Requires-Dist: (?!.*extra ==)(.+)$", metadata, re.M) == ["numpy>=1.26"]
    assert "Classifier: Typing :: Typed" in metadata
    relative = r"\]\((?!https://|#)|^\[[^\]]+\]: (?!https://)"
    assert not re.search(relative, metadata, re.M), "the README has a relative link"
    with tarfile.open(source) as archive:
        inside = archive.getnames()
    assert any(name.endswith("/Cargo.lock") for name in inside), inside[:20]
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB")


def used(wheel: Path, python: str, folder: Path) -> None:
    """Install into an environment of its own, from anywhere but the checkout, and use it."""
    place = Path(tempfile.mkdtemp(dir=folder))
    command = shutil.which(f"python{python}")
    if command is None or subprocess.run([command, "--version"], capture_output=True).returncode:
        print(f"not tried: Python {python} is not on this machine")
        return
    run(command, "-m", "venv", place)
    home = {"PATH": f"{place}/bin:{os.environ['PATH']}", "HOME": str(folder)}
    run(place / "bin/pip", "install", "--quiet", wheel, env=os.environ | home)
    print(run(place / "bin/python", ROOT / "tests/smoke.py", cwd=folder, env=home).strip())


def from_source(source: Path, folder: Path) -> Path:
    """The wheel that pip makes of the source distribution, in a clean environment."""
    venv.create(folder / "clean", with_pip=True)
    run(folder / "clean/bin/pip", "wheel", "--quiet", "--no-deps", "-w", folder, source)
    (wheel,) = folder.glob("*.whl")
    return wheel


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        crate()
        source, wheel = built()
        looked_at(source, wheel)
        for python in VERSIONS:
            used(wheel, python, folder)
        used(from_source(source, folder), f"{sys.version_info[0]}.{sys.version_info[1]}", folder)
    print(f"Ready to publish, by hand: {DIST}")
