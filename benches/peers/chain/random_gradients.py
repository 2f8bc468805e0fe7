"""Gradients of random chains against differences of runs: the scenes of `random_scenes.py`.

    python3 benches/peers/chain/random_gradients.py PROGRAM [FIRST_SEED [NUMBER]]

Needs numpy and scipy. Each scene is run with its derivative with respect to one of its numbers, at a tolerance of 1e-9, and
at four values beside it with the least error; with other steps, too, if they are more than 1e-7 apart. Prints what is off by more
than stated and by more than 1e-7, and the largest.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

import random_scenes


def main():
    program = sys.argv[1]
    first, number = map(int, (sys.argv[2:] + ["0", "500"][len(sys.argv) - 2 :])[:2])
    off, over = [], []
    with tempfile.TemporaryDirectory() as folder:
        path, out = pathlib.Path(folder, "scene.toml"), pathlib.Path(folder, "run.npz")

        def run(text, tolerance, *more):
            text = re.sub(r"(?m)^(tolerance|samples) = .*\n", "", text)
            path.write_text(f"{text}tolerance = {tolerance}\nsamples = 21\n")
            said = subprocess.run(
                [program, "simulate", path, "--out", out, "--force", "--quiet", *more], capture_output=True, text=True
            )
            if said.returncode:
                return said.stderr.strip()
            with np.load(out) as arrays:
                return {name: arrays[name] for name in arrays}

        for seed in range(first, first + number):
            text = random_scenes.scene(seed)[0]
            numbers = dict(re.findall(r"(?m)^(\w+) = (.*)$", text))
            rng = np.random.default_rng(seed)
            keys = ["striker_velocity", "coefficients", "masses", "precompression", "drag", "dashpot", "gravity", "drive_amplitude"]
            keys = [key for key in keys if key in numbers and numbers[key] != "0.0"]
            key = str(rng.choice(keys))
            stated = json.loads(numbers[key])
            place = int(rng.integers(len(stated))) if isinstance(stated, list) else None
            value = stated if place is None else stated[place]
            name = key if place is None else f"{key}[{place}]"
            found = run(text, 1e-9, "--gradient", name)
            if isinstance(found, str):
                print(f"seed {seed}: {name}: {found.splitlines()[0]}")
                continue

            def at(value):
                new = value if place is None else [value if i == place else one for i, one in enumerate(stated)]
                return run(re.sub(rf"(?m)^{key} = .*$", f"{key} = {json.dumps(new)}", text), 1e-13)

            def apart(share):
                """From differences with this step, over the value; None if a scene beside is refused."""
                step = share * value
                around = [at(value + i * step) for i in (-2, -1, 1, 2)]
                if any(isinstance(one, str) for one in around):
                    return None
                a, b, c, d = (one["velocity"] for one in around)
                known = (8 * (c - b) - (d - a)) / (12 * step)
                return np.abs(gradient - known).max() / max(np.abs(known).max(), np.finfo(float).tiny)

            gradient = found["gradient_velocity"][0]
            # Contacts may open between two of the runs, and small gradients drown in rounding: the best of three steps.
            tried = []
            for share in (2e-4, 2e-5, 2e-3):
                tried.append(apart(share))
                if tried[-1] is None or tried[-1] < 1e-7:
                    break
            if None in tried:
                print(f"seed {seed}: {name}: no differences")
                continue
            least = min(tried)
            allowed = found["gradient_error"][0]
            if least > max(allowed, 1e-7):
                print(f"seed {seed}: {name}: {least:.1e}, stated {allowed:.1e}")
            off.append(least)
            over.append(least / max(allowed, 1e-8))
    off.sort()
    over.sort()
    print(f"{len(off)} gradients, off by {[f'{one:.1e}' for one in off[-5:]]}, over what is stated {[f'{one:.2f}' for one in over[-5:]]}")
    print(f"within 1e-7: {np.mean(np.array(off) < 1e-7):.3f}, median {np.median(off):.1e}")


if __name__ == "__main__":
    main()
