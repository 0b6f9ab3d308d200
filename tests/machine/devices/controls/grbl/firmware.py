# SPDX-License-Identifier: Apache-2.0
"""GRBL firmware that runs as a program, behind a TCP port or a serial device that a test owns.

Needs the programs grblhal_sim and grbl_sim (GPL-3, not part of this project) in a folder.
"""
import os
import pty
import re
import select
import socket
import subprocess
import threading
import time
import tty

RATE_MM_MIN = 6000
ACCELERATION_MM_S2 = 1000


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Firmware:
    """One firmware, "grblhal" or "grbl"; bytes go in by send() and come out by receive()."""

    def __init__(self, kind, programs, folder):
        self.is_hal = kind == "grblhal"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
        if self.is_hal:
            port = free_port()
            self.process = subprocess.Popen(
                [f"{programs}/grblhal_sim", "-n", "-p", str(port), "-t", "1", "-e", "eeprom"],
                stdin=subprocess.PIPE, **quiet)
            self.socket = connected(port)
            self.fd = self.socket.fileno()
        else:
            self.fd, device = pty.openpty()
            tty.setraw(device)
            tty.setraw(self.fd)
            quiet["stdout"] = device
            self.process = subprocess.Popen(
                [f"{programs}/grbl_sim", "-n", "-t", "1", "-b", "/dev/null", "-s", "/dev/null"],
                stdin=device, **quiet)
            os.close(device)
        self.set_up()

    def set_up(self):
        time.sleep(0.3)
        self.ask("?")
        for axis in range(3):
            self.ask(f"$11{axis}={RATE_MM_MIN}")
            self.ask(f"$12{axis}={ACCELERATION_MM_S2}")
        if not self.is_hal:
            self.ask("$6=1")  # its probe input has the wrong level, and does not change
        while select.select([self.fd], [], [], 0.2)[0]:
            self.receive()

    def send(self, data):
        os.write(self.fd, data)

    def receive(self):
        return os.read(self.fd, 4096)

    def key(self, key):
        """Presses a key of grblHAL's simulator: p turns the probe's input over."""
        self.process.stdin.write(key.encode())
        self.process.stdin.flush()

    def ask(self, line, limit_s=30.0):
        is_report = line == "?"
        self.send(line.encode() if is_report else (line + "\n").encode())
        answer, until = b"", time.monotonic() + limit_s
        while time.monotonic() < until:
            if select.select([self.fd], [], [], 0.05)[0]:
                answer += self.receive()
            if (b">" in answer) if is_report else (b"ok\r\n" in answer or b"error:" in answer):
                break
        return answer.decode("latin1")

    def place(self):
        """State and machine place of the next report."""
        for _ in range(5):
            found = re.findall(r"<([A-Za-z]+)[:0-9]*\|MPos:([-0-9.,]+)", self.ask("?"))
            if found:
                return found[-1][0], tuple(float(v) for v in found[-1][1].split(","))
        return "", ()

    def resting_place(self, limit_s=20.0):
        """Where it stands when nothing moves any more."""
        until = time.monotonic() + limit_s
        state, before = self.place()
        while time.monotonic() < until:
            time.sleep(0.15)
            state, now = self.place()
            if now == before and state not in ("Run", "Jog"):
                return state, now
            before = now
        raise AssertionError(f"still moves: {state} {before}")

    def close(self):
        self.process.kill()
        self.process.wait()
        if self.is_hal:
            self.process.stdin.close()
            self.socket.close()
        else:
            os.close(self.fd)


def connected(port):
    for _ in range(200):
        try:
            made = socket.create_connection(("127.0.0.1", port))
            made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return made
        except OSError:
            time.sleep(0.02)
    raise AssertionError("the simulator does not listen")


