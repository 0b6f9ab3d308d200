#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Random command lines over a folder of real files: each file that was there is as it was, or was a
declared output, or is what the machine itself keeps up to date.

    command_line_fuzz.py PANELCAL REPOSITORY COUNT [SEED]
"""
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import real_files

SECONDS = 60  # on a busy computer; nothing takes more than a few
WORDS = ["auto", "camera", "spindle-camera", "drill 1", "spindle 1 station 1", "excellon", "csv",
         "sieb-meyer", "gcode", "svg", "jsonl", "offset_x", "L10", "1", "2", "0", "-1", "1e9", "nan",
         "100,80", "0,0,100,80", "3x3", "2026-11-22T02:00:00", "2026-11-22T02:00:00Z", "folder:images",
         "video:job.exc", "sim", "probes", "heightmap", "-", ""]
NEW = ["new.jsonl", "new.svg", "new.html", "new.drl", "new.json", "new", "images/new.png", "no/such"]
INPUTS = {"--against", "-m", "--machine", "-l", "--ledger", "--images", "--measurements", "--plate", "--probes",
          "--program", "--surface", "--truth", "--voids-of", "--zones"}
# Commands that record in the ledger, and what they and calibrations keep.
KEEPERS = {"nightly", "history rollback", "history fresh-start", "align verify"}
KEPT = {"board.align.json", "drill1.ledger", "drill1.ledger.lock", "coupon.json", "spindle.cal.json", "camera.cal.json"}
# Commands that bring something into a database of many.
GATHERERS = {"batch", "batch push", "history push"}
DATABASE = "all.sqlite"


def value(draw, names):
    kind = draw.random()
    if kind < 0.6:
        return draw.choice(names)
    if kind < 0.75:
        return draw.choice(NEW)
    return draw.choice(WORDS)


def mutated(draw, words, names):
    """Now and then one of the usual words is another one, or is missing; half of the lines are as
    usual, so that they come far."""
    out = []
    if draw.random() < 0.5:
        return words
    for word in words:
        kind = draw.random()
        if kind < 0.08:
            out.append(value(draw, names))
        elif kind > 0.03 + 0.08 or word.startswith("-"):
            out.append(word)
    return out


def command_line(draw, options, names):
    command = draw.choice(sorted(options))
    words = [*command.split(), *mutated(draw, shlex.split(real_files.COMMANDS[command]), names)]
    n_options = draw.choice([0, 0, 1, 1, 2, 3, 4])
    for option in draw.sample(sorted(options[command]), min(len(options[command]), n_options)):
        is_text = options[command][option]
        words.append(option)
        if is_text or draw.random() < 0.3:
            words.append(value(draw, names))
    outputs = [o for o in options[command] if o in real_files.OUTPUTS and options[command][o]]
    if outputs:
        new = draw.random() < 0.4
        words += [draw.choice(outputs), draw.choice(NEW) if new else value(draw, names)]
    return command, words


def is_output(words, i):
    return i > 0 and words[i - 1] in real_files.OUTPUTS | {"-o"}


def is_input(words, i):
    if words[i - 1] == "--machine" and words[0] == "history" and words[1] not in ("diff", "verify"):
        return False  # a machine's name
    return not is_output(words, i) and (words[i - 1] in INPUTS or not words[i - 1].startswith("-"))


def may_change(name, command, words):
    """Whether a file is a declared output and no input, or what the machine keeps."""
    keeps = command in KEEPERS or "--install" in words or command.startswith("calibrate")
    if (keeps and name in KEPT) or (command in GATHERERS and name == DATABASE):
        return True
    in_use = {word for i, word in enumerate(words) if is_input(words, i)}
    if "machine.toml" in in_use:
        in_use |= real_files.OF_MACHINE
    path = Path(name)
    outputs = [Path(word) for i, word in enumerate(words) if is_output(words, i) and word]
    return name not in in_use and any(out == path or out in path.parents for out in outputs)


def main():
    panelcal, repository = str(Path(sys.argv[1]).resolve()), sys.argv[2]
    count = int(sys.argv[3])
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else 20261124
    draw = random.Random(seed)
    options = {command: real_files.options_of(panelcal, command)
               for command in real_files.leaves(panelcal) if command not in real_files.ENDLESS}
    exits, problems = {}, []
    with tempfile.TemporaryDirectory() as top:
        origin, folder = Path(top) / "origin", Path(top) / "folder"
        origin.mkdir()
        real_files.make(panelcal, repository, origin)
        shutil.copytree(origin, folder)
        before = real_files.content(folder)
        names = sorted(before) + ["images", "."]
        for i in range(count):
            command, words = command_line(draw, options, names)
            try:
                done = subprocess.run([panelcal, *words], cwd=folder, capture_output=True,
                                      stdin=subprocess.DEVNULL, timeout=SECONDS)
                code = done.returncode
            except subprocess.TimeoutExpired:
                code = "time"
            exits[code] = exits.get(code, 0) + 1
            after = real_files.content(folder)
            lost = [name for name in before if before[name] != after.get(name)]
            problems += [f"{i}: panelcal {shlex.join(words)}: exit {code}, changed {name}"
                         for name in lost if not may_change(name, command, words)]
            if code not in (0, 1, 2, 3):
                problems.append(f"{i}: panelcal {shlex.join(words)}: exit {code}")
            if before != after:
                shutil.rmtree(folder)
                shutil.copytree(origin, folder)
    print("\n".join(problems), end="\n" if problems else "")
    print(f"seed {seed}, {count} command lines, exit codes {exits}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
