// SPDX-License-Identifier: Apache-2.0
// Columns of long tables: plain arrays, or packed as base64 (little-endian, as all browsers are).

/** @typedef {Float32Array | Uint32Array | (number | null)[]} Column */

/** @type {WeakMap<object, Column>} */
const unpackedBefore = new WeakMap();

/**
 * The values of a column; of a packed one the same array at every call.
 * @param {{type: string, base64: string} | (number | null)[]} column
 * @returns {Column}
 */
export function unpacked(column) {
  if (Array.isArray(column)) return column;
  const known = unpackedBefore.get(column);
  if (known) return known;
  const text = atob(column.base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const made = column.type === "float32" ? new Float32Array(bytes.buffer) : new Uint32Array(bytes.buffer);
  unpackedBefore.set(column, made);
  return made;
}

/**
 * Smallest and largest finite value; null where there is none.
 * @param {ArrayLike<number | null>} values
 * @returns {[number, number] | null}
 */
export function extremes(values) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    if (value === null || !Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : null;
}
