# SPDX-License-Identifier: Apache-2.0
import json
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import panelcal
from conftest import run_panelcal


def test_rows_are_those_of_the_command_line_to_the_bit(demo, machine):
    files = sorted((demo / "images").glob("*.png"))[:8]
    for tool in machine.targets:
        lines = run_panelcal("locate", *files, "--tool", tool, "-m", demo / "machine.toml",
                             "--candidates").splitlines()
        assert len(lines) == len(files)
        for file, line in zip(files, lines):
            found = panelcal.locate(panelcal.read_image(file), tool, machine)
            assert panelcal.located_row(found, str(file), tool, candidates=True) == json.loads(line)


def test_an_image_and_arrays_of_any_type_give_the_same(demo, machine):
    image = panelcal.read_image(next((demo / "images").glob("*.png")))
    levels = np.asarray(image)
    row = panelcal.located_row(panelcal.locate(image, 1, machine))
    bordered = np.zeros((levels.shape[0], levels.shape[1], 3), np.uint8)
    bordered[:, :, 1] = levels
    for pixels in (levels.astype(np.uint8), np.asfortranarray(levels.astype(np.uint8)),
                   bordered[:, :, 1], levels.astype(np.uint8)[::-1][::-1]):
        assert panelcal.located_row(panelcal.locate(pixels, 1, machine)) == row
    for pixels in (levels, levels.astype(np.float64)):
        found = panelcal.locate(pixels, 1, machine, full_scale=255)
        assert panelcal.located_row(found) == row


def test_arrays_that_came_through_pickle_are_as_good():
    for dtype, full_scale in ((np.uint8, None), (np.uint16, None), (np.float32, 255),
                              (np.float64, 255)):
        pixels = pickle.loads(pickle.dumps(np.full((2, 3), 7, dtype)))
        assert np.asarray(panelcal.Image(pixels, full_scale)).tolist() == [[7, 7, 7], [7, 7, 7]]


def test_pixels_are_a_view_of_the_image():
    image = panelcal.Image(np.full((3, 4), 7, np.uint16))
    view = np.asarray(image)
    assert view.shape == image.shape == (3, 4) and image.full_scale == 65535
    view[2, 3] = 9
    assert np.asarray(image)[2, 3] == 9 and np.shares_memory(view, np.asarray(image))
    del image
    assert view[2, 3] == 9, "the view keeps the image alive"


@pytest.mark.parametrize("pixels, full_scale", [
    (np.zeros(5, np.uint8), None), (np.zeros((2, 2), np.int32), None),
    (np.zeros((2, 2), np.float32), None), (np.full((2, 2), np.nan), 255),
    (np.full((2, 2), 300.0), 255), (np.zeros((2, 2), np.uint16), 255),
    (np.zeros((2, 2), np.uint8), 100), (np.zeros((2, 2), ">u2"), None)])
def test_pixels_that_mean_nothing_are_refused(pixels, full_scale):
    with pytest.raises(panelcal.Error) as error:
        panelcal.Image(pixels, full_scale)
    assert (error.value.code, error.value.file) == ("usage", "panelcal.Image")


def test_rendered_targets_are_found_where_they_are():
    for target in (panelcal.Target("disc", size_px=40), panelcal.Target("ring", size_px=50),
                   panelcal.Target("square", size_px=44, angle_deg=3),
                   panelcal.Target("cross", size_px=60, width_px=12),
                   panelcal.Target("apriltag", size_px=80, id=5)):
        ground, level = 0.25, 0.75
        image = panelcal.render(target, size_px=(220, 180), center_px=(107.3, 91.8), noise=1.5,
                                level=level, ground=ground)
        found = panelcal.locate(image, target)
        assert found.found, (target, found)
        error = found.center_px - (107.3, 91.8)
        sigma_limit = 5
        assert error @ np.linalg.solve(found.cov_px2, error) < sigma_limit**2, target
        assert np.linalg.norm(error) < 0.1, target


def test_a_mapping_gives_millimetres():
    mapping = panelcal.CameraMapping(0.0125, axis_px=(120.5, 80), rotation_rad=0.01, k1_per_px2=1e-8)
    target = panelcal.Target("disc", size_mm=0.5)
    image = panelcal.render(target, size_px=(240, 160), center_px=(100, 90), mapping=mapping)
    found = panelcal.locate(image, target, mapping=mapping)
    assert found.found and abs(found.size_mm - 0.5) < 1e-3
    assert np.allclose(found.center_mm, mapping([100, 90])[0], atol=1e-4)
    assert not panelcal.locate(image, target).found, "a size in mm says nothing of pixels"


def test_nothing_is_found_in_nothing():
    found = panelcal.locate(np.full((100, 100), 80, np.uint8), panelcal.Target("disc", size_px=30))
    assert (found.found, found.status, found.center_px) == (False, "not_found", None)
    assert found.reason


def test_limits_and_the_place_to_search_are_heeded():
    target = panelcal.Target("disc", size_px=30)
    image = panelcal.render(target, size_px=(200, 100), center_px=(50, 50))
    assert panelcal.locate(image, target, search_center_px=(52, 50), search_radius_px=10).found
    assert not panelcal.locate(image, target, search_center_px=(150, 50), search_radius_px=10).found
    assert not panelcal.locate(image, target, min_contrast=0.9).found
    with pytest.raises(panelcal.Error, match="min_contrast"):
        panelcal.locate(image, target, min_contrst=0.1)
    with pytest.raises(panelcal.Error, match="size_px"):
        panelcal.Target("disc", sizepx=30)
    with pytest.raises(panelcal.Error) as error:
        panelcal.Target("disc", size_px=-1)
    assert error.value.code == "target-invalid"


def test_threads_find_what_one_finds(machine):
    samples = panelcal.Samples(machine, 1, seed=5)
    pictures = [samples(i)[0] for i in range(8)]

    def row(image):
        return panelcal.located_row(panelcal.locate(image, 1, machine))

    expected = [row(image) for image in pictures]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(3):
            assert list(pool.map(row, pictures)) == expected


def test_samples_are_the_pictures_of_synth(demo, machine, tmp_path):
    run_panelcal("synth", "-m", demo / "machine.toml", "--tool", 1, "--count", 3, "-o", tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())
    samples = panelcal.Samples(machine, 1)
    for i in range(3):
        image, known = samples(i)
        assert np.array_equal(image, panelcal.read_image(tmp_path / f"{i:04}.png"))
        assert known["center_px"].tolist() == truth["pictures"][i]["center_px"]
    with pytest.raises(panelcal.Error, match="picture -1"):
        samples(-1)
