# SPDX-License-Identifier: Apache-2.0
"""Cells: named families of pictures. Each draws the parameters of a picture from a seed.

A cell is a base and what it changes. Values: a constant, U(a, b) uniform, N(a, b) whole, P(...) one of a
list, V(a, b) a vector of random direction; "0.3 size": part of the target's size; "off 700": an optical axis
350 to 700 px away.
"""
import numpy as np

from .fields import stream
from .parameters import NAMES, defaults, put

SHAPES = ("disc", "hole", "ring", "square", "diamond", "cross", "tag", "triangle")


class U:
    def __init__(self, low, high):
        self.low, self.high = low, high

    def draw(self, rng):
        return float(rng.uniform(self.low, self.high))


class N(U):
    """A whole number, low to high, both included."""

    def draw(self, rng):
        return int(rng.integers(self.low, self.high + 1))


class P:
    def __init__(self, *values):
        self.values = values

    def draw(self, rng):
        return self.values[int(rng.integers(len(self.values)))]


class V(U):
    """A vector [u, v] of random direction, length low to high."""

    def draw(self, rng):
        r, a = rng.uniform(self.low, self.high), rng.uniform(0, 2 * np.pi)
        return [float(r * np.cos(a)), float(r * np.sin(a))]


AZIMUTHS = tuple(sorted(n for n in NAMES if n.endswith(("azimuth_deg", "phase_deg"))
                        or n in ("rim.etch_side_deg", "rim.breakout_deg", "bore.burr_deg", "surface.brush_angle_deg")))
COPPER, TIN, GOLD = [0.62, 0.42, 0.30], [0.40, 0.34, 0.32], [0.72, 0.55, 0.28]
WHITE, RED = [0.33, 0.40, 0.27], [1.0, 0.0, 0.0]

CLEAN = {
    "board.weave": 0.0, "board.mottle": 0.0, "surface.grain": 0.0, "surface.grain_board": 0.0, "surface.waviness": 0.0,
    "rim.band": 0.0, "lamp.uneven": 0.0, "lamp.gradient_per_100px": 0.0, "lens.glare": 0.0, "lens.spherical_waves": 0.0,
    "lens.coma_waves": 0.0, "lens.astigmatism_waves": 0.0, "sensor.full_well_e": 30000.0, "sensor.read_e": 2.0,
    "sensor.prnu": 0.002, "board.metal_rgb": COPPER, "bore.wall": 0.0, "bore.wall_px": 0.0, "bore.bottom": 0.03,
}
TYPICAL = {
    "board.style": P("bare", "mask"), "board.metal_rgb": P(COPPER, TIN, GOLD), "lamp.rgb": P(WHITE, WHITE, RED),
    "board.laminate_rgb": P([0.24, 0.21, 0.12], [0.16, 0.14, 0.08], [0.10, 0.09, 0.05]),
    "board.weave": U(0.05, 0.15), "board.mottle": U(0.02, 0.05), "board.weave_angle_deg": U(-3, 3),
    "board.weave_pitch_px": P([46.0, 58.0], [38.0, 44.0], [58.0, 79.0]), "board.opening_px": U(2.5, 7),
    "board.opening_shift_px": V(0, 1.5), "surface.grain": U(0.02, 0.06), "surface.grain_px": U(0.8, 2.5),
    "surface.grain_board": U(0.02, 0.05), "surface.waviness": U(0.04, 0.10), "surface.waviness_px": U(8, 30),
    "surface.roughness": U(0.25, 0.4), "rim.band": U(-0.2, 0.3), "rim.band_px": U(0.8, 2.0), "rim.rough_px": U(0.03, 0.08),
    "lamp.uneven": U(0.05, 0.25), "lamp.gradient_per_100px": U(0.02, 0.10), "lamp.vignetting_per_100px": U(0, 0.03),
    "lamp.elevation_deg": U(50, 70), "lamp.coaxial": U(0, 0.4), "lens.cutoff_per_px": U(0.65, 0.98),
    "lens.defocus_waves": U(-0.3, 0.3), "lens.spherical_waves": U(0, 0.05), "lens.coma_waves": U(0, 0.05),
    "lens.astigmatism_waves": U(0, 0.05), "lens.glare": U(0.005, 0.03), "sensor.level": U(0.55, 0.8),
    "sensor.full_well_e": U(7000, 15000), "sensor.read_e": U(3, 8), "sensor.prnu": U(0.004, 0.01), "sensor.row_e": U(0, 3),
    "sensor.column_e": U(0, 3), "bore.wall": U(0.1, 0.4), "bore.bottom": U(0.01, 0.06), "view.tilt_deg": U(0, 0.2),
    "dirt.dust": N(0, 2), "bore.halo": U(0, 0.1),
}

