#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `panelcal serve` costs while nothing happens, and how soon a click acts.

    serve_bench.py PANELCAL REPOSITORY [SECONDS [CLOCK_CAMERA]]

With the simulated machine of datasets/demo, and with CLOCK_CAMERA (a target of the build) with a camera of 1280 x 1024
whose pictures show when they were taken, which a Chromium reads where its canvas is drawn. CPU is user + system of the server's process, as a part
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


# When a picture is drawn, and on the screen with the next animation frame: ms since the camera took it.
READ_CLOCK = """
window.late = [];
const draw = CanvasRenderingContext2D.prototype.drawImage, strip = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
let last = 0;
CanvasRenderingContext2D.prototype.drawImage = function(image, ...rest) {
  draw.call(this, image, ...rest);
  if (!image.naturalWidth || this === strip) return;
  const side = image.naturalWidth / 40;
  let taken = 0;
  for (let i = 0; i < 40; ++i) {
    draw.call(strip, image, side * i + side / 4, side / 4, side / 2, side / 2, i, 0, 1, 1);
    taken = 2 * taken + (strip.getImageData(i, 0, 1, 1).data[0] > 127);
  }
  taken += 2 ** 40 * Math.floor(Date.now() / 2 ** 40);
  if (taken === last) return;
  last = taken;
  requestAnimationFrame(() => window.late.push(Date.now() - taken));
};
"""


def start(panelcal, folder, *source):
    process = subprocess.Popen([panelcal, "serve", "-m", "machine.toml", *source, "--address", "127.0.0.1:0"],
                               cwd=folder, stdout=subprocess.PIPE, text=True)
    return process, int(re.search(r":(\d+)/", process.stdout.readline()).group(1))


def end(process):
    process.send_signal(signal.SIGTERM)
    print(f"ended with exit code {process.wait(timeout=30)}")


def late_pictures(port, seconds):
    """How late the pictures of one browser are, ms, in order of size."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "web"))
    import browser
    page = browser.Browser()
    page.resize(1280)
    page.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": READ_CLOCK})
    page.driver.get(f"http://127.0.0.1:{port}/")
    time.sleep(2)
    page.run("window.late.length = 0")
    time.sleep(seconds)
    late = sorted(page.run("return window.late"))
    page.close()
    return late


def pictures_and_load(process, port, seconds):
    screens = [Screen(port, fetches=True) for _ in range(N_SCREENS)]
    time.sleep(2)
    before = sum(screen.pictures for screen in screens)
    percent = load(process, seconds)
    n_pictures = sum(screen.pictures for screen in screens) - before
    print(f"{N_SCREENS} screens, live pictures: {percent:.1f} % of a processor, "
          f"{n_pictures / seconds / N_SCREENS:.1f} pictures/s each")
    for screen in screens:
        screen.link.shutdown(socket.SHUT_RDWR)


def with_camera(panelcal, folder, clock_camera, seconds):
    camera = subprocess.Popen([clock_camera, "127.0.0.1", "1280", "1024"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True)
    assert camera.stdout.readline() == "ready\n"
    machine = Path(folder) / "machine.toml"
    machine.write_text(machine.read_text().replace("[machine]\n", "[machine]\nstage_command = [\"true\", \"{x}\", \"{y}\"]\n", 1))
    process, port = start(panelcal, folder, "--camera", "gige://127.0.0.1")
    late = late_pictures(port, seconds)
    print(f"camera to screen: {len(late) / seconds:.1f} pictures/s, median {statistics.median(late):.0f} ms, "
          f"95 % below {late[int(0.95 * len(late))]:.0f} ms, worst {late[-1]:.0f} ms")
    pictures_and_load(process, port, seconds)
    time.sleep(2)
    print(f"camera, no screen:         {load(process, seconds):.2f} % of a processor")
    end(process)
    camera.stdin.close()
    camera.wait(10)


def main():
    panelcal, demo = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]) / "datasets/demo"
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 20
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(demo, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("images"))
        programs = Path(folder) / "jobs/programs"
        programs.mkdir(parents=True)
        shutil.copy(demo / "panel.exc", programs)
        process, port = start(panelcal, folder, "--machine-driver", "sim")
        time.sleep(1)
        print(f"idle, no screen:           {load(process, seconds):.2f} % of a processor")
        times = clicks(port)
        for name, column in (("answer", 0), ("another screen", 1)):
            values = sorted(time[column] for time in times)
            print(f"click to {name}: median {statistics.median(values):.1f} ms, worst {values[-1]:.1f} ms")
        end(process)
        if len(sys.argv) > 4:
            with_camera(panelcal, folder, str(Path(sys.argv[4]).resolve()), seconds)


if __name__ == "__main__":
    main()
