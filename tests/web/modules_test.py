#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The modules of web/ can be joined to one script, and all of it is theirs.

    modules_test.py REPOSITORY
"""
import re
import sys
import unittest
from pathlib import Path

ROOT = Path(sys.argv.pop())
WEB = ROOT / "web"
NAME = re.compile(r"^(?:export )?(?:async )?(?:function\*?|const|let|class) (?:(\w+)|\{([^}]*)\})", re.MULTILINE)
IMPORT = re.compile(r'^import [^;]*from "([^"]*)";', re.MULTILINE)
# Code and style, with the operator's screen; it only falls, but for a page of its own (that of batches, 126; of machines, 24; of certificates, 156). The goal is 4,000.
MAX_LINES = 6136
# A table of texts in two languages; its few functions count with it.
WORDS = "base/words.js"
# Keys that facts name, whose words may be those of another thing.
NAMED_BY_FACTS = re.compile(r"(night_state|history_verdict|model|gate|surface_source|height|status|verdict|colour|cause|source|common"
                            r"|chi_square|calibration_(?:row|list|verdict)|plan_reason|limit|targets?|serve_(?:by|kind|job|run|way|choice|light))_")
FORBIDDEN = ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "new Function", "fetch(",
             "XMLHttpRequest", "DOMParser", "javascript:"]


# The one module that speaks to a server.
CONNECTION = "serve/connection.js"


def bundles():
    """The lists of modules that make a script each: the reports' and the operator's screen's."""
    return [listed.split() for listed in re.findall(r"set\(PANELCAL_\w+_MODULES\s+([^)]*)\)", (WEB / "modules.cmake").read_text())]


def modules():
    return list(dict.fromkeys(name for bundle in bundles() for name in bundle))


def read(name):
    return (WEB / name).read_text(encoding="utf-8")


class Modules(unittest.TestCase):
    def test_all_are_in_the_list(self):
        files = {str(path.relative_to(WEB)) for path in WEB.rglob("*.js")}
        self.assertEqual(files, set(modules()))
        self.assertEqual(len(bundles()), 2)
        for bundle in bundles():
            self.assertEqual(len(bundle), len(set(bundle)))

    def test_top_level_names_are_unique(self):
        for bundle in bundles():
            owner = {}
            for module in bundle:
                for one, several in NAME.findall(read(module)):
                    for name in filter(None, [one, *re.split(r"[\s,]+", several)]):
                        self.assertNotIn(name, owner, f"{name} of {module} is also in {owner.get(name)}")
                        owner[name] = module

    def test_imports_stand_before_who_needs_them(self):
        for bundle in bundles():
            self.check_imports(bundle)

    def check_imports(self, bundle):
        seen = set()
        for module in bundle:
            for target in IMPORT.findall(read(module)):
                path = str(((WEB / module).parent / target).resolve().relative_to(WEB.resolve()))
                self.assertIn(path, seen, f"{module} imports {path}, which is not listed before it")
            self.assertNotRegex(IMPORT.sub("", read(module)), r"(?m)^(import|export (default|\{|\*))")
            # Joined modules have no names of their own: `import {a as b}` would be lost.
            self.assertNotRegex(read(module), r"(?m)^import [^;]* as ")
            seen.add(module)

    def test_no_text_becomes_markup_and_nothing_is_loaded(self):
        for module in modules():
            for word in FORBIDDEN:
                if (word, module) != ("fetch(", CONNECTION):
                    self.assertNotIn(word, read(module), module)

    def test_every_word_has_both_languages(self):
        text = read("base/words.js")
        body = text[text.index("const words = {"):text.index("\n};")]
        rows = re.findall(r'^  (\w+): \[\s*("(?:[^"\\]|\\.)*"),\s*("(?:[^"\\]|\\.)*"),?\s*\],', body, re.MULTILINE)
        self.assertEqual(len(rows), len(re.findall(r"^  \w+:", body, re.MULTILINE)), "a row is not [English, German]")
        names = [key for key, _, _ in rows]
        self.assertEqual(len(names), len(set(names)))
        for key, english, german in rows:
            with self.subTest(key=key):
                self.assertTrue(len(english) > 2 and len(german) > 2)
                self.assertEqual(sorted(re.findall(r"\{\w+\}", english)), sorted(re.findall(r"\{\w+\}", german)))

    def test_no_two_words_say_the_same(self):
        text = read(WORDS)
        rows = re.findall(r'^  (\w+): (\[\s*"(?:[^"\\]|\\.)*",\s*"(?:[^"\\]|\\.)*")', text, re.MULTILINE)
        owner = {}
        for key, said in rows:
            if NAMED_BY_FACTS.match(key):
                continue
            said = re.sub(r"\s+", " ", said)
            self.assertEqual(owner.setdefault(said, key), key, said)

    def test_one_german_word_for_one_thing(self):
        text = read(WORDS)
        for word in ("Restfehler", "Streckung", "Passermarke", "Zielmarke", "Loch ", "Löcher", "Platte ", "quadrat. Mittel"):
            self.assertNotIn(word, text)

    def test_every_word_is_used(self):
        text = read("base/words.js")
        keys = re.findall(r"^  (\w+): \[", text, re.MULTILINE)
        rest = "".join(read(module) for module in modules() if module != "base/words.js")
        prefixes = re.findall(r'wordOf\(\s*"(\w+)"', rest) + re.findall(r"word\(`(\w+)_\$\{", rest)
        unused = [key for key in keys if f'"{key}"' not in rest and not any(key.startswith(p + "_") for p in prefixes)]
        self.assertEqual(unused, [])

    def test_front_end_stays_small(self):
        lines = sum(len(path.read_text(encoding="utf-8").splitlines())
                    for path in [*WEB.rglob("*.js"), *WEB.rglob("*.css")] if path != WEB / WORDS)
        self.assertLessEqual(lines, MAX_LINES)


if __name__ == "__main__":
    unittest.main()