# what shapes add to every base
BY_SHAPE = {
    "hole": {"target.polarity": "dark", "board.style": P("bare", "copper"), "board.laminate_rgb": P([0.30, 0.27, 0.16], [0.22, 0.19, 0.11])},
    "ring": {"target.inner": P("etched", "bored"), "target.inner_offset_px": V(0, 2)},
    "tag": {"target.tag_id": N(0, 9), "target.angle_deg": U(-180, 180)},
    "square": {"target.angle_deg": U(-3, 3)}, "diamond": {"target.angle_deg": U(-3, 3)},
    "cross": {"target.angle_deg": U(-3, 3)}, "triangle": {"target.angle_deg": U(-3, 3)},
}
PAD = {"bore.pad_px": "1.7 size", "board.style": P("bare", "mask")}
NO_TARGET = {"target.shape": "none"}

# name: (what it shows, base, changes, further changes of bores)
CELLS = {
    "clean": ("smooth materials, even light, little noise", CLEAN, {}, {}),
    "typical": ("mild everything that a decent machine camera shows", TYPICAL,
                {"clutter.neighbours": N(0, 2), "clutter.vias": N(0, 2)}, {}),
    "dark": ("disc etched out of a copper sheet", TYPICAL, {"target.polarity": "dark", "board.style": "copper"}, {}),
}


def _add(name, text, changes, hole=None, hard=None):
    CELLS[name] = (text, TYPICAL, changes, hole or {})
    if hard:
        CELLS[name + "_hard"] = (text + ", hard", TYPICAL, {**changes, **hard}, hole or {})


_add("drilled", "bore in the pad, near its centre", {"target.drill_px": "0.35 size", "target.drill_offset_px": V(0, 3), "bore.wall": U(0.2, 0.6)},
     {"target.drill_px": 0.0}, {"target.drill_px": "0.5 size", "target.drill_offset_px": V(4, 8), "bore.wall_plated": True, "bore.bottom": U(0.02, 0.3)})
_add("grain", "grain on metal and board", {"surface.grain": U(0.12, 0.2), "surface.grain_board": U(0.06, 0.1), "surface.grain_px": U(1, 4)},
     hard={"surface.grain": U(0.22, 0.35), "surface.grain_board": U(0.12, 0.2), "surface.roughness": U(0.15, 0.25)})
_add("brushed", "brushed copper", {"surface.brushed": U(0.10, 0.2), "board.metal_rgb": COPPER}, {"board.style": "copper"},
     {"surface.brushed": U(0.3, 0.45), "surface.roughness": U(0.12, 0.2), "lamp.uneven": U(0.3, 0.5)})
_add("oxide", "oxide spots on metal", {"surface.oxide": U(0.1, 0.3), "surface.oxide_px": U(6, 20)}, {"board.style": "copper"},
     {"surface.oxide": U(0.35, 0.55), "surface.oxide_depth": U(0.65, 0.85)})
_add("lamp", "uneven lamp", {"lamp.uneven": U(0.3, 0.5), "lamp.gradient_per_100px": U(0.1, 0.2)}, None,
     {"lamp.uneven": U(0.7, 0.95), "lamp.gradient_per_100px": U(0.3, 0.5)})
_add("scratches", "scratches", {"surface.scratches": N(3, 6)}, None, {"surface.scratches": N(8, 14), "surface.scratch_px": 2.2})
_add("hasl", "solder dome with a displaced mirror of the lamp",
     {"surface.dome_deg": U(10, 20), "surface.roughness": U(0.10, 0.18), "surface.grain": U(0.01, 0.03), "surface.waviness": U(0.02, 0.05), "board.metal_rgb": TIN, "surface.dome_shift_px": V(0, 4),
      "lamp.uneven": U(0.2, 0.5)}, PAD,
     {"surface.dome_deg": U(22, 38), "surface.roughness": U(0.06, 0.1), "lamp.uneven": U(0.5, 0.9), "surface.dome_shift_px": V(3, 8)})
