#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs one case folder against a panelcal binary; README.md here says what a case consists of.

    run_golden.py PANELCAL CASE_DIR [--update]
"""
import difflib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

GOLDEN = Path(__file__).resolve().parent
REPOSITORY = GOLDEN.parent.parent
NOT_INPUT = {"command", "setup.py", "absent", "README.md"}
TIMEOUT_S = 60
# The version is no part of what a case pins.
VERSION = re.compile(rb"(made[ _]by\"?: ?\"?panelcal )\d[\w.+-]*")


def is_input(name):
    return name not in NOT_INPUT and not name.startswith("expected.")


def snapshot(folder):
    """Every file below a folder, by name relative to it."""
    return {str(path.relative_to(folder)): VERSION.sub(rb"\1VERSION", path.read_bytes())
            for path in sorted(folder.rglob("*")) if path.is_file()}


def prepare(case, work):
    for entry in sorted(case.iterdir()):
        if not is_input(entry.name):
            continue
        if entry.is_dir():
            shutil.copytree(entry, work / entry.name)
        else:
            shutil.copy(entry, work / entry.name)
    if (case / "setup.py").exists():
        environment = dict(os.environ, PYTHONPATH=str(GOLDEN), PYTHONDONTWRITEBYTECODE="1")
        subprocess.run([sys.executable, str(case / "setup.py")], cwd=work, env=environment,
                       check=True, timeout=TIMEOUT_S)


def run(panelcal, case, work):
    line = (case / "command").read_text().strip()
    if "{demo}" in line:
        shutil.copytree(REPOSITORY / "datasets" / "demo", work / "demo")
        line = line.replace("{demo}", "demo")
    words = shlex.split(line)
    if words[:1] != ["panelcal"]:
        sys.exit(f"{case}/command: must begin with panelcal")
    stdin = subprocess.DEVNULL
    if "<" in words:
        at = words.index("<")
        stdin = open(work / words[at + 1], "rb")
        del words[at:at + 2]
    before = snapshot(work)
    # Called `panelcal` whatever the path is, since outputs quote the command line.
    done = subprocess.run(words, executable=str(Path(panelcal).resolve()), cwd=work, stdin=stdin,
                          capture_output=True, timeout=TIMEOUT_S,
                          env=dict(os.environ, LC_ALL="C", TZ="UTC"))
    written = {name: data for name, data in snapshot(work).items() if before.get(name) != data}
    lost = sorted(before.keys() - snapshot(work).keys())
    return done, written, lost


def expected_files(case):
    folder = case / "expected.files"
    return snapshot(folder) if folder.is_dir() else {}


def read(path):
    return path.read_bytes() if path.exists() else b""


def differences(case, done, written, lost):
    """Pairs of a name and a text that says what is different."""
    found = []

    def compare(name, expected, actual):
        if expected == actual:
            return
        lines = [data.decode("utf-8", "backslashreplace").splitlines(keepends=True)
                 for data in (expected, actual)]
        diff = "".join(line if line.endswith("\n") else line + "\n" for line in
                       difflib.unified_diff(*lines, f"expected {name}", f"actual {name}"))
        found.append(diff or f"{name} differs in its line ends\n")

    compare("exit", read(case / "expected.exit"), b"%d\n" % done.returncode)
    compare("err", read(case / "expected.err"), done.stderr)
    compare("out", read(case / "expected.out"), done.stdout)
    files = expected_files(case)
    for name in sorted(files.keys() | written.keys()):
        if name not in written:
            found.append(f"{name} was not written\n")
        elif ".part-" in name:
            found.append(f"{name} was left behind\n")
        elif name not in files:
            found.append(f"{name} was written, which no expected.files/{name} asks for\n")
        else:
            compare(name, files[name], written[name])
    for name in read(case / "absent").decode().split():
        if name in written:
            found.append(f"{name} must not exist\n")
    found.extend(f"{name} was removed\n" for name in lost)
    return found


def update(case, done, written):
    (case / "expected.exit").write_text(f"{done.returncode}\n")
    (case / "expected.err").write_bytes(done.stderr)
    (case / "expected.out").unlink(missing_ok=True)
    if done.stdout:
        (case / "expected.out").write_bytes(done.stdout)
    shutil.rmtree(case / "expected.files", ignore_errors=True)
    for name, data in written.items():
        path = case / "expected.files" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def main(arguments):
    wants_update = "--update" in arguments
    arguments = [argument for argument in arguments if argument != "--update"]
    if len(arguments) != 2:
        sys.exit(__doc__)
    panelcal, case = arguments[0], Path(arguments[1]).resolve()
    if not (case / "README.md").exists():
        sys.exit(f"{case}: no README.md says what the case pins")
    with tempfile.TemporaryDirectory(prefix="panelcal-golden-") as folder:
        work = Path(folder)
        prepare(case, work)
        done, written, lost = run(panelcal, case, work)
    if wants_update:
        update(case, done, written)
        return 0
    found = differences(case, done, written, lost)
    for text in found:
        print(text, end="")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
