#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Extreme inputs end: every command on every file that it reads, with numbers at the ends of their
range, empty, endless and deeply nested files, within 20 s of processor time and 2 GiB of memory.

    extreme_inputs_test.py PANELCAL REPOSITORY COUNT [SEED]
"""
import random
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import real_files

SECONDS = 20
BYTES = 2 << 30
NUMBERS = ["1e308", "-1e308", "1.7976931348623157e308", "5e-324", "1e-320", "0", "-0.0", "-1", "1e9",
           "1e-9", "1e16", "1e100", "1e-100", "4294967296", "9223372036854775807",
           "18446744073709551615", "99999999999999999999999999", "1" * 400, "nan", "inf", "1e9999"]
REPEATS = {
    "excellon": ["R9999M02X1Y1\n" * 3, "R2M02X1Y0\n" * 60, "M25\n" * 5000, "R99999X0.01\n",
                 "M97,ABCDEFGHIJKLMNOPQRSTUVWXYZ\nX0Y0\n" * 500, "G84\nX0Y0G84X9999Y9999\n",
                 "X1Y1G85X9999999Y9999999\n", "M02X1e9\n", "R1000000000X0.001Y0.001\n"],
    "sieb-meyer": ["M50X1Y1V2\nM50X100000Y1W9999\n" * 4, "N8%T1\n" * 5000, "G83X9999\n"],
}
SIEB_MEYER = "%%5000\nT1\nX1000Y1000\nX2000Y2000\n$\nT1C0.8\n$\n"


def mutated_numbers(draw, text):
    """One to four of its numbers are others."""
    found = list(re.finditer(r"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", text))
    for match in sorted(draw.sample(found, min(len(found), draw.randrange(1, 5))),
                        key=lambda m: -m.start()):
        text = text[:match.start()] + draw.choice(NUMBERS) + text[match.end():]
    return text


def mutated(draw, name, content):
    """A name for what was done, and the bytes."""
    kind = draw.random()
    if kind < 0.6:
        try:
            return "numbers", mutated_numbers(draw, content.decode()).encode()
        except UnicodeDecodeError:
            pass
    if kind < 0.65:
        return "empty", b""
    if kind < 0.7:
        return "cut off", content[:draw.randrange(len(content) + 1)]
    if kind < 0.75:
        return "one long line", content.replace(b"\n", b" ") * draw.choice([1, 2000])
    if kind < 0.8:
        return "repeated", content * draw.choice([2, 500])
    if kind < 0.85:
        return "nested", draw.choice([b"[", b'{"a":', b"(", b"[["]) * 200000
    if kind < 0.9:
        return "zeros", bytes(draw.choice([1, 1 << 20]))
    if name.endswith(".exc"):
        lines = content.decode().splitlines(keepends=True)
        lines.insert(draw.randrange(len(lines)), draw.choice(REPEATS["excellon"]))
        return "repeats", "".join(lines).encode()
    if kind < 0.95:
        return "sieb & meyer", draw.choice(
            [SIEB_MEYER, SIEB_MEYER.replace("T1\n", "T1\n" + draw.choice(REPEATS["sieb-meyer"]), 1)]).encode()
    at = draw.randrange(len(content) + 1)
    return "bytes", content[:at] + draw.randbytes(8) + content[at + 8:]


def readers(names):
    """File -> commands that read it."""
    out = {}
    for command, words in real_files.COMMANDS.items():
        used = set(shlex.split(words))
        if "machine.toml" in used:
            used |= real_files.OF_MACHINE - {"drill1.ledger.lock"}
        if "images" in used:
            used |= {name for name in names if name.startswith("images/")}
        for name in used & names:
            out.setdefault(name, []).append(command)
    return out


def outputs_of(command):
    if command in ("run", "translate"):
        return ["-o", "new.exc"]
    if command == "synth":
        return ["-o", "new"]
    if command in ("surface fit", "surface plan", "history plot", "calibrate camera-import",
                   "calibrate camera-export"):
        return ["-o", "new.json"]
    return ["-o", "new.ngc"] if command in ("surface apply", "align apply") else []


def limit(limits_memory):
    """Sanitizers need more addresses than there is memory."""
    def set_limits():
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        if limits_memory:
            resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    return set_limits


def main():
    panelcal, repository = str(Path(sys.argv[1]).resolve()), sys.argv[2]
    count = int(sys.argv[3])
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else 20261126
    draw = random.Random(seed)
    exits, problems = {}, []
    starts = subprocess.run([panelcal, "--version"], capture_output=True, preexec_fn=limit(True))
    limits = limit(starts.returncode == 0)
    with tempfile.TemporaryDirectory() as top:
        origin, folder = Path(top) / "origin", Path(top) / "folder"
        origin.mkdir()
        real_files.make(panelcal, repository, origin)
        shutil.copytree(origin, folder)
        before = real_files.content(origin)
        read_by = readers(set(before))
        for i in range(count):
            name = draw.choice(sorted(read_by))
            command = draw.choice(sorted(read_by[name]))
            what, content = mutated(draw, name, before[name])
            (folder / name).write_bytes(content)
            words = [*command.split(), *shlex.split(real_files.COMMANDS[command]), *outputs_of(command)]
            done = subprocess.run([panelcal, *words], cwd=folder, capture_output=True,
                                  stdin=subprocess.DEVNULL, preexec_fn=limits)
            exits[done.returncode] = exits.get(done.returncode, 0) + 1
            said = done.stderr.decode(errors="replace")
            if done.returncode not in (0, 1, 2, 3) or "internal" in said:
                kept = Path(tempfile.gettempdir()) / f"extreme-{seed}-{i}-{Path(name).name}"
                kept.write_bytes(content)
                problems.append(f"{i}: panelcal {shlex.join(words)} with {name} ({what}, {kept}): "
                                f"exit {done.returncode}: {said[-300:]}")
            if real_files.content(folder) != before:
                shutil.rmtree(folder)
                shutil.copytree(origin, folder)
    print("\n".join(problems), end="\n" if problems else "")
    print(f"seed {seed}, {count} inputs, exit codes {exits}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
