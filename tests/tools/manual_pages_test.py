# SPDX-License-Identifier: Apache-2.0
"""Each command has a manual page that mandoc and groff read without a word, with all its options.

usage: manual_pages_test.py PANELCAL
"""

import re
import subprocess
import sys

PANELCAL = sys.argv[1]


def help_of(*words):
    return subprocess.run([PANELCAL, "help", *words], check=True, capture_output=True, text=True).stdout


def commands():
    """Of `panelcal help topics`, with the program itself."""
    part = help_of("topics").split("\n\n")[0].splitlines()[1:]
    return [[]] + [line[2:28].split() for line in part]


def complaints(page):
    """Of both readers; a page of no fixed day has no date."""
    lint = subprocess.run(["mandoc", "-Tlint", "-Wwarning"], input=page, capture_output=True, text=True)
    groff = subprocess.run(
        ["groff", "-man", "-Tutf8", "-ww", "-z"], input=page, capture_output=True, text=True)
    lines = (lint.stdout + lint.stderr + groff.stderr).splitlines()
    return [line for line in lines if "missing date" not in line]


def main():
    failures = []
    for command in commands():
        name = "-".join(["panelcal", *command]) + ".1"
        page = help_of(name)
        failures += [f"{name}: {line}" for line in complaints(page)]
        plain = subprocess.run(
            ["mandoc", "-Tascii"], input=page, check=True, capture_output=True, text=True).stdout
        plain = re.sub(".\b", "", plain)
        options = re.findall(r"^ +(?:-\w,)?(--[a-z-]+)", help_of(*command), re.M)
        if command and command[-1] not in ("calibrate", "history", "surface") and len(options) < 2:
            failures.append(f"{name}: the help of this command has {len(options)} options")
        for option in options:
            if not re.search(rf"^ +{option}\b", plain, re.M):
                failures.append(f"{name} lacks {option}")
        below = [other[-1] for other in commands() if other[:-1] == command and other]
        for one in below:
            if f"{name[:-2]}-{one}(1)" not in plain.replace("\n", " "):
                failures.append(f"{name} does not name {one}")
    print("\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
