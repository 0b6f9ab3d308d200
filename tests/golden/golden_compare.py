# SPDX-License-Identifier: Apache-2.0
"""Compares what a run did with what its case expects."""
from golden_case import expected_files

SEVERITIES = (": error[", ": warning[")


def split_short(line):
    """Of a short line of err: place, severity and code as they stand there, and texts; else None.

    A short line is PLACE: error[code], or that and texts behind it, each after ` ... `.
    """
    head, *texts = line.split(" ... ")
    is_short = head.endswith("]") and any(mark in head for mark in SEVERITIES)
    return (head, texts) if is_short else None


def says(actual, short):
    """Whether a line of standard error is what a short line asks for."""
    head, texts = short
    message = actual[len(head):]
    return actual.startswith(head + ": ") and all(words in message for words in texts)


def shortened(expected, actual):
    """The actual standard error, with the short line in place of each line that it agrees with."""
    wanted = expected.split("\n")
    lines = actual.split("\n")
    short = [(line, parts) for line in wanted if (parts := split_short(line))]
    full = [line for line in wanted if not split_short(line)]
    for at, line in enumerate(lines):
        if line in full:
            full.remove(line)
            continue
        match = next((pair for pair in short if says(line, pair[1])), None)
        if match:
            short.remove(match)
            lines[at] = match[0]
    return "\n".join(lines)


def text(data):
    return data.decode("utf-8", "backslashreplace")


def err_of(case, outcome):
    """What the case's err section would be after this run, as far as it agrees in its own words."""
    if case.err == outcome.err or not outcome.err:
        return outcome.err
    return shortened(text(case.err), text(outcome.err)).encode()


def difference(name, expected, actual):
    if expected == actual:
        return []
    import difflib
    lines = [text(data).splitlines(keepends=True) for data in (expected, actual)]
    diff = "".join(line if line.endswith("\n") else line + "\n" for line in
                   difflib.unified_diff(*lines, f"expected {name}", f"actual {name}"))
    return [diff or f"{name} differs in its line ends\n"]


def differences(case, outcome):
    """Texts that say what is different; none if the run did what the case expects."""
    found = difference("exit", b"%d\n" % case.exit, b"%d\n" % outcome.exit)
    found += difference("err", case.err, err_of(case, outcome))
    found += difference("out", case.out, outcome.out)
    files = expected_files(case)
    for name in sorted(files.keys() | outcome.written.keys()):
        if name not in outcome.written:
            found.append(f"{name} was not written\n")
        elif ".part-" in name:
            found.append(f"{name} was left behind\n")
        elif name not in files:
            found.append(f"{name} was written, which no section `file {name}` asks for\n")
            found += difference(name, b"", outcome.written[name])
        else:
            found += difference(name, files[name], outcome.written[name])
    found += [f"{name} must not exist\n" for name in outcome.made]
    found += [f"{name} was removed\n" for name in outcome.lost]
    return found
