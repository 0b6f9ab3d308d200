// SPDX-License-Identifier: Apache-2.0
// The noise of targets that a fit hands on to places, as calib/advice/target_design.h has it; by the
// Jacobians of the models in the facts, so that it follows when a target is moved.

/**
 * A target: place mm, and inverse covariance [xx, xy, yy] in units of the noise of its series.
 * @typedef {{x: number, y: number, weight: [number, number, number]}} Target
 */

/** @typedef {number[][]} Matrix */

/**
 * @param {Matrix} a
 * @param {Matrix} b
 * @returns {Matrix}
 */
function times(a, b) {
  return a.map((row) => b[0].map((_, k) => row.reduce((sum, value, i) => sum + value * b[i][k], 0)));
}

/** @param {Matrix} a
 * @returns {Matrix} */
function transposed(a) {
  return a[0].map((_, k) => a.map((row) => row[k]));
}

/**
 * The inverse of a symmetric positive definite matrix; null if it has none, but for rounding.
 * @param {Matrix} a
 * @returns {Matrix | null}
 */
function inverse(a) {
  const n = a.length, rows = a.map((row, i) => [...row, ...row.map((_, k) => (i === k ? 1 : 0))]);
  const most = Math.max(...a.map((row, i) => row[i]));
  for (let i = 0; i < n; ++i) {
    // Positive definite: no other pivot is needed.
    const pivot = rows[i][i];
    if (!(pivot > 1e-11 * most)) return null;
    for (let k = 0; k < 2 * n; ++k) rows[i][k] /= pivot;
    for (let j = 0; j < n; ++j) {
      const factor = rows[j][i];
      if (j === i || factor === 0) continue;
      for (let k = 0; k < 2 * n; ++k) rows[j][k] -= factor * rows[i][k];
    }
  }
  return rows.map((row) => row.slice(n));
}

/**
 * [x y 0 0 1 0; 0 0 x y 0 1]: what the coefficients [l00 l01 l10 l11 tx ty] do to a place.
 * @param {number} x
 * @param {number} y
 * @returns {Matrix}
 */
function design(x, y) {
  return [[x, y, 0, 0, 1, 0], [0, 0, x, y, 0, 1]];
}

/**
 * The predicted fit of a model to targets; null if they do not determine it.
 *
 * Out  leverage(x, y): of a place, times the noise; covariance(x, y): of it, [xx, xy, yy], in units of the
 *      noise squared; shift(i, error): how places move, in the error's unit, if target i alone is off by it.
 * @param {Target[]} targets
 * @param {Matrix} jacobian of the model
 * @param {Matrix} [baseCov] of the map under which the targets are looked up, in units of the noise squared
 */
export function predictedFit(targets, jacobian, baseCov) {
  if (targets.length === 0) return null;
  const middle = (/** @type {"x" | "y"} */ k) => targets.reduce((sum, one) => sum + one[k], 0) / targets.length;
  const cx = middle("x"), cy = middle("y");
  // In coordinates of the size of 1 about the middle, in which every model stays what it is.
  const size = Math.max(1, ...targets.map((one) => Math.hypot(one.x - cx, one.y - cy)));
  const designAt = (/** @type {number} */ x, /** @type {number} */ y) => design((x - cx) / size, (y - cy) / size);
  const weighted = targets.map(({ x, y, weight: [xx, xy, yy] }) =>
    times(transposed(designAt(x, y)), [[xx, xy], [xy, yy]]));
  let information = /** @type {Matrix} */ (Array.from({ length: 6 }, () => Array(6).fill(0)));
  targets.forEach(({ x, y }, i) => {
    const one = times(weighted[i], designAt(x, y));
    information = information.map((row, j) => row.map((value, k) => value + one[j][k]));
  });
  const inner = inverse(times(transposed(jacobian), times(information, jacobian)));
  if (!inner) return null;
  const own = times(jacobian, times(inner, transposed(jacobian)));
  let cov = own;
  if (baseCov) {
    // l' = size l and t' = t + l c; the part of the base's error that this fit does not take back.
    const scaled = [[size, 0, 0, 0, 0, 0], [0, size, 0, 0, 0, 0], [0, 0, size, 0, 0, 0], [0, 0, 0, size, 0, 0],
      [cx, cy, 0, 0, 1, 0], [0, 0, cx, cy, 0, 1]];
    const taken = times(own, information);
    const left = times(taken.map((row, i) => row.map((value, k) => (i === k ? 1 : 0) - value)), scaled);
    const rest = times(left, times(baseCov, transposed(left)));
    cov = own.map((row, i) => row.map((value, k) => value + rest[i][k]));
  }
  /** @returns {[number, number, number]} */
  const covariance = (/** @type {number} */ x, /** @type {number} */ y) => {
    const p = [(x - cx) / size, (y - cy) / size, 1];
    let xx = 0, xy = 0, yy = 0;
    for (let i = 0; i < 3; ++i) {
      for (let k = 0; k < 3; ++k) {
        const product = p[i] * p[k], atX = (/** @type {number} */ j) => (j === 2 ? 4 : j);
        xx += product * cov[atX(i)][atX(k)];
        xy += product * cov[atX(i)][k === 2 ? 5 : k + 2];
        yy += product * cov[i === 2 ? 5 : i + 2][k === 2 ? 5 : k + 2];
      }
    }
    return [xx, xy, yy];
  };
  return {
    covariance,
    leverage: (/** @type {number} */ x, /** @type {number} */ y) => greatestSigma(covariance(x, y)),
    shift: (/** @type {number} */ i, /** @type {[number, number]} */ error) => {
      const moved = times(times(own, weighted[i]), [[error[0]], [error[1]]]);
      return (/** @type {number} */ x, /** @type {number} */ y) => {
        const [[dx], [dy]] = times(designAt(x, y), moved);
        return /** @type {[number, number]} */ ([dx, dy]);
      };
    },
  };
}

/** Square root of the greater eigenvalue of [xx, xy, yy].
 * @param {[number, number, number]} covariance */
export function greatestSigma([xx, xy, yy]) {
  return Math.sqrt(Math.max(0, (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy)));
}

/** Sigma of a place under a map, in the unit of its coefficients [l00 l01 l10 l11 tx ty].
 * @param {Matrix} covariance @param {number} x @param {number} y */
export function mapSigma(covariance, x, y) {
  const [[xx, xy], [, yy]] = times(times(design(x, y), covariance), transposed(design(x, y)));
  return greatestSigma([xx, xy, yy]);
}
