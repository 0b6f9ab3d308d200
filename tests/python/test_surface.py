# SPDX-License-Identifier: Apache-2.0
import json

import numpy as np
import pytest

import panelcal
from conftest import run_panelcal


def probes():
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 100, 6), np.linspace(0, 80, 5)))
    height = 1.5 + 0.1 * np.sin(x / 30) + 1e-3 * y
    return np.column_stack([x, y]), height + np.random.default_rng(1).normal(0, 0.002, x.size)


def test_a_map_of_a_file_is_that_of_the_command_line(tmp_path):
    places, heights = probes()
    log = tmp_path / "probes.txt"
    log.write_text("".join(f"{x:.4f} {y:.4f} {z:.5f}\n" for (x, y), z in zip(places, heights)))
    run_panelcal("surface", "fit", log, "-o", tmp_path / "map.json")
    surface = panelcal.fit_surface(log)
    assert surface.text == (tmp_path / "map.json").read_text()
    text = log.read_bytes()
    with pytest.raises(panelcal.Error) as error:
        surface.save(tmp_path / "." / "probes.txt")
    assert (error.value.code, error.value.file) == ("output-in-use", "panelcal.Surface.save")
    assert log.read_bytes() == text
    asked = np.array([[12.5, 33.25], [50, 40], [101, 20], [300, 0]])
    run_panelcal("surface", "query", tmp_path / "map.json", *(f"{x},{y}" for x, y in asked),
                 "--json", tmp_path / "query.json", check=False)
    table = json.loads((tmp_path / "query.json").read_text())["places"]
    heights = panelcal.read_surface(tmp_path / "map.json").query(asked)
    for key in ("height_mm", "sigma_um"):
        expected = np.array(table[key], float)
        assert np.array_equal(heights[key], expected, equal_nan=True), key
    words = table["source"]
    assert heights["source"] == [words["words"][i] for i in words["index"]]
    assert heights["source"][-1] == "refused" and np.isnan(heights["height_mm"][-1])


def test_arrays_make_the_same_surface_and_find_a_wild_probe(tmp_path):
    places, heights = probes()
    wild = 7
    heights[wild] += 0.5
    surface = panelcal.fit_surface(places, heights, 2)
    assert surface.outliers == [wild] and surface.n_probes == len(places)
    surface.save(tmp_path / "map.json")
    again = panelcal.read_surface(tmp_path / "map.json").query(places)
    assert np.array_equal(again["height_mm"], surface.query(places)["height_mm"])
    others = np.arange(len(places)) != wild
    sigma_limit = 5
    assert np.abs(again["height_mm"] - heights)[others].max() < sigma_limit * 0.002


def test_probes_that_make_no_surface_are_refused():
    with pytest.raises(panelcal.Error) as error:
        panelcal.fit_surface([[0, 0], [1, 1], [2, 2]], [0, 0, 0], 2)
    assert error.value.code == "grid-invalid"
    with pytest.raises(panelcal.Error, match="auto"):
        panelcal.fit_surface(*probes(), 2, model="plan")
    with pytest.raises(TypeError):
        panelcal.fit_surface(probes()[0])