_add("flux", "flux residue", {"surface.flux": U(0.1, 0.25)}, None, {"surface.flux": U(0.3, 0.5)})
_add("tracks", "tracks that end at the target", {"clutter.tracks": N(1, 2), "clutter.track_px": U(8, 16), "clutter.lines": N(0, 1)}, PAD,
     {"clutter.tracks": N(3, 4), "clutter.track_px": U(16, 24), "clutter.lines": N(1, 3)})
_add("teardrop", "track with a teardrop", {"clutter.tracks": 1, "clutter.teardrop": U(0.3, 0.7), "clutter.track_px": U(8, 16)}, PAD,
     {"clutter.tracks": N(1, 2), "clutter.teardrop": U(0.8, 1.4), "clutter.track_px": U(14, 22)})
_add("debris10", "debris on 10 % of the outline", {"rim.debris": 0.10}, None)
_add("debris25", "debris on 25 % of the outline", {"rim.debris": 0.25}, None)
# of shapes other than holes these cells drill a bore into the target
_add("burr05", "burr of 0.5 px in a bore", {"target.drill_px": "0.45 size", "bore.burr_px": 0.5, "bore.burr_side": U(0.2, 0.8), "bore.burr_light": U(0.3, 1.0)}, None,
     {"bore.burr_px": 1.5})
_add("rough03", "outline rough by 0.3 px rms", {"rim.rough_px": 0.3, "rim.rough_corr_px": U(2, 6)}, None, {"rim.rough_px": 0.6})
_add("bore_wall3", "bore whose lower face is shifted by 3 px", {"target.drill_px": "0.45 size", "bore.wall_px": 3.0, "bore.wall": U(0.15, 0.5)}, None,
     {"bore.wall_px": 6.0, "bore.wall": U(0.3, 0.8), "bore.wall_plated": P(True, False)})
_add("plated", "plated bore: bright bands on the wall", {"target.drill_px": "0.45 size", "bore.wall_plated": True, "bore.wall": U(0.5, 0.9), "bore.wall_px": U(1, 3)},
     {"bore.pad_px": "1.35 size", "board.style": "mask"}, {"bore.bottom": U(0.1, 0.25), "bore.wall": U(0.9, 1.6), "bore.lip": U(0.5, 1.5), "lamp.uneven": U(0.5, 0.8)})
_add("bright_table", "bore above a bright table", {"target.drill_px": "0.45 size", "bore.bottom": U(0.1, 0.2)}, {"board.style": "copper"}, {"bore.bottom": U(0.25, 0.35)})
_add("halo", "crazed laminate around a bore", {"target.drill_px": "0.45 size", "bore.halo": U(0.2, 0.4), "bore.halo_px": U(4, 12), "board.style": "bare"}, {"board.style": "bare"})
_add("mask_crescent", "mask covers a crescent of the pad",
     {"board.style": "mask", "board.opening_px": U(2, 4), "board.opening_shift_px": V(5, 7)}, {**PAD, "board.style": "mask"},
     {"board.opening_shift_px": V(9, 12)})
_add("overetch", "outline etched back all round", {"rim.etch_px": U(0.5, 1.2)}, None)
_add("overetch_side", "outline etched back on one side", {"rim.etch_side_px": U(0.6, 1.0)}, PAD, {"rim.etch_side_px": U(1.8, 3.0)})
_add("breakout", "a bore cuts the outline", {"rim.breakout_px": U(4, 9), "rim.breakout_diameter_px": U(20, 34)},
     {"rim.breakout_px": 0.0, "bore.pad_px": "1.3 size", "bore.pad_shift_px": V(12, 15)}, {"rim.breakout_px": U(10, 16)})
