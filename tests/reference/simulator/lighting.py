# SPDX-License-Identifier: Apache-2.0
"""Radiance of metal under a ring lamp and a coaxial lamp, by the slope of its facets."""
import functools

import numpy as np


def _bessel_ratio(x, order):
    """exp(-x) I_order(x), by the integral (1/pi) int exp(x (cos t - 1)) cos(order t) dt."""
    t = (np.arange(256) + 0.5) * (np.pi / 256)
    return np.mean(np.exp(x[:, None] * (np.cos(t) - 1)) * np.cos(order * t), axis=1)


@functools.lru_cache(maxsize=64)
def _tables(elevation_deg, alpha, s_max):
    """Lobes over slopes 0 to s_max: ring with I0, ring with I1, coaxial."""
    s = np.linspace(0, s_max, 600)
    r = np.tan(np.deg2rad(90 - elevation_deg) / 2)
    r0, a0 = np.tan(np.deg2rad(15)), 0.35
    unit = np.exp(-(r0 / a0) ** 2) / a0 ** 2
    x = 2 * r * s / alpha ** 2
    ring = np.exp(-((r - s) / alpha) ** 2) / alpha ** 2 / unit
    return ring * _bessel_ratio(x, 0), ring * _bessel_ratio(x, 1), np.exp(-(s / alpha) ** 2) / alpha ** 2 / unit


def facing(lamp, azimuth_rad):
    """Relative light on a steep wall whose normal points to azimuth_rad, mean 1 round the ring."""
    return 1 + lamp["uneven"] * np.cos(azimuth_rad - np.deg2rad(lamp["azimuth_deg"]))


class Lamp:
    """Lobe of a micro-facet surface of roughness alpha (rms slope x sqrt 2) under the lamp.

    A facet of slope r = tan((90 deg - elevation) / 2) mirrors the ring lamp into a camera that looks
    straight down. Facets are Beckmann distributed about the local slope s, so that over a whole ring
      L0(s) = exp(-(r^2 + s^2) / alpha^2) I0(2 r s / alpha^2) / (pi alpha^2)
    and an uneven ring, 1 + a cos(phi - phi0), adds a cos(phi_s - phi0) times the same with I1. Coaxial
    light is the same with r = 0. Scaled so that flat metal of alpha 0.35 under an even ring of 60 deg
    elevation has 1. Source: Torrance-Sparrow 1967; Beckmann 1963; shadowing is left out.
    """

    SMAX = 3.0

    def __init__(self, lamp, alpha):
        self.uneven, self.azimuth = lamp["uneven"], np.deg2rad(lamp["azimuth_deg"])
        self.diffuse = lamp["diffuse"]
        ring0, ring1, coaxial = _tables(lamp["elevation_deg"], alpha, self.SMAX)
        c = lamp["coaxial"]
        self.even = ((1 - c) * ring0 + c * coaxial).astype(np.float32)
        self.side = ((1 - c) * self.uneven * ring1).astype(np.float32)

    def radiance(self, su, sv):
        """Radiance relative to the metal's colour, of slopes (d height / du, d height / dv)."""
        s = np.sqrt(su * su + sv * sv)
        k = np.minimum(s * np.float32(599 / self.SMAX), 599).astype(np.int32)
        out = self.even[k]
        if self.uneven:
            # the normal leans against the slope: a facet that falls towards the lamp faces it
            c = -(su * np.float32(np.cos(self.azimuth)) + sv * np.float32(np.sin(self.azimuth)))
            out = out + self.side[k] * c / np.maximum(s, np.float32(1e-6))
        return np.float32(self.diffuse) + np.float32(1 - self.diffuse) * out


def shading(lamp, u, v):
    """Slow change of the light over the picture: linear and, with `vignetting`, quadratic."""
    a = np.deg2rad(lamp["gradient_azimuth_deg"])
    out = 1 + np.float32(lamp["gradient_per_100px"] / 100) * (u * np.float32(np.cos(a)) + v * np.float32(np.sin(a)))
    if lamp["vignetting_per_100px"]:
        out = out - np.float32(lamp["vignetting_per_100px"] / 1e4) * (u * u + v * v)
    return np.maximum(out, np.float32(0.05))
