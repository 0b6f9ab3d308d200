#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that docs/overview.md, CONTRIBUTING.md and headers name files, folders and functions that exist, and all rooms.

    overview_test.py REPOSITORY
"""
import re
import sys
from pathlib import Path


def problems_of(root, page):
    problems = []
    for number, line in enumerate((root / page).read_text(encoding="utf-8").splitlines(), 1):
        words = re.findall(r"`([^`]+)`", line)
        paths = [w for w in words if re.fullmatch(r"[a-z_]+/[\w./-]*", w) and "/NAME" not in w]
        problems += [f"{page}:{number}: there is no {p}" for p in paths if not (root / p).exists()]
        # A row of the tables of functions: | `file` | `function` | ...
        row = re.match(r"\| `([\w./]+\.(?:cc|h))` \| `([\w:]+)` \|", line)
        if row and (root / row[1]).exists():
            text = (root / row[1]).read_text(encoding="utf-8")
            name = row[2].split("::")[-1]
            if not re.search(rf"\b{name}\b", text):
                problems.append(f"{page}:{number}: {row[1]} has no {row[2]}")
    return problems


def rooms_unnamed(root):
    """Rooms (folders inside a library's) that the overview leaves out."""
    text = (root / "docs/overview.md").read_text(encoding="utf-8")
    rooms = [path for folder in ("calib", "surface", "program", "vision", "machine")
             for path in sorted((root / folder).iterdir()) if path.is_dir() and any(path.glob("*.h"))]
    assert rooms, f"{root} has no rooms"
    names = [f"{room.parent.name}/{room.name}/" for room in rooms]
    return [f"docs/overview.md: {name} is not named" for name in names if f"`{name}`" not in text]


def problems_of_headers(root):
    """Files that the comments of headers name."""
    problems = []
    for folder in ("calib", "surface", "program", "vision", "machine", "tools"):
        for header in sorted((root / folder).rglob("*.h")):
            for path in re.findall(r"(?<![\w./])(?:tests|docs)/[\w./]+\.(?:cc|h|md|py)\b",
                                   header.read_text(encoding="utf-8")):
                if not (root / path).exists():
                    problems.append(f"{header.relative_to(root)}: there is no {path}")
    return problems


def main():
    root = Path(sys.argv[1])
    problems = problems_of(root, "docs/overview.md") + problems_of(root, "CONTRIBUTING.md")
    problems += problems_of_headers(root) + rooms_unnamed(root)
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
