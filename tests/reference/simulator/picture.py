# SPDX-License-Identifier: Apache-2.0
"""One picture and its truth, from parameters and a seed."""
import numpy as np

from . import process
from .grid import Grid, View
from .lens import Optics
from .parameters import changed
from .scene import Scene
from .sensor import expose, mosaic, noise_levels


def irradiance(parameters, seed):
    """([planes, height, width], scene, optics): noise-free light on the pixels, in scene units.

    Planes are red, green and blue for a mosaic, otherwise one grey plane.
    """
    p = parameters
    view = View(p["view"], p["target"]["centre_px"])
    grid = Grid(p["picture"]["width_px"], p["picture"]["height_px"], p["picture"]["supersample"], view)
    scene = Scene(grid, p, seed)
    lens, lamp = p["lens"], np.array(p["lamp"]["rgb"], float)
    colours = bool(p["sensor"]["bayer"]) or lens["chromatic"]
    away = np.subtract(p["target"]["centre_px"], p["view"]["axis_px"]) / 1000
    if not colours:
        optics = [Optics(grid, lens, p["motion"], 0.0, (0.0, 0.0), p["sensor"]["fill_factor"])]
        planes = [optics[0].pixels(scene.radiance([lamp])[0])]
        return np.stack(planes), scene, optics
    # a mosaic's own filters see the lamp in thirds; a grey sensor weighs its colours
    weights = np.eye(3) if p["sensor"]["bayer"] else np.diag(lamp)
    optics, planes = [], []
    for i, radiance in enumerate(scene.radiance(weights)):
        if optics and not lens["chromatic"]:
            one = optics[0]
        else:
            shift = away * lens["lateral_per_1000px"][i]
            one = Optics(grid, lens, p["motion"], lens["axial_waves"][i], shift, p["sensor"]["fill_factor"])
        optics.append(one)
        planes.append(one.pixels(radiance))
    planes = np.stack(planes)
    if not p["sensor"]["bayer"]:
        planes = planes.sum(0, keepdims=True)
    return planes, scene, optics


