"""What deny.toml says of licences and sources, without cargo-deny: held against `cargo metadata`.

It knows neither advisories nor yanked versions. Exit code 1 where a dependency is not allowed.
"""

import json
import re
import subprocess
import sys
import tomllib

rules = tomllib.load(open("deny.toml", "rb"))
allowed = set(rules["licenses"]["allow"])
#: As `cargo metadata` writes them.
registries = {f"registry+{one}" for one in rules["sources"]["allow-registry"]}


def permits(expression: str) -> bool:
    """Whether a licence can be chosen so that only allowed ones are needed."""
    words = re.findall(r"[()]|[\w.+-]+(?: WITH [\w.+-]+)?", expression.replace("/", " OR "))
    logic = {"OR": "or", "AND": "and", "(": "(", ")": ")"}
    return bool(eval(" ".join(logic.get(word) or str(word in allowed) for word in words)))


done = subprocess.run(
    ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"],
    stdout=subprocess.PIPE, text=True, check=True,
)  # fmt: skip
foreign = [one for one in json.loads(done.stdout)["packages"] if one["source"]]
faults = [f"{one['name']} {one['version']}: licence {one['license']}" for one in foreign
          if not permits(one["license"] or "none")]  # fmt: skip
faults += [f"{one['name']} {one['version']}: from {one['source']}" for one in foreign if one["source"] not in registries]
print("\n".join(faults) or f"   {len(foreign)} dependencies: licences and sources as deny.toml allows them")
sys.exit(bool(faults))
