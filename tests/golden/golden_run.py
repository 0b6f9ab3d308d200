# SPDX-License-Identifier: Apache-2.0
"""Runs the command of a case in a folder of its own.

Spawns and reads by hand, since subprocess, tempfile, shlex and re take longer to import than most
cases take to run.
"""
import os
import sys

from golden_case import GOLDEN, all_inputs

REPOSITORY = os.path.dirname(os.path.dirname(GOLDEN))
# What Python ignores and a child must not: SIGPIPE and SIGXFSZ.
DEFAULT_SIGNALS = (13, 25)


class Outcome:
    """What a run did: exit, err, out (bytes), written (name -> bytes), lost, made (names)."""

    def __init__(self, code, err, out, written, lost, made):
        self.exit, self.err, self.out = code, err, out
        self.written, self.lost, self.made = written, lost, made


def without_version(data):
    """The version is no part of what a case pins."""
    if b"panelcal " not in data:
        return data
    import re
    data = re.sub(rb'(^|\n)(\{"facts":"\w+","version":\d+,"panelcal":")\d[^"]*', rb"\1\2VERSION", data)
    return re.sub(rb"(made[ _]by\"?: ?\"?panelcal )\d[\w.+-]*", rb"\1VERSION", data)


def names_below(folder):
    """Every file below a folder, by name relative to it."""
    return sorted(os.path.relpath(os.path.join(parent, name), folder)
                  for parent, _, names in os.walk(folder) for name in names)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def write(path, data):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "wb") as file:
        file.write(data)


def snapshot():
    """Content of every file of the current folder, by name."""
    return {name: without_version(read(name)) for name in names_below(".") if os.path.isfile(name)}


def prepare(case):
    """Fills the current folder: inputs, what the case's setup.py makes, the demo's files."""
    for name, data in all_inputs(case).items():
        write(name, data)
    if case.setup:
        setup = {"__name__": "__main__"}
        exec(compile(case.setup, f"{case.path}: setup.py", "exec"), setup)
        setup.clear()  # Databases that it left open are closed.
    if "{demo}" in case.command:
        demo = os.path.join(REPOSITORY, "datasets", "demo")
        for name in names_below(demo):
            write(os.path.join("demo", name), read(os.path.join(demo, name)))


def words_of(case):
    """The words of the command, and the file on standard input."""
    command = case.command.replace("{demo}", "demo")
    if any(char in command for char in "'\"\\"):
        import shlex
        words = shlex.split(command)
    else:
        words = command.split()
    if words[:1] != ["panelcal"]:
        sys.exit(f"{case.path}: the command must begin with panelcal")
    if "<" not in words:
        return words, os.devnull
    at = words.index("<")
    return words[:at] + words[at + 2:], words[at + 1]


def execute(panelcal, words, stdin, err_path):
    """Exit code, standard output and standard error of a command, which runs in this folder."""
    reading, writing = os.pipe()
    # Called `panelcal` whatever the path is, since outputs quote the command line.
    child = os.posix_spawn(
        panelcal, words, dict(os.environ, LC_ALL="C", TZ="UTC"), setsigdef=DEFAULT_SIGNALS,
        file_actions=[
            (os.POSIX_SPAWN_OPEN, 0, stdin, os.O_RDONLY, 0),
            (os.POSIX_SPAWN_DUP2, writing, 1),
            (os.POSIX_SPAWN_OPEN, 2, err_path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)])
    os.close(writing)
    with open(reading, "rb") as pipe:
        out = pipe.read()
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), without_version(out), read(err_path)


def make_folder():
    parent = os.environ.get("TMPDIR", "/tmp")
    number = 0
    while True:
        folder = os.path.join(parent, f"panelcal-golden-{os.getpid()}-{number}")
        try:
            os.mkdir(folder, 0o700)
            return folder
        except FileExistsError:
            number += 1


def remove_folder(folder):
    for parent, folders, names in os.walk(folder, topdown=False):
        for name in names:
            os.unlink(os.path.join(parent, name))
        for name in folders:
            path = os.path.join(parent, name)
            os.unlink(path) if os.path.islink(path) else os.rmdir(path)
    os.rmdir(folder)


def run(panelcal, case):
    """The outcome of the case with this binary."""
    panelcal = os.path.abspath(panelcal)
    back = os.getcwd()
    folder = make_folder()
    try:
        os.mkdir(os.path.join(folder, "run"))
        os.chdir(os.path.join(folder, "run"))
        words, stdin = words_of(case)
        prepare(case)
        before = snapshot()
        code, out, err = execute(panelcal, words, stdin, os.path.join(folder, "err"))
        after = snapshot()
        written = {name: data for name, data in after.items() if before.get(name) != data}
        made = [name for name in case.absent if os.path.lexists(name)]
        return Outcome(code, err, out, written, sorted(before.keys() - after.keys()), made)
    finally:
        os.chdir(back)
        remove_folder(folder)
