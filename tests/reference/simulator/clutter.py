# SPDX-License-Identifier: Apache-2.0
"""What else a board shows: tracks, pads of other shapes, vias, silk screen, copper planes."""
import numpy as np

from . import geometry
from .bore import paint
from .fields import stream
from .target import artwork, reach

# strokes of letters on a grid 2 wide and 4 high: polylines
GLYPHS = {
    "R": [[(0, 4), (0, 0), (2, 0), (2, 2), (0, 2), (2, 4)]], "C": [[(2, 0), (0, 0), (0, 4), (2, 4)]],
    "U": [[(0, 0), (0, 4), (2, 4), (2, 0)]], "P": [[(0, 4), (0, 0), (2, 0), (2, 2), (0, 2)]],
    "1": [[(0, 1), (1, 0), (1, 4)]], "2": [[(0, 0), (2, 0), (2, 2), (0, 4), (2, 4)]],
    "7": [[(0, 0), (2, 0), (1, 4)]], "X": [[(0, 0), (2, 4)], [(2, 0), (0, 4)]],
    "E": [[(2, 0), (0, 0), (0, 4), (2, 4)], [(0, 2), (2, 2)]], "T": [[(0, 0), (2, 0)], [(1, 0), (1, 4)]],
}

# shapes of neighbours that cannot be taken for a target of the shape on the left
OTHERS = {
    "disc": ("rectangle", "oblong", "square", "l"), "hole": ("rectangle", "oblong", "square", "l"),
    "ring": ("rectangle", "oblong", "square", "l"), "square": ("disc", "oblong", "l"),
    "diamond": ("disc", "oblong", "rectangle"), "cross": ("disc", "oblong", "square", "rectangle"),
    "tag": ("disc", "oblong", "square", "rectangle"), "triangle": ("disc", "oblong", "square"),
}


def place(scene, rng, radius_px):
    """A random board place whose disc of radius_px is clear of the target and of earlier ones."""
    grid = scene.grid
    for _ in range(30):
        x, y = rng.uniform(-5, grid.width + 5), rng.uniform(-5, grid.height + 5)
        u, v = (float(t) for t in grid.view.board(np.float64(x), np.float64(y)))
        if all(np.hypot(u - a, v - b) > r + radius_px for a, b, r in scene.taken):
            scene.taken.append((u, v, radius_px + 3))
            return u, v
    return None


def tracks(scene, rng):
    """Tracks that end at the target, with teardrops; they belong to its metal."""
    clutter, target = scene.parameters["clutter"], scene.parameters["target"]
    half, n = clutter["track_px"] / 2, int(clutter["tracks"])
    base = rng.uniform(0, 2 * np.pi)
    inner = target["size_px"] * 0.3 if target["shape"] in ("ring", "hole") else 0
    radius = (clutter_pad(scene) or target["size_px"]) / 2
    for i in range(n):
        a = np.rint((base + 2 * np.pi * (i + rng.uniform(-0.2, 0.2)) / n) / (np.pi / 4)) * (np.pi / 4)
        e = np.array([np.cos(a), np.sin(a)])
        n_ = np.array([-e[1], e[0]])
        bend = e * radius * rng.uniform(1.6, 2.6)
        turn = e + n_ * rng.choice([-1, 0, 0, 1])
        start = e * (inner if inner == 0 else radius * 0.8)
        scene.copper_line(start, bend, half)
        scene.copper_line(bend, bend + turn * 400, half)
        if clutter["teardrop"]:
            tip = e * radius * (1 + clutter["teardrop"])
            scene.copper_line(start, tip, (radius * 0.8, half))


def clutter_pad(scene):
    """Diameter of the pad around a bored target, or None."""
    parameters = scene.parameters
    if parameters["target"]["shape"] == "hole" and parameters["bore"]["pad_px"]:
        return parameters["bore"]["pad_px"]
    return None


