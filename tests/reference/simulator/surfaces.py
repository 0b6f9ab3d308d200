# SPDX-License-Identifier: Apache-2.0
"""Textures of laminate, mask and metal on the coarse grid (half the working resolution)."""
import numpy as np

from .fields import blotches, noise, streaks, stream
from .lighting import Lamp


def weave(u, v, board, step_px, rng):
    """Plain glass weave under resin, mean about 0, extremes about -1 and 1.

    Yarns along u and v pass over each other in turn: sin x sin has their checker of crowns; between
    yarns, where both sines are 0, resin shows dark; filaments give streaks along the upper yarn.
    Pitches wander by some percent. Source: plain weaves 7628 to 1080 (IPC-4412); looks: photographs.
    """
    a = np.deg2rad(board["weave_angle_deg"])
    ny, nx = u.shape
    pu, pv = board["weave_pitch_px"]
    su = (u * np.float32(np.cos(a)) + v * np.float32(np.sin(a)) + pu * 0.06 * noise(rng, ny, nx, step_px, 1.5 * pu)) / pu
    sv = (v * np.float32(np.cos(a)) - u * np.float32(np.sin(a)) + pv * 0.06 * noise(rng, ny, nx, step_px, 1.5 * pv)) / pv
    su, sv = np.float32(np.pi) * (su + rng.random()), np.float32(np.pi) * (sv + rng.random())
    bu, bv = np.sin(su), np.sin(sv)
    crown = bu * bv
    gap = (1 - bu * bu) ** 3 * (1 - bv * bv) ** 3
    upper = crown > 0
    filaments = np.where(upper, noise(rng, ny, nx, step_px, (30.0, 1.2)), noise(rng, ny, nx, step_px, (1.2, 30.0)))
    return 0.6 * crown - 1.2 * gap + 0.18 * filaments * np.abs(crown) + 0.1


def laminate_and_mask(u, v, parameters, seed, step_px):
    """(laminate, mask): radiance relative to the material's colour, mean about 1."""
    board, surface = parameters["board"], parameters["surface"]
    rng = stream(seed, "laminate")
    ny, nx = u.shape
    pattern = board["weave"] * weave(u, v, board, step_px, rng) if board["weave"] else np.float32(0)
    fine = surface["grain_board"] * noise(rng, ny, nx, step_px, surface["grain_px"])
    slow = board["mottle"] * noise(rng, ny, nx, step_px, 30.0)
    laminate = np.maximum(1 + pattern + fine + slow, 0.05)
    mask = np.maximum(1 + board["weave_mask"] * pattern + 0.7 * fine + slow, 0.05)
    return laminate.astype(np.float32), mask.astype(np.float32)


def domes(su, sv, u, v, crowns, surface, step_px):
    """Adds to slopes those of a solder dome on each pad (u, v, radius): falls towards the rim."""
    edge = np.tan(np.deg2rad(surface["dome_deg"]))
    for cu, cv, radius in crowns:
        du, dv = u - np.float32(cu), v - np.float32(cv)
        r = np.sqrt(du * du + dv * dv) + np.float32(1e-3)
        near = r < radius * 1.3
        slope = edge * np.minimum(r[near] / radius, 1.1) ** surface["dome_power"]
        su[near] -= slope * du[near] / r[near]
        sv[near] -= slope * dv[near] / r[near]


def metal(u, v, parameters, seed, step_px, crowns):
    """Radiance of bare metal relative to its colour: facets' slopes seen under the lamp, oxide.

    crowns: (u, v, radius) of pads that carry a solder dome.
    """
    surface = parameters["surface"]
    rng = stream(seed, "metal")
    ny, nx = u.shape
    su = surface["grain"] * noise(rng, ny, nx, step_px, surface["grain_px"])
    sv = surface["grain"] * noise(rng, ny, nx, step_px, surface["grain_px"])
    su += surface["waviness"] * noise(rng, ny, nx, step_px, surface["waviness_px"])
    sv += surface["waviness"] * noise(rng, ny, nx, step_px, surface["waviness_px"])
    if surface["brushed"]:
        a = surface["brush_angle_deg"]
        marks = surface["brushed"] * streaks(rng, u, v, a, *surface["brush_px"], step_px)
        su -= marks * np.float32(np.sin(np.deg2rad(a)))
        sv += marks * np.float32(np.cos(np.deg2rad(a)))
    if surface["dome_deg"]:
        domes(su, sv, u, v, crowns, surface, step_px)
    out = Lamp(parameters["lamp"], surface["roughness"]).radiance(su, sv)
    # tarnish and grains of different orientation also differ in colour
    out = out * np.maximum(1 + surface["grain"] * 0.6 * noise(rng, ny, nx, step_px, surface["grain_px"] * 1.5), 0.1)
    if surface["oxide"]:
        rng = stream(seed, "oxide")
        field = 0.85 * noise(rng, ny, nx, step_px, surface["oxide_px"]) + 0.5 * noise(rng, ny, nx, step_px, 2.0)
        out = out * (1 - surface["oxide_depth"] * blotches(field, surface["oxide"], 0.6))
    return out.astype(np.float32)


def flux(u, v, parameters, seed, step_px):
    """(alpha, radiance) of flux residue: a clear film with a bright, wrinkled border."""
    rng = stream(seed, "flux")
    ny, nx = u.shape
    field = noise(rng, ny, nx, step_px, 18.0) + 0.25 * noise(rng, ny, nx, step_px, 4.0)
    film = blotches(field, parameters["surface"]["flux"], 0.5)
    border = 4 * film * (1 - film)
    wrinkles = 1 + 0.4 * noise(rng, ny, nx, step_px, 1.5)
    alpha = np.clip(0.35 * film + 0.45 * border, 0, 1)
    return alpha.astype(np.float32), (0.30 * np.maximum(wrinkles, 0.1)).astype(np.float32)
