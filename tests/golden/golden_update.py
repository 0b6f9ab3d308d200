# SPDX-License-Identifier: Apache-2.0
"""Takes what runs did into their cases, one by one and only if a person says yes to its diff."""
import sys

from golden_case import expected_files, load, text_of
from golden_compare import differences, err_of
from golden_run import run


def take(case, outcome):
    """Makes the outcome the case's expectation; short lines of err stay short where they agree."""
    case.exit = outcome.exit
    case.err = err_of(case, outcome)
    case.out = outcome.out
    files = expected_files(case)
    case.same = {name: fixture for name, fixture in case.same.items()
                 if outcome.written.get(name) == files[name]}
    case.files = {name: data for name, data in outcome.written.items() if name not in case.same}
    case.absent = [name for name in case.absent if name not in outcome.made]


def says_yes(question):
    """An end of the input, as by Ctrl-D, is a no."""
    try:
        return input(question).strip().lower() in ("y", "yes")
    except EOFError:
        print()
        return False


def update(panelcal, paths):
    """Returns the exit code: 1 if a case still differs."""
    if not sys.stdin.isatty():
        sys.exit("--update asks about every case, and standard input is no terminal")
    left = 0
    for path in paths:
        case = load(path)
        outcome = run(panelcal, case)
        found = differences(case, outcome)
        if not found:
            print(f"{path}: no difference")
            continue
        print("".join(found), end="")
        if outcome.lost or any(".part-" in name for name in outcome.written):
            print(f"{path}: a lost or left file is a fault of panelcal, not an expectation")
            left += 1
        elif says_yes(f"{path}: take this as expected? [y/n] "):
            take(case, outcome)
            with open(path, "wb") as file:
                file.write(text_of(case))
        else:
            left += 1
    return 1 if left else 0
