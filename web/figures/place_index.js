// SPDX-License-Identifier: Apache-2.0
// The columns of a job's places, and the place nearest to a point among a million, by cells of a grid.
import { columnOf } from "../base/columns.js";

/** @type {WeakMap<object, ArrayLike<number | null>>} */
const columnsBefore = new WeakMap();

/**
 * A column of the table of places; the same array at every call.
 * @param {any} table facts.places.table
 * @param {string} key
 */
export function placeColumn(table, key) {
  const known = columnsBefore.get(table[key]);
  if (known) return known;
  const made = columnOf(table[key]);
  columnsBefore.set(table[key], made);
  return made;
}

/**
 * @param {ArrayLike<number | null>} x_mm
 * @param {ArrayLike<number | null>} y_mm
 * @param {{left: number, bottom: number, width: number, height: number}} box in mm
 */
export function placeIndex(x_mm, y_mm, box) {
  const n = x_mm.length;
  const size_mm = Math.max(1e-6, Math.sqrt((box.width || 1) * (box.height || 1) / Math.max(1, n / 4)),
    Math.max(box.width, box.height) / 2000);
  const columns = Math.floor(box.width / size_mm) + 1;
  const rows = Math.floor(box.height / size_mm) + 1;
  const clamp = (/** @type {number} */ v, /** @type {number} */ end) => Math.min(end - 1, Math.max(0, Math.floor(v)));
  const column = (/** @type {number} */ x) => clamp((x - box.left) / size_mm, columns);
  const row = (/** @type {number} */ y) => clamp((y - box.bottom) / size_mm, rows);
  const starts = new Uint32Array(columns * rows + 1);
  const cells = new Uint32Array(n);
  for (let i = 0; i < n; i++) {
    cells[i] = row(Number(y_mm[i])) * columns + column(Number(x_mm[i]));
    starts[cells[i] + 1]++;
  }
  for (let i = 1; i < starts.length; i++) starts[i] += starts[i - 1];
  const order = new Uint32Array(n);
  const next = starts.slice();
  for (let i = 0; i < n; i++) order[next[cells[i]]++] = i;

  /**
   * Calls `visit` with each place whose cell meets the box.
   * @param {number} low_x
   * @param {number} low_y
   * @param {number} high_x
   * @param {number} high_y
   * @param {(i: number) => void} visit
   */
  function within(low_x, low_y, high_x, high_y, visit) {
    const last_column = column(high_x);
    const last_row = row(high_y);
    for (let r = row(low_y); r <= last_row; r++) {
      for (let c = column(low_x); c <= last_column; c++) {
        const cell = r * columns + c;
        for (let k = starts[cell]; k < starts[cell + 1]; k++) visit(order[k]);
      }
    }
  }

  return {
    /**
     * The nearest place within a radius, or -1.
     * @param {number} x
     * @param {number} y
     * @param {number} radius_mm
     */
    nearest(x, y, radius_mm) {
      let best = -1;
      let least = radius_mm * radius_mm;
      within(x - radius_mm, y - radius_mm, x + radius_mm, y + radius_mm, (i) => {
        const square = (Number(x_mm[i]) - x) ** 2 + (Number(y_mm[i]) - y) ** 2;
        if (square <= least) {
          least = square;
          best = i;
        }
      });
      return best;
    },
  };
}
