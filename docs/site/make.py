"""Writes the sources of the site: the documents, the commands' help, Python's docstrings and the gallery.

    python docs/site/make.py BOOK [--source] [--without-gallery]

`cascade` must be found where this runs, `node` must find katex in BOOK/node_modules. Docstrings are those
of the installed package, with `--source` those of its source, which leave out what is compiled.
docs/site/build does all of it, and mdBook makes pages of what is written here.
"""

import ast
import html
import importlib
import inspect
import itertools
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib
import types

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
#: Longer pages begin with a table of their headings; the rule is 900 words.
LONG = 880

#: Parts of the site: documents by their place in the repository, or made pages as (title, name).
PARTS: list[tuple[str, list[str | tuple[str, str]]]] = [
    (
        "Start",
        [
            "docs/site/start.md",
            "docs/site/questions.md",
            "docs/site/gallery.md",
            "docs/site/comparison.md",
        ],
    ),
    (
        "Fields",
        [
            *(
                f"docs/guide/{name}.md"
                for name in ("first-field", "report", "formats", "scans", "gaps-and-noise")
            ),
            *(
                f"docs/guide/{name}.md"
                for name in ("spectra", "ridges", "coherence", "bicoherence", "transfer")
            ),
            *(f"docs/guide/{name}.md" for name in ("modes", "increments", "slopes", "parts")),
        ],
    ),
    (
        "Chains",
        [
            *(f"docs/guide/{name}.md" for name in ("chains", "budgets", "triads", "localized-waves")),
            *(f"docs/guide/{name}.md" for name in ("attenuation", "plan", "fit", "design")),
        ],
    ),
    (
        "Python",
        [
            "docs/guide/python.md",
            "docs/guide/distributed.md",
            "docs/notebooks/*.md",
            ("Functions", "functions.md"),
        ],
    ),
    (
        "Reference",
        [
            ("Commands", "commands/*.md"),
            "docs/reference.md",
            "docs/formats/*.md",
            "docs/guide/glossary.md",
        ],
    ),
    (
        "Methods and measurements",
        [f"docs/{name}.md" for name in ("methods", "accuracy", "robustness", "performance")],
    ),
    (
        "The project",
        [
            *(f"{name}.md" for name in ("DESIGN", "CONTRIBUTING", "SECURITY", "CODE_OF_CONDUCT")),
            "figures/README.md",
            "benches/README.md",
            "crates/*/README.md",
            "crates/column-fft/DESIGN.md",
        ],
    ),
]
#: Documents that others link to, and the page that has their content.
ELSEWHERE = {"README.md": "docs/site/start.md", "docs/README.md": "docs/site/questions.md"}

CODE = re.compile(r"(^ *```.*?^ *```$|(?<!`)(`+)(?!`).+?(?<!`)\2(?!`))", re.DOTALL | re.MULTILINE)
FORMULA = re.compile(r"\$\$(.+?)\$\$|(?<![\\$\w])\$(?=\S)([^$]+?)(?<=\S)\$(?![\w$])", re.DOTALL)
LINK = re.compile(r"(\]\()([^)\s]+)(\))")


def page_of(document: str) -> str:
    """Where a document is on the site."""
    if document == "docs/site/start.md":
        return "index.md"
    path = document.removeprefix("docs/site/").removeprefix("docs/").replace("README", "index")
    return path if document.startswith("docs/") else f"project/{path.lower()}"


def outside_code(text: str, change) -> str:
    """The text with everything that is no code changed."""
    parts, at = [], 0
    for found in CODE.finditer(text):
        parts += [change(text[at : found.start()]), found[0]]
        at = found.end()
    return "".join([*parts, change(text[at:])])


