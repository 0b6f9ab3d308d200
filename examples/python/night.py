# SPDX-License-Identifier: Apache-2.0
"""A night: has the camera, or its distance from the spindle, changed since it was calibrated?

Pictures and looks come from a virtual machine whose truth is known; give --images for your own.

    PYTHONPATH=build/release/python /usr/bin/python3 examples/python/night.py
"""
import argparse
import pathlib
import tempfile

import numpy as np

import panelcal

DEMO = pathlib.Path(__file__).resolve().parents[2] / "datasets" / "demo"

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--machine", type=pathlib.Path, default=DEMO / "machine.toml")
arguments.add_argument("--images", type=pathlib.Path, help="pictures of one mark, with images.csv")
arguments.add_argument("--ledger", type=pathlib.Path, help="show what earlier nights have found")
arguments.add_argument("--small", action="store_true", help="as the tests run it")
options = arguments.parse_args()

machine = panelcal.read_machine(options.machine)
in_force = machine.mapping


def take_pictures(folder: pathlib.Path, n_per_side: int) -> None:
    """A mark seen at places all over the picture, by a camera that has warmed up."""
    warm = panelcal.CameraMapping(in_force.scale_mm_per_px * (1 + 80e-6), in_force.axis_px,
                                  in_force.rotation_rad + 100e-6)
    mark_mm = np.array([150.0, 100.0])
    width, height = machine.picture_px
    rows = ["file,x,y"]
    for y in np.linspace(0.25, 0.75, n_per_side) * height:
        for x in np.linspace(0.25, 0.75, n_per_side) * width:
            image = panelcal.render(machine.targets[1], size_px=(width, height), center_px=(x, y),
                                    mapping=warm, noise=3, seed=len(rows))
            axis_mm = mark_mm - warm([x, y])[0]
            panelcal.write_png(folder / f"{len(rows)}.png", image)
            rows.append(f"{len(rows)}.png,{axis_mm[0]:.6f},{axis_mm[1]:.6f}")
    (folder / "images.csv").write_text("\n".join(rows) + "\n")


# The camera, from pictures of one mark.
with tempfile.TemporaryDirectory() as made:
    images = options.images or pathlib.Path(made)
    if not options.images:
        take_pictures(images, 3 if options.small else 5)
    camera = panelcal.calibrate_camera(machine, images, tool=1)
    camera.save(pathlib.Path(made) / "camera.cal.json", force=True)
    text = options.machine.read_text().replace("camera.cal.json", f"{made}/camera.cal.json")
    found = panelcal.parse_machine(text, options.machine).mapping
print(camera.report)
growth_ppm = 1e6 * (found.scale_mm_per_px / in_force.scale_mm_per_px - 1)
print(f"scale changed by {growth_ppm:+.0f} ppm; "
      + (f"not to be installed: {camera.refusal}" if camera.refusal else "may be installed"))

# The distance from spindle to camera, from looks at holes that the spindle drilled.
random = np.random.default_rng(7)
true_offset_mm = np.array([62.5031, -4.0018])
drilled_mm = np.array([[20.0 + 4 * i, 15.0 + 4 * j] for i in range(4) for j in range(3)])
hole = np.repeat(np.arange(len(drilled_mm)), 4)
spindle_mm = drilled_mm[hole] - true_offset_mm + random.uniform(-0.1, 0.1, (len(hole), 2))
wander_mm = random.normal(0, 0.002, drilled_mm.shape)[hole]
seen_mm = (drilled_mm[hole] + wander_mm - spindle_mm - true_offset_mm
           + random.normal(0, 0.0005, (len(hole), 2)))
offset = panelcal.calibrate_spindle_camera(drilled_mm, hole, spindle_mm, seen_mm, 0.0005)
sigma_um = 1e3 * np.sqrt(np.diag(offset.cov_mm2))
print(f"spindle to camera: {offset.offset_mm.round(4)} mm, sigma {sigma_um.round(2)} um")
assert (np.abs(offset.offset_mm - true_offset_mm) < 5e-3 * sigma_um).all()

# Earlier nights, from the ledger that `panelcal nightly` keeps.
for entry in panelcal.history(options.ledger) if options.ledger else []:
    values = {one["name"]: one["value"] for one in entry["parameters"]}
    print(entry["time"], entry["kind"], entry["subject"], entry["verdict"], values)
