"""Open every built page of the manual in Chromium, without a network, and say what is wrong.

``python docs/check.py [docs/_build/html]``; ``--self-test`` plants each fault in a copy of a page
and fails unless it is found.
"""

import argparse
import re
import shutil
import sys
import tempfile
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote, urldefrag, urlparse

HERE = Path(__file__).parent
WIDTHS = (390, 1280)
THEMES = ("light", "dark")
ROLE = re.compile(r"(?<!\w):[a-z]+(?::[a-z]+)?:`|\{[a-z]+\}`")
LATEX = re.compile(r"\\[a-zA-Z]{2,}|\\\\|\$[^$\n]+\$")

# What a page holds, read in the page itself; code is not text to be checked.
READ = """() => {
  const main = document.querySelector('[role=main]') || document.body;
  const text = main.cloneNode(true);
  text.querySelectorAll('pre, code, script, style, annotation').forEach(it => it.remove());
  const all = (what) => [...document.querySelectorAll(what)];
  return {
    text: text.textContent,
    ids: all('[id]').map(it => it.id).concat(all('a[name]').map(it => it.name)),
    links: all('a[href]').map(it => it.getAttribute('href')),
    images: [...main.querySelectorAll('img')].map(it => ({
      source: it.getAttribute('src'), alt: it.getAttribute('alt') || '',
      loaded: it.complete && it.naturalWidth > 0,
      shown: it.getClientRects().length > 0})),
    heads: [...main.querySelectorAll('h1,h2,h3,h4,h5,h6')].map(it => +it.tagName[1]),
    title: document.title,
    description: !!document.querySelector('meta[name=description]'),
    latex: all('math').length + all('.math').length,
  };
}"""
# Furo's boxes around the text scroll too where it is wider than a phone.
SIDEWAYS = """() => Math.max(document.documentElement.scrollWidth - window.innerWidth,
  ...[...document.querySelectorAll('.page, .main, .content')].map(
    it => it.clientWidth ? it.scrollWidth - it.clientWidth : 0))"""


def browser(play):
    """Start Debian's Chromium."""
    path = shutil.which("chromium")
    if path is None:
        sys.exit("docs-check: chromium is missing; `make setup-debian` installs it")
    return play.chromium.launch(executable_path=path, args=["--no-sandbox"])


class Pages:
    """The built pages below a directory, each looked at once."""

    def __init__(self, root, window):
        self.root, self.faults, self.external = root, [], set()
        self.seen, self.asked = {}, {}
        self.page = window.new_page()
        self.name = ""
        self.page.on("console", self.console)
        self.page.on("pageerror", lambda error: self.fault(f"script error: {error}"))
        self.page.on("requestfailed", lambda it: self.fault(f"cannot load {it.url}"))
        self.page.route("**/*", self.request)

    def fault(self, what):
        """Note a fault of the page that is open."""
        self.faults.append(f"{self.name}: {what}")

    def console(self, message):
        """Note errors and warnings."""
        if message.type in ("error", "warning"):
            self.fault(f"console {message.type}: {message.text}")

    def request(self, route):
        """Let files through, and nothing else."""
        if urlparse(route.request.url).scheme in ("file", "data", "blob"):
            route.continue_()
        else:
            self.fault(f"asks the network for {route.request.url}")
            route.abort()

    def look(self, file):
        """Open a page in each width and theme."""
        self.name = str(file.relative_to(self.root))
        self.page.set_viewport_size({"width": WIDTHS[-1], "height": 900})
        self.page.goto(file.as_uri())
        # Pictures of the other theme and those further down are loaded too.
        self.page.evaluate("document.querySelectorAll('img').forEach(it => it.loading = 'eager')")
        self.page.wait_for_function("[...document.images].every(it => it.complete)")
        self.seen[file] = found = self.page.evaluate(READ)
        self.examine(file, found)
        for theme in THEMES:
            self.page.evaluate(f"document.body.dataset.theme = '{theme}'")
            for width in WIDTHS:
                self.page.set_viewport_size({"width": width, "height": 900})
                over = self.page.evaluate(SIDEWAYS)
                if over > 0:
                    self.fault(f"scrolls {over} px sideways at {width} px, {theme}")
            if found["images"] and not any(
                it["shown"] for it in self.page.evaluate(READ)["images"]
            ):
                self.fault(f"shows no picture, {theme}")

    def examine(self, file, found):
        """Judge text, headings, pictures of a page; keep its links for later."""
        for match in (*LATEX.finditer(found["text"]), *ROLE.finditer(found["text"])):
            around = found["text"][max(match.start() - 20, 0) : match.end() + 20]
            self.fault(f"raw markup {match[0]!r} in {around!r}")
        if not found["title"].strip():
            self.fault("has no title")
        heads = found["heads"]
        if heads and (heads[0] != 1 or heads.count(1) != 1):
            self.fault(f"wants one h1, the first heading; has {heads}")
        for above, below in pairwise(heads):
            if below > above + 1:
                self.fault(f"h{below} follows h{above}")
        for image in found["images"]:
            if not image["loaded"]:
                self.fault(f"picture not loaded: {image['source']}")
            alt = image["alt"]
            if not alt.strip() or alt == image["source"] or re.search(r"\.(png|svg)$", alt):
                self.fault(f"picture without a text: {image['source']}")
        self.asked[file] = found["links"]

    def follow(self):
        """Judge the links of all pages, which have been looked at."""
        for file, links in self.asked.items():
            self.name = str(file.relative_to(self.root))
            for link in dict.fromkeys(links):
                if urlparse(link).scheme:
                    self.external.add(link)
                    continue
                path, place = urldefrag(link)
                target = (file.parent / unquote(path.split("?")[0])).resolve() if path else file
                if not target.is_file():
                    self.fault(f"dead link: {link}")
                elif target in self.seen and place:
                    ids = self.seen[target]["ids"]
                    if unquote(place) not in ids:
                        self.fault(f"dead anchor: {link}")


