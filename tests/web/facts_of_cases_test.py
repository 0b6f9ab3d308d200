#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The facts of every golden case of `run`, `check` and `locate` follow their schema, whatever becomes of it.

    facts_of_cases_test.py PANELCAL REPOSITORY
"""
import json
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(sys.argv.pop()).resolve()
PANELCAL = Path(sys.argv.pop()).resolve()
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "tests/golden")]
import golden_case  # noqa: E402
import json_schema  # noqa: E402

# Parts of a job that some case has to have, so that the schema of none goes unused.
PARTS = ("targets", "series", "places", "tolerance", "depth", "budget", "calibrations", "focus", "surface", "messages",
         "truth")


def facts_of(case, command, folder):
    for name, data in golden_case.all_inputs(case).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    if case.setup:
        subprocess.run([sys.executable, "-c", case.setup.decode()], cwd=folder, check=True,
                       env={**os.environ, "PYTHONPATH": str(ROOT / "tests/golden")})
    words = [str(PANELCAL), *shlex.split(command)[1:], "--json", "facts-of-case.json"]
    subprocess.run(words, cwd=folder, capture_output=True, check=False, timeout=120)
    facts = folder / "facts-of-case.json"
    return json.loads(facts.read_text(encoding="utf-8")) if facts.exists() else None


def main():
    schemas = {kind: json.loads((ROOT / f"share/schema/{kind}.schema.json").read_text(encoding="utf-8"))
               for kind in ("job", "check", "locate")}
    counts = dict.fromkeys(schemas, 0)
    seen, broken = set(), []
    for path in sorted((ROOT / "tests/golden").glob("*/*.case")):
        case = golden_case.load(path)
        command = case.command
        is_wanted = command.startswith(("panelcal run ", "panelcal check ", "panelcal locate ")) and not any(c in command for c in "|<>;&")
        if not is_wanted or "--json" in command:
            continue
        with tempfile.TemporaryDirectory() as folder:
            facts = facts_of(case, command, Path(folder))
        if facts is None:
            continue
        kind = facts["facts"]
        counts[kind] += 1
        broken += [f"{path.name}: {problem}" for problem in json_schema.problems(schemas[kind], facts)[:5]]
        seen |= {part for part in PARTS if kind == "job" and facts[part]}
    print(counts, sorted(seen))
    print("\n".join(broken))
    assert not broken
    assert min(counts["job"], counts["check"]) > 50 and counts["locate"] > 5, counts
    # A truth is compared with in job_report_test.py.
    assert not set(PARTS) - seen - {"truth"}, f"no case has {set(PARTS) - seen}"


if __name__ == "__main__":
    main()