_add("torn", "torn outline", {"rim.torn": N(1, 2), "rim.torn_px": U(1.5, 4)}, None, {"rim.torn": N(3, 5), "rim.torn_px": U(4, 7)})
_add("dust", "dust and fibres", {"dirt.dust": N(8, 20), "dirt.fibres": N(0, 2), "dirt.lens_dust": N(0, 2)}, None,
     {"dirt.dust": N(40, 70), "dirt.fibres": N(2, 4)})
_add("glint", "small mirrors that saturate", {"dirt.glints": N(2, 6)}, None, {"dirt.glints": N(8, 16), "dirt.glint_level": 25.0})
_add("neighbours", "pads, vias, text and tracks close by", {"clutter.neighbours": N(2, 4), "clutter.vias": N(1, 4), "clutter.text": N(0, 2),
     "clutter.lines": N(0, 2)}, None, {"clutter.neighbours": 6, "clutter.clearance_px": 4.0, "clutter.lines": N(1, 4)})
_add("plane", "copper plane around the target's clearance", {"clutter.plane": U(12, 25)}, None)
_add("weave", "strong glass weave", {"board.style": "bare", "board.weave": U(0.2, 0.35)}, {"board.style": "bare"}, {"board.weave": U(0.45, 0.6)})
_add("low_contrast", "metal hardly brighter than the board", {"board.style": "bare", "board.laminate_rgb": [0.30, 0.27, 0.16], "board.metal_rgb": [0.36, 0.31, 0.22]},
     {"board.style": "bare", "bore.bottom": U(0.15, 0.2)})
_add("bayer", "colour mosaic, bilinear, grey", {"sensor.bayer": P("RG", "GR", "GB", "BG")}, None, {"process.demosaic": "none"})
_add("bayer_edge", "colour mosaic, edge-aware, grey", {"sensor.bayer": P("RG", "GR", "GB", "BG"), "process.demosaic": "edge"}, None)
_add("bayer_rgb", "colour mosaic, edge-aware, written in colours",
     {"sensor.bayer": P("RG", "GR", "GB", "BG"), "process.demosaic": "edge", "process.colour": True}, None)
_add("denoise", "bilateral filter", {"process.denoise": "bilateral", "sensor.full_well_e": 4000.0, "sensor.read_e": 12.0}, None,
     {"process.denoise": "nonlocal", "process.denoise_px": 3, "process.denoise_level": 0.06, "sensor.full_well_e": 1500.0})
_add("sharpen", "unsharp mask", {"process.sharpen": U(0.4, 1.0), "process.sharpen_px": U(0.8, 1.5)}, None, {"process.sharpen": U(1.5, 2.5)})
_add("gamma", "gamma 2.2", {"process.gamma": 2.2}, None)
_add("rowcol", "row and column noise", {"sensor.row_e": U(15, 40), "sensor.column_e": U(15, 40)}, None,
     {"sensor.row_e": U(80, 150), "sensor.column_e": U(80, 150)})
_add("noise", "little light", {"sensor.full_well_e": 2000.0, "sensor.read_e": 12.0}, None, {"sensor.full_well_e": 400.0})
_add("saturated", "exposed too long", {"sensor.level": U(0.95, 1.1)}, None, {"sensor.level": U(1.3, 1.8)})
_add("underexposed", "exposed too short", {"sensor.level": U(0.15, 0.25)}, None, {"sensor.level": U(0.05, 0.08)})
_add("chromatic", "lateral and axial colour, grey sensor",
     {"lens.chromatic": True, "lens.lateral_per_1000px": [0.5, 0.0, -0.7], "lens.axial_waves": [0.15, 0.0, 0.25],
      "view.axis_px": "off 700", "lamp.rgb": WHITE}, None,
     {"lens.lateral_per_1000px": [1.5, 0.0, -2.0], "lens.axial_waves": [0.4, 0.0, 0.6]})
_add("defocus", "out of focus", {"lens.defocus_waves": P(-0.7, 0.7)}, None, {"lens.defocus_waves": U(1.2, 1.8)})
_add("motion", "vibration that decays", {"motion.amplitude_px": U(0.5, 1.2), "motion.frequency_hz": U(30, 120), "motion.decay_ms": U(8, 30)}, None,
     {"motion.amplitude_px": U(2.0, 3.5)})
