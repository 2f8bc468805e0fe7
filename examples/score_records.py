"""Scores what a method makes of a table of `cargo run --example impact_records -- DIR`.

`python examples/score_records.py DIR/NAME RESULT.json`, where RESULT.json is the `summary.json` of
`cascade fit`, or holds the same: `{"values": [{"name": "young", "value": 70.3, "low": 70.2, "high": 70.4}],
"misfit": null}`, in the units of the truth, with 95 % intervals, and in `misfit` anything but null where the
chain does not explain the records.
"""

import json
import sys
import tomllib
from pathlib import Path


def number(value: object) -> float | None:
    """The number of a value with its unit."""
    try:
        return float(str(value).split()[0])
    except (IndexError, ValueError):
        return None


def main(name: str, result: str) -> None:
    """Prints a line for each value that is known, and the score."""
    scene = tomllib.loads(Path(f"{name}.truth.toml").read_text())
    added = json.loads(Path(f"{name}.truth.json").read_text())
    truth = {key: number(value) for key, value in scene.items()} | {"time_shift": added["time_shift"]}
    truth |= {f"gain[{body}]": gain for body, gain in zip(added["bodies"], added["gains"], strict=True)}
    found = json.loads(Path(result).read_text())
    held = known = 0
    squares = 0.0
    for value in found["values"]:
        true = truth.get(value["name"])
        if true is None or value.get("low") is None:
            continue
        off = value["value"] - true
        half = 0.5 * (value["high"] - value["low"])
        is_held = value["low"] <= true <= value["high"]
        held, known, squares = held + is_held, known + 1, squares + (1.96 * off / half) ** 2
        word = "in" if is_held else "not in"
        print(f"{value['name']}: {value['value']:.6g}, true {true:.6g}, {word} the interval +-{half:.2g}")
    if known:
        size = (squares / known) ** 0.5
        print(f"{held} of {known} intervals hold; errors are {size:.2f} of what is said")
    is_seen, is_wrong = found.get("misfit") is not None, added["wrong"] is not None
    said = "a misfit is seen" if is_seen else "no misfit is seen"
    word = "rightly" if is_seen == is_wrong else "wrongly"
    print(f"{said}, {word}: {added['wrong'] or 'the chain'} is {'wrong' if is_wrong else 'right'}")


if __name__ == "__main__":
    main(*sys.argv[1:3])