class Line:
    """Stands between panelcal and the firmware: counts messages, trips the probe, breaks things.

    fault(line, firmware) is called at message number `at`, in place of passing it on; what it returns
    goes to the control.
    """

    def __init__(self, firmware, surface_mm=None, fault=None, at=0, is_serial=False):
        self.firmware, self.surface_mm, self.fault, self.at = firmware, surface_mm, fault, at
        self.n_messages, self.n_moves, self.n_probes = 0, 0, 0
        self.last_jog = None
        self.is_probing = self.is_tripped = self.is_silent = self.is_closed = False
        self.after_fault = []
        self.heard_back = b""   # all that the control said
        self.peer = None
        if is_serial:
            self.fd, device = pty.openpty()
            tty.setraw(device)
            tty.setraw(self.fd)
            self.address = f'device = "{os.ttyname(device)}"'
            self.device = device
        else:
            self.fd = self.device = None
            self.listener = socket.create_server(("127.0.0.1", 0))
            self.address = f'host = "127.0.0.1"\nport = {self.listener.getsockname()[1]}'
        self.wake, self.waker = os.pipe()
        self.thread = threading.Thread(target=self.pump, daemon=True)
        self.thread.start()

    def pump(self):
        if self.fd is None:
            if self.listener not in select.select([self.listener, self.wake], [], [])[0]:
                return
            self.peer, _ = self.listener.accept()
            self.peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.fd = self.peer.fileno()
        while True:
            watched = [self.firmware.fd, self.wake] + ([] if self.is_closed else [self.fd])
            ready = select.select(watched, [], [])[0]
            if self.wake in ready:
                return
            if self.fd in ready and not self.is_closed:
                try:
                    data = os.read(self.fd, 4096)
                except OSError:
                    data = b""
                if not data:
                    self.close_peer()
                else:
                    self.firmware.send(self.heard(data))
            if self.firmware.fd in ready:
                try:
                    self.passed(self.firmware.receive())
                except OSError:
                    return

    def close_peer(self):
        self.is_closed = True
        if self.peer is not None:
            self.peer.close()
        else:
            os.close(self.fd)
            os.close(self.device)

    def say(self, data):
        if not self.is_silent and not self.is_closed:
            try:
                os.write(self.fd, data)
            except OSError:
                self.close_peer()

    def heard(self, data):
        """Bytes from panelcal; those that go on."""
        out = b""
        for part in re.findall(rb"[^\n?]*\n|\?|[^\n?]+", data):
            if part[-1:] in b"\n?":
                self.n_messages += 1
                if self.n_messages == self.at and self.fault:
                    out += self.fault(self, part)
                    continue
            if self.at and self.n_messages > self.at:
                self.after_fault.append(part)
            out += part
            self.note(part)
        return out

    def note(self, part):
        if part.startswith(b"$J="):
            self.n_moves += 1
            self.last_jog = part.decode()
            if self.is_tripped:
                # Its first move after the touch lifts the probe.
                self.is_tripped = False
                self.firmware.key("p")
        if b"G38.2" in part:
            self.n_probes += 1
            self.is_probing = True

    def passed(self, data):
        """Bytes from the control, kept. The probe trips where the report says that it is at the surface."""
        self.heard_back += data
        if self.is_probing and self.surface_mm is not None:
            for z in re.findall(rb"<Run\|MPos:[-0-9.]+,[-0-9.]+,([-0-9.]+)", data):
                if float(z) <= self.surface_mm and not self.is_tripped:
                    self.is_tripped = True
                    self.firmware.key("p")
            if b"[PRB" in data or b"ALARM" in data:
                self.is_probing = False
        self.say(data)

    def touches(self):
        """Z of each [PRB:x,y,z:1]."""
        found = re.findall(rb"\[PRB:[-0-9.]+,[-0-9.]+,([-0-9.]+):1\]", self.heard_back)
        return [float(z) for z in found]

    def close(self):
        os.write(self.waker, b"x")
        self.thread.join()
        if not self.is_closed and self.fd is not None:
            self.close_peer()
        os.close(self.wake)
        os.close(self.waker)
        if self.peer is None and self.device is None:
            self.listener.close()
