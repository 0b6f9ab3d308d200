# SPDX-License-Identifier: Apache-2.0
"""A folder of real files of every kind, and the command lines that panelcal has for them."""
import os
import re
import shutil
import subprocess
from pathlib import Path

MACHINE = """\
[machine]
name = "drill 1"
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
[vision]
search_radius_mm = 0.5
[[vision.tool]]
number = 1
shape = "hole"
size_mm = 0.8
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 0.6
[[vision.tool]]
number = 3
shape = "template"
picture = "template.png"
size_mm = 2.4
[camera]
calibration = "camera.cal.json"
[spindle]
calibration = "spindle.cal.json"
camera_offset_mm = [45.0, -3.0]
[coupon]
name = "A"
origin_mm = [300, 100]
pitch_mm = 2
columns = 3
rows_per_run = 3
rows = 300
state = "coupon.json"
[ledger]
file = "drill1.ledger"
[nightly]
machine_driver = "sim"
calibrate = ["spindle-camera"]
temperature_file = "temperature.txt"
[sim]
seed = 20261101
spindle_camera_offset_mm = [45.012, -2.991]
picture_px = [320, 320]
noise = 3
background = 0.6
target_level = 0.9
"""

JOB = """\
M48
METRIC,TZ
FMAT,2
T1C0.800
%
G05
G90
G34,2
G35X10.0Y10.0
T1
X20.0Y20.0
M99,PATT
X100.0Y80.0
M30
"""

LENS = """\
image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [2000, 0, 320, 0, 2000, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.05, 0.01, 0, 0, 0]}
"""

# What machine.toml names, and what lies beside the ledger.
OF_MACHINE = {"machine.toml", "camera.cal.json", "spindle.cal.json", "coupon.json", "drill1.ledger",
              "drill1.ledger.lock", "temperature.txt", "template.png"}
# Other names of the same files.
LINKS = {"link-of-ledger": "drill1.ledger", "link-of-camera": "camera.cal.json",
         "link-of-job": "job.exc", "link-of-picture": "images/0000.png"}
HARD = {"hard-of-coupon": "coupon.json", "hard-of-map": "map.json", "hard-of-picture": "images/0000.png",
        "hard-of-measurements": "measurements.jsonl"}

# Each command with valid inputs and all outputs that it needs but for the one that is tried.
KEY = "--machine 'drill 1' --kind spindle-camera --subject 'spindle 1 station 1'"
SURFACE_PLAN = "--tolerance-um 20 --program job.exc -m machine.toml map.json"
COMMANDS = {
    "init": "--template folder camera.cal.json",
    "check": "job.exc -m machine.toml",
    "doctor": "-m machine.toml",
    "survey": "job.exc -m machine.toml",
    "plan": "job.exc -m machine.toml --measurements measurements.jsonl",
    "run": "job.exc -m machine.toml --images images --probes probes.jsonl --surface map.json "
           "--truth truth.json",
    "align": "job.exc -m machine.toml --images images",
    "align verify": "board.align.json -m machine.toml --images images",
    "align show": "board.align.json -m machine.toml",
    "align apply": "program.ngc -m machine.toml --align board.align.json --surface map.json",
    "filter": "program.ngc -m machine.toml --align board.align.json",
    "translate": "job.exc -m machine.toml",
    "locate": "images/0000.png -m machine.toml --tool 2",
    "synth": "job.exc -m machine.toml",
    "batch": "jobs.csv",
    "batch merge": "results",
    "batch push": "results --store all.sqlite",
    "batch report": "results",
    "batch show": "results",
    "calibrate camera": "-m machine.toml --images images --plate plate.toml",
    "calibrate camera-import": "camera.yaml --scale-mm-per-px 0.01 --corner-sigma-um 5",
    "calibrate camera-export": "camera.cal.json --to opencv --focal-px 2000",
    "calibrate table": "-m machine.toml --plate plate.toml --measurements looks.jsonl",
    "calibrate surface": "map.json -m machine.toml",
    "calibrate spindle-camera": "-m machine.toml --machine-driver sim",
    "calibrate focus": "-m machine.toml --machine-driver sim --at 100,80",
    "calibrate light": "-m machine.toml --machine-driver sim --at 100,80",
    "calibrate settle": "-m machine.toml --machine-driver sim --at 100,80",
    "nightly": "-m machine.toml",
    # On an address of no computer, so that it never begins.
    "serve": "-m machine.toml --images images --address 192.0.2.1:8330",
    "history certificate": "-l drill1.ledger -m machine.toml --plate plate.toml --against map.json",
    "history list": "-l drill1.ledger",
    "history export": "-l drill1.ledger",
    "history show": "1 -l drill1.ledger",
    "history diff": "1 2 -l drill1.ledger --program job.exc -m machine.toml "
                    "--measurements measurements.jsonl",
    "history rollback": f"-l drill1.ledger {KEY} --reason test",
    "history fresh-start": f"-l drill1.ledger {KEY} --reason test",
    "history plot": f"-l drill1.ledger {KEY} --parameter offset_x",
    "history push": "-l drill1.ledger --store all.sqlite",
    "history fleet": "--store all.sqlite",
    "history verify": "-l drill1.ledger -m machine.toml --against map.json",
    "surface fit": "probes.jsonl -m machine.toml --zones zones.toml --voids-of job.exc",
    "surface query": "map.json --program job.exc -m machine.toml",
    "surface diff": "map.json map.json",
    "surface plan": SURFACE_PLAN,
    "surface apply": "map.json program.ngc --zero 10,10",
    "surface export": "map.json --grid 3x3 --format heightmap",
}
# Options with a text that name no output (--store: only a database of its own is written to); all others with a text are tried as outputs.
NO_OUTPUTS = {
    "--address", "--against", "--align", "--area", "--at", "--by", "--camera", "--certificate", "--clock", "--device", "--engine", "--explain", "--flavour", "--form", "--format", "--grid",
    "--host", "--host-name", "--images", "--key", "--kind", "--ledger", "--log-level", "--machine", "--machine-driver",
    "--measurements", "--model", "--name", "--only", "--panel", "--parameter", "--pattern", "--plate", "--probes", "--profile", "--program", "--program-format", "--range",
    "--reason", "--reports", "--seed", "--shard", "--since", "--slots", "--store", "--subject", "--surface", "--sweep", "--template", "--to", "--truth",
    "--unit", "--voids-of", "--zero", "--zone", "--zones"}