class Site:
    def __init__(self, book: pathlib.Path) -> None:
        self.book = book
        self.source = book / "src"
        shutil.rmtree(self.source, ignore_errors=True)
        self.source.mkdir(parents=True)
        #: Pages by the document that they are made of.
        self.pages: dict[str, str] = {}
        #: All pages with their texts, in order; a part's title has none.
        self.order: list[tuple[str, str]] = []
        self.texts: dict[str, str] = {}

    def add(self, page: str, text: str) -> None:
        self.texts[page] = text
        self.order.append(("page", page))

    def linked(self, text: str, document: str) -> str:
        """Links of a document as links of its page; what is linked to and is no page is copied."""
        page = pathlib.PurePosixPath(page_of(document))

        def target(found: re.Match[str]) -> str:
            head, link, tail = found.groups()
            if re.match(r"[a-z]+:|#", link):
                return found[0]
            path, mark, anchor = link.partition("#")
            place = os.path.normpath(pathlib.PurePosixPath(document).parent / path)
            place = ELSEWHERE.get(place, place)
            if place in self.pages:
                to = self.pages[place]
            elif (ROOT / place).is_file():
                to = self.copied(place)
            else:
                to = self.pages[self.about(place)]
            return f"{head}{os.path.relpath(to, page.parent)}{mark}{anchor}{tail}"

        return outside_code(text, lambda part: LINK.sub(target, part))

    def about(self, folder: str) -> str:
        """The document that says what is in a folder: its own, or that of one around it."""
        around = [folder, *map(str, pathlib.PurePosixPath(folder).parents)]
        found = (f"{one}/README.md" for one in around if f"{one}/README.md" in self.pages)
        return next(found, "docs/site/questions.md")

    def copied(self, place: str) -> str:
        """A file beside the pages; text so that browsers show it."""
        is_picture = place.endswith((".png", ".svg"))
        to = f"files/{place}" if is_picture else f"files/{place.replace('.', '_')}.txt"
        (self.source / to).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / place, self.source / to)
        return to

    def documents(self) -> None:
        parts = [
            (title, [match for entry in entries for match in matches(entry)]) for title, entries in PARTS
        ]
        for _, entries in parts:
            self.pages |= {entry: page_of(entry) for entry in entries if isinstance(entry, str)}
        for title, entries in parts:
            self.order.append(("part", title))
            for entry in entries:
                if isinstance(entry, str):
                    self.add(page_of(entry), self.linked((ROOT / entry).read_text(), entry))
                elif entry[1].startswith("commands"):
                    commands(self)
                else:
                    self.add(entry[1], functions(entry[0]))

    def write(self) -> None:
        formulas = {}
        for text in self.texts.values():
            outside_code(
                text,
                lambda part: formulas.update({f[0]: f.groups() for f in FORMULA.finditer(part)}) or "",
            )
        typeset = katex(self.book, formulas)
        lines = []
        for kind, what in self.order:
            if kind == "part":
                lines.append(f"\n# {what}\n")
                continue
            text = outside_code(self.texts[what], lambda part: FORMULA.sub(lambda f: typeset[f[0]], part))
            title = re.search(r"^# (.+)$", text, re.MULTILINE)[1]
            path = self.source / what
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(with_contents(text, self.texts[what]))
            indent = "  " if what.startswith("commands/") and what != "commands/index.md" else ""
            lines.append(f"{indent}- [{re.sub('[`]', '', title)}]({what})")
        (self.source / "SUMMARY.md").write_text("# Summary\n" + "\n".join(lines) + "\n")


def matches(entry: str | tuple[str, str]) -> list[str | tuple[str, str]]:
    if isinstance(entry, tuple) or "*" not in entry:
        return [entry]
    found = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(entry))
    return sorted(found, key=lambda path: not path.endswith("README.md"))


def with_contents(text: str, words: str) -> str:
    """A long text with a table of its headings below the first."""
    headings = re.findall(r"^## (.+)$", outside_code_blocks(text), re.MULTILINE)
    if len(words.split()) <= LONG or len(headings) < 2:
        return text
    items = "\n".join(f"- [{re.sub('[`]', '', heading)}](#{anchor(heading)})" for heading in headings)
    table = f'<nav class="contents">\n\n{items}\n\n</nav>'
    return re.sub(r"^(# .+)$", lambda found: f"{found[1]}\n\n{table}", text, count=1, flags=re.MULTILINE)


def outside_code_blocks(text: str) -> str:
    return re.sub(r"^ *```.*?^ *```$", "", text, flags=re.DOTALL | re.MULTILINE)


