// SPDX-License-Identifier: Apache-2.0
// Columns of tables in facts: plain arrays, or packed where they are long.

/** @type {WeakMap<object, ArrayLike<number | null>>} */
const unpacked = new WeakMap();

/**
 * The values of a column; the same array at every call.
 * @param {(number | null)[] | {type: "float32" | "uint32", base64: string}} column
 * @returns {ArrayLike<number | null>}
 */
export function columnOf(column) {
  if (Array.isArray(column)) return column;
  const known = unpacked.get(column);
  if (known) return known;
  const text = atob(column.base64);
  // A loop of its own: Uint8Array.from() takes a second for a million places.
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const values = column.type === "float32" ? new Float32Array(bytes.buffer) : new Uint32Array(bytes.buffer);
  unpacked.set(column, values);
  return values;
}

/**
 * A column of words that repeat.
 * @param {{words: string[], index: any}} column
 * @returns {string[]}
 */
export function wordsOf(column) {
  return Array.from(columnOf(column.index), (i) => column.words[i ?? 0]);
}

/**
 * Smallest and largest finite value; null where there is none.
 * @param {ArrayLike<number | null>} values
 * @returns {[number, number] | null}
 */
export function extremes(values) {
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    if (value === null || !Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : null;
}
