#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Names in anonymous namespaces are unique in their library, so that unity builds stay possible.

Lists every name that two files of one top-level folder define; the same alias twice is no clash.
"""
import collections
import pathlib
import re
import sys

LIBRARIES = ("calib", "surface", "program", "vision", "machine", "tools")


def without_text(source):
    """The source, as long as before, with comments and the inside of literals blanked."""
    blank = lambda match: re.sub(r"[^\n]", " ", match.group(0))
    literal = lambda match: match.group(0)[0] + re.sub(r"[^\n]", "x", match.group(0)[1:-1]) + match.group(0)[0]
    source = re.sub(r'R"(\w*)\(.*?\)\1"', lambda m: '"' + re.sub(r"[^\n]", "x", m.group(0)[2:-1]) + '" ', source, flags=re.S)
    source = re.sub(r"(?<=\d)'(?=\d)", " ", source)
    pattern = r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|' + r"'(?:[^'\\\n]|\\.)+'"
    return re.sub(pattern, lambda m: blank(m) if m.group(0)[0] == "/" else literal(m), source, flags=re.S)


def declared_name(head):
    """(name, what is declared if an alias) of the text before a body or a semicolon, or None."""
    head = re.sub(r"^\s*#.*$", "", head, flags=re.M).strip()
    head = re.sub(r"^PANELCAL_\w+\([^)]*\)\s*", "", head)
    head = re.sub(r"^template\s*<[^{;]*?>\s*(?=[A-Za-z])", "", head)
    if not head:
        return None
    if alias := re.match(r"using\s+(\w+)\s*=(.*)", head, flags=re.S):
        return alias.group(1), " ".join(alias.group(2).split())
    if re.match(r"(using|namespace|static_assert|friend)\b", head):
        return None
    if kind := re.match(r"(?:enum\s+class|enum|struct|class|union)\s+(\w+)", head):
        return kind.group(1), None
    call = re.search(r"([\w:]+)\s*\(", head)
    equals = head.find("=")
    if call and (equals < 0 or call.start() < equals):
        return None if "::" in call.group(1) or "operator" in head else (call.group(1), None)
    variable = re.search(r"\b([A-Za-z_]\w*)\s*(?:\[[^\]]*\]\s*)*(?:=|$)", head)
    return (variable.group(1), None) if variable else None


def names_of(source):
    """What the anonymous namespaces of a file declare: name -> (alias or None, line)."""
    text = without_text(source)
    names = {}
    for opening in re.finditer(r"namespace\s*\{", text):
        begin = at = opening.end()
        braces = parentheses = 0
        while at < len(text) and (text[at] != "}" or braces > 0):
            c = text[at]
            parentheses += (c == "(") - (c == ")")
            if parentheses == 0 and braces == 0 and c in "{;" and (name := declared_name(text[begin:at])):
                names.setdefault(name[0], (name[1], text.count("\n", 0, at) + 1))
            braces += (c == "{") - (c == "}")
            if parentheses == 0 and braces == 0 and c in "};":
                begin = at + 1
            at += 1
    return names


def clashes(root, library):
    """One line for each name that two files of a library define."""
    places = collections.defaultdict(list)
    for file in sorted((root / library).rglob("*.cc")):
        source = re.sub(r'#include "([^"]+[.]def)"', lambda m: (root / m.group(1)).read_text(), file.read_text())
        for name, (alias, line) in names_of(source).items():
            places[name].append((f"{file.relative_to(root)}:{line}", alias))
    for name, found in sorted(places.items()):
        aliases = {alias for _, alias in found}
        if len(found) > 1 and (None in aliases or len(aliases) > 1):
            yield f"{name}: " + ", ".join(place for place, _ in found)


def main():
    root = pathlib.Path(sys.argv[1])
    sample = "namespace {\nint f(int a) { return a; }\nconstexpr int kA = 1'0;\nusing B = int;\nbool C::g() const {}\n}"
    if names_of(sample) != {"f": (None, 2), "kA": (None, 3), "B": ("int", 4)}:
        sys.exit(f"the parser is wrong: {names_of(sample)}")
    lines = [line for library in LIBRARIES for line in clashes(root, library)]
    print("\n".join(lines))
    if lines:
        sys.exit(f"{len(lines)} names stand in two anonymous namespaces of one library: rename them, or share one")


if __name__ == "__main__":
    main()