def anchor(heading: str) -> str:
    kept = re.sub(r"[^\w\- ]", "", re.sub(r"<[^>]+>", "", heading)).strip().lower()
    return kept.replace(" ", "-")


def katex(book: pathlib.Path, formulas: dict[str, tuple[str | None, str | None]]) -> dict[str, str]:
    """Formulas typeset as HTML that no Markdown changes."""
    given = [[display or inline, display is not None] for display, inline in formulas.values()]
    done = subprocess.run(
        ["node", HERE / "formulas.cjs"],
        input=json.dumps(given), capture_output=True, text=True, check=True,
        env=os.environ | {"NODE_PATH": str(book / "node_modules")},
    )  # fmt: skip

    def plain(found: re.Match[str]) -> str:
        return ">" + re.sub(r"[*_\[\]|\\`~#$]", lambda c: f"&#{ord(c[0])};", found[1]) + "<"

    made = (re.sub(r">([^<]+)<", plain, one.replace("\n", " ")) for one in json.loads(done.stdout))
    return dict(zip(formulas, made, strict=True))


def told(*words: str) -> str:
    """What the program prints."""
    done = subprocess.run(
        ["cascade", *words],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"COLUMNS": "100"},
    )
    return done.stdout


def commands(site: Site) -> None:
    """A page for each command, with its help under the headings that it has."""
    overview = told("--help")
    names = re.findall(r"^  ([a-z]+) +\S", overview.split("Options:")[0], re.MULTILINE)
    names = [name for name in names if name != "help"]
    groups = re.findall(r"^(\S[^\n]*):\n((?:  [a-z]+ +[^\n]+\n)+)", overview, re.MULTILINE)
    lines = ["# Commands", "", "As `cascade --help` lists them.", ""]
    for group, rows in groups:
        if group != "Options":
            lines += [f"## {group}", "", "| command | |", "|---|---|"]
            pairs = re.findall(r"^  ([a-z]+) +(.+)$", rows, re.MULTILINE)
            lines += [
                f"| [`{name}`]({name}.md) | {text} |" if name in names else f"| `{name}` | {text} |"
                for name, text in pairs
            ] + [""]
    site.add("commands/index.md", "\n".join(lines))
    for name in names:
        text = told(name, "--help")
        about, usage, rest = re.match(r"(.*?)\n(Usage: .*?)\n\n(.*)", text, re.DOTALL).groups()
        parts = re.split(r"^(\S[^\n]*):\n", "\n" + rest, flags=re.MULTILINE)
        lines = [f"# cascade {name}", "", prose(about), "", "```text", usage, "```", ""]
        for head, body in zip(parts[1::2], parts[2::2], strict=True):
            lines += [f"## {head}", "", "```text", body.strip("\n"), "```", ""]
        example = re.search(r"^Example: (cascade .+)$", text, re.MULTILINE)
        if example:
            lines = [line for line in "\n".join(lines).replace(example[0], "").splitlines()]
            lines[3:3] = ["", "```sh", example[1], "```"]
        site.add(f"commands/{name}.md", "\n".join(lines) + "\n")


def prose(text: str) -> str:
    """Help as Markdown: words that look like tags are none."""
    return outside_code(
        text, lambda part: html.escape(part, quote=False).replace("*", r"\*").replace("_", r"\_")
    )


def package_from_source() -> None:
    """The package without its compiled module, of which docstrings need names alone."""
    stub = ast.parse((ROOT / "python/wavecascade/_native.pyi").read_text()).body
    native = types.ModuleType("wavecascade._native")
    for one in stub:
        match one:
            case ast.ClassDef(name=name):
                setattr(native, name, type(name, (), {}))
            case ast.FunctionDef(name=name):
                setattr(native, name, list)
    native.version = ""
    sys.modules[native.__name__] = native
    sys.path.insert(0, str(ROOT / "python"))


