#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The runner of the cases finds every kind of difference, and --update takes none without a yes.

    run_golden_test.py
"""
import os
import pty
import random
import subprocess
import sys
import tempfile
from pathlib import Path

from golden_case import CaseError, escape, is_plain, parse, text_of, unescape
from golden_compare import shortened
from golden_wording import template

RUNNER = Path(__file__).resolve().parent / "run_golden.py"
# Does what its input files say.
FAKE = """#!/bin/sh
cat say.err >&2
cat say.out
cp say.file out.txt
exit 2
"""
CASE = """# A program that does what it is told.
command: panelcal check 'a b' < say.out
exit: 2
absent: other.txt

--- in say.err ---
p.exc:3:4: error[gate-failed]: offset is 2.000 mm, limit 1.500 mm
p.exc:9: warning[tool-unused]: the tool has no hole
--- in say.file ---
line one
--- in say.out ---
all said
--- err ---
p.exc:3:4: error[gate-failed] ... 2.000 mm
p.exc:9: warning[tool-unused]: the tool has no hole
--- out ---
all said
--- file out.txt ---
line one
"""


def write(text):
    Path("a.case").write_text(text)


def check():
    done = subprocess.run([sys.executable, "-I", "-S", RUNNER, "./panelcal", "a.case"],
                          capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout + done.stderr


def finds(old, new, *said):
    """A case in which old is replaced fails, and the runner says why."""
    assert old in CASE
    write(CASE.replace(old, new))
    code, output = check()
    assert code == 1 and all(words in output for words in said), (new, code, output)


def answers(answer):
    """Runs --update on a terminal whose person types the answer."""
    child, terminal = pty.fork()
    if not child:
        os.execv(sys.executable, [sys.executable, str(RUNNER), "./panelcal", "--update", "a.case"])
    os.write(terminal, answer.encode() + b"\n")
    output = b""
    try:
        while data := os.read(terminal, 4096):
            output += data
    except OSError:  # The terminal's end.
        pass
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), output.decode()


def refuses(text):
    try:
        parse("a.case", text.encode())
    except CaseError:
        return
    raise AssertionError(f"accepted: {text!r}")


def sections_hold_any_bytes():
    for data in (b"", b"\n", b"a", b"a\r\nb\n", b"a\rb\r", b"\r\0\n", b"--- err ---\n", b"\\n\\\n",
                 b"\xff\xfe\n", "\u00b5m\n".encode(), b"a\r\n"):
        assert unescape(escape(data)) == data, data
        case = parse("a.case", CASE.encode())
        case.inputs["x"] = data
        assert parse("a.case", text_of(case)).inputs["x"] == data, data
    dice = random.Random(7)
    for _ in range(2000):
        data = bytes(dice.choice(b"\\\r\n\0x-a \xff") for _ in range(dice.randrange(12)))
        assert unescape(escape(data)) == data, data
        assert is_plain(escape(data)), data


def broken_cases_are_refused():
    assert text_of(parse("a.case", CASE.encode())).decode() == CASE
    refuses(CASE.replace("# A program that does what it is told.\n", ""))
    refuses(CASE.replace("exit: 2\n", ""))
    refuses(CASE.replace("exit: 2", "exits: 2"))
    refuses(CASE.replace("--- out ---", "--- stdout ---"))
    refuses(CASE.replace("--- out ---", "--- err ---"))
    refuses(CASE.replace("--- out ---", "--- out, quoted ---"))
    refuses(CASE.replace("line one", "line one\r"))
    refuses(CASE.replace("--- out ---\nall", "--- out, escaped ---\n\\all"))
    refuses(CASE.rstrip("\n"))


def differences_are_found():
    write(CASE)
    assert check() == (0, ""), check()
    finds("exit: 2", "exit: 0", "-0", "+2")
    finds("--- out ---\nall said", "--- out ---\nall sad", "-all sad", "+all said")
    finds("out.txt ---\nline one", "out.txt ---\nline two", "-line two", "+line one")
    finds("--- file out.txt ---\nline one\n", "", "out.txt was written")
    finds("--- file out.txt ---", "--- file b.txt ---", "b.txt was not written")
    finds("absent: other.txt", "absent: out.txt", "out.txt must not exist")
    finds("p.exc:3:4: error[gate-failed] ...", "p.exc:3:5: error[gate-failed] ...", "+p.exc:3:4")
    finds("error[gate-failed] ...", "warning[gate-failed] ...", "+p.exc:3:4")
    finds("[gate-failed] ... 2.000 mm", "[gate-faile] ... 2.000 mm", "+p.exc:3:4")
    finds("... 2.000 mm", "... 2.001 mm", "2.001 mm", "+p.exc:3:4")
    finds("err ---\np.exc:3:4: error[gate-failed] ... 2.000 mm\n", "err ---\n", "+p.exc:3:4")
    finds("the tool has no hole\n--- out", "the tool has a hole\n--- out", "-p.exc:9")
    finds("absent: other.txt", "use: no/such.toml", "no/such.toml")


def short_lines_are_found_behind_whole_ones():
    expected = "p: error[a]: one\np: error[a]\n"
    assert shortened(expected, "p: error[a]: one\np: error[a]: two\n") == expected
    assert shortened(expected, "p: error[a]: two\np: error[a]: one\n") != expected
    assert shortened("p: error[a]\n", "p: error[ab]: x\n") == "p: error[ab]: x\n"


def update_asks():
    wrong = CASE.replace("exit: 2", "exit: 0").replace("out.txt ---\nline one", "out.txt ---\nold")
    write(wrong)
    blind = subprocess.run([sys.executable, RUNNER, "./panelcal", "--update", "a.case"],
                           stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert blind.returncode == 1 and "no terminal" in blind.stderr, blind
    code, output = answers("n")
    assert code == 1 and "-old" in output and Path("a.case").read_text() == wrong, output
    code, output = answers("y")
    assert code == 0 and "+line one" in output, output
    assert Path("a.case").read_text() == CASE  # The short line stayed short.
    assert "no difference" in answers("n")[1]


def wordings_are_told_apart():
    same = template('rotate in [vision] is 7, expected one of "a", "b" or "c"')
    assert same == template('row_count in [sim.camera] is -1.5e3, expected one of "d" or "e"'), same
    assert same != template('rotate in [vision] is 7, expected "a"')


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("panelcal").write_text(FAKE)
        Path("panelcal").chmod(0o755)
        sections_hold_any_bytes()
        broken_cases_are_refused()
        differences_are_found()
        short_lines_are_found_behind_whole_ones()
        update_asks()
        wordings_are_told_apart()
