# SPDX-License-Identifier: Apache-2.0
"""The target's outline as artwork and as etching left it."""
import numpy as np

from . import geometry
from .fields import lobe, noise, rim_profile, stream

N_ANGLES = 720


def reach(target):
    """Radius about the centre that holds the whole target, px."""
    half = target["size_px"] / 2
    return half * {"square": 1.42, "diamond": 1.42, "tag": 1.8, "triangle": 1.2, "cross": 1.1}.get(target["shape"], 1.0)


def artwork(target, u, v):
    """Distance to the nominal outline of all shapes but tags; u, v turned with the target."""
    shape, half = target["shape"], target["size_px"] / 2
    if shape in ("disc", "hole"):
        return geometry.disc(u, v, half)
    if shape == "ring":
        du, dv = target["inner_offset_px"]
        return np.maximum(geometry.disc(u, v, half),
                          -geometry.disc(u - np.float32(du), v - np.float32(dv), target["inner_px"] / 2))
    if shape == "square":
        return geometry.box(u, v, half, half)
    if shape == "diamond":
        c = np.float32(np.sqrt(0.5))
        return geometry.box(c * (u + v), c * (v - u), half, half)
    if shape == "cross":
        return geometry.cross(u, v, half, target["width_px"] / 2)
    if shape == "triangle":
        return geometry.triangle(u, v, target["size_px"])
    raise SystemExit(f'render.py: unknown shape: "{shape}"; disc, hole, ring, square, diamond, cross, tag, triangle or none')


def outline_point(target, rng):
    """A random point of the nominal outline, board px about the target's centre, and the outline's length."""
    half, shape = target["size_px"] / 2, target["shape"]
    if shape in ("disc", "hole", "ring", "none"):
        a = rng.uniform(0, 2 * np.pi)
        return half * np.cos(a), half * np.sin(a), 2 * np.pi * half
    if shape == "triangle":
        p = (target["size_px"] / np.sqrt(12.0), rng.uniform(-half, half))
        a, length = np.pi / 2 + rng.integers(3) * 2 * np.pi / 3, 6 * half
    elif shape == "cross":
        w = target["width_px"] / 2
        p = (rng.uniform(w, half), rng.choice([-w, w]))
        a, length = rng.integers(4) * np.pi / 2, 8 * half
    else:
        p = (half, rng.uniform(-half, half))
        a, length = rng.integers(4) * np.pi / 2 + (np.pi / 4 if shape == "diamond" else 0), 8 * half
    a += np.deg2rad(target["angle_deg"])
    c, s = np.cos(a), np.sin(a)
    return p[0] * c - p[1] * s, p[0] * s + p[1] * c, length


def outline_shift(parameters, seed):
    """Displacement of the outline over 720 angles, px outwards: roughness of round shapes, etching."""
    rim, target = parameters["rim"], parameters["target"]
    radius = target["size_px"] / 2
    rng = stream(seed, "rim")
    delta = np.zeros(N_ANGLES)
    if rim["rough_px"] and target["shape"] in ("disc", "hole", "ring"):
        delta += rim["rough_px"] * rim_profile(rng, rim["rough_corr_px"], radius, N_ANGLES)
    # etching takes metal: a bright target shrinks, an opening in metal grows
    sign = -1 if target["polarity"] == "bright" and target["shape"] != "hole" else 1
    delta += sign * rim["etch_px"]
    if rim["etch_side_px"]:
        width = np.deg2rad(rim["etch_side_width_deg"])
        delta += sign * rim["etch_side_px"] * lobe(N_ANGLES, np.deg2rad(rim["etch_side_deg"]), width)
    return delta


def torn(distance, u, v, parameters, seed):
    """Takes ragged bites out of metal at random places of an outline; out of what is around a bore."""
    rim, target = parameters["rim"], parameters["target"]
    rng = stream(seed, "torn")
    angle = np.deg2rad(target["angle_deg"])
    for _ in range(int(rim["torn"])):
        pu, pv, _ = outline_point(target, rng)
        # u, v are turned with the target, the point is not
        pu, pv = pu * np.cos(angle) + pv * np.sin(angle), pv * np.cos(angle) - pu * np.sin(angle)
        radius = rim["torn_px"] * rng.uniform(0.6, 1.2)
        du, dv = (u - np.float32(pu)) * np.float32(rng.uniform(0.6, 1.0)), v - np.float32(pv)
        bite = geometry.disc(du, dv, radius)
        bite = geometry.displace(bite, du, dv, 0.25 * radius * rim_profile(rng, 1.5, radius, N_ANGLES), radius)
        if target["shape"] == "hole" or target["polarity"] == "dark":
            distance = np.minimum(distance, bite)
        else:
            distance = np.maximum(distance, -bite)
    return distance


class Outline:
    """Target on the grid: its window, distances (px, negative inside) and covered part of samples."""

    def __init__(self, grid, parameters, seed):
        target, rim = parameters["target"], parameters["rim"]
        self.window = grid.window(0, 0, reach(target) + 16)
        self.u, self.v = grid.local(self.window, 0, 0, np.deg2rad(target["angle_deg"]))
        if target["shape"] == "tag":
            u, v = self.u, self.v
            if rim["rough_px"]:
                rng = stream(seed, "rim")
                u = u + rim["rough_px"] * noise(rng, *u.shape, grid.h, rim["rough_corr_px"])
                v = v + rim["rough_px"] * noise(rng, *v.shape, grid.h, rim["rough_corr_px"])
            white, plate = geometry.tag_coverage(u, v, target["size_px"], geometry.tag_cells(geometry.TAG36H11[target["tag_id"]]), grid.h)
            self.plate = plate
            self.black = (1 - white) * geometry.coverage(plate, grid.h)
            self.nominal = self.distance = plate
            self.covered = geometry.coverage(plate, grid.h)
            return
        self.nominal = artwork(target, self.u, self.v)
        delta = outline_shift(parameters, seed)
        self.distance = self.nominal
        if np.any(delta):
            self.distance = geometry.displace(self.nominal, self.u, self.v, delta, np.abs(delta).max() + 2)
        if rim["rough_px"] and target["shape"] not in ("disc", "hole", "ring"):
            rng = stream(seed, "rim")
            self.distance = self.distance + rim["rough_px"] * noise(rng, *self.u.shape, grid.h, rim["rough_corr_px"])
        if rim["torn"]:
            self.distance = torn(self.distance, self.u, self.v, parameters, seed)
        self.covered = geometry.coverage(self.distance, grid.h)