def check(root, only=None):
    """Return the faults and the external links of the pages below a directory."""
    from playwright.sync_api import sync_playwright

    root = root.resolve()
    with sync_playwright() as play:
        window = browser(play).new_context(color_scheme="light", offline=True)
        pages = Pages(root, window)
        for file in sorted(root.rglob("*.html")) if only is None else [root / only]:
            if "_static" not in file.parts:
                pages.look(file)
        pages.follow()
        pages.page.close()
    return pages.faults, sorted(pages.external), len(pages.seen)


# One fault of each kind: what is put before the end of the article, and what must be said.
PLANTS = {
    "console error": ("<script>console.error('planted')</script>", "console error"),
    "console warning": ("<script>console.warn('planted')</script>", "console warning"),
    "script error": ("<script>throw Error('planted')</script>", "script error"),
    "network": ("<script src='https://example.org/a.js'></script>", "asks the network"),
    "missing file": ("<script src='_static/none.js'></script>", "cannot load"),
    "dead link": ("<a href='none.html'>x</a>", "dead link"),
    "dead anchor": ("<a href='#none-such'>x</a>", "dead anchor"),
    "raw latex": ("<p>$\\dot q$</p>", "raw markup"),
    "raw role": ("<p>:func:`step`</p>", "raw markup"),
    "MyST role": ("<p>{func}`step`</p>", "raw markup"),
    "wide": ("<div style='width:2000px'>x</div>", "sideways at 1280"),
    "wide on a phone": ("<div style='width:600px'>x</div>", "sideways at 390"),
    "dark only": (
        "<style>body[data-theme=dark] article{width:3000px}</style>",
        "px, dark",
    ),
    "no picture": ("<img alt='it' src='none.png'>", "picture not loaded"),
    "no text": ("<img src='_static/plus.png'>", "picture without a text"),
    "headings": ("<h6>x</h6>", "h6 follows"),
    "second title": ("<h1>x</h1>", "one h1"),
}


def self_test(root):
    """Plant each fault in a copy of a page; return what was not found."""
    missed = []
    with tempfile.TemporaryDirectory() as directory:
        copy = Path(directory) / "html"
        shutil.copytree(root, copy)
        page = copy / "files.html"
        whole = page.read_text(encoding="utf-8")
        for name, (markup, said) in PLANTS.items():
            page.write_text(whole.replace("</article>", markup + "</article>"), encoding="utf-8")
            found, _, _ = check(copy, "files.html")
            if not any(said in fault for fault in found):
                missed.append(f"self-test: {name} was planted and not found: {found}")
    return missed


def main():
    """Print the faults; exit 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=Path, default=HERE / "_build/html")
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    try:
        import playwright.sync_api  # noqa: F401
    except ImportError:
        sys.exit("docs-check: playwright is missing; it is in the dependency group docs-check")
    if arguments.self_test:
        faults = self_test(arguments.root)
        print("\n".join(faults) or f"docs-check finds all {len(PLANTS)} planted faults")
        return bool(faults)
    faults, external, count = check(arguments.root)
    print(f"{count} pages; {len(external)} external links, not fetched:", *external, sep="\n  ")
    print(*faults, f"{len(faults)} faults", sep="\n")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
