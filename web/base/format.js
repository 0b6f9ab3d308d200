// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them. A number that is not known (null) is a dash.
import { language } from "./words.js";

const unknown = "\u2013";

/**
 * With a true minus sign.
 * @param {number | null | undefined} value
 * @param {Intl.NumberFormatOptions} options
 */
function formatted(value, options) {
  if (value === null || value === undefined || !Number.isFinite(value)) return unknown;
  return new Intl.NumberFormat(language(), options).format(value).replace("-", "\u2212");
}

/**
 * Fixed point with grouped thousands: 20,000.0 (German: 20.000,0); never "-0.0".
 * @param {number | null | undefined} value
 * @param {number} decimals
 * @param {{signed?: boolean}} [options]
 */
export function fixed(value, decimals, options = {}) {
  const isZero = Math.abs(value ?? NaN) < 0.5 * 10 ** -decimals;
  return formatted(isZero ? 0 : value, { minimumFractionDigits: decimals, maximumFractionDigits: decimals,
    signDisplay: options.signed ? "always" : "auto" });
}

/**
 * In at most six significant digits, as few as tell it.
 * @param {number | null | undefined} value
 */
export function shortest(value) {
  return formatted(value, { maximumSignificantDigits: 6 });
}

/** @param {number | null | undefined} value */
export function whole(value) {
  return fixed(value, 0);
}

/**
 * A length in micrometres.
 * @param {number | null | undefined} value_um
 * @param {number} [decimals]
 */
export function micrometres(value_um, decimals = 1) {
  return `${fixed(value_um, decimals)}\u00a0\u00b5m`;
}

/**
 * A length in millimetres.
 * @param {number | null | undefined} value_mm
 * @param {number} [decimals]
 */
export function millimetres(value_mm, decimals = 3) {
  return `${fixed(value_mm, decimals)}\u00a0mm`;
}

/**
 * "(15.000, 89.026) mm"
 * @param {[number | null, number | null] | null | undefined} point_mm
 */
export function place(point_mm) {
  if (!point_mm) return unknown;
  return `(${fixed(point_mm[0], 3)}, ${fixed(point_mm[1], 3)})\u00a0mm`;
}

/** Decimals that show two digits of a standard deviation.
 * @param {number | null | undefined} sigma */
export function sigmaDecimals(sigma) {
  if (!sigma || !Number.isFinite(sigma)) return 3;
  return Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(Math.abs(sigma)))));
}

/**
 * Value and standard deviation in the decimals that show two digits of the latter.
 * @param {number | null | undefined} value
 * @param {number | null | undefined} sigma
 * @param {string} unit
 * @param {boolean} [signed]
 */
export function withSigma(value, sigma, unit, signed = true) {
  const decimals = sigmaDecimals(sigma);
  return `${fixed(value, decimals, { signed })} \u00b1 ${fixed(sigma, decimals)}\u00a0${unit}`;
}

/** A step of 1, 2 or 5 times a power of ten that is at least this.
 * @param {number} least */
export function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * (least <= power ? 1 : least <= 2 * power ? 2 : least <= 5 * power ? 5 : 10);
}

/** Multiples of a round step in a range, about n of them.
 * @param {number} low @param {number} high @param {number} n */
export function roundLevels(low, high, n) {
  const out = [], step = roundStep((high - low) / n);
  for (let i = Math.ceil(low / step); high > low && i * step <= high; ++i) out.push(i * step || 0);
  return out;
}

/** Decimals that tell apart multiples of a step.
 * @param {number} step */
export function decimalsOf(step) {
  return Math.min(9, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
}

/** A probability: 0.14, 6.3 x 10^-5, < 10^-12.
 * @param {number | null | undefined} risk */
export function probability(risk) {
  if (risk === null || risk === undefined) return unknown;
  if (risk < 1e-12) return "< 10\u207b\u00b9\u00b2";
  if (risk >= 0.001) return formatted(risk, { maximumSignificantDigits: 2 });
  const [digits, exponent] = risk.toExponential(1).split("e-");
  const superscript = [...exponent].map((digit) =>
    "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[Number(digit)]).join("");
  return `${fixed(Number(digits), 1)} \u00d7 10\u207b${superscript}`;
}

/** @param {number | null | undefined} share */
export function percent(share, decimals = 1) {
  return `${fixed(share === null || share === undefined ? null : 100 * share, decimals)}\u00a0%`;
}

/** @param {string} text @param {string} unit empty for a plain number */
function withUnit(text, unit) {
  return unit ? `${text}\u00a0${unit}` : text;
}

/** The unit in which people read small values of a unit.
 * @param {string} unit */
export function shownUnit(unit) {
  if (unit === "mm") return { factor: 1e3, name: "\u00b5m" };
  if (unit === "rad") return { factor: 1e3, name: "mrad" };
  return { factor: 1, name: unit === "1" ? "" : unit };
}

/**
 * A difference or a sigma, with its unit: 4.1 \u00b5m.
 * @param {number | null | undefined} value
 * @param {string} unit
 * @param {boolean} [signed]
 */
export function amount(value, unit, signed = false) {
  if (value === null || value === undefined || !Number.isFinite(value)) return unknown;
  if (unit === "mm" && Math.abs(value) >= 1) return `${fixed(value, 3, { signed })}\u00a0mm`;
  const { factor, name } = shownUnit(unit);
  if (factor !== 1) return `${fixed(factor * value, unit === "mm" ? 1 : 3, { signed })}\u00a0${name}`;
  return withUnit(formatted(value, { maximumSignificantDigits: 4, signDisplay: signed ? "always" : "auto" }), name);
}

/**
 * A value itself, with the digits that matter on a machine.
 * @param {number | null | undefined} value
 * @param {string} unit
 */
export function absolute(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return unknown;
  return unit === "mm" ? millimetres(value, 4) : withUnit(shortest(value), unit === "1" ? "" : unit);
}

/** "2026-11-21 03:10" (UTC).
 * @param {number} time_s */
export function timeText(time_s) {
  return new Date(1000 * time_s).toISOString().slice(0, 16).replace("T", " ");
}

/** "2026-11-21 03:10 UTC"
 * @param {string} iso */
export function minuteText(iso) {
  return `${timeText(secondsOf(iso))} UTC`;
}

/** @param {string} iso */
export function secondsOf(iso) {
  return Date.parse(iso) / 1000;
}
