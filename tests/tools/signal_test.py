#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A signal ends what moves first, then the command: nothing is written, the exit code names it.

    signal_test.py PANELCAL ROOT
"""

import json
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Stands for a machine: it says that it moves, halts when it is asked to, and else takes a minute.
STAGE = """#!/usr/bin/env python3
import pathlib, signal, sys, time
here = pathlib.Path(sys.argv[0]).parent
def halt(number, frame):
    (here / "halted").write_text("by SIGTERM")
    sys.exit(1)
signal.signal(signal.SIGTERM, halt)
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGHUP, signal.SIG_IGN)
(here / "moves").write_text("")
time.sleep(60)
"""
# A machine that takes some time to come to rest.
SLOW = STAGE.replace("def halt(number, frame):\n", "def halt(number, frame):\n    time.sleep(0.4)\n")
# A shell neither passes signals on nor waits for what it runs once it is ended.
WRAPPER = """#!/bin/sh
./stage.py "$@"
exit $?
"""
# It halts only when it is made to.
STUBBORN = """#!/usr/bin/env python3
import os, pathlib, signal, time
for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)
pathlib.Path("moves.part").write_text(str(os.getpid()))
pathlib.Path("moves.part").rename("moves")
time.sleep(60)
"""
# How long a test waits for what takes milliseconds.
PATIENCE_S = 30
# A stage has a second to halt, of which a busy machine may leave it nothing. What never halts in
# time fails as often as it is asked.
TRIES = 5


def wait_for(path, child):
    deadline = time.monotonic() + PATIENCE_S
    while not path.exists():
        assert child.poll() is None, f"ended before {path.name}: {child.communicate()}"
        assert time.monotonic() < deadline, f"no {path.name}"
        time.sleep(0.01)


def interrupted(command, folder, number):
    """(exit code, standard error) of a command that gets a signal while its stage moves."""
    for name in ("moves", "halted"):
        (folder / name).unlink(missing_ok=True)
    began = time.monotonic()
    child = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             text=True)
    wait_for(folder / "moves", child)
    child.send_signal(number)
    _, error = child.communicate(timeout=PATIENCE_S)
    assert time.monotonic() - began < 60, "the stage was waited for"
    assert (folder / "halted").exists(), f"the stage was not halted: {error}"
    return child.returncode, error


def asked_again(check, *arguments):
    for attempt in range(TRIES):
        try:
            return check(*arguments)
        except AssertionError as error:
            print(f"attempt {attempt + 1} of {TRIES}: {error}", file=sys.stderr)
            if attempt + 1 == TRIES:
                raise


def is_alive(process):
    """Whether it runs; a zombie that waits for its parent does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


def write_stage(folder, wrapper, stage):
    for name, text in (("wrapper.sh", wrapper), ("stage.py", stage)):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)


def check_stubborn(command, folder, second):
    """A stage that ignores signals, behind a wrapper, is ended; at once by a second signal."""
    (folder / "moves").unlink(missing_ok=True)
    child = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             text=True)
    wait_for(folder / "moves", child)
    stage = int((folder / "moves").read_text())
    assert is_alive(stage)
    child.send_signal(signal.SIGTERM)
    if second:
        time.sleep(0.7)
        child.send_signal(second)
    _, error = child.communicate(timeout=PATIENCE_S)
    assert not is_alive(stage), f"the stage moves on: {error}"
    number = signal.SIGTERM if second != signal.SIGINT else signal.SIGINT
    assert child.returncode == 128 + number, (child.returncode, error)
    assert "error[interrupted]" in error, error


def check_relayed(command, folder):
    """Two signals at once are one, as `timeout` sends them: the stage has its time to halt."""
    for name in ("moves", "halted"):
        (folder / name).unlink(missing_ok=True)
    child = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             text=True)
    wait_for(folder / "moves", child)
    child.send_signal(signal.SIGTERM)
    time.sleep(0.02)
    child.send_signal(signal.SIGTERM)
    _, error = child.communicate(timeout=PATIENCE_S)
    assert child.returncode == 128 + signal.SIGTERM, (child.returncode, error)
    assert (folder / "halted").exists(), f"the stage was killed before it had halted: {error}"


