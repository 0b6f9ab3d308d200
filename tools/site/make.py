#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the manual as a site: docs/ with the pictures of its tutorials, by Sphinx.

    make.py PANELCAL ROOT OUTPUT

OUTPUT/html/index.html opens from the disk.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from tutorials import PICTURE, Wrong, pages_of, run_page  # noqa: E402

LINK = re.compile(r"\[([^\]\n]*)\]\(([^)\s]+)\)")
FOREIGN = re.compile(r"(?:src|href)=\"https?://[^\"]*\.(?:js|css|woff2?|png|svg)")


def without_links_out(text, page, docs):
    """Links to files beside docs/, which the site does not have, become their names."""
    def named(link):
        words, target = link.groups()
        path = (page.parent / target.split("#")[0]).resolve()
        if re.match(r"\w+:", target) or target.startswith("#") or path.is_relative_to(docs):
            return link.group()
        name = str(path.relative_to(docs.parent))
        return f"`{name}`" if words.strip("`") in (name, target) else f"{words} (`{name}`)"
    return LINK.sub(named, text)


def copy_pages(root, source):
    """docs/ as Sphinx reads it."""
    docs = root / "docs"
    shutil.copytree(docs, source)
    for page in docs.rglob("*.md"):
        (source / page.relative_to(docs)).write_text(without_links_out(page.read_text(), page, docs))


def build(source, output):
    """By Sphinx; a link that leads nowhere or a missing picture fails. Debian's Sphinx is that of Debian's own Python."""
    subprocess.run(["/usr/bin/python3", "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-c",
                    Path(__file__).parent, "-d", output / "trees", source, output / "html"], check=True,
                   env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    foreign = [f"{page.name}: {found}" for page in (output / "html").rglob("*.html")
               for found in FOREIGN.findall(page.read_text())]
    if foreign:
        raise Wrong("the site loads from the network: " + ", ".join(foreign))


def main():
    panelcal, root, output = (Path(word).resolve() for word in sys.argv[1:])
    source = output / "source"
    shutil.rmtree(output, ignore_errors=True)
    copy_pages(root, source)
    try:
        for page in pages_of(root):
            if PICTURE.search(page.read_text()):
                pictures = source / page.relative_to(root / "docs").parent / "pictures"
                print(run_page(panelcal, root, page, pictures), flush=True)
        build(source, output)
    except Wrong as problem:
        return str(problem)
    print(f"file://{output}/html/index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
