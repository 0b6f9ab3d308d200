#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The demo job through a GigE Vision camera gives to the byte what the same pictures give.

    gige_job_test.py PANELCAL FAKE_PANEL_CAMERA REPOSITORY

fake_panel_camera serves the demo's pictures over the real protocol on loopback; which one follows
from a file that the stage_command writes. Runs in a network of its own where the system allows it.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

SKIPPED = 77
ADDRESS = "127.0.0.1"
OFFSET_MM = ("62.5", "-4.0")      # [spindle] camera_offset_mm of the demo
LOST_SHARE = 0.002                # of 158 packets a frame: every fourth frame
HOPELESS_SHARE = 0.2              # no frame arrives whole
FRAMES_TO_LIVE = 9                # then the camera is gone in the middle of the job
# Writes where the spindle was sent, whole or not at all.
STAGE = """stage_command = ["sh", "-c", "echo $1 $2 >stage.new && mv stage.new stage", "sh", "{x}", "{y}"]
settle_s = 0.001
"""
TIMEOUT_S = 120


def enter_own_network():
    """Begins anew in a network that only has loopback; goes on as it is where that is refused."""
    if os.environ.get("PANELCAL_OWN_NETWORK") or not shutil.which("unshare"):
        return
    environment = dict(os.environ, PANELCAL_OWN_NETWORK="1")
    words = ["unshare", "--user", "--map-root-user", "--net"]
    if subprocess.run([*words, "true"], capture_output=True).returncode == 0:
        os.execvpe(words[0], [*words, sys.executable, *sys.argv], environment)


def bring_up_loopback():
    import fcntl
    import socket
    import struct
    set_flags, up_and_running = 0x8914, 0x41
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, set_flags, struct.pack("16sH14x", b"lo", up_and_running))


@contextmanager
def camera(program, pictures, folder, lost_share=0.0, n_frames=0):
    """A camera over the panel; it ends with its standard input, so also with this test."""
    process = subprocess.Popen([program, ADDRESS, pictures, folder / "stage", *OFFSET_MM,
                                str(lost_share), str(n_frames)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    try:
        if process.stdout.readline() != "ready\n":
            print("SKIP:", process.stderr.read())
            sys.exit(SKIPPED)
        yield
    finally:
        process.stdin.close()
        process.wait(10)
        process.stdout.close()
        process.stderr.close()


class Job:
    def __init__(self, panelcal, root, folder):
        self.panelcal, self.folder = panelcal, folder
        shutil.copytree(Path(root) / "datasets/demo", folder, dirs_exist_ok=True)
        machine = (folder / "machine.toml").read_text()
        (folder / "machine.toml").write_text(machine.replace("[machine]\n", "[machine]\n" + STAGE, 1))

    def run(self, *source, output, expect=0, prefix=()):
        begin = time.monotonic()
        done = subprocess.run([*prefix, self.panelcal, "run", "panel.exc", "-m", "machine.toml",
                               *source, "-o", output, "--save-measurements", "m.jsonl"],
                              cwd=self.folder, capture_output=True, text=True, timeout=TIMEOUT_S)
        if done.returncode != expect:
            sys.exit(f"{source}: exit {done.returncode}, expected {expect}\n{done.stderr}")
        print(f"{source[1]}: {time.monotonic() - begin:.1f} s")
        return done.stderr

    def output(self, name):
        """Without the lines that say where it came from."""
        text = (self.folder / name).read_text()
        return re.sub(r"^.*(command line|sha256).*\n", "", text, flags=re.MULTILINE)

    def measurements(self):
        """Without the names of pictures, which a camera has not."""
        return re.sub(r',"image":"[^"]*"', "", (self.folder / "m.jsonl").read_text())


def check_same(job, name, source, expected, prefix=()):
    said = job.run("--camera", source, output=name, prefix=prefix)
    assert job.output(name) == expected[0], f"{source}: other coordinates"
    assert job.measurements() == expected[1], f"{source}: other measurements"
    return said


def check_refused(job, source, *words, limit_s=20):
    begin = time.monotonic()
    message = job.run("--camera", source, output="refused.drl", expect=3)
    for word in words:
        assert word in message, f"{source}: {word} is not in\n{message}"
    assert time.monotonic() - begin < limit_s, source
    assert not (job.folder / "refused.drl").exists()


def main():
    enter_own_network()
    if os.environ.get("PANELCAL_OWN_NETWORK"):
        bring_up_loopback()
    panelcal, fake, root = sys.argv[1:]
    with tempfile.TemporaryDirectory(prefix="panelcal-gige-") as folder:
        job = Job(Path(panelcal).resolve(), root, Path(folder))
        # Pictures are recorded where this program looks, to the last bit: the bundled ones were
        # taken by an earlier one.
        pictures = job.folder / "recorded"
        subprocess.run([job.panelcal, "synth", "panel.exc", "-m", "machine.toml", "-o", pictures],
                       cwd=job.folder, capture_output=True, check=True, timeout=TIMEOUT_S)
        job.run("--images", "recorded", output="folder.drl")
        expected = job.output("folder.drl"), job.measurements()
        assert expected[0].count("\nX") > 900 and expected[1].count('"found"') == 21

        with camera(fake, pictures, job.folder):
            check_same(job, "camera.drl", f"gige://{ADDRESS}", expected)
            # As an ordinary user, without the raw socket of an administrator.
            if os.geteuid() == 0 and shutil.which("setpriv"):
                check_same(job, "user.drl", f"gige://{ADDRESS}?format=mono8", expected,
                           prefix=("setpriv", "--bounding-set=-net_raw"))
        with camera(fake, pictures, job.folder, LOST_SHARE):
            said = check_same(job, "lossy.drl", f"gige://{ADDRESS}", expected)
            assert "taken again" in said, "the test lost nothing"
        with camera(fake, pictures, job.folder, HOPELESS_SHARE):
            check_refused(job, f"gige://{ADDRESS}?retries=5", "error[device-frame]",
                          "6 of 6 frames")
        with camera(fake, pictures, job.folder, 0, FRAMES_TO_LIVE):
            check_refused(job, f"gige://{ADDRESS}", "error[device-frame]")
        check_refused(job, f"gige://{ADDRESS}", "error[device-camera]")
    print("the same to the byte")


if __name__ == "__main__":
    main()
