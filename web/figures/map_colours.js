// SPDX-License-Identifier: Apache-2.0
// The places of a job in columns, and how the map colours them.
import { categoryColour, colour, scaleColour } from "../base/colours.js";
import { columnOf, extremes } from "../base/columns.js";

/**
 * The places of a job in columns, and what the map colours them by.
 * @param {any} table facts.places.table
 */
export function mapColumns(table) {
  const get = (/** @type {string} */ key) => columnOf(table[key]);
  const shift_x_um = get("shift_x_um");
  const shift_y_um = get("shift_y_um");
  const shift_um = new Float32Array(table.n);
  for (let i = 0; i < table.n; i++) {
    const [dx, dy] = [Number(shift_x_um[i]), Number(shift_y_um[i])];
    shift_um[i] = Math.sqrt(dx * dx + dy * dy);
  }
  return {
    n: table.n, kind: get("kind"), x_mm: get("nominal_x_mm"), y_mm: get("nominal_y_mm"), shift_x_um, shift_y_um,
    shift_um, sigma_um: get("sigma_um"), risk: get("risk"), line: get("line"), tool: get("tool"),
    board: get("board"), file: get("file"), boards: table.boards, files: table.files,
  };
}

/** @typedef {ReturnType<typeof mapColumns>} MapColumns */

/**
 * Red, green, blue of a colour of CSS: #rgb, #rrggbb.
 * @param {string} css
 * @returns {[number, number, number]}
 */
function rgbOf(css) {
  const digits = css.length === 4 ? [...css.slice(1)].map((d) => d + d).join("") : css.slice(1);
  const value = parseInt(digits, 16);
  return [value >> 16 & 255, value >> 8 & 255, value & 255];
}

/**
 * A pixel of a canvas, opaque.
 * @param {[number, number, number]} rgb
 */
function pixelOf([red, green, blue]) {
  return (255 << 24 | blue << 16 | green << 8 | red) >>> 0;
}

/**
 * How places are coloured: by tool, or by a value on the scale.
 * @param {string} mode
 * @param {MapColumns} columns
 * @param {number[]} tools
 * @returns {{css: (i: number) => string, pixel: (i: number) => number, range: [number, number] | null,
 *   isLogarithm: boolean}}
 */
export function colouring(mode, columns, tools) {
  const quiet = colour("quiet");
  if (mode === "tool") {
    const colours = new Map(tools.map((tool, i) => [tool, categoryColour(i)]));
    const pixels = new Map([...colours].map(([tool, css]) => [tool, pixelOf(rgbOf(css))]));
    const none = pixelOf(rgbOf(quiet));
    return {
      css: (i) => colours.get(Number(columns.tool[i])) ?? quiet,
      pixel: (i) => pixels.get(Number(columns.tool[i])) ?? none, range: null, isLogarithm: false,
    };
  }
  const isLogarithm = mode === "risk";
  const values = mode === "shift" ? columns.shift_um : mode === "sigma" ? columns.sigma_um : columns.risk;
  const range = isLogarithm ? /** @type {[number, number]} */ ([-12, 0]) : extremes(values) ?? [0, 1];
  const span = Math.max(1e-9, range[1] - range[0]);
  const table = Array.from({ length: 256 }, (_, i) => scaleColour(i / 255));
  // The last one is that of values that are not known.
  const pixels = Uint32Array.from([...table, rgbOf(quiet)], (rgb) => pixelOf(rgb));
  const step = (/** @type {number} */ i) => {
    const value = values[i];
    if (value === null || !Number.isFinite(value)) return 256;
    const at = isLogarithm ? Math.log10(Math.max(1e-12, Number(value))) : Number(value);
    return Math.max(0, Math.min(255, Math.round(255 * (at - range[0]) / span)));
  };
  return {
    css: (i) => step(i) === 256 ? quiet : `rgb(${table[step(i)].join(" ")})`, pixel: (i) => pixels[step(i)], range, isLogarithm,
  };
}
