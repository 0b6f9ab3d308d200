// SPDX-License-Identifier: Apache-2.0
// Values at the nodes of an even grid: colours and contours.
import { colour } from "../base/colours.js";

/**
 * Rows from low y; a value that is not known is NaN.
 * @typedef {{first: [number, number], step: [number, number], columns: number, rows: number,
 *   values: Float64Array}} Field
 */

/** @typedef {import("./plane.js").Plane} Plane */

/**
 * A field of facts; null becomes NaN.
 * @param {(number | null)[]} values
 * @returns {Field}
 */
export function fieldOf(facts, values) {
  return {
    first: facts.first_mm, step: facts.step_mm, columns: facts.columns, rows: facts.rows,
    values: Float64Array.from(values, (value) => value ?? NaN),
  };
}

/**
 * The same with values at the rim of what is known, so that colours reach an edge between nodes.
 * @param {Field} field
 * @returns {Field}
 */
export function widenedField(field) {
  const values = field.values.slice();
  field.values.forEach((value, i) => {
    if (!Number.isNaN(value)) return;
    let sum = 0, n = 0;
    const column = i % field.columns, row = Math.floor(i / field.columns);
    for (let k = 0; k < 9; ++k) {
      const x = column - 1 + (k % 3), y = row - 1 + Math.floor(k / 3);
      if (x < 0 || x >= field.columns || y < 0 || y >= field.rows) continue;
      const near = field.values[y * field.columns + x];
      if (Number.isNaN(near)) continue;
      sum += near;
      ++n;
    }
    if (n > 0) values[i] = sum / n;
  });
  return { ...field, values };
}

/**
 * The value at a place, from the four nodes about it; NaN outside.
 * @param {Field} field
 * @param {[number, number]} place
 */
export function fieldAt(field, place) {
  const x = (place[0] - field.first[0]) / field.step[0], y = (place[1] - field.first[1]) / field.step[1];
  const column = Math.min(field.columns - 2, Math.floor(x)), row = Math.min(field.rows - 2, Math.floor(y));
  if (column < 0 || row < 0 || x > field.columns - 1 || y > field.rows - 1) return NaN;
  const u = x - column, v = y - row, i = row * field.columns + column;
  const value = (/** @type {number} */ k) => field.values[i + k];
  return (1 - v) * ((1 - u) * value(0) + u * value(1)) +
    v * ((1 - u) * value(field.columns) + u * value(field.columns + 1));
}

/**
 * Paints a field by a function from value to colour, smoothly.
 * @param {Plane} plane
 * @param {Field} field
 * @param {(value: number) => [number, number, number]} paint
 */
export function paintField(plane, field, paint) {
  const picture = new ImageData(field.columns, field.rows);
  field.values.forEach((value, i) => {
    if (Number.isNaN(value)) return;
    // Pictures begin above.
    const row = field.rows - 1 - Math.floor(i / field.columns);
    picture.data.set([...paint(value), 255], 4 * (row * field.columns + (i % field.columns)));
  });
  const small = document.createElement("canvas");
  small.width = field.columns;
  small.height = field.rows;
  /** @type {CanvasRenderingContext2D} */ (small.getContext("2d")).putImageData(picture, 0, 0);
  const width = field.step[0] * plane.scale, height = field.step[1] * plane.scale;
  plane.context.imageSmoothingEnabled = true;
  plane.context.imageSmoothingQuality = "high";
  // Each pixel lies about its node.
  plane.context.drawImage(small, plane.x(field.first[0]) - width / 2,
    plane.y(field.first[1] + (field.rows - 1) * field.step[1]) - height / 2, width * field.columns, height * field.rows);
}

/**
 * Segments of the contour at a level, by marching squares (Lorensen and Cline 1987, in the plane).
 * @param {Field} field
 * @param {number} level
 * @returns {[number, number, number, number][]} mm
 */
