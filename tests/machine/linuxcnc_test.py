#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A real LinuxCNC, headless, is driven and probed through linuxcncrsh.

    linuxcnc_test.py DRIVE_LINUXCNC

Its axes are simulated by its own motion controller: what it says is compared with its HAL pins. Runs
in a network, IPC and process namespace of its own, since LinuxCNC has fixed ports and keys.
"""
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SKIPPED = 77
PORT = 5007
SAME_MM = 1e-3                    # between what is said and what the pins say
TOUCH_MM = 1.5e-3                 # one servo cycle at 60 mm/min is 1 um
READY_S = 60
MIDDLE_S = 1.0                    # a move of 400 mm at 3000 mm/min takes 8 s
# What the operator has left behind; none of it may matter.
OFFSETS = ["G10 L2 P1 X1.25 Y-0.5 Z-3 R30", "G92 X5 Z1", "G43.1 Z2.5", "G20", "G91 F12.5"]

JOINT = """TYPE = LINEAR
HOME = 0
HOME_SEARCH_VEL = 0
HOME_SEQUENCE = 0
FERROR = 5
MIN_FERROR = 1
"""
INI = """[EMC]
MACHINE = panelcal
VERSION = 1.1
[DISPLAY]
DISPLAY = linuxcncrsh
[TASK]
TASK = milltask
CYCLE_TIME = 0.001
[RS274NGC]
PARAMETER_FILE = sim.var
[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 1.0
SERVO_PERIOD = 1000000
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.010
TOOL_TABLE = sim.tbl
[HAL]
HALFILE = sim.hal
[TRAJ]
COORDINATES = X Y Z
LINEAR_UNITS = {unit}
ANGULAR_UNITS = degree
MAX_LINEAR_VELOCITY = {speed}
[KINS]
KINEMATICS = trivkins
JOINTS = 3
"""
HAL = """loadrt trivkins
loadrt motmod base_period_nsec=0 servo_period_nsec=1000000 num_joints=3
loadrt mult2 count=1
loadrt sum2 count=2
loadrt comp count=1
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf mult2.0 servo-thread
addf sum2.0 servo-thread
addf sum2.1 servo-thread
addf comp.0 servo-thread
net x joint.0.motor-pos-cmd joint.0.motor-pos-fb mult2.0.in0 sum2.0.in0
net y joint.1.motor-pos-cmd joint.1.motor-pos-fb mult2.0.in1 sum2.0.in1
net z joint.2.motor-pos-cmd joint.2.motor-pos-fb comp.0.in0
net xy mult2.0.out sum2.1.in0
net plane sum2.0.out sum2.1.in1
net surface sum2.1.out comp.0.in1
setp sum2.0.gain0 {a}
setp sum2.0.gain1 {b}
setp sum2.1.gain0 {ab}
setp sum2.1.offset {z}
net touched comp.0.out motion.probe-input
net no-estop iocontrol.0.emc-enable-in
sets no-estop 1
net change iocontrol.0.tool-change iocontrol.0.tool-changed
net prepare iocontrol.0.tool-prepare iocontrol.0.tool-prepared
"""
MACHINE = """[machine]
name = "headless"
driver = "linuxcnc"
safe_z_mm = 0
move_limit_s = 20
probe_feed_mm_min = 60
probe_from_mm = -39.5
probe_to_mm = -41
probe_z0_mm = -40
"""


def surface_mm(x, y):
    return -40.1234 + 1e-3 * x - 0.7e-3 * y + 1e-5 * x * y


def enter_own_namespace():
    """Begins anew in namespaces of its own; ends as skipped where that is refused."""
    if os.environ.get("PANELCAL_OWN_NETWORK"):
        return
    words = ["unshare", "--net", "--ipc", "--pid", "--fork", "--kill-child", "--mount-proc"]
    if os.getuid() != 0:
        words += ["--user", "--map-root-user"]
    if subprocess.run([*words, "true"], capture_output=True).returncode != 0:
        print("SKIP: no namespace of its own")
        sys.exit(SKIPPED)
    kind = "root" if os.getuid() == 0 else "user"
    os.execvpe(words[0], [*words, sys.executable, *sys.argv],
               dict(os.environ, PANELCAL_OWN_NETWORK=kind))


def as_user():
    """LinuxCNC refuses root."""
    if os.environ["PANELCAL_OWN_NETWORK"] == "root":
        return ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    return ["unshare", "--user", "--map-user=1000", "--map-group=1000"]


def bring_up_loopback():
    import fcntl
    import struct
    set_flags, up_and_running = 0x8914, 0x41
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, set_flags, struct.pack("16sH14x", b"lo", up_and_running))


class LinuxCnc:
    def __init__(self, folder, unit="mm"):
        self.folder = folder
        scale = {"mm": 1.0, "inch": 25.4}[unit]
        self.scale = scale
        text = INI.format(unit=unit, speed=200 / scale)
        for i, (axis, low, high) in enumerate([("X", -10, 500), ("Y", -10, 500), ("Z", -60, 10)]):
            limits = (f"MIN_LIMIT = {low / scale}\nMAX_LIMIT = {high / scale}\n"
                      f"MAX_VELOCITY = {200 / scale}\nMAX_ACCELERATION = {5000 / scale}\n")
            text += f"[AXIS_{axis}]\n{limits}[JOINT_{i}]\n{JOINT}{limits}"
        (folder / "sim.ini").write_text(text)
        (folder / "sim.hal").write_text(HAL.format(a=1e-3, b=-0.7e-3, ab=1e-5 * scale, z=-40.1234 / scale))
        (folder / "sim.tbl").write_text("T1 P1 Z0 D3 ;\n")
        for path in [folder, *folder.iterdir()]:
            path.chmod(0o777)
        self.environment = dict(os.environ, HOME=str(folder))
        self.log = (folder / "log").open("w")
        self.process = subprocess.Popen([*as_user(), "linuxcnc", "-r", str(folder / "sim.ini")],
                                        cwd=folder, env=self.environment, stdin=subprocess.DEVNULL,
                                        stdout=self.log, stderr=subprocess.STDOUT)

    def connect(self):
        until = time.monotonic() + READY_S
        while time.monotonic() < until and self.process.poll() is None:
            try:
                return socket.create_connection(("127.0.0.1", PORT), timeout=READY_S)
            except OSError:
                time.sleep(0.05)
        raise SystemExit("LinuxCNC does not come up:\n" + (self.folder / "log").read_text()[-2000:])

    def orders(self, *lines):
        """Each order is answered, since verbose is on, before the next one is sent. Who sets takes
        the right to control from who has it."""
        takes = [] if all(line.startswith("get") for line in lines) else ["set enable EMCTOO"]
        with self.connect() as link:
            answers = link.makefile("r", newline="\n")
            def say(line):
                link.sendall(line.encode() + b"\r\n")
                while True:
                    answer = answers.readline()
                    if not answer:
                        return ""
                    if answer.strip() and answer.strip() not in (line, "set echo off"):
                        return answer.strip()
            assert say("hello EMC test 1").startswith("HELLO ACK")
            link.sendall(b"set echo off\r\n")
            return [say(line) for line in ["set verbose on", *takes, *lines]][1 + len(takes):]

    def hal(self, *words):
        done = subprocess.run([*as_user(), "halcmd", *words], env=self.environment, cwd=self.folder,
                              capture_output=True, text=True, check=True)
        return done.stdout.strip()

    def pins_mm(self):
        rows = [row.split() for row in self.hal("-s", "show", "pin", "joint.?.pos-fb").splitlines()]
        return [float(row[3]) * self.scale for row in rows if row]

    def home(self):
        """Where it is switched on and homed, with offsets and modes of an operator."""
        self.orders("set estop off", "set machine on", "set mode manual", "set home -1")
        until = time.monotonic() + READY_S
        while not self.orders("get joint_homed")[0].startswith("JOINT_HOMED YES YES YES"):
            assert time.monotonic() < until, "it does not home"
            time.sleep(0.05)
        self.orders("set mode mdi", *("set mdi " + line for line in OFFSETS))

    def end(self):
        try:
            self.orders("shutdown")
        except (OSError, SystemExit, AssertionError):
            self.process.terminate()
        try:
            self.process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            self.process.kill()
        Path("/tmp/linuxcnc.lock").unlink(missing_ok=True)


class Drive:
    def __init__(self, program, folder, more=""):
        file = folder / "machine.toml"
        file.write_text(MACHINE + more)
        self.process = subprocess.Popen([program, file], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)
        self.greeting = self.process.stdout.readline().strip()

    def send(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def answer(self):
        return self.process.stdout.readline().strip()

    def ask(self, line):
        self.send(line)
        return self.answer()

    def end(self):
        self.process.stdin.close()
        assert self.process.wait(timeout=20) == 0


def near(found, wanted, tolerance):
    return all(abs(f - w) <= tolerance for f, w in zip(found, wanted, strict=True))


def moves_and_touches(cnc, drive):
    worst = 0.0
    for place in [(100.0153, 50.0271), (0, 0), (12.3456, 499.5)]:
        answer = drive.ask("move {} {}".format(*place))
        assert re.match(r"at \S+ \S+$", answer), answer
        said = [float(word) for word in answer.split()[1:]]
        pins = cnc.pins_mm()
        assert near(said, place, SAME_MM) and near(said, pins[:2], SAME_MM), (answer, pins)
        worst = max(worst, *(abs(s - p) for s, p in zip(said, pins[:2])))
    print(f"moves: worst {worst * 1e3:.3f} um of the pins")
    errors = []
    for y in (20, 60, 100):
        for x in (20, 70, 120):
            answer = drive.ask(f"probe {x} {y}")
            assert answer.startswith("height "), answer
            errors.append(float(answer.split()[1]) - (surface_mm(x, y) + 40))
    print(f"touches: {len(errors)}, worst {max(map(abs, errors)) * 1e3:.3f} um")
    assert max(map(abs, errors)) <= TOUCH_MM, errors
    assert near(cnc.pins_mm()[2:], [0], SAME_MM), "Z is lifted again"
    answer = drive.ask("move 900 0")
    assert "exceed" in answer and "positive limit" in answer, answer
    codes = cnc.orders("get program_codes")[0].split()
    assert {"G20", "G91", "G43", "G54"} <= set(codes), codes
    drive.end()
    cnc.orders("set mdi (DEBUG,#<_feed>)")
    time.sleep(0.2)
    feed = cnc.orders("get operator_display")[0]
    assert feed == "OPERATOR_DISPLAY 12.500000", feed


def stopped_in_the_middle(cnc, drive):
    """An emergency stop, which an operator then clears."""
    assert drive.ask("move 0 0").startswith("at "), "back"
    drive.send("move 400 0")
    time.sleep(MIDDLE_S)
    cnc.hal("sets", "no-estop", "0")
    answer = drive.answer()
    assert "emergency stop is on" in answer and "the machine stands" in answer, answer
    place = cnc.pins_mm()
    assert 0 <= place[0] < 400, place
    answer = drive.ask("move 0 0")
    assert "emergency stop is on" in answer, answer
    assert cnc.pins_mm() == place, "nothing moves after that"
    print(f"emergency stop: {answer}")
    cnc.hal("sets", "no-estop", "1")
    cnc.orders("set estop off", "set machine on")
    answer = drive.ask("move 0 0")
    assert "another client" in answer, answer
    drive.end()


def held(cnc, program, folder):
    drive = Drive(program, folder, "move_feed_mm_min = 3000\n")
    drive.send("move 400 0")
    time.sleep(MIDDLE_S)
    cnc.hal("setp", "motion.feed-hold", "1")
    answer = drive.answer()
    assert "feed hold" in answer and "the machine stands" in answer, answer
    cnc.hal("setp", "motion.feed-hold", "0")
    place = cnc.pins_mm()
    time.sleep(0.1)
    assert cnc.pins_mm() == place, "the rest of the move is gone"
    print(f"feed hold: {answer}")
    drive.end()


def interrupted(cnc, program, folder):
    """A signal in the middle of a move halts the machine before the program ends."""
    drive = Drive(program, folder, "move_feed_mm_min = 600\n")
    start = cnc.pins_mm()[0]
    drive.send("move 0 0")
    time.sleep(MIDDLE_S)
    drive.process.send_signal(signal.SIGINT)
    answer = drive.answer()
    place = cnc.pins_mm()
    assert "error[interrupted]" in answer and "the machine stands" in answer, answer
    assert 0 <= place[0] <= start, place
    time.sleep(0.1)
    assert cnc.pins_mm() == place
    print(f"signal: {answer}")
    drive.end()


def killed(cnc, program, folder):
    """linuxcncrsh is gone in the middle of a move, which then comes to its end."""
    drive = Drive(program, folder, "move_feed_mm_min = 600\n")
    assert drive.greeting.startswith("LinuxCNC at"), drive.greeting
    drive.send("move 0 0")
    time.sleep(MIDDLE_S)
    for process in Path("/proc").glob("[0-9]*/comm"):  # of this namespace alone
        if process.read_text() == "linuxcncrsh\n":
            os.kill(int(process.parent.name), signal.SIGKILL)
    answer = drive.answer()
    assert "lost connection" in answer and "could not be stopped" in answer, answer
    print(f"control killed: {answer}")
    drive.end()


def main(program):
    if not all(shutil.which(word) for word in ("linuxcnc", "linuxcncrsh", "halcmd", "unshare")):
        print("LinuxCNC is not installed (Debian: linuxcnc-uspace)")
        return SKIPPED
    enter_own_namespace()
    bring_up_loopback()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        cnc = LinuxCnc(folder)
        try:
            cnc.orders("get estop")
            greeting = Drive(program, folder).greeting
            assert "the machine is switched off" in greeting, greeting
            cnc.home()
            drive = Drive(program, folder)
            assert drive.greeting == f"LinuxCNC at 127.0.0.1:{PORT}", drive.greeting
            moves_and_touches(cnc, drive)
            slow = Drive(program, folder, "move_feed_mm_min = 3000\n")
            stopped_in_the_middle(cnc, slow)
            held(cnc, program, folder)
            interrupted(cnc, program, folder)
            killed(cnc, program, folder)
        finally:
            cnc.end()
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(os.path.abspath(sys.argv[1])))
