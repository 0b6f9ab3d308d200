# SPDX-License-Identifier: Apache-2.0
"""Whether the include graph is as docs say: paths of the repository, one direction, no cycles.

    include_graph_test.py SOURCE_FOLDER

Fails, with `file -> file` lines, on
  - an include in quotes that is no file of the repository by its path,
  - a library that includes what is installed of another, as <panelcal/panelcal.h>,
  - a folder that includes one to its right (calib, surface, program; vision beside them; machine;
    tools; python),
  - a language of part programs that is entered by another door than its ProgramDialect,
  - a cycle of units in a library (a unit is name.h with name.cc),
  - a cycle of rooms in a library (a room is a folder with the files that lie in it).
"""
import collections
import os
import re
import sys
import tempfile
import unittest

# What a folder may include beside itself.
MAY_INCLUDE = {
    "calib": (),
    "surface": ("calib",),
    "program": ("calib", "surface"),
    "vision": ("calib",),
    "machine": ("calib", "surface", "program", "vision"),
    "tools": ("calib", "surface", "program", "vision", "machine"),
    "python": ("calib", "surface", "program", "vision", "machine", "tools"),
}
# Rooms of languages, and who includes them: all others ask a ProgramDialect (program/walk/dialect.h).
LANGUAGES = ("program/excellon/", "program/sieb_meyer/")
DOORS = {
    "program/dialects.cc": "lists the dialects",
    "program/writers/": "writes a language in its own words and numbers",
    "machine/job/checked_program.cc": "reads nc_param.txt beside a program, before its language is known",
    "tools/cli/help/help_topics.cc": "prints the tables of commands",
    "tools/cli/output_paths.cc": "asks for the files in which subprograms were looked for",
}
ALSO_READ = ("tests",)  # their includes must be paths, too
OWN_INCLUDES = ("tests/install",)  # what a user of the installed libraries writes
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"')
INSTALLED = re.compile(r"^\s*#\s*include\s+<(panelcal/[^>]+)>")


def sources(root):
    """The C++ files of the repository."""
    for top in (*MAY_INCLUDE, *ALSO_READ):
        for folder, _, names in os.walk(os.path.join(root, top)):
            for name in names:
                path = os.path.relpath(os.path.join(folder, name), root)
                if name.endswith((".h", ".cc", ".def")) and not path.startswith(OWN_INCLUDES):
                    yield path


