# SPDX-License-Identifier: Apache-2.0
"""A board as layers on the working grid, and the radiance of each colour that follows.

From below: laminate; copper (covered part C of each sample); mask, open where O; then painted layers:
bores, silk screen, dirt. Where mask is closed its colour depends on what lies under it.
"""
import numpy as np

from . import bore, clutter, dirt, geometry, surfaces
from .lighting import shading
from .target import Outline, reach


class Scene:
    def __init__(self, grid, parameters, seed):
        self.grid, self.parameters, self.seed = grid, parameters, seed
        self.layers, self.later = [], []
        self.crowns, self.taken = [], []
        self.reach = reach(parameters["target"]) if parameters["target"]["shape"] != "none" else 0.0
        self.masked = parameters["board"]["style"] == "mask"
        self.c = np.zeros(grid.shape, np.float32)
        self.o = np.zeros(grid.shape, np.float32) if self.masked else None
        self.outline = None
        self._build()

    # what builders call

    def add(self, window, alpha, value, metal=False, scratch=False):
        """Paints over a window: L = L (1 - alpha) + alpha value; a scratch multiplies L by value."""
        self.layers.append((window, alpha, value, "scratch" if scratch else "metal" if metal else "grey"))

    def copper(self, window, distance, open_by=None):
        """Adds copper, and an opening of the mask that is open_by px larger."""
        c = self.c[window]
        np.maximum(c, geometry.coverage(distance, self.grid.h), out=c)
        if self.masked and open_by is not None:
            self.open(window, distance - np.float32(open_by))

    def open(self, window, distance):
        o = self.o[window]
        # the mask's edge is not vertical and light creeps under it: a ramp of 1 px
        np.maximum(o, geometry.coverage(distance, 1.0), out=o)

    def copper_line(self, a, b, half, avoid=False):
        """A track from a to b (board px); `half` may differ at the ends. avoid: stops before the target."""
        a, b = np.asarray(a, float), np.asarray(b, float)
        r = max(half) if isinstance(half, tuple) else half
        pa, pb = self.grid._picture(*a), self.grid._picture(*b)

        def span(p, q, axis):
            return slice(int(np.searchsorted(axis, min(p, q) - r - 2)), int(np.searchsorted(axis, max(p, q) + r + 2)))
        window = (span(pa[1], pb[1], self.grid.y), span(pa[0], pb[0], self.grid.x))
        u, v = self.grid.local(window)
        if u.size == 0:
            return
        d = geometry.capsule(u, v, a, b, half)
        if avoid:
            clear = self.reach + self.parameters["clutter"]["clearance_px"]
            d = np.maximum(d, np.float32(clear) - np.sqrt(u * u + v * v))
        self.copper(window, d)

    # construction

    def _build(self):
        p = self.parameters
        target, board = p["target"], p["board"]
        shape = target["shape"]
        sheet = board["style"] == "copper"
        if sheet:
            self.c[:] = 1
        if shape != "none":
            self.outline = Outline(self.grid, p, self.seed)
            if p["clutter"]["plane"]:
                gap = self.reach + p["clutter"]["plane"]
                self.copper((slice(None), slice(None)), np.float32(gap) - np.sqrt(self.grid.u ** 2 + self.grid.v ** 2))
            self.taken.append((0.0, 0.0, self.reach + p["clutter"]["clearance_px"]))
        clutter.build(self)
        if shape != "none":
            self._target()
        for paint in self.later:
            paint()
        if p["rim"]["breakout_px"] and shape != "none":
            a, r = np.deg2rad(p["rim"]["breakout_deg"]), p["rim"]["breakout_diameter_px"] / 2
            away = target["size_px"] / 2 + r - p["rim"]["breakout_px"]
            bore.paint(self, away * np.cos(a), away * np.sin(a), 2 * r, "breakout", burr=False)
        dirt.build(self)

    def _target(self):
        p, w, outline = self.parameters, self.outline.window, self.outline
        target, board = p["target"], p["board"]
        h = self.grid.h
        if target["shape"] == "hole":
            if p["bore"]["pad_px"]:
                su, sv = p["bore"]["pad_shift_px"]
                r = p["bore"]["pad_px"] / 2
                window = self.grid.window(su, sv, r + 10)
                u, v = self.grid.local(window, su, sv)
                self.copper(window, geometry.disc(u, v, r), open_by=board["opening_px"])
                self.crowns.append((su, sv, r))
            elif self.masked:
                self.open(w, outline.distance - np.float32(board["opening_px"]))
            u, v = self.grid.local(w)
            bore.paint(self, 0.0, 0.0, target["size_px"], "target", distance=outline.distance, window=w)
            return
        c = self.c[w]
        du, dv = target["inner_offset_px"]
        if target["shape"] == "ring" and target["polarity"] == "bright":
            # a track that ends at a ring does not fill its hole
            c *= 1 - geometry.coverage(geometry.disc(outline.u - np.float32(du), outline.v - np.float32(dv), target["inner_px"] / 2), h)
        if target["shape"] == "tag":
            dark = outline.black if target["polarity"] == "bright" else outline.covered - outline.black
            c *= 1 - outline.covered
            c += outline.covered - dark
        elif target["polarity"] == "bright":
            np.maximum(c, outline.covered, out=c)
        else:
            c *= 1 - outline.covered
        if target["shape"] == "ring" and target["inner"] == "bored":
            a = np.deg2rad(target["angle_deg"])
            bore.paint(self, du * np.cos(a) - dv * np.sin(a), du * np.sin(a) + dv * np.cos(a), target["inner_px"], "ring")
        if target["drill_px"]:
            bore.paint(self, *target["drill_offset_px"], target["drill_px"], "drill")
        if self.masked:
            self.open(w, outline.nominal - np.float32(board["opening_px"]))
        if target["polarity"] == "bright":
            du, dv = p["surface"]["dome_shift_px"]
            self.crowns.append((du, dv, target["size_px"] / 2))

    # radiance

    def _metal(self, u, v):
        """Shading of metal on the working grid, the etched flank of the target's outline included."""
        p, outline = self.parameters, self.outline
        metal = self.grid.spread(surfaces.metal(u, v, p, self.seed, 2 * self.grid.h, self.crowns))
        rim = p["rim"]
        if outline is not None and rim["band"] and p["target"]["shape"] not in ("tag", "hole"):
            inwards = outline.distance if p["target"]["polarity"] == "bright" else -outline.distance
            band = np.clip(1 + inwards * np.float32(1 / rim["band_px"]), 0, 1)
            a = np.deg2rad(p["lamp"]["azimuth_deg"] - p["target"]["angle_deg"])
            r = np.sqrt(outline.u ** 2 + outline.v ** 2) + np.float32(1e-3)
            lean = (outline.u * np.float32(np.cos(a)) + outline.v * np.float32(np.sin(a))) / r
            if p["target"]["polarity"] != "bright":
                lean = -lean
            metal[outline.window] *= np.maximum(1 + rim["band"] * band * (1 + 2 * p["lamp"]["uneven"] * lean), 0.05)
        return metal

    def _ridge(self):
        """Light on the slope of the mask where it climbs copper, on the coarse grid."""
        c = self.c.reshape(self.c.shape[0] // 2, 2, self.c.shape[1] // 2, 2).mean((1, 3))
        k = 3
        for axis in (0, 1):
            s = np.cumsum(np.concatenate([np.repeat(np.take(c, [0], axis), k, axis), c,
                                          np.repeat(np.take(c, [-1], axis), k, axis)], axis), axis)
            n = c.shape[axis]
            c = (np.take(s, range(2 * k - 1, n + 2 * k - 1), axis) - np.take(s, range(n), axis)) / (2 * k - 1)
        gv, gu = np.gradient(c)
        a = np.deg2rad(self.parameters["lamp"]["azimuth_deg"])
        steep = np.sqrt(gu * gu + gv * gv)
        facing = -(gu * np.float32(np.cos(a)) + gv * np.float32(np.sin(a)))
        return np.maximum(steep + 2 * self.parameters["lamp"]["uneven"] * facing, 0) * np.float32(6)

    def radiance(self, weights):
        """Radiance on the working grid, float32, for each row of weights (parts of red, green, blue)."""
        p, grid = self.parameters, self.grid
        board = p["board"]
        u, v = grid.coarse()
        laminate, mask = (grid.spread(f) for f in surfaces.laminate_and_mask(u, v, p, self.seed, 2 * grid.h))
        metal = self._metal(u, v)
        light = grid.spread(shading(p["lamp"], u, v))
        film = surfaces.flux(u, v, p, self.seed, 2 * grid.h) if p["surface"]["flux"] else None
        ridge = None
        opening = self.o
        if self.masked:
            shift = np.rint(np.array(board["opening_shift_px"]) * grid.ss).astype(int)
            opening = np.roll(opening, (shift[1], shift[0]), (0, 1))
            if board["mask_ridge"]:
                ridge = grid.spread(self._ridge())
        out = []
        for w in np.asarray(weights, np.float32):
            lam, met, on_lam, on_met = (np.float32(w @ np.array(board[k], np.float32)) for k in (
                "laminate_rgb", "metal_rgb", "mask_rgb_laminate", "mask_rgb_copper"))
            low = laminate * lam
            radiance = low + self.c * (metal * met - low)
            if self.masked:
                closed = mask * (on_lam + self.c * (on_met - on_lam))
                if ridge is not None:
                    closed += ridge * np.float32(board["mask_ridge"] * max(on_met, 0.25 * met))
                radiance = closed + opening * (radiance - closed)
            white, tint = np.float32(w.sum()), np.float32(met / np.mean(board["metal_rgb"]))
            for window, alpha, value, kind in self.layers:
                part = radiance[window]
                if kind == "scratch":
                    part *= 1 + alpha * (value - 1)
                else:
                    part += alpha * (value * (tint if kind == "metal" else white) - part)
            if film is not None:
                radiance += grid.spread(film[0]) * (grid.spread(film[1]) * white - radiance)
            out.append(radiance * light)
        return out
