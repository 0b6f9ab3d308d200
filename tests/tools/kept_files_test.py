#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No output takes the place of another night's record, or of a subprogram file that was read.

    kept_files_test.py PANELCAL REPOSITORY
"""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import real_files

PANELCAL = str(Path(sys.argv[1]).resolve())
NIGHT = ("nightly", "-m", "machine.toml", "--clock", "2026-11-23T02:00:00Z")


def panelcal(*words, code=0):
    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done


def refused(*words):
    """The output in words is refused, and every file stays as it is."""
    before = real_files.content(".")
    done = panelcal(*words, code=2)
    assert "error[output-in-use]" in done.stderr, done
    assert real_files.content(".") == before, words
    return done.stderr


def check_records():
    panelcal("nightly", "-m", "machine.toml", "--clock", "2026-11-22T02:00:00Z")
    for ending in ("json", "html"):
        other = f"rep/2026-11-21.{ending}"
        assert "the record of a night" in refused(*NIGHT, "--json", other)
        assert "the record of a night" in refused(*NIGHT, "--report", other)
        assert "the record of a night" in refused("run", "job.exc", "-m", "machine.toml", "--images",
                                                  "images", "-o", "new.drl", "--report", other)
        # A command that knows the ledger alone.
        for action in ("list", "export", "verify"):
            assert "notes the head of a ledger" in refused("history", action, "-l", "drill1.ledger",
                                                           "-o", other)
    # The night's own, and all that notes no head, may be replaced.
    panelcal(*NIGHT, "--json", "rep/2026-11-22.json")
    panelcal(*NIGHT, "--json", "rep/2026-11-22.json", "--report", "rep/mine.html")
    for _ in range(2):
        panelcal("history", "export", "-l", "drill1.ledger", "-o", "rep/export.json")
    # What a person is told to do to have a calibration at once.
    panelcal("history", "show", "1", "--result", "-l", "drill1.ledger", "-o", "one.json")


def check_report_of_a_job():
    """A job's report that is named by its day: another job's replaces it, a night's does not."""
    job = ("run", "job.exc", "-m", "machine.toml", "--images", "images", "-o", "new.drl", "--report",
           "rep/2026-11-24.html")
    panelcal(*job)
    panelcal(*job)
    page = Path("rep/2026-11-24.html").read_bytes()
    panelcal("nightly", "-m", "machine.toml", "--clock", "2026-11-25T02:00:00Z")
    assert Path("rep/2026-11-24.html").read_bytes() == page
    assert Path("rep/2026-11-24-2.html").exists()


def check_subprograms():
    Path("sub").mkdir()
    Path("sub/A.SS5").write_text("@A\nX1.Y1.\n")
    Path("sub/B.SS5").write_text("@B\nX2.Y2.\n@C\nX2.Y2.\n")
    Path("sub/D.SS5").write_text("@D\nX2.Y2.\n")
    Path("s.s5").write_text("%%5000\nT1\nX1.0Y1.0\nM99,C\n$\nT1D0.8F1.S60\n$\n")
    Path("sp.toml").write_text(Path("machine.toml").read_text() +
                               '[program]\nsearch_path = ["sub"]\n')
    run = ("run", "s.s5", "-m", "sp.toml", "--to", "sieb-meyer", "-o")
    # @C is looked for in A.SS5, and found in B.SS5.
    assert "a file of subprograms" in refused(*run, "sub/A.SS5")
    assert "a stored pattern" in refused(*run, "sub/B.SS5")
    panelcal(*run, "sub/D.SS5")


def main():
    real_files.make(PANELCAL, sys.argv[2], ".")
    text = Path("machine.toml").read_text()
    Path("machine.toml").write_text(text.replace("[nightly]\n", '[nightly]\nreports = "rep"\n'))
    check_records()
    check_report_of_a_job()
    check_subprograms()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        main()
