# SPDX-License-Identifier: Apache-2.0
"""From radiance on the working grid to irradiance averaged over pixels.

Spectrum of the scene x OTF of the lens x OTF of the motion x pixel aperture, then every pixel is
sampled at its centre. The OTF comes from a pupil with aberrations, not from a Gaussian.
"""
import numpy as np

N_PUPIL = 48


def pupil_otf(lens, offset_waves):
    """(OTF, step in cycles/px, shift of edges [x, y] in px) by autocorrelation of the pupil.

    OTF: square complex array, frequency 0 in the middle, 2 N_PUPIL samples over +-cutoff. Aberrations in
    waves, on rho = radius / pupil radius, t from coma_azimuth_deg:
      W = defocus rho^2 + spherical (6 rho^4 - 6 rho^2) + coma (3 rho^3 - 2 rho) cos t + astigmatism rho^2 cos 2t
    Source: Goodman, Introduction to Fourier Optics, 6.3 and 6.4; Seidel and Zernike terms.
    """
    k = (np.arange(N_PUPIL) + 0.5) * (2 / N_PUPIL) - 1
    px, py = np.meshgrid(k, k)
    rho2 = px * px + py * py
    a = np.deg2rad(lens["coma_azimuth_deg"])
    along = px * np.cos(a) + py * np.sin(a)
    across = py * np.cos(a) - px * np.sin(a)
    w = ((lens["defocus_waves"] + offset_waves) * rho2 + lens["spherical_waves"] * (6 * rho2 ** 2 - 6 * rho2)
         + lens["coma_waves"] * (3 * rho2 - 2) * along
         + lens["astigmatism_waves"] * (along ** 2 - across ** 2))
    # a soft pupil edge, one cell wide, keeps the sampled pupil round
    inside = np.clip((1 - np.sqrt(rho2)) * (N_PUPIL / 2) + 0.5, 0, 1)
    spectrum = np.fft.fft2(inside * np.exp(2j * np.pi * w), (2 * N_PUPIL, 2 * N_PUPIL))
    otf = np.fft.ifft2(np.abs(spectrum) ** 2)
    otf /= otf[0, 0]
    step = lens["cutoff_per_px"] / N_PUPIL
    return np.fft.fftshift(otf), step, edge_shift(otf, step, a)


def edge_shift(otf, step, azimuth_rad):
    """Where the picture of a straight edge passes half its height, along the direction of coma, px [x, y].

    Edge response at x: 1/2 + (1/pi) sum Im(OTF(f) exp(2 pi i f x)) / f df; its root by bisection. Coma
    moves all edges of a small target alike, and a calibration of the lens contains that.
    """
    e = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad)])
    k = np.arange(0.5, N_PUPIL - 1)
    i, j = k * e[0], k * e[1]
    i0, j0 = np.floor(i).astype(int), np.floor(j).astype(int)
    fi, fj = i - i0, j - j0
    line = ((otf[j0, i0] * (1 - fi) + otf[j0, i0 + 1] * fi) * (1 - fj)
            + (otf[j0 + 1, i0] * (1 - fi) + otf[j0 + 1, i0 + 1] * fi) * fj)
    f = k * step
    low, high = -4.0, 4.0
    for _ in range(24):
        x = (low + high) / 2
        if np.sum(np.imag(line * np.exp(2j * np.pi * f * x)) / f) < 0:
            low = x
        else:
            high = x
    return tuple(float(t) for t in (low + high) / 2 * e)


def _linear(f, step):
    """Matrix (len(f) x 2 N_PUPIL) that interpolates pupil_otf's samples at f, 0 beyond the cutoff."""
    s = np.clip(f / step + N_PUPIL, 0, 2 * N_PUPIL - 1)
    k = np.minimum(s.astype(int), 2 * N_PUPIL - 2)
    out = np.zeros((len(f), 2 * N_PUPIL), np.complex64)
    rows = np.arange(len(f))
    out[rows, k] = 1 - (s - k)
    out[rows, k + 1] = s - k
    return out