_add("bits10in16", "10 bits in 16, as they are", {"sensor.bits": 10}, None)
_add("bits12in16", "12 bits in 16, as they are", {"sensor.bits": 12}, None)
_add("bits12high", "12 bits in 16, shifted up", {"sensor.bits": 12, "process.align": "high"}, None)
_add("bits16", "16 bits", {"sensor.bits": 16}, None)
_add("jpeg90", "JPEG of quality 90", {"process.jpeg": 90}, None)
_add("jpeg60", "JPEG of quality 60", {"process.jpeg": 60}, None)
_add("photo", "a tinned board as in photographs: colours, denoised, sharpened, gamma, JPEG 90",
     {"sensor.bayer": P("RG", "GR", "GB", "BG"), "process.demosaic": "edge", "process.colour": True, "process.denoise": "nonlocal",
      "process.denoise_level": 0.03, "process.sharpen": U(0.3, 0.8), "process.gamma": 2.2, "process.jpeg": 90, "board.style": "mask",
      "board.metal_rgb": TIN, "board.laminate_rgb": [0.10, 0.11, 0.05], "board.opening_px": U(0.3, 2), "board.opening_shift_px": V(0, 0.6), "sensor.full_well_e": 4000.0, "sensor.level": U(0.25, 0.5),
      "surface.dome_deg": U(4, 20), "surface.dome_shift_px": V(0, 6), "surface.roughness": U(0.14, 0.28), "surface.grain": U(0.01, 0.04),
      "process.subtract_black": True, "process.saturation": U(1.1, 1.6), "bore.lip": U(0.3, 1.5), "bore.lip_px": U(0.8, 2.2), "surface.waviness": U(0.05, 0.12),
      "surface.waviness_px": U(4, 15), "surface.scratches": N(0, 4), "surface.oxide": U(0, 0.06), "lamp.uneven": U(0.3, 0.7), "rim.band": U(-0.3, 0.5),
      "rim.rough_px": U(0.05, 0.2), "target.drill_px": P(0.0, "0.22 size", "0.3 size"), "target.drill_offset_px": V(0, 4), "bore.wall_plated": True,
      "bore.wall": U(0.5, 1.2), "bore.wall_px": U(0, 3), "bore.bottom": U(0.05, 0.4), "clutter.tracks": N(0, 2), "clutter.track_px": U(14, 34),
      "clutter.plane": P(0.0, 16.0, 24.0), "clutter.lines": N(0, 2), "lens.defocus_waves": U(0.2, 0.5)},
     {"board.style": "mask", **PAD})
_add("tilt", "telecentric view, tilted by 1 to 2 deg", {"view.tilt_deg": U(1, 2)}, None, {"view.tilt_deg": U(4, 6)})
_add("entocentric", "entocentric view, target off the axis", {"view.kind": "entocentric", "view.axis_px": "off 250", "view.tilt_deg": U(0, 0.5)}, None,
     {"view.distance_px": 3000.0, "view.tilt_deg": U(1, 3)})
_add("all", "a bad day: many mild effects at once",
     {"surface.grain": U(0.08, 0.14), "surface.oxide": U(0.0, 0.15), "surface.scratches": N(0, 3), "rim.rough_px": U(0.1, 0.25), "rim.debris": U(0, 0.08),
      "clutter.neighbours": N(1, 3), "clutter.tracks": N(0, 2), "clutter.lines": N(0, 2), "dirt.dust": N(2, 8), "dirt.glints": N(0, 2),
      "process.sharpen": U(0, 0.6), "lamp.uneven": U(0.2, 0.4), "surface.brushed": U(0, 0.1)}, {"bore.burr_px": U(0, 0.4), **PAD})

