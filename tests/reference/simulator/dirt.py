# SPDX-License-Identifier: Apache-2.0
"""What lies on a board or in the camera: debris on the outline, specks, fibres, scratches, mirrors."""
import numpy as np

from . import geometry
from .fields import rim_profile, stream
from .target import outline_point


def _blob(scene, rng, u0, v0, radius, value, alpha, metal=False):
    window = scene.grid.window(u0, v0, radius * 2 + 2)
    u, v = scene.grid.local(window, u0, v0)
    if u.size == 0:
        return
    d = geometry.disc(u, v, radius)
    if radius > 1.2:
        delta = 0.25 * radius * rim_profile(rng, radius * 0.8, radius, 180)
        d = geometry.displace(d, u, v, delta, radius)
    scene.add(window, np.float32(alpha) * geometry.coverage(d, scene.grid.h), np.float32(value), metal=metal)


def debris(scene):
    """Chips and resin smear over a stated part of the outline; their colour is any of a board's."""
    rng = stream(scene.seed, "debris")
    target, left = scene.parameters["target"], None
    while left is None or left > 0:
        u, v, length = outline_point(target, rng)
        if left is None:
            left = scene.parameters["rim"]["debris"] * length
        radius = min(rng.uniform(1.5, 7.0), max(left / 1.6, 1.0))
        left -= 1.7 * radius
        u, v = u + rng.normal(0, 0.4 * radius), v + rng.normal(0, 0.4 * radius)
        _blob(scene, rng, u, v, radius, rng.choice([0.02, 0.08, 0.2, 0.35, 0.6]), rng.uniform(0.8, 1.0))


def scratches(scene):
    """Long thin marks, brighter or darker than what they cross; a few are bent."""
    rng = stream(scene.seed, "scratches")
    surface = scene.parameters["surface"]
    for _ in range(int(surface["scratches"])):
        at = rng.uniform(-0.6, 0.6, 2) * scene.parameters["target"]["size_px"]
        a, length = rng.uniform(0, 2 * np.pi), rng.uniform(20, 110)
        bend = rng.normal(0, 0.15)
        middle = at + length / 2 * np.array([np.cos(a), np.sin(a)])
        end = middle + length / 2 * np.array([np.cos(a + bend), np.sin(a + bend)])
        width = surface["scratch_px"] * rng.uniform(0.5, 1.3) / 2
        alpha = rng.uniform(0.3, 0.9)
        value = rng.choice([0.1, 1.3, 1.6])
        for p, q in ((at, middle), (middle, end)):
            centre = (p + q) / 2
            window = scene.grid.window(*centre, length / 4 + 3)
            u, v = scene.grid.local(window)
            if u.size:
                d = geometry.capsule(u, v, p, q, (width, width * 0.6))
                # on metal a scratch mirrors or hides light, elsewhere it is a faint white mark
                scene.add(window, np.float32(alpha) * geometry.coverage(d, scene.grid.h), np.float32(value), scratch=True)


def dust(scene):
    """Specks and fibres anywhere, dark or bright."""
    rng = stream(scene.seed, "dust")
    grid, dirt = scene.grid, scene.parameters["dirt"]

    def anywhere():
        x, y = rng.uniform(0, grid.width), rng.uniform(0, grid.height)
        return np.array([float(t) for t in grid.view.board(np.float64(x), np.float64(y))])
    for _ in range(int(dirt["dust"])):
        _blob(scene, rng, *anywhere(), np.exp(rng.normal(0.1, 0.5)), rng.choice([0.03, 0.1, 0.4, 0.7]), rng.uniform(0.5, 1))
    for _ in range(int(dirt["fibres"])):
        p, a = anywhere(), rng.uniform(0, 2 * np.pi)
        value, width, curl = rng.choice([0.04, 0.5]), rng.uniform(0.4, 0.8), rng.normal(0, 0.35)
        for _ in range(rng.integers(4, 10)):
            q = p + 7 * np.array([np.cos(a), np.sin(a)])
            window = grid.window(*((p + q) / 2), 6)
            u, v = grid.local(window)
            if u.size:
                scene.add(window, np.float32(0.8) * geometry.coverage(geometry.capsule(u, v, p, q, width), grid.h), np.float32(value))
            p, a = q, a + curl + rng.normal(0, 0.15)


def glints(scene):
    """Small mirrors that throw the lamp into the lens, on metal and mostly near its rim."""
    rng = stream(scene.seed, "glints")
    dirt, target = scene.parameters["dirt"], scene.parameters["target"]
    for _ in range(int(dirt["glints"])):
        u, v, _ = outline_point(target, rng)
        inward = rng.choice([rng.uniform(0.9, 1.0), rng.uniform(0.1, 0.9)])
        if target["shape"] in ("hole",) or target["polarity"] == "dark":
            inward = 2 - inward
        u, v = u * inward, v * inward
        _blob(scene, rng, u, v, rng.uniform(0.4, 1.6), dirt["glint_level"] * rng.uniform(0.3, 1.5), 1.0, metal=True)


def lens_dust(scene):
    """Dust that is out of focus: soft discs that take some light."""
    rng = stream(scene.seed, "lens dust")
    grid = scene.grid
    for _ in range(int(scene.parameters["dirt"]["lens_dust"])):
        x, y = rng.uniform(0, grid.width), rng.uniform(0, grid.height)
        u0, v0 = (float(t) for t in grid.view.board(np.float64(x), np.float64(y)))
        radius = rng.uniform(6, 16)
        window = grid.window(u0, v0, radius + 6)
        u, v = grid.local(window, u0, v0)
        if u.size:
            scene.add(window, np.float32(rng.uniform(0.08, 0.25)) * geometry.coverage(geometry.disc(u, v, radius), 5.0), np.float32(0.0))


def build(scene):
    parameters = scene.parameters
    if parameters["surface"]["scratches"]:
        scratches(scene)
    if parameters["rim"]["debris"] and parameters["target"]["shape"] != "none":
        debris(scene)
    if parameters["dirt"]["glints"]:
        glints(scene)
    if parameters["dirt"]["dust"] or parameters["dirt"]["fibres"]:
        dust(scene)
    if parameters["dirt"]["lens_dust"]:
        lens_dust(scene)
