// SPDX-License-Identifier: Apache-2.0
// Arrows of small displacements on a plan of the panel, magnified, with the magnification stated.
import { element, svg } from "../base/dom.js";
import { word } from "../base/words.js";
import { fixed, micrometres, shortest } from "../base/format.js";
import { placeColumn } from "./place_index.js";
import { ellipseOf } from "./target_picture.js";

/** Longest side of the plan in its own units. */
const planSide = 400;
/** Arrows along the longer side, of displacements of many places. */
const planCells = 14;

/**
 * One displaced place; covariance in um^2 where it is known.
 * @typedef {{x: number, y: number, dx_um: number, dy_um: number, label?: string, isBad?: boolean,
 *   covariance_um2?: [number, number, number]}} Displaced
 */

/**
 * @param {Displaced[]} places
 * @param {string} kind class of the arrows
 * @param {string} caption
 */
export function arrowPlan(places, kind, caption) {
  const xs = places.map((p) => p.x);
  const ys = places.map((p) => p.y);
  const [left, bottom] = [Math.min(...xs), Math.min(...ys)];
  const size = Math.max(1e-3, Math.max(...xs) - left, Math.max(...ys) - bottom);
  const scale = planSide / size;
  const width = (Math.max(...xs) - left) * scale;
  const height = (Math.max(...ys) - bottom) * scale;
  const longest = Math.max(0, ...places.map((p) => Math.hypot(p.dx_um, p.dy_um)));
  if (!(longest > 1e-3)) return element("figure", {}, element("figcaption", {}, caption, " ", word("nothing_to_draw")));
  const reach = Math.max(longest, ...places.map((p) =>
    p.covariance_um2 ? Math.hypot(p.dx_um, p.dy_um) + ellipseOf(p.covariance_um2).major : 0));
  const px_per_um = 0.15 * planSide / reach;
  const drawn = places.map((p) => {
    const [u, v] = [(p.x - left) * scale, height - (p.y - bottom) * scale];
    const [du, dv] = [p.dx_um * px_per_um, -p.dy_um * px_per_um];
    const ellipse = p.covariance_um2 && ellipseOf(p.covariance_um2);
    return svg("g", { class: p.isBad ? "refused" : kind },
      p.label && svg("title", {}, p.label),
      svg("circle", { cx: u, cy: v, r: 1.5 }),
      svg("path", { d: arrowPath(u, v, du, dv) }),
      ellipse && svg("ellipse", { class: "ellipse", cx: u + du, cy: v + dv, rx: ellipse.major * px_per_um,
        ry: ellipse.minor * px_per_um, transform: `rotate(${-ellipse.angle_deg} ${u + du} ${v + dv})` }),
      p.label && places.length <= 12 && svg("text", { x: u + 6, y: v - 6 }, p.label));
  });
  const margin = 0.17 * planSide;
  const times = Math.round(1e3 * px_per_um / scale);
  return element("figure", {},
    svg("svg", { class: "plan", viewBox: `${-margin} ${-margin} ${width + 2 * margin} ${height + 2 * margin}`,
      role: "img", "aria-label": caption },
      svg("rect", { class: "gridline", x: 0, y: 0, width, height }), drawn),
    element("figcaption", {}, caption, " ",
      word("magnified", { times: shortest(times), longest: micrometres(longest, 2) })));
}

/**
 * @param {number} u
 * @param {number} v
 * @param {number} du
 * @param {number} dv
 */
export function arrowPath(u, v, du, dv) {
  const length = Math.hypot(du, dv);
  if (!(length > 0.1)) return "";
  const head = Math.min(6, 0.4 * length) / length;
  const [a, b] = [du * head, dv * head];
  const digits = (/** @type {number} */ value) => value.toFixed(1);
  return `M${digits(u)} ${digits(v)}L${digits(u + du)} ${digits(v + dv)}` +
    `M${digits(u + du - a - b / 2)} ${digits(v + dv - b + a / 2)}L${digits(u + du)} ${digits(v + dv)}` +
    `L${digits(u + du - a + b / 2)} ${digits(v + dv - b - a / 2)}`;
}

/**
 * The place nearest to the middle of each cell of a coarse grid.
 * @param {any} table facts.places.table
 * @returns {Displaced[]}
 */
function placesOnGrid(table) {
  const [x, y, dx, dy] = ["nominal_x_mm", "nominal_y_mm", "shift_x_um", "shift_y_um"].map((key) => placeColumn(table, key));
  let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < table.n; i++) {
    left = Math.min(left, Number(x[i]));
    right = Math.max(right, Number(x[i]));
    bottom = Math.min(bottom, Number(y[i]));
    top = Math.max(top, Number(y[i]));
  }
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
    ({ x: Number(x[i]), y: Number(y[i]), dx_um: Number(dx[i]), dy_um: Number(dy[i]) }));
}

/**
 * @param {any} target
 * @returns {Displaced}
 */
function displacedTarget(target) {
  const [x, y] = target.nominal_mm;
  const [u, v] = target.measured.place_mm;
  return { x, y, dx_um: 1e3 * (u - x), dy_um: 1e3 * (v - y), label: `#${target.seq}` };
}

/**
 * Where the panel went: with the shift of its middle taken out, then with the rotation as well.
 * @param {any} facts
 */
export function shiftPlans(facts) {
  const table = facts.places?.table;
  const hasPlaces = table && table.n > 0;
  const places = hasPlaces ? placesOnGrid(table)
    : facts.targets.filter((/** @type {any} */ t) => t.measured).map(displacedTarget);
  if (places.length < 2 || !places.some((/** @type {Displaced} */ p) => Math.hypot(p.dx_um, p.dy_um) > 1e-3)) return [];
  const mean = (/** @type {(p: Displaced) => number} */ of) =>
    places.reduce((/** @type {number} */ sum, /** @type {Displaced} */ p) => sum + of(p), 0) / places.length;
  const middle = { x: mean((p) => p.x), y: mean((p) => p.y), dx: mean((p) => p.dx_um), dy: mean((p) => p.dy_um) };
  // The rotation nearest to the displacements about their middle, exact for any angle.
  let [along, across] = [0, 0];
  for (const p of places) {
    const [a, b] = [p.x - middle.x, p.y - middle.y];
    const [c, d] = [a + (p.dx_um - middle.dx) / 1e3, b + (p.dy_um - middle.dy) / 1e3];
    along += a * c + b * d;
    across += a * d - b * c;
  }
  const angle = Math.atan2(across, along);
  const without = (/** @type {number} */ rotation) => places.map((/** @type {Displaced} */ p) => {
    const [a, b] = [p.x - middle.x, p.y - middle.y];
    const turned_x = Math.cos(rotation) * a - Math.sin(rotation) * b;
    const turned_y = Math.sin(rotation) * a + Math.cos(rotation) * b;
    return { ...p, dx_um: p.dx_um - middle.dx - 1e3 * (turned_x - a), dy_um: p.dy_um - middle.dy - 1e3 * (turned_y - b) };
  });
  const moved = word(hasPlaces ? "shift_of_holes" : "shift_of_targets", {
    x: fixed(middle.dx / 1e3, 3, { signed: true }), y: fixed(middle.dy / 1e3, 3, { signed: true }),
  });
  return [
    arrowPlan(without(0), "shift", moved),
    arrowPlan(without(angle), "shift", word("shift_and_rotation", { mrad: fixed(1e3 * angle, 3, { signed: true }) })),
  ];
}