OUTPUTS = {"--jobs", "--json", "--linuxcnc", "--metrics", "--output", "--overlay", "--report",
           "--save-measurements", "--save-probes", "--token-file"}
# Commands that end by a signal only: words that are changed at random could begin one.
ENDLESS = {"serve"}


def help_of(panelcal, words):
    return subprocess.run([panelcal, *words, "--help"], capture_output=True, text=True,
                          check=True).stdout


def leaves(panelcal, words=()):
    """Every command that can be executed, as registered: also those with commands below them."""
    text = help_of(panelcal, words)
    found = re.search(r"^Subcommands:\n((?:  .*\n)+)", text, re.M)
    if not found:
        return [" ".join(words)]
    names = re.findall(r"^  ([a-z][a-z-]*)", found.group(1), re.M)
    own = [" ".join(words)] if "\nPositionals:" in text and words else []
    return own + [leaf for name in names if name != "help" for leaf in leaves(panelcal, (*words, name))]


def options_of(panelcal, command):
    """The long names of a command's options, and whether each takes a text."""
    text = help_of(panelcal, command.split()).split("\nExample")[0]
    return {name: bool(re.match(r" TEXT\b", rest))
            for name, rest in re.findall(r"^ +(?:-\w,)?(--[a-z-]+)(?:,--[a-z-]+)*(.*)", text, re.M)
            if name != "--help"}


def make(panelcal, repository, folder):
    """Writes the folder; what panelcal itself writes, it writes."""
    folder = Path(folder)
    fixtures = Path(repository) / "tests/golden/fixtures"

    def panelcal_writes(*words):
        done = subprocess.run([panelcal, *words], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, (words, done)

    (folder / "machine.toml").write_text(MACHINE)
    (folder / "job.exc").write_text(JOB)
    (folder / "patt.exc").write_text("X30.0Y30.0\nX40.0Y60.0\n")
    (folder / "program.ngc").write_text("G21 G90\nG0 Z5\nG0 X10 Y10\nG1 Z-0.1 F100\nG1 X20\nG0 Z5\nM2\n")
    (folder / "camera.yaml").write_text(LENS)
    (folder / "temperature.txt").write_text("21.5\n")
    shutil.copy(Path(repository) / "tests/tools/surface/plane.jsonl", folder / "probes.jsonl")
    shutil.copy(fixtures / "two-zones/zones.toml", folder / "zones.toml")
    shutil.copy(fixtures / "camera-320-px/camera.cal.json", folder / "camera.cal.json")
    for name in ("plate.toml", "looks.jsonl"):
        shutil.copy(fixtures / "dot-plate" / name, folder / name)
    (folder / "template.png").write_bytes((Path(repository) / "datasets/demo/images/0000.png").read_bytes())
    for minute in (0, 1):
        panelcal_writes("nightly", "-m", "machine.toml", "--clock", f"2026-11-2{minute}T02:00:00Z")
    panelcal_writes("synth", "job.exc", "-m", "machine.toml", "-o", "images")
    # Without the digests the pictures are a camera's.
    (folder / "images/synth.sha256").unlink()
    (folder / "images/truth.json").rename(folder / "truth.json")
    panelcal_writes("surface", "fit", "probes.jsonl", "-o", "map.json")
    panelcal_writes("run", "job.exc", "-m", "machine.toml", "--images", "images", "--clock",
                    "2026-11-22T02:00:00", "--surface", "map.json", "--truth", "truth.json",
                    "-o", "out.jsonl", "--save-measurements", "measurements.jsonl")
    panelcal_writes("align", "job.exc", "-m", "machine.toml", "--images", "images", "-o", "board.align.json")
    (folder / "jobs.csv").write_text("program,machine,images\njob.exc,machine.toml,images\n")
    panelcal_writes("history", "push", "-l", "drill1.ledger", "--store", "all.sqlite")
    panelcal_writes("batch", "jobs.csv", "-o", "results", "--clock", "2026-11-22T02:00:00")
    assert OF_MACHINE <= set(os.listdir(folder)), os.listdir(folder)


def add_links(folder):
    for name, target in LINKS.items():
        os.symlink(target, Path(folder) / name)
    for name, target in HARD.items():
        os.link(Path(folder) / target, Path(folder) / name)


def content(folder):
    """Every file below a folder, by its name there."""
    return {str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(Path(folder).rglob("*")) if path.is_file()}
