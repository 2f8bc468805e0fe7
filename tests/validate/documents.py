"""What documents state: blocks of code, commands with what they print, single numbers."""

import itertools
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
GUIDE = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs/guide").glob("*.md"))
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
#: A block of code.
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
#: Heights of the bars of a profile.
BARS = "▁▂▃▄▅▆▇█"


def text(page):
    """A page by its place in the repository or in docs/, also with a heading: `accuracy.md, Chains`."""
    name = page.split(",")[0]
    path = next(path for path in (ROOT / name, ROOT / "docs" / name) if path.exists())
    return path.read_text(encoding="utf-8")


def blocks(page):
    """Languages of the blocks of a page with their content."""
    return BLOCK.findall(text(page))


def commands(shell):
    """The lines of a block that run the program, continued ones as one, without comments."""
    lines = (line.split("  #")[0].rstrip() for line in shell.replace("\\\n", " ").splitlines())
    return [line for line in lines if line.startswith("cascade ")]


def outputs(page):
    """Shell with what it prints: the next block, at once or after a colon; or comments with `; ...`."""
    for shell, follows in itertools.pairwise(BLOCK.finditer(text(page))):
        between = text(page)[shell.end() : follows.start()].rstrip()
        if (shell[1], follows[1]) == ("sh", "text") and between[-1:] in ("", ":"):
            yield shell[2], follows[2]
    for language, shell in blocks(page):
        if language == "sh" and (comments := re.findall(r"^# (.+); \.\.\.$", shell, re.MULTILINE)):
            yield "\n".join(commands(shell)), "\n".join(comments)


def missing(printed, said):
    """Lines of a text, folded ones whole, that are not said to one of the last digit of each number."""
    said = " ".join(said.split())
    lines = (" ".join(line.split()) for line in re.split(r"\n(?!\s)", printed))
    return [line for line in lines if line not in ("", "...") and not _is_said(line, said)]


def _is_said(line, said):
    words = re.split(f"({NUMBER})", line)
    pattern = "".join(f"({NUMBER})" if n % 2 else re.escape(word) for n, word in enumerate(words))
    pattern = re.sub(f"[{BARS}]", f"[{BARS}]", pattern)
    places = re.finditer(pattern, said)
    return any(all(map(_is_near, words[1::2], place.groups())) for place in places)


def _is_near(stated, found):
    return abs(float(stated) - float(found)) <= 1.001 * unit(stated)


def unit(number):
    """One of the last digit of a number as it is written: 0.01 of 4.56, 1e-12 of 3e-12."""
    digits, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))


def numbers(page, sentence):
    """The numbers that a page has in place of each `#` of a sentence, which it states once."""
    pattern = r"\s+".join(re.escape(word).replace(r"\#", f"({NUMBER})") for word in sentence.split())
    found = set(re.findall(pattern, text(page)))
    if len(found) != 1:
        raise ValueError(f"{page}: expected one text like {sentence!r}, found {len(found)}")
    stated = found.pop()
    return [float(number) for number in (stated if isinstance(stated, tuple) else [stated])]


def number(page, sentence):
    """As `numbers`, of one `#`."""
    (stated,) = numbers(page, sentence)
    return stated