function contourSegments(field, level) {
  /** @type {[number, number, number, number][]} */
  const out = [];
  const { columns, values } = field;
  for (let row = 0; row + 1 < field.rows; ++row) {
    for (let column = 0; column + 1 < columns; ++column) {
      const i = row * columns + column;
      // Corners counter-clockwise from the lower left one, as offsets.
      const corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
      const heights = [values[i], values[i + 1], values[i + columns + 1], values[i + columns]];
      if (heights.some(Number.isNaN)) continue;
      /** @type {[number, number][]} */
      const crossings = [];
      for (let k = 0; k < 4; ++k) {
        const a = heights[k] - level, b = heights[(k + 1) % 4] - level;
        if (a < 0 === b < 0) continue;
        const from = corners[k], to = corners[(k + 1) % 4], t = a / (a - b);
        crossings.push([field.first[0] + (column + from[0] + t * (to[0] - from[0])) * field.step[0],
          field.first[1] + (row + from[1] + t * (to[1] - from[1])) * field.step[1]]);
      }
      // Of a saddle the mean decides which corners hang together.
      const mean = heights.reduce((sum, height) => sum + height, 0) / 4;
      const shift = crossings.length === 4 && mean < level === heights[0] < level ? 1 : 0;
      for (let k = 0; k + 1 < crossings.length; k += 2) {
        const a = crossings[(k + shift) % crossings.length], b = crossings[(k + shift + 1) % crossings.length];
        out.push([a[0], a[1], b[0], b[1]]);
      }
    }
  }
  return out;
}

/**
 * Draws contours, and the figure of each where there is room.
 * @param {Plane} plane
 * @param {Field} field
 * @param {number[]} levels
 * @param {(level: number) => string} text
 */
export function drawContours(plane, field, levels, text) {
  const { context } = plane;
  /** @type {[number, number][]} */
  const taken = [];
  context.lineWidth = 1;
  context.strokeStyle = colour("paper");
  context.globalAlpha = 0.75;
  const all = levels.map((level) => contourSegments(field, level));
  context.beginPath();
  for (const [ax, ay, bx, by] of all.flat()) {
    context.moveTo(plane.x(ax), plane.y(ay));
    context.lineTo(plane.x(bx), plane.y(by));
  }
  context.stroke();
  context.globalAlpha = 1;
  context.textAlign = "center";
  context.textBaseline = "middle";
  all.forEach((segments, k) => {
    // From the middle outwards.
    for (let i = 0; i < segments.length; ++i) {
      const segment = segments[(i * 7 + Math.floor(segments.length / 3)) % segments.length];
      const x = plane.x(segment[0]), y = plane.y(segment[1]);
      if (y < plane.top + 12 || y > plane.bottom - 12) continue;
      if ([-26, 26].some((aside) => Number.isNaN(fieldAt(field, plane.place(x + aside, y))))) continue;
      if (taken.some(([ox, oy]) => Math.hypot(ox - x, oy - y) < 42)) continue;
      taken.push([x, y]);
      plane.drawText(text(levels[k]), x, y, colour("ink"));
      break;
    }
  });
}

/**
 * A function of the place, at nodes a few pixels apart over the frame.
 * @param {Plane} plane
 * @param {(x_mm: number, y_mm: number) => number} valueAt
 * @returns {Field}
 */
export function sampledField(plane, valueAt) {
  const columns = 110, rows = Math.max(2, Math.round((columns * (plane.bottom - plane.top)) / (plane.right - plane.left)));
  const first = plane.place(plane.left, plane.bottom), last = plane.place(plane.right, plane.top);
  const step = /** @type {[number, number]} */ ([(last[0] - first[0]) / (columns - 1), (last[1] - first[1]) / (rows - 1)]);
  const values = Float64Array.from({ length: columns * rows }, (_, i) =>
    valueAt(first[0] + (i % columns) * step[0], first[1] + Math.floor(i / columns) * step[1]));
  return { first, step, columns, rows, values };
}