def functions(title: str) -> str:
    """The docstrings of the package."""
    lines = [f"# {title}", "", "What `help()` says of each; `import wavecascade as wc`.", ""]
    for module, prefix in (
        ("wavecascade", "wc"),
        ("wavecascade.distributed", "wc.distributed"),
        ("wavecascade.fft", "wc.fft"),
    ):
        found = importlib.import_module(module)
        for name in found.__all__:
            one = getattr(found, name)
            text = inspect.getdoc(one)
            if (
                not callable(one)
                or not text
                or (prefix != "wc" and one is getattr(importlib.import_module("wavecascade"), name, None))
            ):
                continue
            lines += [
                f"## {prefix}.{name}",
                "",
                "```python",
                f"{prefix}.{name}{signature(one)}",
                "```",
                "",
                docstring(text),
                "",
            ]
    return "\n".join(lines)


def signature(one) -> str:
    try:
        return re.sub(r"'", "", str(inspect.signature(one)))
    except (TypeError, ValueError):
        return "(...)"


def docstring(text: str) -> str:
    """A docstring in NumPy's style as Markdown."""
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text.replace("``", "`"))
    parts = re.split(r"^(\w[\w ]*)\n-{3,}\n", text, flags=re.MULTILINE)
    lines = [prose(parts[0])]
    for head, body in zip(parts[1::2], parts[2::2], strict=True):
        lines += [f"**{head}**", ""]
        for line in body.strip("\n").splitlines():
            if line and not line.startswith(" "):
                lines.append(f"- `{line}`:")
            else:
                lines.append("  " + prose(line.strip()))
        lines.append("")
    return "\n".join(lines)


def gallery(site: Site) -> None:
    """Runs the commands of the gallery, and adds their pictures and pages."""
    work = site.book / "gallery"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    (work / "examples").symlink_to(ROOT / "examples")
    entries = tomllib.loads((HERE / "gallery.toml").read_text())["entry"]
    to = site.source / "gallery"
    to.mkdir()
    lines = [site.texts["gallery.md"].rstrip(), ""]
    for entry in entries:
        for command in entry["commands"]:
            done = subprocess.run(
                command, shell=True, cwd=work, capture_output=True, text=True, check=False
            )
            if done.returncode:
                sys.exit(f"gallery: {command}: exit code {done.returncode}\n{done.stderr}")
        result = work / entry["page"]
        name = anchor(entry["title"])
        shutil.copyfile(result / "report.html", to / f"{name}.html")
        pictures = sorted(result.glob("**/*.png"))
        wanted = (
            [path for path in pictures if path.stem == entry.get("picture", pictures[0].stem)]
            if pictures
            else []
        )
        lines += [f"## {entry['title']}", "", entry["shows"], ""]
        if wanted:
            shutil.copyfile(wanted[0], to / f"{name}.png")
            lines += [f"[![{entry['title']}](gallery/{name}.png)](gallery/{name}.html)", ""]
        elif entry.get("picture"):
            sys.exit(
                f"gallery: {entry['page']} has no {entry['picture']}, but {[p.stem for p in pictures]}"
            )
        first, *rest = done.stdout.strip().splitlines()
        # The whole sentence: where it is wrapped, it goes on indented.
        rest = itertools.takewhile(lambda line: line.startswith("  "), rest)
        answer = " ".join([first, *map(str.strip, rest)])
        lines += ["```sh", *entry["commands"], "```", "", "```text", answer, "```", ""]
        lines += [f"[Open the page](gallery/{name}.html)", ""]
        print(f"gallery: {entry['title']}", flush=True)
    site.texts["gallery.md"] = "\n".join(lines)


def main() -> None:
    book = pathlib.Path(sys.argv[1]).resolve()
    book.mkdir(parents=True, exist_ok=True)
    if "--source" in sys.argv:
        package_from_source()
    site = Site(book)
    site.documents()
    if "--without-gallery" not in sys.argv:
        gallery(site)
    site.write()
    theme = site.source / "theme"
    shutil.copytree(
        book / "node_modules/katex/dist/fonts",
        theme / "fonts",
        ignore=shutil.ignore_patterns("*.ttf", "*.woff"),
    )
    shutil.copyfile(HERE / "book.toml", book / "book.toml")
    (book / "theme").mkdir(exist_ok=True)
    shutil.copyfile(book / "node_modules/katex/dist/katex.min.css", book / "theme/katex.css")
    shutil.copyfile(HERE / "site.css", book / "theme/site.css")
    print(f"{len(site.texts)} pages in {site.source}")


if __name__ == "__main__":
    main()