def includes_of(root, path, pattern=INCLUDE):
    """What a file includes in quotes, or by another pattern, with the line."""
    with open(os.path.join(root, path), encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            found = pattern.match(line)
            if found:
                yield number, found.group(1)


def is_side_door(path, other):
    """A file outside of a language's room includes one inside."""
    language = next((room for room in LANGUAGES if other.startswith(room)), None)
    return language is not None and not path.startswith((language, *DOORS))


def unit_of(path):
    return os.path.splitext(path)[0]


def cycles(edges):
    """One shortest cycle of each strongly connected component, as a list of nodes."""
    found = []
    for component in components(edges):
        start = min(component)
        came_from = {start: None}
        waiting = collections.deque([start])
        while waiting:
            node = waiting.popleft()
            if start in edges[node]:
                way = [start]
                while node is not None:
                    way.append(node)
                    node = came_from[node]
                found.append(way[::-1])
                break
            for other in sorted(edges[node]):
                if other in component and other not in came_from:
                    came_from[other] = node
                    waiting.append(other)
    return found


def components(edges):
    """The strongly connected components of more than one node (Tarjan 1972, without recursion)."""
    index, low, stack, on_stack, found = {}, {}, [], set(), []
    for root in sorted(edges):
        if root in index:
            continue
        work = [(root, iter(sorted(edges[root])))]
        index[root] = low[root] = len(index)
        stack.append(root)
        on_stack.add(root)
        while work:
            node, others = work[-1]
            for other in others:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on_stack.add(other)
                    work.append((other, iter(sorted(edges.get(other, ())))))
                    break
                if other in on_stack:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    component = set()
                    while node not in component:
                        component.add(stack.pop())
                    on_stack -= component
                    if len(component) > 1:
                        found.append(component)
    return found


def problems(root):
    """Everything that is wrong, as lines for people."""
    out = []
    files = set(sources(root))
    if not files:
        return [f"{root}: no C++ files"]
    by_kind = {"units": collections.defaultdict(dict), "rooms": collections.defaultdict(dict)}
    for path in sorted(files):
        library = path.split(os.sep)[0]
        for line, other in includes_of(root, path, INSTALLED) if library in MAY_INCLUDE else ():
            out.append(f"{path}:{line}: an installed header: <{other}>; include by the path in the "
                       "repository")
        for line, other in includes_of(root, path):
            if other not in files:
                out.append(f"{path}:{line}: no such file: \"{other}\"; include by the path in the "
                           "repository")
                continue
            target = other.split("/")[0]
            if library not in MAY_INCLUDE:
                continue
            if is_side_door(path, other):
                out.append(f"{path}:{line}: a language by a side door: \"{other}\"; ask its "
                           "ProgramDialect, or name the door in DOORS")
            if target != library:
                if target not in MAY_INCLUDE[library]:
                    out.append(f"{path}:{line}: {library} includes {target}: \"{other}\"; "
                               f"{library} may include " +
                               (", ".join(MAY_INCLUDE[library]) or "no other folder"))
                continue
            for kind, name_of in (("units", unit_of), ("rooms", os.path.dirname)):
                a, b = name_of(path), name_of(other)
                by_kind[kind][a], by_kind[kind][b]  # every node has an entry
                if a != b:
                    by_kind[kind][a].setdefault(b, f"{path}:{line} -> {other}")
    for kind, edges in by_kind.items():
        for way in cycles(edges):
            out.append(f"a cycle of {kind}; move the type that both need to the lower of them:")
            out += ["    " + edges[a][b] for a, b in zip(way, way[1:])]
    return out


class IncludeGraph(unittest.TestCase):
    """What the check finds in small trees."""

    def problems_of(self, tree):
        with tempfile.TemporaryDirectory() as root:
            for path, text in tree.items():
                os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(text)
            return problems(root)

    def test_accepts_one_direction(self):
        self.assertEqual(
            self.problems_of({
                "calib/base/a.h": "#include <vector>\n",
                "calib/base/a.cc": '#include "calib/base/a.h"\n#include "calib/base/b.def"\n',
                "calib/base/b.def": "",
                "vision/fit/c.h": '#include "calib/base/a.h"\n',
            }), [])

    def test_names_an_include_that_is_no_path(self):
        found = self.problems_of({"calib/base/a.h": "", "calib/base/b.cc": '\n#include "a.h"\n'})
        self.assertEqual(len(found), 1)
        self.assertIn('calib/base/b.cc:2: no such file: "a.h"', found[0])

    def test_names_an_installed_header(self):
        found = self.problems_of({"calib/base/a.cc": "\n#include <panelcal/panelcal.h>\n"})
        self.assertEqual(len(found), 1)
        self.assertIn("calib/base/a.cc:2: an installed header: <panelcal/panelcal.h>", found[0])

    def test_finds_nothing_to_be_no_success(self):
        self.assertEqual(len(self.problems_of({"docs/a.md": ""})), 1)

    def test_names_a_folder_that_includes_one_to_its_right(self):
        found = self.problems_of({
            "program/text/a.h": "",
            "vision/fit/b.h": '#include "program/text/a.h"\n',
        })
        self.assertEqual(len(found), 1)
        self.assertIn("vision/fit/b.h:1: vision includes program", found[0])

    def test_names_a_side_door_of_a_language(self):
        tree = {
            "program/excellon/text/a.h": "",
            "program/sieb_meyer/b.cc": '#include "program/excellon/text/a.h"\n',
            "program/dialects.cc": '#include "program/excellon/text/a.h"\n',
            "program/excellon/c.cc": '#include "program/excellon/text/a.h"\n',
            "machine/job/d.cc": '#include "program/excellon/text/a.h"\n',
        }
        found = self.problems_of(tree)
        self.assertEqual(len(found), 2)
        self.assertIn("machine/job/d.cc:1: a language by a side door", found[0])
        self.assertIn("program/sieb_meyer/b.cc:1: a language by a side door", found[1])

    def test_shows_a_cycle_of_units(self):
        found = self.problems_of({
            "calib/base/a.h": "",
            "calib/base/a.cc": '#include "calib/base/b.h"\n',
            "calib/base/b.h": '#include "calib/base/c.h"\n',
            "calib/base/c.h": '#include "calib/base/a.h"\n',
        })
        self.assertEqual(found[1:], [
            "    calib/base/a.cc:1 -> calib/base/b.h",
            "    calib/base/b.h:1 -> calib/base/c.h",
            "    calib/base/c.h:1 -> calib/base/a.h",
        ])

    def test_shows_a_cycle_of_rooms(self):
        found = self.problems_of({
            "calib/low/a.h": "",
            "calib/low/b.h": '#include "calib/high/c.h"\n',
            "calib/high/c.h": "",
            "calib/high/d.h": '#include "calib/low/a.h"\n',
        })
        self.assertEqual(found[1:], [
            "    calib/high/d.h:1 -> calib/low/a.h",
            "    calib/low/b.h:1 -> calib/high/c.h",
        ])


def main():
    if not unittest.main(argv=sys.argv[:1], exit=False, verbosity=0).result.wasSuccessful():
        return 1
    found = problems(sys.argv[1])
    print("\n".join(found) or "no problem in the include graph")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
