# SPDX-License-Identifier: Apache-2.0
"""A PostgreSQL server in a folder, on a socket of that folder; nothing of the system is used or changed."""
import glob
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

USER = "tester"
# No power is cut here: the tests end what they end by signals.
OPTIONS = "-c listen_addresses='' -c fsync=off -c synchronous_commit=off -c full_page_writes=off"


def programs_folder():
    """Where Debian has the server's programs, which are in no PATH; empty: not installed."""
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"))
    return str(Path(found[-1]).parent) if found and shutil.which("psql") else ""


def as_server_user():
    """Its programs refuse to run as root."""
    return ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"] if os.geteuid() == 0 else []


class Server:
    def __init__(self):
        # Short: a socket's path has at most 107 characters.
        self.folder = Path(tempfile.mkdtemp(prefix="pg", dir="/tmp"))
        if os.geteuid() == 0:
            shutil.chown(self.folder, "postgres")
        self.call("initdb", "-D", self.data, "-U", USER, "-A", "trust", "--no-sync", "--locale=C.UTF-8", "-E", "UTF8")
        self.start()
        self.call("createdb", "-h", self.folder, "-U", USER, "drill")

    @property
    def data(self):
        return self.folder / "data"

    @property
    def address(self):
        return f"postgresql://{USER}@/drill?host={self.folder}"

    def call(self, program, *words):
        done = subprocess.run([*as_server_user(), f"{programs_folder()}/{program}", *map(str, words)], cwd="/",
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def control(self, *words):
        # The server keeps what it inherits open: no pipe of the test's may be among it.
        subprocess.run([*as_server_user(), f"{programs_folder()}/pg_ctl", "-D", str(self.data), "-w", "-s", *words], cwd="/", check=True,
                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def start(self):
        self.control("-o", f"{OPTIONS} -k {self.folder}", "-l", str(self.folder / "log"), "start")

    def stop(self):
        """As a power cut ends it."""
        self.control("-m", "immediate", "stop")

    def close(self):
        self.stop()
        shutil.rmtree(self.folder)

    def ask(self, sql):
        """Rows as dictionaries."""
        done = subprocess.run(["psql", "-XAtq", "-v", "ON_ERROR_STOP=1", "-h", str(self.folder), "-U", USER, "drill", "-c",
                               f"SELECT coalesce(json_agg(row), '[]') FROM ({sql}) AS row"],
                              capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def run(self, sql):
        subprocess.run(["psql", "-Xq", "-h", str(self.folder), "-U", USER, "drill", "-c", sql], capture_output=True, check=False)
