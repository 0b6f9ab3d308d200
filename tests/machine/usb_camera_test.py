#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A job through a USB camera of 640 x 480 px, 20 um each, whose driver keeps old frames: every picture is of the
place that was driven to, the camera is held, and one that refuses is named.

    usb_camera_test.py PANELCAL FAKE_V4L2 REPOSITORY

FAKE_V4L2 stands in front of the C library; which picture follows from a file that the stage_command writes.
"""
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from facts import checked  # noqa: E402

WIDTH, HEIGHT = 640, 480
OFFSET_MM = (45.0, -3.0)
DEVICE = f"v4l2:/dev/zero?width={WIDTH}&height={HEIGHT}"
FOCUS_AUTO, EXPOSURE_AUTO, WHITE_BALANCE_AUTO = 0x9a090c, 0x9a0901, 0x98090c
EXPOSURE, FOCUS, POWER_LINE = 0x9a0902, 0x9a090a, 0x980918
MANUAL_EXPOSURE = 1

MACHINE = """
[machine]
stage_command = ["sh", "-c", "cp \\"frame $1 $2\\" new && mv new frame", "sh", "{x}", "{y}"]
settle_s = 0.001
[vision]
rotate = 4
search_radius_mm = 1.5
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 1.0
polarity = "bright"
[camera]
calibration = "camera.cal.json"
patience_s = 0
[spindle]
camera_offset_mm = [45.0, -3.0]
camera_offset_sigma_um = 5
[tolerance]
position_um = 125
[uncertainty]
stage_repeatability_um = 0
table_residual_um = 0
drill_wander_um = 0
[sim]
seed = 5
panel_offset_mm = [0.4, -0.25]
panel_rotation_mrad = 2.0
stretch_ppm = [200, -120]
picture_px = [640, 480]
blur_px = 1.5
noise = 4
"""

CAMERA = {
    "kind": "camera", "version": 1, "date": "2026-11-20T22:15:00Z", "provenance": "chosen for this test",
    "units": {"length": "mm", "angle": "rad", "picture": "px"}, "picture_px": [WIDTH, HEIGHT],
    "parameters": {"scale_mm_per_px": 0.02, "rotation_rad": 0.004, "axis_px": [321.3, 236.8], "k1_per_px2": 0},
    "covariance": [[(4e-16, 4e-12, 1e-4, 1e-4, 1e-20)[i] if i == j else 0 for j in range(5)] for i in range(5)]}


PROGRAM = """M48
METRIC,TZ
FMAT,2
VER,1
T1C0.8
%
G90
G34,1
G36X5.0Y5.0
G36X95.0Y5.0
G36X95.0Y65.0
G36X5.0Y65.0
T1
X12.0Y12.0
X48.0Y40.0
X90.0Y60.0
M30
"""


def grey_bytes(png):
    """The bytes of a grey picture of 8 bit."""
    data, at, packed = png.read_bytes(), 8, b""
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            assert (int.from_bytes(body[:4], "big"), int.from_bytes(body[4:8], "big")) == (WIDTH, HEIGHT)
            assert body[8:] == bytes((8, 0, 0, 0, 0)), "not grey of 8 bit"
        packed += body if kind == b"IDAT" else b""
        at += length + 12
    raw, above, out = zlib.decompress(packed), bytes(WIDTH), bytearray()
    for y in range(HEIGHT):
        kind, row = raw[y * (WIDTH + 1)], bytearray(raw[y * (WIDTH + 1) + 1:(y + 1) * (WIDTH + 1)])
        for x in range(WIDTH if kind else 0):
            left, corner = (row[x - 1], above[x - 1]) if x else (0, 0)
            guess = left + above[x] - corner
            paeth = min((left, above[x], corner), key=lambda value: abs(guess - value))
            row[x] = (row[x] + (0, left, above[x], (left + above[x]) // 2, paeth)[kind]) & 255
        out += row
        above = row
    return bytes(out)


class UsbCamera(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = folder = Path(temporary.name)
        (folder / "machine.toml").write_text(MACHINE)
        (folder / "camera.cal.json").write_text(json.dumps(CAMERA))
        (folder / "panel.exc").write_text(PROGRAM)
        subprocess.run([PANELCAL, "synth", "panel.exc", "-m", "machine.toml", "-o", "recorded"], cwd=folder,
                       capture_output=True, check=True)
        lines = [line for line in (folder / "recorded/images.csv").read_text().splitlines() if not line.startswith("#")]
        for row in csv.DictReader(lines):
            x, y = (float(row[key]) - offset for key, offset in zip(("x", "y"), OFFSET_MM, strict=True))
            (folder / f"frame {x:.6f} {y:.6f}").write_bytes(grey_bytes(folder / "recorded" / row["file"]))
        cls.run_panelcal("run", "panel.exc", "-m", "machine.toml", "--images", "recorded", "-o", "folder.drl",
                         "--save-measurements", "folder.jsonl")

    @classmethod
    def run_panelcal(cls, *words, code=0, **fake):
        environment = dict(os.environ)
        if fake or DEVICE in " ".join(words):
            environment |= {"LD_PRELOAD": FAKE, "FAKE_V4L2_FRAME": "frame", "FAKE_V4L2_SIZE": f"{WIDTH} {HEIGHT}"}
            environment |= {f"FAKE_V4L2_{key.upper()}": value for key, value in fake.items()}
        done = subprocess.run([PANELCAL, *words], cwd=cls.folder, capture_output=True, text=True, env=environment)
        assert done.returncode == code, f"{words}: exit {done.returncode}\n{done.stdout}{done.stderr}"
        return done.stdout + done.stderr

    def run_job(self, name, address=DEVICE, *words, code=0, **fake):
        return self.run_panelcal("run", "panel.exc", "-m", "machine.toml", "--camera", address, "-o", f"{name}.drl",
                                 "--save-measurements", f"{name}.jsonl", *words, code=code, **fake)

    def measured(self, name):
        return re.sub(r',"image":"[^"]*"', "", (self.folder / f"{name}.jsonl").read_text())

    def test_every_picture_is_of_the_place_that_was_driven_to_and_the_camera_is_held(self):
        said = self.run_job("camera", DEVICE + "&exposure_us=8000&focus=30&power_line_hz=50", log="orders")
        self.assertEqual(self.measured("camera"), self.measured("folder"))
        self.assertEqual(self.measured("folder").count('"found"'), 4)
        self.assertNotIn("tolerance-warning", said)
        orders = [line.split() for line in (self.folder / "orders").read_text().splitlines()]
        self.assertEqual({int(control, 16): int(value) for control, value in orders},
                         {FOCUS_AUTO: 0, EXPOSURE_AUTO: MANUAL_EXPOSURE, WHITE_BALANCE_AUTO: 0, EXPOSURE: 80,
                          FOCUS: 30, POWER_LINE: 1})

    def test_a_camera_that_refuses_is_a_risk_of_the_job(self):
        said = self.run_job("refused", DEVICE, "--json", "refused.json", refuses=f"{FOCUS_AUTO:x}")
        self.assertIn("v4l2:/dev/zero: warning[tolerance-warning]: tolerance at risk: automatic focus stays on", said)
        document = checked(json.loads((self.folder / "refused.json").read_text()), ROOT)
        self.assertIn("automatic focus stays on", json.dumps(document["messages"]))

    def test_doctor_names_what_is_held_and_what_is_not(self):
        (self.folder / "frame").write_bytes(bytes(WIDTH * HEIGHT))
        examine = ("doctor", "-m", "machine.toml", "--devices", "--camera", DEVICE + "&exposure_us=8000")
        said = self.run_panelcal(*examine)
        self.assertIn("v4l2:/dev/zero: a picture of 640 x 480 px, exposure 8000 us", said)
        self.assertNotIn("stays on", said)
        said = self.run_panelcal(*examine, refuses=f"{WHITE_BALANCE_AUTO:x} {FOCUS_AUTO:x}")
        self.assertRegex(said, "warning +camera device: .*automatic focus stays on")
        self.assertRegex(said, "warning +camera device: .*automatic white balance stays on")

    def test_a_setting_outside_of_its_bounds_is_refused(self):
        said = self.run_job("dark", DEVICE + "&exposure_us=100", code=3)
        self.assertIn("error[device-camera]", said)
        self.assertIn("exposure_us=100; expected 300 to 204700", said)
        self.assertFalse((self.folder / "dark.drl").exists())

    def test_a_camera_that_is_pulled_out_ends_the_job(self):
        said = self.run_job("pulled", DEVICE, code=3, lives="6")
        self.assertRegex(said, r"error\[device-(frame|camera)\]")
        self.assertFalse((self.folder / "pulled.drl").exists())


if __name__ == "__main__":
    ROOT = Path(sys.argv.pop()).resolve()
    FAKE = str(Path(sys.argv.pop()).resolve())
    PANELCAL = str(Path(sys.argv.pop()).resolve())
    unittest.main()
