#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No output replaces a file in use: every command, every output option, every file in use.

    output_files_test.py PANELCAL REPOSITORY

Commands and options are those that the help pages list. A new option that takes a text is taken for
an output here until it is listed in real_files.py.
"""
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import real_files


def files_in_use(command, names):
    """Of the folder's files those that a command reads, or that its machine needs."""
    words = shlex.split(real_files.COMMANDS[command])
    used = {name for name in names if name in words}
    if "machine.toml" in words:
        used |= real_files.OF_MACHINE & names
    if "job.exc" in words and command not in ("check", "survey"):
        used.add("patt.exc")
    # A ledger and a folder of pictures are respected by all.
    used |= {"drill1.ledger"} | {name for name in names if name.startswith("images/")}
    links = {**real_files.LINKS, **real_files.HARD}
    # The hard link to a picture is another file to those that do not read the folder.
    reads_pictures = "images" in words or "images/0000.png" in words
    return used | {link for link, target in links.items()
                   if target in used and (reads_pictures or link != "hard-of-picture")}


def problems_of(panelcal, folder, command, option, name, before):
    words = [panelcal, *command.split(), *shlex.split(real_files.COMMANDS[command]), option, name]
    if command in ("surface fit", "surface apply", "surface export") and option != "--output":
        words += ["-o", "new.json"]
    if command == "batch report" and option != "--output":
        words += ["-o", "new.html"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120)
    after = real_files.content(folder)
    problems = []
    # A pattern is found when its program is read, a ledger that nothing names when it would be
    # replaced, and synth knows its own pictures: other words may be said before.
    is_named = "machine.toml" in words or "drill1.ledger" in words[:-2]
    is_late = name == "patt.exc" or command == "synth" or (
        name in ("drill1.ledger", "link-of-ledger") and not is_named)
    if done.returncode != 2 or ("error[output-in-use]" not in done.stderr and not is_late):
        problems.append(f"exit {done.returncode}: {done.stderr.strip()[-300:]}")
    if "error[output-in-use]" in done.stderr and Path(name).name not in done.stderr:
        problems.append(f"the file is not named: {done.stderr.strip()}")
    changed = {n for n in before.keys() | after.keys() if before.get(n) != after.get(n)}
    if changed:
        problems.append(f"changed {sorted(changed)}")
        for changed_name in changed & before.keys():
            (Path(folder) / changed_name).write_bytes(before[changed_name])
        for changed_name in changed - before.keys():
            (Path(folder) / changed_name).unlink()
    return [f"panelcal {shlex.join(words[1:])}: {problem}" for problem in problems]


def main():
    panelcal = str(Path(sys.argv[1]).resolve())
    known = set(real_files.COMMANDS)
    listed = set(real_files.leaves(panelcal))
    assert listed == known, f"commands without inputs in real_files.py: {listed ^ known}"
    problems, n_tried, n_options = [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        real_files.make(panelcal, sys.argv[2], folder)
        real_files.add_links(folder)
        before = real_files.content(folder)
        for command in sorted(listed):
            takes_text = real_files.options_of(panelcal, command)
            outputs = {option for option, is_text in takes_text.items()
                       if is_text and option not in real_files.NO_OUTPUTS}
            assert outputs <= real_files.OUTPUTS, f"{command}: outputs that are new: {outputs}"
            n_options += len(outputs)
            for option in sorted(outputs):
                names = files_in_use(command, set(before))
                if option in ("--jobs", "--linuxcnc") or (command, option) in (
                        ("synth", "--output"), ("batch", "--output")):
                    names = {"images"}  # folders
                for name in sorted(names):
                    problems += problems_of(panelcal, folder, command, option, name, before)
                    n_tried += 1
    print("\n".join(problems), end="\n" if problems else "")
    print(f"{len(listed)} commands, {n_options} output options, {n_tried} files tried")
    assert n_options >= 30 and n_tried >= 400, "the help pages were not understood"
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
