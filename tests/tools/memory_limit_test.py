#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Under any limit of memory a command ends as it always does, or says that memory does not suffice.

    memory_limit_test.py PANELCAL ROOT
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

MIB = 2**20
N_HOLES = 300_000
OUT_OF_MEMORY = 3


def program():
    holes = "".join(f"X{i % 1000 * 0.1 + 0.1:.1f}Y{i // 1000 * 0.1 + 0.1:.1f}\n" for i in range(N_HOLES))
    return "M48\nMETRIC,LZ\nT1C0.1\n%\nT1\n" + holes + "M30\n"


def limited(command, folder, limit_mib):
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (limit_mib * MIB, limit_mib * MIB))

    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False,
                          preexec_fn=limit)


def least_to_start(panelcal, folder):
    """MiB with which the program itself can be loaded."""
    for limit_mib in range(8, 1024, 4):
        if limited([panelcal, "--version"], folder, limit_mib).returncode == 0:
            return limit_mib
    sys.exit("panelcal --version does not run in 1 GiB")


def outcomes(command, folder, output, limits_mib):
    """(limits refused, limits served); what is served has the bytes of an unlimited run."""
    subprocess.run(command, cwd=folder, capture_output=True, check=True)
    whole = (folder / output).read_bytes()
    n_refused = n_served = 0
    for limit_mib in limits_mib:
        (folder / output).unlink(missing_ok=True)
        run = limited(command, folder, limit_mib)
        about = f"{' '.join(command[1:])} in {limit_mib} MiB: exit {run.returncode}\n{run.stderr}"
        if run.returncode == 0:
            n_served += 1
            assert (folder / output).read_bytes() == whole, about
            continue
        n_refused += 1
        assert run.returncode == OUT_OF_MEMORY, about
        assert f"error[out-of-memory]: memory does not suffice: {limit_mib} MiB by ulimit -v" in run.stderr, about
        assert not (folder / output).exists(), about
        assert not list(folder.glob("*.part-*")), about
    print(f"{command[1]}: {n_refused} limits refused, {n_served} served")
    return n_refused, n_served


def main():
    panelcal, root = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "large.exc").write_text(program())
        (folder / "machine.toml").write_text("")
        least = least_to_start(panelcal, folder)
        run = [panelcal, "run", "large.exc", "-m", "machine.toml", "-o", "out.csv"]
        n_refused, n_served = outcomes(run, folder, "out.csv", range(least, least + 16))
        assert n_refused > 0 and n_served > 0, f"limits from {least} MiB do not tell anything"

        demo = Path(root).resolve() / "datasets/demo"
        locate = [panelcal, "run", str(demo / "panel.exc"), "-m", str(demo / "machine.toml"),
                  "--images", str(demo / "images"), "--threads", "2", "-o", "out.csv"]
        outcomes(locate, folder, "out.csv", range(least, least + 400, 20))


if __name__ == "__main__":
    main()
