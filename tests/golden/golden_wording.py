# SPDX-License-Identifier: Apache-2.0
"""What the err sections of all cases say about diagnostics, for tests over all cases."""
import re
from collections import namedtuple
from pathlib import Path

from golden_case import load
from golden_compare import split_short

GOLDEN = Path(__file__).resolve().parent

# A line of an err section; message is None in a short one.
Line = namedtuple("Line", "case code message")

DIAGNOSTIC = re.compile(r"(?:.*?: )(?:error|warning)\[([a-z-]+)\](?:: (.*))?$")
# What differs between two messages of one wording: texts, sections, keys, numbers, lists of such.
DATA = (
    (re.compile(r'"[^"]*"'), "TEXT"),
    (re.compile(r"\[\[?[a-z][a-z_.]*\]\]?"), "SECTION"),
    (re.compile(r"\b[a-z0-9]+(?:_[a-z0-9]+)+\b"), "KEY"),
    (re.compile(r"(?:^|(?<=: ))\S+ in SECTION"), "KEY in SECTION"),
    (re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"), "NUMBER"),
    (re.compile(r"\b(TEXT|KEY|NUMBER)(?:(?:,| or| and)+ ?\1)+"), r"\1"),
)


def template(message):
    """The message without its data."""
    for pattern, name in DATA:
        message = pattern.sub(name, message)
    return message


def case_paths():
    return sorted(GOLDEN.glob("*/*.case"))


def name_of(path):
    return f"{path.parent.name}/{path.stem}"


def lines_of(name, err):
    for line in err.decode("utf-8", "replace").splitlines():
        short = split_short(line)
        match = DIAGNOSTIC.match(short[0] if short else line)
        if match:
            yield Line(name, match[1], match[2])


def diagnostics():
    """Every diagnostic of every case, as a Line."""
    return [line for path in case_paths() for line in lines_of(name_of(path), load(path).err)]
