#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `panelcal serve` costs while nothing happens, and how soon a click acts.

    serve_bench.py PANELCAL REPOSITORY [SECONDS]

With the simulated machine of datasets/demo. CPU is user + system of the server's process, as a part
of one processor, over SECONDS (20): without a screen and with 20 of them that show live pictures.
A click is a command on one connection that stays open: the times from the first byte that is sent to
the answer, and to the new state on another screen.
"""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

N_SCREENS = 20
N_CLICKS = 50


def cpu_s(process):
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def load(process, seconds):
    """Percent of one processor."""
    before, begin = cpu_s(process), time.monotonic()
    time.sleep(seconds)
    return 100 * (cpu_s(process) - before) / (time.monotonic() - begin)


class Screen:
    """Reads a stream of events in a thread, and fetches each picture as the front end does."""

    def __init__(self, port, fetches):
        self.states = 0
        self.changed = threading.Condition()
        self.pictures = 0
        self.link = socket.create_connection(("127.0.0.1", port))
        self.link.sendall(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
        self.fetches = http.client.HTTPConnection("127.0.0.1", port) if fetches else None
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        rest = b""
        while piece := self.link.recv(1 << 20):
            rest += piece
            *events, rest = rest.split(b"\n\n")
            for event in events:
                if b"event: state" in event:
                    with self.changed:
                        self.states += 1
                        self.changed.notify_all()
                elif b"event: frame" in event and self.fetches:
                    self.fetches.request("GET", "/api/frame.jpg")
                    self.fetches.getresponse().read()
                    self.pictures += 1

    def wait_beyond(self, states):
        with self.changed:
            assert self.changed.wait_for(lambda: self.states > states, timeout=10)


def clicks(port):
    """(answer, on another screen) in ms."""
    link = http.client.HTTPConnection("127.0.0.1", port)

    def post(target, body, **headers):
        link.request("POST", target, json.dumps(body), {"Content-Type": "application/json", **headers})
        answer = link.getresponse()
        return answer.status, answer.read()

    link.connect()
    link.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    key = json.loads(post("/api/controls", {"name": "Anna", "take": True})[1])["key"]
    screen = Screen(port, fetches=False)
    screen.wait_beyond(0)
    times = []
    for _ in range(N_CLICKS):
        for body in ({"do": "open", "program": "panel.exc"}, {"do": "close"}):
            time.sleep(0.2)
            seen, begin = screen.states, time.monotonic()
            status, said = post("/api/command", body, **{"X-Panelcal-Controls": key})
            answered = time.monotonic()
            assert status == 200, said
            screen.wait_beyond(seen)
            if body["do"] == "close":
                times.append((1000 * (answered - begin), 1000 * (time.monotonic() - begin)))
    return times


def main():
    panelcal, demo = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]) / "datasets/demo"
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 20
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(demo, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("images"))
        programs = Path(folder) / "jobs/programs"
        programs.mkdir(parents=True)
        shutil.copy(demo / "panel.exc", programs)
        process = subprocess.Popen([panelcal, "serve", "-m", "machine.toml", "--machine-driver", "sim",
                                    "--address", "127.0.0.1:0"], cwd=folder, stdout=subprocess.PIPE, text=True)
        port = int(re.search(r":(\d+)/", process.stdout.readline()).group(1))
        time.sleep(1)
        print(f"idle, no screen:           {load(process, seconds):.2f} % of a processor")
        times = clicks(port)
        for name, column in (("answer", 0), ("on another screen", 1)):
            values = sorted(time[column] for time in times)
            print(f"click to {name}: median {statistics.median(values):.1f} ms, worst {values[-1]:.1f} ms")
        screens = [Screen(port, fetches=True) for _ in range(N_SCREENS)]
        time.sleep(1)
        before = sum(screen.pictures for screen in screens)
        percent = load(process, seconds)
        n_pictures = sum(screen.pictures for screen in screens) - before
        print(f"{N_SCREENS} screens, live pictures: {percent:.1f} % of a processor, "
              f"{n_pictures / seconds / N_SCREENS:.1f} pictures/s each")
        process.send_signal(signal.SIGTERM)
        print(f"ended with exit code {process.wait(timeout=30)}")


if __name__ == "__main__":
    main()
