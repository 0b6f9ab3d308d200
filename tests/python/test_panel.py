# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

import panelcal

NOMINAL = np.array([[0, 0], [300, 0], [300, 200], [0, 200], [150, 100.0]])


def moved(angle_rad, stretch, shift_mm):
    turn = np.array([[np.cos(angle_rad), -np.sin(angle_rad)], [np.sin(angle_rad), np.cos(angle_rad)]])
    return NOMINAL @ (turn @ np.diag(stretch)).T + shift_mm


def test_a_stretched_panel_is_found():
    fit = panelcal.fit_panel(NOMINAL, moved(0.002, [1.0003, 0.9998], [0.4, -0.2]), 0.001,
                             model="stretch")
    assert fit.model == "stretch" and not fit.is_smooth
    for (value, sigma), truth in ((fit.rotation_rad, 0.002), (fit.stretch_x_ppm, 300),
                                  (fit.stretch_y_ppm, -200)):
        assert abs(value - truth) < 1e-6 * max(1, abs(truth)) and sigma > 0
    assert np.abs(fit.residuals_mm).max() < 1e-9 and fit.degrees_of_freedom == 5
    places, cov = fit(NOMINAL)
    assert places.shape == (5, 2) and cov.shape == (5, 2, 2)
    assert np.allclose(places, NOMINAL @ fit.matrix.T + fit.shift_mm, atol=1e-9)


def test_the_covariance_is_that_of_the_textbook():
    sigma_mm = 0.003
    fit = panelcal.fit_panel(NOMINAL, NOMINAL, sigma_mm, model="affine")
    design = np.column_stack([NOMINAL, np.ones(len(NOMINAL))])
    row = np.linalg.inv(design.T @ design) * sigma_mm**2  # of l00, l01, tx: Gauss-Markov
    assert np.allclose(fit.cov[np.ix_([0, 1, 4], [0, 1, 4])], row, rtol=1e-9, atol=1e-18)


def test_covariances_of_all_shapes_mean_the_same():
    one = np.diag([4e-6, 1e-6])
    fits = [panelcal.fit_panel(NOMINAL, NOMINAL + [0.1, 0], cov, model="rigid").cov
            for cov in (one, np.broadcast_to(one, (5, 2, 2)))]
    assert np.array_equal(*fits)


def test_targets_choose_their_model():
    noise = np.random.default_rng(3).normal(0, 0.001, NOMINAL.shape)
    assert panelcal.fit_panel(NOMINAL, moved(0, [1.002, 0.998], 0) + noise, 0.001).model == "stretch"


@pytest.mark.parametrize("nominal, measured, model, code", [
    (NOMINAL[:1], NOMINAL[:1], "affine", "targets-too-few"),
    (NOMINAL[[0, 0, 0]], NOMINAL[:3], "affine", "series-degenerate"),
    (NOMINAL, NOMINAL * [-1, 1], "affine", "panel-mirrored"),
    (NOMINAL, NOMINAL[:4], "rigid", "usage"),
    (NOMINAL, np.full_like(NOMINAL, np.nan), "rigid", "measurement-invalid"),
    (NOMINAL, NOMINAL, "rgid", "usage"),
    (np.zeros((3, 3)), NOMINAL, "rigid", "usage")])
def test_what_is_no_panel_is_refused(nominal, measured, model, code):
    with pytest.raises(panelcal.Error) as error:
        panelcal.fit_panel(nominal, measured, 0.001, model=model)
    assert error.value.code == code
