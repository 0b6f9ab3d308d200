// SPDX-License-Identifier: Apache-2.0
// Colours that stay apart for all kinds of colour vision; the style sheet has them, dark and light.

/**
 * A colour of the style sheet, for drawing on a canvas: colour("good").
 * @param {string} name
 */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Colours of categories in the order of the style sheet (after Okabe and Ito).
 * @param {number} index */
export function categoryColour(index) {
  return colour(`category-${index % 8}`);
}

// Stops of viridis (CC0), from dark to light.
const stops = [
  [68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128],
  [94, 201, 98], [173, 220, 48], [253, 231, 37],
];

/**
 * A colour of the scale from 0 to 1: red, green, blue.
 * @param {number} share
 * @returns {[number, number, number]}
 */
export function scaleColour(share) {
  const at = Math.min(1, Math.max(0, Number.isFinite(share) ? share : 0)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(at));
  const mix = (/** @type {number} */ k) =>
    Math.round(stops[i][k] + (at - i) * (stops[i + 1][k] - stops[i][k]));
  return [mix(0), mix(1), mix(2)];
}

/** @param {number} share */
export function scaleCss(share) {
  return `rgb(${scaleColour(share).join(" ")})`;
}

/**
 * A colour for a difference from -1 (blue) over 0 (grey) to 1 (orange): red, green, blue.
 * @param {number} share
 * @returns {[number, number, number]}
 */
export function differenceColour(share) {
  const middle = [236, 236, 236], end = share < 0 ? [5, 92, 157] : [192, 79, 0];
  const at = Math.min(1, Math.abs(Number.isFinite(share) ? share : 0));
  const mix = (/** @type {number} */ k) => Math.round(middle[k] + at * (end[k] - middle[k]));
  return [mix(0), mix(1), mix(2)];
}
