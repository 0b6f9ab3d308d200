// SPDX-License-Identifier: Apache-2.0
// Columns of tables in facts: plain arrays, or packed where they are long.

/**
 * @param {(number | null)[] | {type: "float32" | "uint32", base64: string}} column
 * @returns {ArrayLike<number | null>}
 */
export function columnOf(column) {
  if (Array.isArray(column)) return column;
  const bytes = Uint8Array.from(atob(column.base64), (letter) => letter.charCodeAt(0));
  return column.type === "float32" ? new Float32Array(bytes.buffer) : new Uint32Array(bytes.buffer);
}

/**
 * A column of words that repeat.
 * @param {{words: string[], index: any}} column
 * @returns {string[]}
 */
export function wordsOf(column) {
  return Array.from(columnOf(column.index), (i) => column.words[i ?? 0]);
}
