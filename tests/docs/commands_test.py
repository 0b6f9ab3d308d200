#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program takes every command that the manual's pages show: its words and options exist and go together.

In an empty folder each ends at the first file that it asks for. Pages that run whole have a test of their own
(tutorials_test.py).

    commands_test.py PANELCAL ROOT
"""
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL, ROOT = (Path(word).resolve() for word in sys.argv[1:3])
sys.path.insert(0, str(ROOT / "tools/site"))
sys.dont_write_bytecode = True
from tutorials import pages_of  # noqa: E402

COMMAND = re.compile(r"(?:\$ )?panelcal (.*)")
END = {"|", "||", "&&", ">", ";"}
# Of words and options; what a placeholder such as X,Y is answered with does not count.
NOT_TAKEN = re.compile(r"unknown command|an argument that `panelcal help")
LONGEST_S = 120


def code_lines(text):
    """The lines of all code blocks, fenced or indented; one that ends with a backslash goes on."""
    is_fenced, begun = False, ""
    for line in text.splitlines():
        if line.startswith("```"):
            is_fenced = not is_fenced
        elif is_fenced or line.startswith("    "):
            begun += line.strip()
            if begun.endswith("\\"):
                begun = begun[:-1]
                continue
            yield begun
            begun = ""


def commands(text):
    for line in code_lines(text):
        if match := COMMAND.fullmatch(line):
            words = shlex.split(match[1], comments=True)
            end = next((i for i, word in enumerate(words) if word in END), len(words))
            yield words[:end]


def problem(words):
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([PANELCAL, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=LONGEST_S)
    return done.stderr if NOT_TAKEN.search(done.stderr) else ""


def main():
    assert problem(["run", "--frob"]) and problem(["frob"]), "a wrong command is taken"
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    n_tried, wrong = 0, []
    for page in pages:
        for words in () if page in pages_of(ROOT) else commands(page.read_text()):
            n_tried += 1
            if said := problem(words):
                wrong.append(f"{page.relative_to(ROOT)}: panelcal {shlex.join(words)}: {said}")
    assert not wrong, "\n".join(wrong)
    assert n_tried > 80, n_tried


main()
