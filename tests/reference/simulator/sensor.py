# SPDX-License-Identifier: Apache-2.0
"""From irradiance to digital numbers: photons, reading noise, fixed patterns, converter, mosaic."""
import numpy as np

from .fields import stream

BAYER = {"RG": ((0, 1), (1, 2)), "GR": ((1, 0), (2, 1)), "GB": ((1, 2), (0, 1)), "BG": ((2, 1), (1, 0))}


def mosaic(rgb, pattern):
    """One value a pixel, of the colour that its filter passes; rgb: [3, height, width]."""
    out = np.empty(rgb.shape[1:], np.float32)
    for j in (0, 1):
        for i in (0, 1):
            out[j::2, i::2] = rgb[BAYER[pattern][j][i], j::2, i::2]
    return out


def expose(irradiance, sensor, seed):
    """Digital numbers 0 to 2^bits - 1 (float32 that holds integers), irradiance 1 = full well.

    Electrons: n = Poisson(fw E (1 + PRNU)), as a normal variable; plus reading noise, an offset per
    row (new in every picture) and one per column (fixed pattern). Source: EMVA 1288 linear model.
    """
    rng = stream(seed, "sensor")
    fw = np.float32(sensor["full_well_e"])
    h, w = irradiance.shape
    n = np.clip(irradiance, 0, None) * fw
    if sensor["prnu"]:
        n = n * (1 + np.float32(sensor["prnu"]) * rng.standard_normal((h, w), dtype=np.float32))
    if sensor["shot"]:
        n = n + np.sqrt(np.maximum(n, 0)) * rng.standard_normal((h, w), dtype=np.float32)
    n = np.minimum(n, fw)
    if sensor["read_e"]:
        n = n + np.float32(sensor["read_e"]) * rng.standard_normal((h, w), dtype=np.float32)
    if sensor["row_e"]:
        n = n + np.float32(sensor["row_e"]) * rng.standard_normal((h, 1), dtype=np.float32)
    if sensor["column_e"]:
        n = n + np.float32(sensor["column_e"]) * rng.standard_normal((1, w), dtype=np.float32)
    top = 2 ** sensor["bits"] - 1
    black = np.float32(sensor["black"] * top)
    return np.clip(np.floor(n * np.float32((top - black) / fw) + black + 0.5), 0, top)


def noise_levels(irradiance, sensor):
    """Sigma of expose() at a flat irradiance, in parts of full scale, quantisation included."""
    fw = sensor["full_well_e"]
    n = irradiance * fw
    var = (n if sensor["shot"] else 0) + (sensor["prnu"] * n) ** 2
    var += sensor["read_e"] ** 2 + sensor["row_e"] ** 2 + sensor["column_e"] ** 2
    return float(np.sqrt(var / fw ** 2 * (1 - sensor["black"]) ** 2 + 1 / 12 / (2 ** sensor["bits"] - 1) ** 2))
