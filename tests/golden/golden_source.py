# SPDX-License-Identifier: Apache-2.0
"""Finds a file of panelcal's sources, in whichever folder it stands."""
import os
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
NO_SOURCES = {"build", "datasets", "docs", "out", "tests"}


def source_text(ending, words):
    """The text of the source whose name ends so and which holds these words."""
    for folder, folders, names in os.walk(REPOSITORY):
        folders[:] = sorted(below for below in folders
                            if below not in NO_SOURCES and not below.startswith("."))
        for name in names:
            if name.endswith(ending):
                text = Path(folder, name).read_text(encoding="utf-8")
                if words in text:
                    return text
    raise FileNotFoundError(f"no source *{ending} below {REPOSITORY} holds {words!r}")
