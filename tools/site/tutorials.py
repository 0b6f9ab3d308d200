#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows a page of the manual word by word in an empty folder, and takes its pictures.

    tutorials.py PANELCAL ROOT PAGE.md PICTURES

Blocks of `sh` run one after the other in one shell that ends at the first failure. The lines of a `text` block have
to be among what was printed before, in any order; their numbers may differ by 2 %, since processors and compilers
round differently. `<!-- not run: REASON -->` excuses the block below it. `<!-- picture: FILE -->` names the file that the image
below it shows: a PNG is copied, a page is photographed by Chromium.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(r"(<!-- not run: [^>]+ -->\n)?```(\w*)\n(.*?)```", re.S)
PICTURE = re.compile(r"(?:<!-- picture: (\S+) -->\n)?!\[([^\]]*)\]\(pictures/([^)]+)\)")
NUMBER = re.compile(r"[-+]?\d+\.\d+(?:e[-+]?\d+)?")
LARGEST_SHARE = 0.02
LARGEST_DIFFERENCE = 0.05  # of residuals near 0, in the unit of the line
LONGEST_S = 600  # with sanitizers
# High enough for the first figure of each page.
WINDOW = "1280,1700"


class Wrong(Exception):
    """The page does not do what it says."""


def is_like(shown, printed):
    """True if the lines differ in no more than the last digits of their decimals."""
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return False
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(printed)))
    return all(abs(a - b) <= max(LARGEST_DIFFERENCE, LARGEST_SHARE * abs(a)) for a, b in pairs)


def blocks_of(text, name):
    """(kind, content) of all blocks that count; one of an unknown kind is a mistake of the writer."""
    found = []
    for excuse, kind, content in BLOCK.findall(text):
        if kind not in ("sh", "text"):
            raise Wrong(f"{name}: block of kind \"{kind}\"; expected sh or text")
        if not excuse:
            found.append((kind, content))
    return found


def examples_in(folder, root):
    """As the package has them: the examples, and the demo's job beside them."""
    for source in (*(root / "examples").iterdir(), root / "datasets/demo"):
        (folder / source.name).symlink_to(source)
    return folder


def follow(panelcal, root, text, name, folder, examples):
    """Runs the blocks; what they printed is held against the text blocks."""
    blocks = blocks_of(text, name)
    commands = "\n".join(content for kind, content in blocks if kind == "sh")
    paths = [str(Path(panelcal).parent), os.environ["PATH"]]
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", commands], cwd=folder, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LONGEST_S,
                          env={**os.environ, "PATH": ":".join(paths), "EXAMPLES": str(examples)})
    if done.returncode:
        raise Wrong(f"{name}: exit code {done.returncode}\n{done.stdout}")
    printed = done.stdout.splitlines()
    for kind, content in blocks:
        for shown in content.splitlines() if kind == "text" else ():
            if not any(is_like(shown, line) for line in printed):
                raise Wrong(f"{name} shows a line that its commands do not print: {shown}\n{done.stdout}")
    return len(blocks)


def photograph(page, picture):
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                        f"--user-data-dir={profile}", f"--window-size={WINDOW}", "--virtual-time-budget=20000",
                        f"--screenshot={picture}", page.as_uri()],
                       check=True, capture_output=True, timeout=LONGEST_S)


def take_pictures(text, name, folder, pictures):
    pictures.mkdir(parents=True, exist_ok=True)
    taken = 0
    for source, words, picture in PICTURE.findall(text):
        if not source or not words:
            raise Wrong(f"{name}: {picture}: the line <!-- picture: FILE --> or its words are missing")
        source = folder / source
        if not source.is_file():
            raise Wrong(f"{name}: {picture}: no command wrote {source.name}")
        if source.suffix == ".html":
            photograph(source, pictures / picture)
        else:
            shutil.copy(source, pictures / picture)
        if not (pictures / picture).read_bytes().startswith(b"\x89PNG"):
            raise Wrong(f"{name}: {picture} is not a PNG")
        taken += 1
    return taken


def pages_of(root):
    """The pages whose blocks are run."""
    return [*sorted((root / "docs/tutorials").glob("*.md")), root / "docs/how_sure.md"]


def run_page(panelcal, root, page, pictures, check=lambda folder: None):
    """Follows a page and takes its pictures; `check` sees the folder before it goes."""
    text = page.read_text()
    with tempfile.TemporaryDirectory() as name, tempfile.TemporaryDirectory() as examples:
        folder = Path(name)
        n_blocks = follow(panelcal, root, text, page.name, folder, examples_in(Path(examples), root))
        check(folder)
        n_pictures = take_pictures(text, page.name, folder, pictures)
    return f"{page.name}: {n_blocks} blocks, {n_pictures} pictures"


def main():
    panelcal, root, page, pictures = (Path(word).resolve() for word in sys.argv[1:])
    try:
        print(run_page(panelcal, root, page, pictures))
    except Wrong as problem:
        return str(problem)
    return 0


if __name__ == "__main__":
    sys.exit(main())
