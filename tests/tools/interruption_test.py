#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An output appears whole or not at all: killed in the middle, out of disk, or refused."""

import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from demo_job import run

JOB = ("M48\nMETRIC,TZ\nT1C0.8\n%\nT1\nM25\nX1.0Y1.0\nR99X0.5\nM01\nR99M02X0.01Y1.5\nM01\n"
       "R999M02X0.01Y1.5\nM08\nM30\n")
LIMIT_BYTES = 1 << 20


def small_files_only():
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT_BYTES, LIMIT_BYTES))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def main():
    panelcal = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "job.exc").write_text(JOB)
        (folder / "machine.toml").write_text('[machine]\nname = "test"\n')
        output = folder / "out.csv"
        output.write_text("the old one\n")
        command = [panelcal, "run", "job.exc", "-m", "machine.toml", "-o", "out.csv"]

        child = subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 30
        while not list(folder.glob("out.csv.part-*")) and time.monotonic() < deadline:
            time.sleep(0.005)
        child.kill()
        assert child.wait() == -signal.SIGKILL, "the job was over before it could be killed"
        assert output.read_text() == "the old one\n"
        assert list(folder.glob("out.csv.part-*")), "a process that is killed cannot tidy up"

        result = subprocess.run(command, cwd=folder, capture_output=True, text=True,
                                preexec_fn=small_files_only)
        assert result.returncode == 3, result
        assert "device-write" in result.stderr, result.stderr
        assert output.read_text() == "the old one\n"
        assert not list(folder.glob("out.csv.part-*"))

        if os.path.exists("/dev/full"):
            with open("/dev/full", "w") as full:
                result = subprocess.run([*command[:-1], "-", "--to", "csv"], cwd=folder,
                                        stdout=full, stderr=subprocess.PIPE, text=True)
            assert result.returncode == 3 and "device-write" in result.stderr, result
        run(panelcal, "run", "job.exc", "-m", "machine.toml", "-o", "no/such/folder.csv",
            cwd=folder, expect=3)


if __name__ == "__main__":
    main()