def pads(scene, rng):
    """Pads of other shapes, bare in a mask opening."""
    parameters = scene.parameters
    shape, size = parameters["target"]["shape"], parameters["target"]["size_px"]
    kinds = OTHERS[parameters["target"]["unlike"] if shape == "none" else shape]
    for _ in range(int(parameters["clutter"]["neighbours"])):
        kind = kinds[rng.integers(len(kinds))]
        r = size * rng.uniform(0.25, 0.55)
        at = place(scene, rng, r * 1.2)
        if at is None:
            continue
        window = scene.grid.window(*at, r * 1.6 + 8)
        u, v = scene.grid.local(window, *at)
        if rng.random() < 0.5:
            u, v = v, u
        if kind == "disc":
            d = geometry.disc(u, v, r)
        elif kind == "square":
            d = geometry.box(u, v, r * 0.8, r * 0.8)
        elif kind == "rectangle":
            d = geometry.box(u, v, r, r * rng.uniform(0.4, 0.6), 1.0)
        elif kind == "l":
            d = np.minimum(geometry.box(u, v, r, r * 0.25), geometry.box(u - np.float32(0.75 * r), v, r * 0.25, r))
        else:
            d = geometry.capsule(u, v, (-0.5 * r, 0), (0.5 * r, 0), 0.5 * r)
        scene.copper(window, d, open_by=parameters["board"]["opening_px"])
        scene.crowns.append((*at, r))
        if rng.random() < 0.5:
            away = rng.uniform(0, 2 * np.pi)
            scene.copper_line(at, np.add(at, 300 * np.array([np.cos(away), np.sin(away)])),
                              parameters["clutter"]["track_px"] / 2, avoid=True)


def alike(scene, rng):
    """The target's own shape, but far too large or too small: no target."""
    parameters = scene.parameters
    wanted = parameters["target"]["unlike"]
    for _ in range(int(parameters["clutter"]["alike"])):
        factor = rng.choice([rng.uniform(0.4, 0.65), rng.uniform(1.35, 1.6)])
        like = {**parameters["target"], "shape": wanted, "size_px": parameters["target"]["size_px"] * factor,
                "inner_px": parameters["target"]["inner_px"] * factor, "width_px": parameters["target"]["width_px"] * factor}
        at = place(scene, rng, reach(like))
        if at is None:
            continue
        if wanted == "hole":
            paint(scene, *at, like["size_px"], f"alike{at[0]:.2f}", burr=False)
            continue
        window = scene.grid.window(*at, reach(like) + 8)
        if wanted == "tag":
            # a frame with bits that are no code
            u, v = scene.grid.local(window, *at, rng.uniform(0, np.pi))
            white, plate = geometry.tag_coverage(u, v, like["size_px"] / factor, geometry.tag_cells(int(rng.integers(1 << 36))), scene.grid.h)
            np.maximum(scene.c[window], white * geometry.coverage(plate, scene.grid.h), out=scene.c[window])
            continue
        scene.copper(window, artwork(like, *scene.grid.local(window, *at)), open_by=parameters["board"]["opening_px"])


def vias(scene, rng):
    """Small bored pads."""
    size = scene.parameters["target"]["size_px"]
    for i in range(int(scene.parameters["clutter"]["vias"])):
        r = size * rng.uniform(0.10, 0.2)
        at = place(scene, rng, r)
        if at is None:
            continue
        window = scene.grid.window(*at, r + 6)
        u, v = scene.grid.local(window, *at)
        scene.copper(window, geometry.disc(u, v, r), open_by=1.0)
        scene.later.append(lambda at=at, r=r, i=i: paint(scene, *at, 2 * r * 0.55, f"via{i}", burr=False))


def lines(scene, rng):
    """Tracks that pass by the target at a distance."""
    clutter = scene.parameters["clutter"]
    half = clutter["track_px"] / 2
    clear = scene.reach + clutter["clearance_px"] + half
    for i in range(int(clutter["lines"])):
        a = rng.integers(8) * np.pi / 4
        e, n = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
        at = n * (clear + rng.uniform(0, 30)) * rng.choice([-1, 1])
        scene.copper_line(at - 400 * e, at + 400 * e, half, avoid=True)


def text(scene, rng):
    """White letters of silk screen."""
    letters = list(GLYPHS)
    for _ in range(int(scene.parameters["clutter"]["text"])):
        unit = rng.uniform(5, 9)
        at = place(scene, rng, 2.2 * unit)
        if at is None:
            continue
        window = scene.grid.window(*at, 3 * unit)
        u, v = scene.grid.local(window, *at)
        quarter = rng.integers(4)
        for _ in range(quarter):
            u, v = v, -u
        d = None
        for line in GLYPHS[letters[rng.integers(len(letters))]]:
            for p, q in zip(line, line[1:]):
                a, b = (np.subtract(t, (1, 2)) * unit for t in (p, q))
                one = geometry.capsule(u, v, a, b, unit * 0.22)
                d = one if d is None else np.minimum(d, one)
        scene.later.append(lambda w=window, d=d: scene.add(w, 0.9 * geometry.coverage(d, scene.grid.h), np.float32(0.55)))


def build(scene):
    """All clutter, in an order that lets near things win places."""
    rng = stream(scene.seed, "clutter")
    tracks(scene, rng)
    lines(scene, rng)
    alike(scene, rng)
    pads(scene, rng)
    vias(scene, rng)
    text(scene, rng)
