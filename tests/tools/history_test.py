#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Goes back to an earlier calibration on a ledger that was made without panelcal.

    history_test.py PANELCAL REPOSITORY
"""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
sys.dont_write_bytecode = True
ROOT = Path(sys.argv[2]).resolve()
sys.path[:0] = [str(ROOT / "tests" / "golden"), str(ROOT / "tests" / "support")]
import golden_ledger  # noqa: E402
from facts import checked, in_page  # noqa: E402

KEY = ["--machine", "drill 1", "--kind", "spindle-camera", "--subject", "spindle 1 station 1"]


def history(*words, code=0):
    done = subprocess.run([PANELCAL, "history", *words, "-l", "drill1.ledger"],
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done.stdout


def facts(*words):
    """The facts on standard output, which a file and a page have as well, beside the text."""
    alone = history(*words, "--json", "-")
    document = checked(json.loads(alone), ROOT)
    if words[0] in ("list", "show", "diff", "plot"):
        text = history(*words, "--json", "facts.json", "--report", "page.html")
        assert text == history(*words)
        paged, written = in_page("page.html"), json.loads(Path("facts.json").read_text())
        for one in (document, paged, written):
            one.pop("provenance")
        assert document == paged == written
    return document


def in_force():
    entries = facts("list", *KEY)["entries"]
    return [entry["id"] for entry in entries if entry["in_force"]]


def main():
    golden_ledger.two_nights().close()
    _, first_result = golden_ledger.offset(50.0, -3.0, "")
    assert in_force() == [2]
    # Two operators at once: one goes back, the other finds that there is nothing before it.
    both = [subprocess.Popen([PANELCAL, "history", "rollback", "-l", "drill1.ledger", *KEY,
                              "--reason", "holes are off", "--by", name],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE) for name in "ab"]
    codes = sorted(process.wait(timeout=60) for process in both)
    assert codes == [0, 2], codes
    assert in_force() == [1]
    (entry,) = facts("show", "6")["entries"]
    assert entry["verdict"] == "rolled-back" and entry["restores"] == 1 and entry["replaces"] == 2
    history("show", "1", "--result", "-o", "spindle1.cal.json")
    assert Path("spindle1.cal.json").read_text() == first_result
    assert history("verify").startswith("6 entries, undamaged")
    assert facts("verify")["verification"]["entries"] == 6
    plotted = facts("plot", *KEY, "--parameter", "offset_x")
    assert [one["id"] for one in plotted["entries"]] == [1, 2, 3, 6], plotted
    change = facts("diff", "1", "2")["difference"]["parameters"][0]
    # sqrt(2) of each entry's 1 um.
    assert abs(change["change_sigma"] - 2 ** 0.5 * 1e-3) < 1e-12, change
    exported = [json.loads(line) for line in history("export").splitlines()]
    assert [one["id"] for one in exported] == [1, 2, 3, 4, 5, 6]
    assert exported[0]["result"] == json.loads(first_result)
    for words in (["--to", "3"], ["--to", "4"], ["--to", "99"]):
        history("rollback", *KEY, *words, "--reason", "r", code=2)
    assert in_force() == [1]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
