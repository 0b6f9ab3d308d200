#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds the words of denied_words.txt in comments, texts and documents of the product.

    check_words.py

Of C++ only comments and string literals count, of other files every line. Tests are searched for the
first words of that file only; tables that quote the machines' manuals are left out.
"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KINDS = ("*.cc", "*.h", "*.def", "*.md", "*.sh", "*.py", "*.cmake", "*CMakeLists.txt", "*.toml",
         "*.case", "*.service", "*.timer")
LEFT_OUT = re.compile(r"^(program/[\w/]+/\w*commands\.def$|tools/denied_words\.txt$)")
TOKEN = re.compile(
    r'(?P<raw>R"(?P<tag>[^(\s]*)\((?P<body>.*?)\)(?P=tag)")'
    r'|(?P<text>"(?:[^"\\\n]|\\.)*")'
    r"|(?P<char>'(?:[^'\\\n]|\\.){1,2}')"
    r"|(?P<comment>//[^\n]*|/\*.*?\*/)", re.DOTALL)


def denied():
    """Rows of expression, word instead, ends of files' names, and whether tests follow it too."""
    rows = []
    is_for_tests = True
    for line in (ROOT / "tools" / "denied_words.txt").read_text(encoding="utf-8").splitlines():
        is_for_tests = is_for_tests and line != "# not in tests"
        if not line or line.startswith("#"):
            continue
        expression, instead, *suffix = line.split(" => ")
        rows.append((re.compile(expression, re.IGNORECASE), instead, tuple(suffix) or ("",),
                     is_for_tests))
    return rows


def only_prose(source):
    """Comments and string literals in their places; all else is blank."""
    prose = [c if c == "\n" else " " for c in source]
    for token in TOKEN.finditer(source):
        if token["char"] is None:
            prose[token.start():token.end()] = source[token.start():token.end()]
    return "".join(prose)


def main():
    rows = denied()
    files = subprocess.run(["git", "ls-files", "-z", *KINDS], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\0")
    n_found = 0
    for name in filter(None, files):
        if LEFT_OUT.match(name) or not (ROOT / name).is_file():
            continue
        text = (ROOT / name).read_text(encoding="utf-8")
        if name.endswith((".cc", ".h", ".def")):
            text = only_prose(text)
        for number, line in enumerate(text.split("\n"), 1):
            for expression, instead, suffix, is_for_tests in rows:
                if not name.endswith(suffix) or name.startswith("tests/") and not is_for_tests:
                    continue
                if found := expression.search(line.replace(" is None", "")):
                    print(f'{name}:{number}: denied word: "{found[0]}"; write: {instead}')
                    n_found += 1
    return 1 if n_found else 0


if __name__ == "__main__":
    sys.exit(main())
