// SPDX-License-Identifier: Apache-2.0
// Where the panel of a job went: arrows at its places, without what they have in common.
import { columnOf, extremes } from "../base/columns.js";
import { fixed, micrometres, place } from "../base/format.js";
import { word } from "../base/words.js";
import { panelArrows } from "./panel_arrows.js";

/** Arrows along the longer side, of displacements of many places. */
const planCells = 14;

/** @typedef {{at_mm: number[], moved_um: number[], name?: string}} Displaced */

/**
 * The place nearest to the middle of each cell of a coarse grid.
 * @returns {Displaced[]}
 */
function placesOnGrid(table) {
  const [x, y, dx, dy] = ["nominal_x_mm", "nominal_y_mm", "shift_x_um", "shift_y_um"].map((key) => columnOf(table[key]));
  const [left, right] = extremes(x) ?? [0, 0], [bottom, top] = extremes(y) ?? [0, 0];
  const cell = Math.max(1e-3, Math.max(right - left, top - bottom) / planCells);
  /** @type {Map<number, {i: number, distance: number}>} */
  const nearest = new Map();
  for (let i = 0; i < table.n; i++) {
    const a = (Number(x[i]) - left) / cell;
    const b = (Number(y[i]) - bottom) / cell;
    const key = Math.floor(a) * 1000 + Math.floor(b);
    const distance = Math.hypot(a % 1 - 0.5, b % 1 - 0.5);
    const known = nearest.get(key);
    if (!known || distance < known.distance) nearest.set(key, { i, distance });
  }
  return [...nearest.values()].map(({ i }) =>
    ({ at_mm: [Number(x[i]), Number(y[i])], moved_um: [Number(dx[i]), Number(dy[i])] }));
}

/** @returns {Displaced} */
function displacedTarget(target) {
  const moved_um = target.measured.place_mm.map((at, k) => 1e3 * (at - target.nominal_mm[k]));
  return { at_mm: target.nominal_mm, moved_um, name: `#${target.seq}` };
}

/** What an arrow says when it is pointed at: its place, and its size in um. */
export function arrowLines(at_mm, vector_um) {
  return [place(at_mm), `(${vector_um.map((one) => fixed(one, 2, { signed: true })).join(", ")})\u00a0\u00b5m`,
    `${word("length")} ${micrometres(Math.hypot(...vector_um), 2)}`];
}

/** With the shift of the middle taken out, then with the rotation as well. */
export function shiftPlans(facts) {
  const table = facts.places?.table;
  const hasPlaces = table && table.n > 0;
  /** @type {Displaced[]} */
  const places = hasPlaces ? placesOnGrid(table) : facts.targets.filter((target) => target.measured).map(displacedTarget);
  if (places.length < 2 || !places.some((one) => Math.hypot(...one.moved_um) > 1e-3)) return [];
  const mean = (key) => [0, 1].map((k) => places.reduce((sum, one) => sum + one[key][k], 0) / places.length);
  const middle = mean("at_mm"), moved = mean("moved_um");
  // The rotation nearest to the displacements about their middle, exact for any angle.
  let [along, across] = [0, 0];
  for (const { at_mm, moved_um } of places) {
    const [a, b] = at_mm.map((at, k) => at - middle[k]);
    const [c, d] = [a + (moved_um[0] - moved[0]) / 1e3, b + (moved_um[1] - moved[1]) / 1e3];
    along += a * c + b * d;
    across += a * d - b * c;
  }
  const angle = Math.atan2(across, along);
  const plan = (rotation, caption) => panelArrows({ label: caption, mostHeight: 460, places: places.map(({ at_mm, moved_um, name }) => {
    const [a, b] = at_mm.map((at, k) => at - middle[k]);
    const turned = [Math.cos(rotation) * a - Math.sin(rotation) * b, Math.sin(rotation) * a + Math.cos(rotation) * b];
    const left_um = [moved_um[0] - moved[0] - 1e3 * (turned[0] - a), moved_um[1] - moved[1] - 1e3 * (turned[1] - b)];
    return { at_mm, vector_mm: left_um.map((one) => one / 1e3), kind: "shift", name, lines: arrowLines(at_mm, left_um) };
  }) }, caption);
  const [x, y] = moved.map((one) => fixed(one / 1e3, 3, { signed: true }));
  return [plan(0, word(hasPlaces ? "shift_of_holes" : "shift_of_targets", { x, y })),
    plan(angle, word("shift_and_rotation", { mrad: fixed(1e3 * angle, 3, { signed: true }) }))];
}