def check_time_limit(panelcal, folder):
    """Past command_limit_s what the wrapper runs is ended as well."""
    (folder / "moves").unlink(missing_ok=True)
    text = (folder / "machine.toml").read_text()
    (folder / "limit.toml").write_text(
        text.replace("[machine]\n", "[machine]\ncommand_limit_s = 3\n"))
    done = subprocess.run([panelcal, "run", "panel.exc", "-m", "limit.toml", "--camera",
                           "folder:images", "-o", "out.drl"], cwd=folder, capture_output=True,
                          text=True, timeout=PATIENCE_S)
    assert done.returncode == 3 and "did not end within 3 s" in done.stderr, done
    assert not is_alive(int((folder / "moves").read_text())), "the stage moves on"


def check_wrapper(panelcal, command, folder):
    config = folder / "machine.toml"
    config.write_text(config.read_text().replace("./stage.py", "./wrapper.sh"))
    write_stage(folder, WRAPPER, STAGE)
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        code, error = asked_again(interrupted, command, folder, number)
        assert code == 128 + number, f"exit {code} after {number.name}: {error}"
    write_stage(folder, WRAPPER, SLOW)
    asked_again(check_relayed, command, folder)
    write_stage(folder, WRAPPER, STUBBORN)
    for second in (None, signal.SIGTERM, signal.SIGINT):
        asked_again(check_stubborn, command, folder, second)
    check_time_limit(panelcal, folder)


def prepare(folder, root):
    demo = Path(root) / "datasets/demo"
    for name in ("panel.exc", "board.drl", "camera.cal.json"):
        shutil.copy(demo / name, folder)
    shutil.copytree(demo / "images", folder / "images")
    config = (demo / "machine.toml").read_text()
    assert config.count("[machine]\n") == 1
    config = config.replace("[machine]\n", '[machine]\nstage_command = ["./stage.py", "{x}", "{y}"]\n')
    (folder / "machine.toml").write_text(config)


def prepare_night(folder, root):
    """A night that begins with a hole to drill, by the same program."""
    config = (Path(root) / "tests/golden/fixtures/night/machine.toml").read_text()
    for old, new in (("[machine]\n", '[machine]\nstage_command = ["./stage.py", "{x}", "{y}"]\n'
                                     'drill_command = ["./stage.py", "{tool}"]\n'),
                     ('machine_driver = "sim"', 'camera = "folder:images"')):
        assert config.count(old) == 1, old
        config = config.replace(old, new)
    (folder / "night.toml").write_text(config[:config.index("[sim]")])


def check_night(panelcal, folder):
    command = [panelcal, "nightly", "-m", "night.toml", "--clock", "2026-11-20T23:00:00Z"]
    code, error = asked_again(interrupted, command, folder, signal.SIGTERM)
    assert code == 128 + signal.SIGTERM, f"exit {code}: {error}"
    record = json.loads((folder / "reports/2026-11-20.json").read_text())
    assert not record["may_drill"], record
    assert "interrupted: SIGTERM" in json.dumps(record), record
    assert "interrupted" in (folder / "reports/2026-11-20.html").read_text()


def main():
    panelcal, root = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        stage = folder / "stage.py"
        stage.write_text(STAGE)
        stage.chmod(0o755)
        prepare(folder, root)
        output = folder / "out.drl"
        output.write_text("the old one\n")
        command = [panelcal, "run", "panel.exc", "-m", "machine.toml", "--camera", "folder:images",
                   "-o", "out.drl"]
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            code, error = asked_again(interrupted, command, folder, number)
            assert code == 128 + number, f"exit {code} after {number.name}: {error}"
            assert f"error[interrupted]: ended by a signal: {number.name}" in error, error
            assert output.read_text() == "the old one\n"
            assert not list(folder.glob("*.part-*"))
        prepare_night(folder, root)
        check_night(panelcal, folder)
        check_wrapper(panelcal, command, folder)
        assert output.read_text() == "the old one\n"


if __name__ == "__main__":
    main()