def _levels(grey, scene):
    """(inside, around) the target: mean noise-free light, pixels whose centre is clear of the rim."""
    g, p = scene.grid, scene.parameters
    ss = g.ss
    if scene.outline is None:
        return None
    full = np.full(g.shape, 1e3, np.float32)
    full[scene.outline.window] = scene.outline.nominal
    inside_of = full
    if p["target"]["shape"] == "tag":
        inside_of = np.full(g.shape, 1e3, np.float32)
        inside_of[scene.outline.window] = np.where(scene.outline.black > 0.99, -1e3, 1e3)

    def pixels(a):
        return a[ss // 2::ss, ss // 2::ss][g.top:g.top + g.height, g.left:g.left + g.width]
    d, inner = pixels(full), pixels(inside_of)
    depth = -0.35 * min(p["target"]["width_px"] if p["target"]["shape"] == "cross" else 6.0, 6.0)
    inside, around = inner < depth, (d > 2.5) & (d < 8)
    if p["target"]["shape"] == "tag":
        around = (d < -1) & (inner > 0)
    if not inside.any() or not around.any():
        return None
    return float(grey[inside].mean()), float(grey[around].mean())


def _develop(planes, p, seed):
    """Sensor and processing: [1 or 3, height, width] in 0 to 1, from light scaled to full well."""
    sensor, steps = p["sensor"], p["process"]
    top = 2 ** sensor["bits"] - 1
    if sensor["bayer"]:
        sensitivity = np.array([0.65, 1.0, 0.75], np.float32)[:, None, None]
        raw = expose(mosaic(planes * sensitivity, sensor["bayer"]), sensor, seed) / np.float32(top)
        if sensor["white_balance"]:
            black = np.float32(sensor["black"])
            gain = mosaic(np.broadcast_to(1 / sensitivity, planes.shape), sensor["bayer"])
            raw = np.clip((raw - black) * gain + black, 0, 1)
        if steps["demosaic"] == "none":
            out = raw[None]
        else:
            out = np.clip(process.demosaic(raw, sensor["bayer"], steps["demosaic"]), 0, 1)
            if not steps["colour"]:
                out = np.tensordot(process.LUMA, out, 1)[None]
    else:
        out = expose(planes[0], sensor, seed)[None] / np.float32(top)
    if steps["subtract_black"]:
        out = np.clip((out - np.float32(sensor["black"])) * np.float32(1 / (1 - sensor["black"])), 0, 1)
    if steps["saturation"] != 1 and len(out) == 3:
        luma = np.tensordot(process.LUMA, out, 1)
        out = np.clip(luma + np.float32(steps["saturation"]) * (out - luma), 0, 1)
    if steps["denoise"] == "bilateral":
        out = np.stack([process.bilateral(a, int(steps["denoise_px"]), 1.5, steps["denoise_level"]) for a in out])
    elif steps["denoise"] == "nonlocal":
        out = np.stack([process.nonlocal_means(a, int(steps["denoise_px"]), steps["denoise_level"]) for a in out])
    if steps["sharpen"]:
        out = np.stack([process.sharpen(a, steps["sharpen"], steps["sharpen_px"]) for a in out])
    if steps["gamma"] != 1:
        out = out ** np.float32(1 / steps["gamma"])
    if steps["jpeg"]:
        out = process.jpeg(out, steps["jpeg"])
    return np.clip(out, 0, 1)


def _numbers(out, p):
    """Integers of the file: uint8, or uint16 with 10 or 12 bits low or shifted up."""
    bits = p["sensor"]["bits"]
    depth = p["process"]["depth"] or (8 if bits == 8 or p["process"]["jpeg"] else 16)
    if depth == 8:
        a = np.rint(out * 255).astype(np.uint8)
    elif bits < 16 and p["process"]["align"] == "low":
        a = np.rint(out * (2 ** bits - 1)).astype(np.uint16)
    else:
        a = (np.rint(out * (2 ** bits - 1)).astype(np.uint32) << (16 - bits)).astype(np.uint16)
    return a[0] if len(a) == 1 else np.ascontiguousarray(a.transpose(1, 2, 0))


def render(parameters, seed):
    """(picture, truth): uint8 or uint16, [height, width] or [height, width, 3], and a JSON-able dict.

    Truth: centre_px is where the centre of the artwork's outline lies in the picture, of a bore its axis
    at the upper face, whatever etching, dirt and light made of it. Noise and contrast are parts of full
    scale at the sensor, before any processing; contrast is inside minus around.
    """
    p = parameters
    planes, scene, optics = irradiance(p, seed)
    grey = planes[0] if len(planes) == 1 else np.tensordot(process.LUMA, planes, 1)
    levels = _levels(grey, scene)
    gain = p["sensor"]["level"] / max(max(levels) if levels else float(np.quantile(grey, 0.95)), 1e-3)
    picture = _numbers(_develop(planes * np.float32(gain), p, seed), p)
    target = p["target"]
    has = target["shape"] != "none"
    shape = target["shape"] if has else target["unlike"]
    middle = gain * (sum(levels) / 2 if levels else float(grey.mean()))
    truth = {
        "shape": shape,
        "has_target": has,
        "centre_px": [round(float(c), 6) for c in target["centre_px"]] if has else None,
        "size_px": round(float(target["size_px"]), 4),
        "polarity": "dark" if shape == "hole" else target["polarity"],
        "angle_deg": target["angle_deg"],
        "blur_px": round(optics[len(optics) // 2].blur_px(), 4),
        "noise": round(noise_levels(min(middle, 1.0), p["sensor"]), 6),
        "contrast": round(gain * (levels[0] - levels[1]), 4) if levels else None,
        "bits": p["sensor"]["bits"],
    }
    if truth["shape"] == "ring":
        truth["inner_px"] = round(float(target["inner_px"]), 4)
    if truth["shape"] == "cross":
        truth["width_px"] = round(float(target["width_px"]), 4)
    if truth["shape"] == "tag":
        truth["id"] = target["tag_id"]
    truth["seed"] = int(seed)
    truth["parameters"] = changed(p)
    return picture, truth
