# SPDX-License-Identifier: Apache-2.0
import json
import shutil

import numpy as np
import pytest

import panelcal
from conftest import ROOT, run_panelcal


def pictures_of_a_mark(folder, machine, truth):
    """The axis is driven over a mark; as images.csv has it."""
    mark_mm = np.array([150.0, 100.0])
    rows = ["file,x,y"]
    places = [(x, y) for y in (120, 240, 360) for x in (120, 240, 360)]
    for i, center_px in enumerate(places):
        image = panelcal.render(machine.targets[1], size_px=machine.picture_px, center_px=center_px,
                                mapping=truth, noise=2, seed=i)
        panelcal.write_png(folder / f"{i}.png", image)
        x_mm, y_mm = mark_mm - truth(center_px)[0]
        rows.append(f"{i}.png,{x_mm!r},{y_mm!r}")
    (folder / "images.csv").write_text("\n".join(rows) + "\n")


def test_a_camera_from_pictures_is_that_of_the_command_line(demo, machine, tmp_path):
    images = tmp_path / "images"
    images.mkdir()
    was = machine.mapping
    truth = panelcal.CameraMapping(was.scale_mm_per_px * 1.001, was.axis_px, was.rotation_rad + 0.002)
    pictures_of_a_mark(images, machine, truth)
    clock = "2026-11-21T02:00:00Z"
    made = panelcal.calibrate_camera(machine, images, tool=1, clock=clock)
    run_panelcal("calibrate", "camera", "-m", demo / "machine.toml", "--images", images, "--tool",
                 1, "--clock", clock, "-o", tmp_path / "camera.cal.json", "--force")
    assert made.text == (tmp_path / "camera.cal.json").read_text()
    assert made.calibration == json.loads(made.text)
    made.save(tmp_path / "saved.json", force=True)
    assert (tmp_path / "saved.json").read_text() == made.text
    text = (demo / "machine.toml").read_text().replace("camera.cal.json", "saved.json")
    found = panelcal.parse_machine(text, tmp_path / "machine.toml").mapping
    assert abs(found.scale_mm_per_px / truth.scale_mm_per_px - 1) < 1e-4
    assert abs(found.rotation_rad - truth.rotation_rad) < 1e-4


def looks(n_holes, offset_mm, sigma_mm, seed=1):
    random = np.random.default_rng(seed)
    drilled = np.array([[10.0 * i, 5.0 * (i % 3)] for i in range(n_holes)])
    hole = np.repeat(np.arange(n_holes), 4)
    spindle = drilled[hole] - offset_mm + random.uniform(-0.2, 0.2, (len(hole), 2))
    seen = drilled[hole] - spindle - offset_mm + random.normal(0, sigma_mm, (len(hole), 2))
    return drilled, hole, spindle, seen


def test_the_spindle_camera_offset_is_found():
    offset_mm = np.array([62.5, -4.0])
    made = panelcal.calibrate_spindle_camera(*looks(9, offset_mm, 0.001), 0.001)
    error = made.offset_mm - offset_mm
    sigma_limit = 5
    assert error @ np.linalg.solve(made.cov_mm2, error) < sigma_limit**2
    assert made.outliers == [] and made.degrees_of_freedom > 0 and made.report


def test_data_that_determine_nothing_are_refused():
    with pytest.raises(panelcal.Error) as error:
        panelcal.calibrate_spindle_camera(*looks(2, np.zeros(2), 0.001), 0.001)
    assert error.value.code == "calibration-data"
    drilled, hole, spindle, seen = looks(4, np.zeros(2), 0.001)
    with pytest.raises(panelcal.Error) as error:
        panelcal.calibrate_spindle_camera(drilled, hole + 1, spindle, seen, 0.001)
    assert error.value.code == "usage"


def test_a_table_from_looks_is_that_of_the_command_line(demo, machine, tmp_path):
    random = np.random.default_rng(2)
    (tmp_path / "plate.toml").write_text(
        "[plate]\ncolumns = 5\nrows = 5\npitch_mm = 40\ndot_diameter_mm = 1\ncertified = true\n"
        "[[pose]]\norigin_mm = [100, 80]\nangle_deg = 0\n")
    scale = 1 + 20e-6  # of the table's x axis
    rows = []
    for i, j in np.ndindex(5, 5):
        axis = np.array([100 + 40 * i, 80 + 40 * j]) + random.uniform(-0.2, 0.2, 2)
        seen = [100 + 40 * i, 80 + 40 * j] - axis * [scale, 1] + random.normal(0, 0.0005, 2)
        rows.append({"pose": 0, "axis": axis.tolist(), "dot": [i, j], "seen": seen.tolist(),
                     "cov": [2.5e-7, 0, 2.5e-7]})
    looks_file = tmp_path / "looks.jsonl"
    looks_file.write_text("".join(json.dumps(row) + "\n" for row in rows))
    clock = "2026-11-21T02:00:00Z"
    made = panelcal.calibrate_table(machine, tmp_path / "plate.toml", measurements=looks_file,
                                    clock=clock)
    run_panelcal("calibrate", "table", "-m", demo / "machine.toml", "--plate", tmp_path / "plate.toml",
                 "--measurements", looks_file, "--clock", clock, "-o", tmp_path / "table.json",
                 "--force")
    assert made.text == (tmp_path / "table.json").read_text()
    assert made.report and made.degrees_of_freedom > 0


def test_a_ledger_has_the_entries_that_history_exports(tmp_path):
    night = ROOT / "examples" / "nightly"
    for name in ("machine.toml", "camera.cal.json"):
        shutil.copy(night / name, tmp_path)
    run_panelcal("nightly", "-m", tmp_path / "machine.toml")
    ledger = tmp_path / "drill1.ledger"
    exported = [json.loads(line)
                for line in run_panelcal("history", "export", "-l", ledger).splitlines()]
    entries = panelcal.history(ledger)
    assert [entry["kind"] for entry in entries].count("spindle-camera") == 1
    for entry, row in zip(entries, exported, strict=True):
        assert {key: row[key] for key in entry} == entry


def test_a_missing_ledger_is_an_error(tmp_path):
    with pytest.raises(panelcal.Error):
        panelcal.history(tmp_path / "none.sqlite")