EMPTY = {
    "empty_weave": ("bare laminate", {"board.style": "bare", "board.weave": U(0.15, 0.35)}),
    "empty_mask": ("mask over laminate", {"board.style": "mask"}),
    "empty_copper": ("copper sheet, brushed, scratched, oxidised",
                     {"board.style": "copper", "surface.scratches": N(0, 6), "surface.oxide": U(0, 0.3), "surface.brushed": U(0, 0.2)}),
    "empty_tracks": ("tracks only", {"clutter.lines": N(3, 6), "clutter.track_px": U(10, 26)}),
    "empty_pads": ("pads of other shapes", {"clutter.neighbours": N(4, 7), "clutter.lines": N(0, 2)}),
    "empty_vias": ("small vias", {"clutter.vias": N(5, 12), "clutter.lines": N(0, 2)}),
    "empty_text": ("silk screen", {"clutter.text": N(4, 9)}),
    "empty_alike": ("same shape, far too large or small", {"clutter.alike": N(1, 3)}),
    "empty_dirt": ("dust, fibres, flux, glints", {"dirt.dust": N(10, 40), "dirt.fibres": N(1, 4), "surface.flux": U(0, 0.3), "dirt.lens_dust": N(1, 4)}),
    "empty_clutter": ("pads of other shapes, vias, tracks, text, dust",
                      {"clutter.neighbours": N(2, 5), "clutter.vias": N(1, 5), "clutter.lines": N(1, 3), "clutter.text": N(0, 4), "dirt.dust": N(2, 10)}),
}
for _name, (_text, _changes) in EMPTY.items():
    CELLS[_name] = ("no target: " + _text, TYPICAL, {**_changes, **NO_TARGET}, {})


def split(name):
    """("cell", "shape") of "cell" or "cell:shape"; names the nearest one of an unknown word."""
    import difflib
    cell, _, shape = name.partition(":")
    for word, known, kind in ((cell, CELLS, "cell"), (shape or "disc", SHAPES, "shape")):
        if word not in known:
            near = difflib.get_close_matches(word, list(known), 1, 0)[0]
            raise SystemExit(f'render.py: unknown {kind}: "{word}"; nearest: "{near}"; "render.py cells" lists them')
    return cell, shape or "disc"


def draw(name, seed, overrides=()):
    """Parameters of one picture of a cell, from a seed; overrides: ((name, value), ...), drawn last."""
    cell, shape = split(name)
    _, base, changes, hole = CELLS[cell]
    rng = stream(seed, "cell " + cell)
    p = defaults()
    put(p, "target.shape", shape)
    put(p, "target.unlike", shape)
    fixed = dict(overrides)
    size = float(fixed.get("target.size_px", 70.0 * rng.uniform(0.8, 1.2)))
    put(p, "target.size_px", size)
    put(p, "target.inner_px", size * rng.uniform(0.35, 0.5))
    put(p, "target.width_px", size * rng.uniform(0.16, 0.26))
    for azimuth in AZIMUTHS:
        put(p, azimuth, float(rng.uniform(0, 180 if azimuth == "surface.brush_angle_deg" else 360)))
    together = {**base, **BY_SHAPE.get(shape, {}), **changes, **(hole if shape == "hole" else {})}
    if cell == "clean":
        together.pop("target.inner_offset_px", None)
    for key, value in together.items():
        if isinstance(value, str) and value.startswith("off "):
            value = V(0.5 * float(value[4:]), float(value[4:]))
        if isinstance(value, U | P):
            value = value.draw(rng)
        if isinstance(value, str) and value.endswith(" size"):
            value = float(value[:-5]) * size
        put(p, key, value)
    width, height = (fixed.get(f"picture.{k}", p["picture"][k]) for k in ("width_px", "height_px"))
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    put(p, "target.centre_px", [float(c) for c in middle + rng.uniform(-9, 9, 2)])
    if p["view"]["axis_px"] == [79.5, 79.5]:
        put(p, "view.axis_px", [float(c) for c in middle])
    else:
        put(p, "view.axis_px", [float(a + m) for a, m in zip(p["view"]["axis_px"], middle)])
    for key, value in overrides:
        put(p, key, value)
    return p


def search_place(parameters, seed):
    """Where to look, px: the truth and up to 8 px in a random direction; the middle if no target."""
    rng = stream(seed, "search")
    r, a = 8 * np.sqrt(rng.random()), rng.uniform(0, 2 * np.pi)
    x, y = parameters["target"]["centre_px"]
    if parameters["target"]["shape"] == "none":
        x, y = (parameters["picture"]["width_px"] - 1) / 2, (parameters["picture"]["height_px"] - 1) / 2
    return [round(float(x + r * np.cos(a)), 2), round(float(y + r * np.sin(a)), 2)]
