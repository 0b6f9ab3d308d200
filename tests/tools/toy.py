# SPDX-License-Identifier: Apache-2.0
"""A toy thing is added to a copy of the sources, by touching only the files that docs/overview.md names for it."""

import atexit
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


class Toy:
    """Changed files stand in a folder of their own, which the compiler searches before the sources."""

    def __init__(self, source, build, heading):
        self.source, self.build = Path(source), Path(build)
        self.folder = Path(tempfile.mkdtemp(prefix="panelcal_toy_"))
        atexit.register(shutil.rmtree, self.folder)
        text = (self.source / "docs/overview.md").read_text()
        section = re.search(rf"^### {re.escape(heading)}\n(.*?)(?=^##|\Z)", text, re.S | re.M)
        if section is None:
            sys.exit(f'docs/overview.md has no heading "{heading}"')
        self.named = re.findall(r"`([a-z_]+/[^`\s]*)`", section.group(1))
        self.touched = set()

    def is_named(self, path):
        return any(path == named or (named.endswith("/") and path.startswith(named)) for named in self.named)

    def text(self, path):
        changed = self.folder / path
        return (changed if changed.exists() else self.source / path).read_text()

    def write(self, path, text):
        if not self.is_named(path):
            sys.exit(f'"{path}" is not among the files that docs/overview.md names: {", ".join(self.named)}')
        target = self.folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
        self.touched.add(path)

    def insert_before(self, path, mark, addition):
        """`mark` stands once in the file."""
        text = self.text(path)
        if text.count(mark) != 1:
            sys.exit(f'"{mark}" stands {text.count(mark)} times in {path}; the toy counts on one')
        self.write(path, text.replace(mark, addition + mark))

    def flags_of(self, library):
        """The compiler and its flags for the sources of a library, without optimisation and precompiled headers."""
        commands = json.loads((self.build / "compile_commands.json").read_text())
        row = next(row for row in commands if f"/{library}.dir/" in row["command"])
        words = row["command"].split()
        words = words[next(i for i, word in enumerate(words) if word.endswith(("g++", "c++", "clang++-16"))):]
        kept, skip = [words[0]], False
        for word in words[1:]:
            if skip or word in ("-include", "-o"):
                skip = not skip
            elif word not in ("-c", "-O2", row["file"]) and not word.startswith(("-Winvalid-pch", "-fpch")):
                kept.append(word)
        return [kept[0], f"-I{self.folder}", *kept[1:], "-O0", "-w"]

    def libraries_of(self, target):
        """What the linker gives to a built program, without its own objects."""
        lines = subprocess.run(["ninja", "-C", str(self.build), "-t", "commands", target],
                               capture_output=True, text=True, check=True).stdout.splitlines()
        words = next(line for line in reversed(lines) if f" -o {target}" in line).split()
        words = " ".join(words[words.index("-o") + 2:]).split(" && ")[0].split()
        return [word for word in words if not word.endswith(".o") and "libgtest_main" not in word]

    def program(self, library, units, main, like, replaces=False):
        """Compiles units of a library and a main function in one go, and links them as the program `like` is.

        Where `replaces` is set, the units are some of a built library's, and count instead of its own."""
        unity = self.folder / "toy.cc"
        lines = []
        for unit in units:
            changed = self.folder / unit
            lines.append(f'#include "{changed if changed.exists() else self.source / unit}"\n')
        unity.write_text("".join(lines) + main)
        program = self.folder / "toy"
        command = [*self.flags_of(library), str(unity), "-o", str(program), "-fuse-ld=mold", "-Wl,--gc-sections",
                   *(["-Wl,--allow-multiple-definition"] if replaces else []), *self.libraries_of(like)]
        done = subprocess.run(command, cwd=self.build, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"the toy does not compile: {' '.join(command)}\n{done.stderr[:4000]}")
        return program

    def run(self, program, *arguments):
        done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60)
        return done.returncode, done.stdout + done.stderr


def expect(condition, message):
    if not condition:
        sys.exit(message)

