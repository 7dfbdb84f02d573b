"""What the manual says of the code is there, and its examples run."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
import test_reliability
from steadyarm import cli

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [
    page
    for page in sorted(DOCS.rglob("*.md"))
    if "_build" not in page.parts and page != DOCS / "which/tables.md"  # a part of which.md
]
TEXTS = [ROOT / "README.md", *PAGES]

HOMES = (
    "https://github.com/steadyarm/steadyarm/blob/main/",
    "https://raw.githubusercontent.com/steadyarm/steadyarm/main/",
)
"""Where the files of the project are for who reads the README elsewhere: a registry, a package."""


def blocks(text: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text.read_text(encoding="utf-8"), re.DOTALL)


def anchors(page: Path) -> set[str]:
    """The places of a page that links may name: its headings, as GitHub and MyST write them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def examples(page: Path) -> list[tuple[str, str | None]]:
    """The Python of a page, each block with what is shown to be printed by it, if anything is."""
    form = r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?"
    found = re.findall(form, page.read_text(encoding="utf-8"), re.DOTALL)
    return [(code, shown or None) for code, shown in found]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_python_examples_of_the_manual_run_and_print_what_is_shown(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A block goes on from the one before it, unless it imports steadyarm itself. Where lines break
    is not compared: a page breaks long ones."""
    monkeypatch.chdir(tmp_path)  # some write files, and some read the robot of the examples
    shutil.copy(ROOT / "examples/04_arm.urdf", tmp_path)
    names: dict[str, object] = {}
    for code, shown in examples(page):
        if "import steadyarm as sa\n" in code:
            names = {}
        exec(compile(code, str(page), "exec"), names)
        printed = capsys.readouterr().out
        assert shown is None or shown.split() == printed.split(), code


def test_pictures_of_the_tutorial_are_those_that_its_code_saves() -> None:
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    shown = re.findall(r"^```\{image\} tutorial/(\S+)$", text, re.MULTILINE)
    assert shown == re.findall(r'savefig\("(\S+)"', text)
    assert set(shown) == {picture.name for picture in (DOCS / "tutorial").iterdir()}


def test_rust_examples_are_whole_as_they_are_read() -> None:
    """What rustdoc hides, a reader does not have; that they compile is tested as doctests."""
    found = [(page, code) for page in TEXTS for code in blocks(page, "rust")]
    assert found
    doctested = (ROOT / "src/lib.rs").read_text(encoding="utf-8")
    for page, code in found:
        assert f'include_str!("../{page.relative_to(ROOT)}")' in doctested
        assert "fn main()" in code
        assert not re.search(r"^\s*#(\s|$)", code, re.MULTILINE)
        assert "```{" not in page.read_text(encoding="utf-8"), "rustdoc takes it for Rust; use :::"


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    defined = re.findall(r"^\[[^\]]+\]: (\S+)$", text, re.MULTILINE)
    for link in [*re.findall(r"\]\(([^)\s]+)\)", text), *defined]:
        file, _, place = link.partition("#")
        home = next((home for home in HOMES if link.startswith(home)), None)
        if home is None and link.startswith("https://"):
            continue
        target = ROOT / file.removeprefix(home) if home else page.parent / file if file else page
        assert target.exists(), link
        assert not place or place in anchors(target), link


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: page.name)
def test_every_file_that_is_named_exists(page: Path) -> None:
    named = r"`((?:src|python|tests|benches|examples|docs)/[\w/.-]+)"
    text = page.read_text(encoding="utf-8")
    assert not [name for name in re.findall(named, text) if not (ROOT / name).exists()]


def listed(page: Path) -> set[Path]:
    """The pages that are in the contents of a page, and in theirs."""
    lines = "".join(blocks(page, "{toctree}")).splitlines()
    entries = [line.rpartition("<")[2].rstrip(">") for line in lines]
    below = {page.parent / f"{entry}.md" for entry in entries} & set(PAGES)
    return below.union(*map(listed, below))


def test_every_page_is_in_the_contents() -> None:
    assert set(PAGES) - listed(DOCS / "index.md") == {DOCS / "index.md"}


def commands(page: Path) -> list[list[str]]:
    """The commands of steadyarm in the blocks of a page, without what the shell does with them."""
    lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
    words = [shlex.split(line.partition(" > ")[0], comments=True) for line in lines]
    return [line[1:] for line in words if line[:1] == ["steadyarm"]]


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: page.name)
def test_every_command_of_the_manual_is_one(page: Path) -> None:
    for arguments in commands(page):
        cli._parser().parse_args(arguments)


def test_the_table_of_reliability_is_that_of_its_tests() -> None:
    """Each row with its promise; "pass" where no mark says that the test is not expected to."""
    rows = re.findall(
        r"^\| (\d+) \| (.+) \| (.+) \| (.+) \|$",
        (ROOT / "docs/reliability.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    tests = [(name, it) for name, it in sorted(vars(test_reliability).items()) if "_row_" in name]
    assert [int(number) for number, *_ in rows] == list(range(1, 42))
    for (number, row, promise, result), (name, test) in zip(rows, tests, strict=True):
        assert name == f"test_row_{int(number):02}_{row.replace(' ', '_')}"
        assert promise == test.__doc__.splitlines()[0]
        marks = {mark.name for mark in getattr(test, "pytestmark", [])}
        if result != "pass":
            assert marks & {"xfail", "skip", "skipif"}, result
            assert result.startswith(("falls short: ", "not had here: "))
        else:
            assert not marks & {"xfail", "skip"}


def steps() -> list[tuple[str, str]]:
    """File and name of every step of the walk in design.md."""
    rows = re.findall(
        r"^\| `([^`]+\.\w+)` \| ([^|]+) \|",
        (ROOT / "docs/design.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    return [(file, name) for file, names in rows for name in re.findall(r"`(\w+)`", names)]


@pytest.mark.parametrize(("file", "name"), steps())
def test_every_step_of_the_walk_is_in_the_code(file: str, name: str) -> None:
    code = (ROOT / file).read_text(encoding="utf-8")
    assert re.search(rf"\b(fn|def|struct|class|trait|enum) {name}\b", code)


def test_the_map_has_every_room() -> None:
    rooms = {path.name for path in (ROOT / "src").iterdir()} - {"lib.rs"}
    design = (ROOT / "docs/design.md").read_text(encoding="utf-8")
    assert not [room for room in rooms if f"`{room.removesuffix('/')}" not in design]
