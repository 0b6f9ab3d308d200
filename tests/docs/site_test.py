#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each link of the manual leads to a page and a heading that are there, and no page loads from the network.

Pictures are blank here: docs.tutorials_run takes the real ones.

    site_test.py ROOT
"""
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(sys.argv[1]).resolve()
sys.path.insert(0, str(ROOT / "tools/site"))
sys.dont_write_bytecode = True
from make import LINK, build, copy_pages  # noqa: E402
from tutorials import PICTURE  # noqa: E402

SKIP = 77
CODE = re.compile(r"```.*?```|`[^`\n]*`|^    .*?$", re.S | re.M)
BLANK = bytes.fromhex("89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c4944415478da63"
                      "f8ffff3f0005fe02fea7569d050000000049454e44ae426082")


def broken_links(pages):
    """Links to files that are not there, also those out of docs/."""
    return [f"{page.relative_to(ROOT)}: {target}" for page in pages
            for _, target in LINK.findall(CODE.sub("", page.read_text()))
            if not re.match(r"\w+:|#|pictures/", target) and not (page.parent / target.split("#")[0]).exists()]


def main():
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    broken = broken_links(pages)
    assert not broken, broken
    if subprocess.run(["/usr/bin/python3", "-c", "import sphinx, myst_parser, sphinx_rtd_theme"],
                      capture_output=True).returncode:
        print("SKIP: Sphinx is not installed (tools/packages.txt, site)")
        return SKIP
    with tempfile.TemporaryDirectory() as name:
        output = Path(name)
        source = output / "source"
        copy_pages(ROOT, source)
        for page in source.rglob("*.md"):
            for _, _, picture in PICTURE.findall(page.read_text()):
                (page.parent / "pictures").mkdir(exist_ok=True)
                (page.parent / "pictures" / picture).write_bytes(BLANK)
        build(source, output)
        built = {page.relative_to(output / "html").with_suffix("") for page in (output / "html").rglob("*.html")}
        lost = [page for page in source.rglob("*.md") if page.relative_to(source).with_suffix("") not in built]
        assert not lost, lost
        assert "fiduci" in (output / "html/searchindex.js").read_text(), "the search has no index"
        with open(source / "index.md", "a") as index:
            index.write("\n[lost](gone.md)\n")
        try:
            build(source, output)
        except subprocess.CalledProcessError:
            return 0
    raise AssertionError("a link to a page that is not there was not noticed")


if __name__ == "__main__":
    sys.exit(main())