def motion_path(motion, n=64):
    """Displacements (n x 2, px) over the exposure: drift and vibration that decays, mean 0.

      d(t) = A exp(-t / tau) cos(2 pi f t + phase) + drift (t / T - 1/2)
    Source: a stage that rings down after its move; truth is the mean place during exposure.
    """
    t = (np.arange(n) + 0.5) / n * motion["exposure_ms"]
    ring = (motion["amplitude_px"] * np.exp(-t / motion["decay_ms"])
            * np.cos(2 * np.pi * motion["frequency_hz"] * t / 1000 + np.deg2rad(motion["phase_deg"])))
    d = ring + motion["drift_px"] * (t / motion["exposure_ms"] - 0.5)
    d -= d.mean()
    a = np.deg2rad(motion["azimuth_deg"])
    return np.stack([d * np.cos(a), d * np.sin(a)], 1)


class Optics:
    """Everything between scene and pixel of one colour channel."""

    def __init__(self, grid, lens, motion, defocus_offset_waves, shift_px, fill_factor):
        self.grid = grid
        # bins per pixel of the picture that carry light: the OTF is 0 above the lens' cutoff
        self.keep = 2 if lens["cutoff_per_px"] <= 1 else 4
        self.keep = min(self.keep, grid.ss)
        nx, ny = grid.nx * self.keep, grid.ny * self.keep
        self.fx, self.fy = np.arange(nx // 2 + 1) / grid.nx, np.fft.fftfreq(ny, 1 / ny) / grid.ny
        table, step, moved = pupil_otf(lens, defocus_offset_waves)
        otf = _linear(self.fy, step) @ (table.astype(np.complex64) @ _linear(self.fx, step).T)
        glare = lens["glare"]
        if glare:
            # transform of a halo that falls off as exp(-r / glare_px)
            k = np.float32((2 * np.pi * lens["glare_px"]) ** 2)
            t = 1 + k * (self.fx.astype(np.float32)[None, :] ** 2 + self.fy.astype(np.float32)[:, None] ** 2)
            otf *= np.float32(1 - glare)
            otf += np.float32(glare) / (t * np.sqrt(t))
        h = grid.h
        # pixel aperture over the working sample's own, and the shift to the pixel's centre
        def axis(f, shift):
            aperture = np.sinc(f * fill_factor ** 0.5) / np.sinc(f * h)
            return aperture * np.exp(2j * np.pi * f * (0.5 - 0.5 * h - shift))
        otf *= axis(self.fx, shift_px[0] - moved[0])[None, :].astype(np.complex64)
        otf *= axis(self.fy, shift_px[1] - moved[1])[:, None].astype(np.complex64)
        if motion["amplitude_px"] or motion["drift_px"]:
            d = motion_path(motion)
            mx = np.exp(-2j * np.pi * np.outer(d[:, 0], self.fx))
            my = np.exp(-2j * np.pi * np.outer(self.fy, d[:, 1]))
            otf *= ((my @ mx) / len(d)).astype(np.complex64)
        self.otf = otf

    def blur_px(self):
        """Sigma of the Gaussian with the same frequency of half modulation, mean of x and y."""
        def half(mtf, f):
            below = np.flatnonzero(mtf < 0.5)
            if not len(below):
                return f[-1]
            i = below[0]
            return f[i - 1] + (f[i] - f[i - 1]) * (mtf[i - 1] - 0.5) / max(mtf[i - 1] - mtf[i], 1e-9)
        n = len(self.fy) // 2
        fx = half(np.abs(self.otf[0]), self.fx)
        fy = half(np.abs(self.otf[:n, 0]), self.fy[:n])
        return float(np.sqrt(2 * np.log(2)) / (2 * np.pi) / np.sqrt(fx * fy))

    def pixels(self, radiance):
        """Irradiance of every pixel of the picture, from radiance on the working grid."""
        g = self.grid
        nfx, nfy = len(self.fx), len(self.fy)
        rows = np.fft.rfft(radiance, axis=1)[:, :nfx]
        spectrum = np.fft.fft(rows, axis=0)
        low = np.concatenate([spectrum[:nfy // 2], spectrum[-(nfy - nfy // 2):]])
        low *= self.otf
        low[:, -1] = 0
        low[nfy // 2] = 0
        fine = np.fft.irfft2(low, s=(nfy, 2 * (nfx - 1)))
        scale = (self.keep / g.ss) ** 2
        out = fine[::self.keep, ::self.keep] * scale
        return out[g.top:g.top + g.height, g.left:g.left + g.width].astype(np.float32)
