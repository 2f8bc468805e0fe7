"""Runs notebooks and writes a page of each, with what it prints and draws.

    pip install './python[dask]' matplotlib zarr
    python docs/notebooks/make.py [NAME ...] [--to FOLDER]

A notebook is a script whose cells begin with `# %%`, which Jupyter (with jupytext), VS Code and
Spyder open as cells; `# %% [markdown]` are cells of text in comments. The page NAME.md has text,
code, printed text, and pictures in `pictures/`.
"""

import argparse
import contextlib
import io
import os
import pathlib
import sys
import warnings

HERE = pathlib.Path(__file__).resolve().parent
MARK = "# %%"


def names() -> list[str]:
    """All notebooks."""
    return sorted(path.stem for path in HERE.glob("*.py") if path.stem != "make")


def cells(source: str) -> list[tuple[bool, str]]:
    """Whether each cell is text, and what it holds."""
    found = []
    for part in ("\n" + source).split("\n" + MARK)[1:]:
        head, _, body = part.partition("\n")
        is_text = "[markdown]" in head
        if is_text:
            body = "\n".join(line.removeprefix("#").removeprefix(" ") for line in body.splitlines())
        found.append((is_text, body.strip("\n")))
    return found


def page(name: str, folder: pathlib.Path) -> str:
    """Runs a notebook, saves its pictures in `folder`, and returns its page."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.close("all")
    plt.rcdefaults()
    plt.rcParams.update({"figure.dpi": 100, "savefig.dpi": 100, "font.size": 10})
    path = HERE / f"{name}.py"
    space = {"__name__": name, "__file__": str(path)}
    out, pictures = [], 0
    for is_text, body in cells(path.read_text(encoding="utf-8")):
        if is_text:
            out.append(body)
            continue
        out.append(f"```python\n{body}\n```")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            exec(compile(body, str(path), "exec"), space)
        said = [
            f"{w.category.__name__}: {w.message}" for w in told if w.category.__name__ == "CascadeWarning"
        ]
        text = "\n".join([printed.getvalue().rstrip(), *said]).strip()
        if text:
            out.append(f"```text\n{text}\n```")
        for number in plt.get_fignums():
            figure = plt.figure(number)
            pictures += 1
            folder.mkdir(parents=True, exist_ok=True)
            picture = f"{name}-{pictures}.png"
            figure.savefig(folder / picture, bbox_inches="tight", metadata={"Software": None})
            shown = " and ".join(
                axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")
            )
            out.append(f"![{shown}](pictures/{picture})")
            plt.close(figure)
    origin = f"Made by `python docs/notebooks/make.py {name}` from [{name}.py]({name}.py)."
    head, _, rest = out[0].partition("\n")
    return "\n\n".join([head, origin, rest.strip(), *out[1:]]) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", default=[])
    parser.add_argument("--to", type=pathlib.Path, default=HERE)
    typed = parser.parse_args()
    # Notebooks name files from the root of the repository.
    os.chdir(HERE.parents[1])
    for name in typed.names or names():
        text = page(name, typed.to / "pictures")
        (typed.to / f"{name}.md").write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
