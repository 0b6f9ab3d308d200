# SPDX-License-Identifier: Apache-2.0
"""A drilled bore: upper rim, wall that shows on one side, what lies below, burr and halo."""
import numpy as np

from . import geometry
from .fields import lobe, noise, rim_profile, stream
from .lighting import facing
from .target import N_ANGLES


def lower_face(grid, parameters):
    """(shift [u, v] px, scale) of the lower face against the upper one."""
    bore = parameters["bore"]
    if bore["wall_px"] is not None:
        a = np.deg2rad(bore["wall_azimuth_deg"])
        return bore["wall_px"] * np.array([np.cos(a), np.sin(a)]), 1.0
    return grid.view.lower_face(parameters["board"]["thickness_px"])


def paint(scene, u0, v0, diameter_px, name, distance=None, window=None, burr=True):
    """Adds a bore at (u0, v0) to a scene; distance: of its upper rim, if that is not a circle.

    The wall between the rims: depth t from 0 at the upper rim to 1 at the lower one, by distances to
    both. Light falls off as exp(-2.2 t); its azimuth faces the lamp. An unplated wall shows glass ends in
    layers, a plated one a bright band. The lower rim is out of focus: its edge is a ramp of 1.2 px.
    """
    grid, parameters = scene.grid, scene.parameters
    bore = parameters["bore"]
    rng = stream(scene.seed, "bore" + name)
    radius = diameter_px / 2
    if window is None:
        window = grid.window(u0, v0, radius + 12)
    u, v = grid.local(window, u0, v0)
    if u.size == 0:
        return
    upper = geometry.disc(u, v, radius) if distance is None else distance
    shift, scale = lower_face(grid, parameters)
    lower = geometry.disc(u - np.float32(shift[0]), v - np.float32(shift[1]), radius * scale)
    bottom = geometry.coverage(lower, 1.2)
    depth = np.clip(-upper / np.maximum(lower - upper, 1e-3), 0, 1)
    angle = np.arctan2(v - np.float32(shift[1] / 2), u - np.float32(shift[0] / 2))
    lamp = parameters["lamp"]
    light = bore["wall"] * np.exp(-2.2 * depth) * facing(lamp, angle + np.pi)
    if bore["wall_plated"]:
        light = light * (0.6 + 2.2 * np.exp(-((depth - 0.3) / 0.15) ** 2))
    else:
        ends = noise(rng, N_ANGLES, 24, 1.0, (1.0, 6.0))
        k = (angle * (N_ANGLES / (2 * np.pi))).astype(np.int32) % N_ANGLES
        light = light * np.maximum(1 + 0.25 * np.cos(2 * np.pi * 5 * depth) + 0.25 * ends[k, (depth * 23).astype(np.int32)], 0.1)
    inside = light * (1 - bottom) + bore["bottom"] * bottom
    if bore["halo"]:
        # light on glass that the drill has loosened
        uneven = np.interp(angle % (2 * np.pi), np.arange(N_ANGLES) * (2 * np.pi / N_ANGLES),
                           1 + 0.5 * rim_profile(rng, 10.0, radius, N_ANGLES))
        halo = np.exp(-np.maximum(upper, 0) / bore["halo_px"]) * np.clip(uneven, 0, 2)
        scene.add(window, np.clip(bore["halo"] * halo, 0, 1).astype(np.float32), np.float32(0.6))
    scene.add(window, geometry.coverage(upper, grid.h), inside.astype(np.float32))
    if bore["lip"]:
        # solder or plating bends over the rim: facets of every slope, those on the lamp's side mirror it
        uneven = np.clip(1 + 0.4 * rim_profile(rng, 5.0, radius, N_ANGLES), 0, 2)
        k = (angle * (N_ANGLES / (2 * np.pi))).astype(np.int32) % N_ANGLES
        alpha = np.exp(-((upper - np.float32(0.5 * bore["lip_px"])) / bore["lip_px"]) ** 2)
        towards = np.clip(facing(lamp, angle), 0, None) ** 3 + 0.4 * np.clip(facing(lamp, angle + np.pi), 0, None) ** 3
        scene.add(window, (0.85 * alpha).astype(np.float32), (bore["lip"] * 0.5 * towards * uneven[k]).astype(np.float32), metal=True)
    if burr and bore["burr_px"]:
        one = lobe(N_ANGLES, np.deg2rad(bore["burr_deg"]), 1.2)
        mean = (1 - bore["burr_side"]) + bore["burr_side"] * one / one.mean()
        height = bore["burr_px"] * mean * np.clip(1 + 0.8 * rim_profile(rng, 3.0, radius, N_ANGLES), 0, 3)
        edge = geometry.displace(upper, u, v, -height, height.max() + 2)
        alpha = geometry.coverage(upper - np.float32(0.3), grid.h) - geometry.coverage(edge, grid.h)
        spark = np.exp(0.5 * rim_profile(rng, 2.5, radius, N_ANGLES))
        spark = np.interp(angle % (2 * np.pi), np.arange(N_ANGLES) * (2 * np.pi / N_ANGLES), spark)
        value = bore["burr_light"] * spark * facing(lamp, angle)
        scene.add(window, np.clip(alpha, 0, 1), value.astype(np.float32), metal=True)
