// SPDX-License-Identifier: Apache-2.0
// Maps of a surface: colours and contours, probes, hatching where none vouches for a height; and a view of it in space.
import { colour, scaleColour } from "../base/colours.js";
import { columnOf, extremes } from "../base/columns.js";
import { colourScale, element } from "../base/dom.js";
import { decimalsOf, fixed, micrometres, place, roundLevels, shortest } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { drawContours, fieldAt, paintField, widenedField } from "./field.js";
import { arrowKeys, extentOf, Plane, preparedContext, redrawn } from "./plane.js";

/** @typedef {import("./plane.js").Point} Point */
/** @typedef {import("./field.js").Field} Field */

/**
 * Lines at 45 degrees, dark and light side by side, so that they show on any colour.
 * @param {number} step
 * @param {1 | -1} way
 */
function hatch(step, way) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = step;
  const context = /** @type {CanvasRenderingContext2D} */ (tile.getContext("2d"));
  for (const [css, shift] of /** @type {[string, number][]} */ ([["#000", 0], ["#fff", 1.4]])) {
    context.strokeStyle = css;
    context.beginPath();
    for (const at of [-step, 0, step]) {
      context.moveTo(at + shift, way > 0 ? step : 0);
      context.lineTo(at + step + shift, way > 0 ? 0 : step);
    }
    context.stroke();
  }
  return /** @type {CanvasPattern} */ (context.createPattern(tile, "repeat"));
}

/**
 * The part of the panel in which heights are given: the probes' hull, wider by how far they are extrapolated.
 * @param {Plane} plane
 * @param {() => void} paint of all within
 */
function paintWithin(plane, zone, paint) {
  plane.drawLayer(() => {
    const { context } = plane;
    plane.tracePolygon(zone.hull_mm);
    context.lineJoin = "round";
    context.lineWidth = 2 * zone.max_extrapolation_mm * plane.scale;
    context.fill();
    if (zone.max_extrapolation_mm > 0) context.stroke();
    context.globalCompositeOperation = "source-atop";
    paint();
  });
}

/**
 * Hatches all within but for what `clear` fills.
 * @param {Plane} plane
 * @param {CanvasPattern} pattern
 * @param {() => void} clear
 */
function hatchWithin(plane, zone, pattern, clear) {
  paintWithin(plane, zone, () => {
    const { context } = plane;
    context.globalCompositeOperation = "source-in";
    context.fillStyle = pattern;
    context.fillRect(0, 0, plane.width, plane.height);
    context.globalCompositeOperation = "destination-out";
    context.fillStyle = "#000";
    context.beginPath();
    clear();
    context.fill();
  });
}

/**
 * Extrapolated places thinly hatched, filled ones densely.
 * @param {Plane} plane
 */
function drawHatching(plane, zone) {
  hatchWithin(plane, zone, hatch(11, 1), () => plane.tracePolygon(zone.hull_mm));
  hatchWithin(plane, { ...zone, max_extrapolation_mm: 0 }, hatch(6, -1), () => {
    const [dx, dy] = zone.reach_mm.map((reach) => reach * plane.scale);
    for (const [x, y] of keptPlaces(zone)) {
      plane.context.rect(plane.x(x) - dx - 0.5, plane.y(y) - dy - 0.5, 2 * dx + 1, 2 * dy + 1);
    }
  });
  plane.stroke(colour("ink"), () => plane.tracePolygon(zone.hull_mm), 1.1, [5, 4]);
}

/**
 * Covers what has no surface: voids, and what lies beyond the border of a zone.
 * @param {Plane} plane
 * @param {Point[] | undefined} border
 */
export function drawBlanks(plane, voids, border) {
  const { context } = plane;
  const cover = (/** @type {() => void} */ trace, /** @type {CanvasFillRule} */ rule = "nonzero") => {
    context.beginPath();
    trace();
    context.fillStyle = colour("page");
    context.fill(rule);
    context.strokeStyle = colour("quiet");
    context.lineWidth = 0.8;
    context.stroke();
  };
  const around = (/** @type {Point[]} */ corners) => cover(() => {
    plane.traceFrame();
    plane.tracePolygon(corners);
  }, "evenodd");
  if (border) {
    around(border);
    plane.stroke(colour("link"), () => plane.tracePolygon(border), 1.4);
  }
  if (!voids) return;
  for (const track of voids.tracks) {
    for (const [css, wider] of /** @type {[string, number][]} */ ([[colour("quiet"), 1.6], [colour("page"), 0]])) {
      context.strokeStyle = css;
      context.lineWidth = Math.max(1, track.width_mm * plane.scale) + wider;
      context.lineCap = context.lineJoin = "round";
      context.beginPath();
      plane.traceWay(track.points_mm);
      context.stroke();
    }
  }
  for (const corners of voids.polygons_mm) cover(() => plane.tracePolygon(corners));
  for (const corners of voids.panel_edges_mm) around(corners);
  const x_mm = columnOf(voids.circles.x_mm), y_mm = columnOf(voids.circles.y_mm), radius_mm = columnOf(voids.circles.radius_mm);
  cover(() => {
    for (let i = 0; i < x_mm.length; ++i) {
      plane.traceCircle([x_mm[i] ?? 0, y_mm[i] ?? 0], Math.max(0.8, (radius_mm[i] ?? 0) * plane.scale));
    }
  });
}

/**
 * A map of one field with all that is drawn on it.
 * @param {{field: Field, outline: Point[], title: string, unit: string, caption?: import("../base/dom.js").Child, n_levels: number, label: string,
 *   paint: (value: number, low: number, high: number) => [number, number, number], isCounted?: (i: number) => boolean,
 *   isSymmetric?: boolean, within?: any, over: (plane: Plane) => void,
 *   hint?: (at: Point, plane: Plane) => string[] | null}} options
 */
export function fieldFigure(options) {
  const { field, paint } = options;
  const found = extremes(field.values.filter((_, i) => options.isCounted?.(i) !== false));
  if (!found) return null;
  const most = Math.max(Math.abs(found[0]), Math.abs(found[1]));
  const low = options.isSymmetric ? -most : found[0], high = Math.max(low + 1e-3, options.isSymmetric ? most : found[1]);
  const wide = widenedField(field), levels = roundLevels(low, high, options.n_levels);
  const decimals = decimalsOf(levels.length > 1 ? levels[1] - levels[0] : high - low);
  const figure = new Plane({
    extent: extentOf(options.outline), label: options.label, most_px: 460,
    draw: (plane) => {
      const within = options.within ?? { hull_mm: options.outline, max_extrapolation_mm: 0 };
      paintWithin(plane, within, () => {
        paintField(plane, wide, (value) => paint(value, low, high));
        drawContours(plane, wide, levels, (level) => fixed(level, decimals));
      });
      options.over(plane);
    },
    hint: options.hint,
  });
  const ends = decimalsOf((high - low) / 5), css = (share) => `rgb(${paint(low + share * (high - low), low, high).join(" ")})`;
  return element("figure", {}, options.title && element("h3", {}, options.title), figure.node,
    colourScale(fixed(low, ends), `${fixed(high, ends)}\u00a0${options.unit}`, css),
    options.caption ? element("figcaption", {}, options.caption) : null);
}

/** @type {(value: number, low: number, high: number) => [number, number, number]} */
export const fromLowToHigh = (value, low, high) => scaleColour((value - low) / (high - low));

/**
 * Dots where probes stand; `rings` instead for those of before.
 * @param {Plane} plane
 * @param {Point[]} places
 * @param {boolean} [rings]
 */
export function drawProbes(plane, places, rings = false) {
  if (!rings) plane.drawDots(places.map(([x]) => x), places.map(([, y]) => y), 2.2);
  else for (const at of places) plane.stroke(colour("ink"), () => plane.traceCircle(at, 5), 1.2);
}

/**
 * Crosses where a probe was left out, is not used, or is missing.
 * @param {Plane} plane
 * @param {string} css
 */
export function drawCrosses(plane, probes, css) {
  const { context } = plane;
  plane.stroke(css, () => {
    for (const { place_mm: [x_mm, y_mm] } of probes) {
      const x = plane.x(x_mm), y = plane.y(y_mm);
      context.moveTo(x - 5, y - 5);
      context.lineTo(x + 5, y + 5);
      context.moveTo(x - 5, y + 5);
      context.lineTo(x + 5, y - 5);
    }
  });
}

/** Places of the probes that make the surface.
 * @returns {Point[]} */
export function keptPlaces(zone) {
  const y_mm = columnOf(zone.kept.y_mm);
  return Array.from(columnOf(zone.kept.x_mm), (x, i) => [x ?? 0, y_mm[i] ?? 0]);
}

/**
 * Heights or sigmas of a zone.
 * @param {{zone: any, facts: any, heights: Field, sigmas: Field, isHeights: boolean}} options
 */
export function zoneFigure({ zone, facts, heights, sigmas, isHeights }) {
  const outline = keptPlaces(zone), margin = zone.max_extrapolation_mm;
  const rectangle = /** @type {Point[]} */ (outline.flatMap(([x, y]) => [[x - margin, y - margin], [x + margin, y + margin]]));
  const sources = zone.field.source;
  return fieldFigure({
    field: isHeights ? heights : sigmas, outline: rectangle, within: zone, unit: isHeights ? "mm" : "\u00b5m",
    title: word(isHeights ? "surface_heights" : "surface_sigmas"), label: word(isHeights ? "surface_heights" : "surface_sigmas"),
    n_levels: isHeights ? 8 : 5, paint: fromLowToHigh, isCounted: (i) => sources[i] !== "b" && sources[i] !== "-",
    over: (plane) => {
      drawHatching(plane, zone);
      drawBlanks(plane, facts.voids, zone.border_mm);
      drawProbes(plane, outline);
      drawCrosses(plane, [...facts.unused, ...facts.missing], colour("shift"));
      drawCrosses(plane, zone.left_out, colour("bad"));
    },
    hint: (at) => {
      const height = fieldAt(heights, at), sigma = fieldAt(sigmas, at);
      if (Number.isNaN(height)) return null;
      const column = Math.round((at[0] - heights.first[0]) / heights.step[0]), row = Math.round((at[1] - heights.first[1]) / heights.step[1]);
      return [place(at), word("surface_height_at", { mm: `${fixed(height, 4)}\u00a0mm`, um: micrometres(sigma, 2) }),
        wordOf("surface_source", sources[row * heights.columns + column])];
    },
  });
}

/** Residuals: the area of a mark shows the size, filled above the surface and open below. */
export function residualFigure(zone) {
  const places = keptPlaces(zone), residual_um = columnOf(zone.kept.residual_um);
  const most_um = Array.from(residual_um).reduce((/** @type {number} */ most, value) => Math.max(most, Math.abs(value ?? 0)), 0);
  if (most_um === 0) return null;
  const figure = new Plane({
    extent: extentOf(places), label: word("surface_residuals"), most_px: 460,
    draw: (plane) => {
      const { context } = plane;
      plane.stroke(colour("quiet"), () => plane.tracePolygon(zone.hull_mm), 1, [5, 4]);
      places.forEach(([x, y], i) => {
        const value = residual_um[i] ?? 0;
        context.beginPath();
        plane.traceCircle([x, y], 1 + 11 * Math.sqrt(Math.abs(value) / most_um));
        context.strokeStyle = context.fillStyle = colour(value > 0 ? "category-1" : "category-0");
        context.lineWidth = 1.6;
        context[value > 0 ? "fill" : "stroke"]();
      });
    },
    hint: (at, plane) => {
      const i = places.findIndex(([x, y]) => Math.hypot(x - at[0], y - at[1]) < 10 / plane.scale);
      return i < 0 ? null : [place(places[i]), `${fixed(residual_um[i], 2, { signed: true })}\u00a0\u00b5m`];
    },
  });
  return element("figure", {}, element("h3", {}, word("surface_residuals")), figure.node,
    element("figcaption", {}, word("surface_residuals_text", { um: micrometres(most_um, 2) })));
}

/**
 * The surface in space, seen from above and aside; heights are drawn higher than they are.
 * @param {Field} heights
 */
export function spaceFigure(zone, heights) {
  const { columns, rows, values } = heights, sources = zone.field.source;
  const isShown = (/** @type {number} */ i) => !Number.isNaN(values[i]) && sources[i] !== "b";
  const [low, high] = extremes(values.filter((_, i) => isShown(i))) ?? [0, 0];
  if (!(high > low)) return null;
  const size = [(columns - 1) * heights.step[0], (rows - 1) * heights.step[1]], across = Math.hypot(size[0], size[1]);
  // A fifth of the panel, in a round factor.
  const raised = 10 ** Math.floor(Math.log10((0.2 * across) / (high - low)));
  const factor = raised * Math.max(1, Math.floor((0.2 * across) / (high - low) / raised));
  let turn = -0.6, tilt = 0.9;
  const canvas = element("canvas", { role: "img", class: "dragged", "aria-label": word("surface_view_3d"), tabindex: 0 });
  const draw = () => {
    const width = canvas.clientWidth, height = Math.min(460, 0.72 * width), scale = (0.94 * Math.min(width, height / (0.25 + Math.sin(tilt)) * 1.1)) / across;
    const context = preparedContext(canvas, width, height);
    const c = Math.cos(turn), s = Math.sin(turn);
    /** Right, down and away from who looks. */
    const seen = (/** @type {number} */ column, /** @type {number} */ row, /** @type {number} */ z) => {
      const x = column * heights.step[0] - size[0] / 2, y = row * heights.step[1] - size[1] / 2;
      const right = c * x - s * y, away = s * x + c * y, up = factor * (z - (low + high) / 2);
      return [width / 2 + scale * right, height / 2 - scale * (away * Math.sin(tilt) + up * Math.cos(tilt)), away];
    };
    const cells = [];
    for (let row = 0; row + 1 < rows; ++row) {
      for (let column = 0; column + 1 < columns; ++column) {
        const i = row * columns + column, corners = [i, i + 1, i + columns + 1, i + columns];
        if (!corners.every(isShown)) continue;
        const points = corners.map((k) => seen(k % columns, Math.floor(k / columns), values[k]));
        const mean = corners.reduce((sum, k) => sum + values[k], 0) / 4;
        // Light comes from the left, so that slopes show.
        const slope = (factor * (values[i + 1] + values[i + columns + 1] - values[i] - values[i + columns])) / (2 * heights.step[0]);
        cells.push({ points, mean, light: Math.min(1, Math.max(0.72, 0.9 - 0.25 * slope)), isSure: sources[i] === "m" });
      }
    }
    // Far ones first.
    cells.sort((a, b) => b.points[0][2] - a.points[0][2]);
    for (const { points, mean, light, isSure } of cells) {
      context.beginPath();
      points.forEach(([x, y], k) => context[k === 0 ? "moveTo" : "lineTo"](x, y));
      context.closePath();
      const rgb = scaleColour((mean - low) / (high - low)).map((value) => Math.round(light * value));
      context.fillStyle = context.strokeStyle = `rgb(${rgb.join(" ")} / ${isSure ? 1 : 0.45})`;
      context.fill();
      if (isSure) context.stroke();
    }
  };
  const redraw = redrawn(canvas, draw);
  const by = (/** @type {number} */ dx, /** @type {number} */ dy) => {
    turn += dx;
    tilt = Math.min(1.5, Math.max(0.15, tilt + dy));
    redraw();
  };
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons > 0) by(0.01 * event.movementX, 0.01 * event.movementY);
  });
  canvas.addEventListener("keydown", (event) => {
    const way = arrowKeys[event.key];
    if (!way) return;
    by(0.1 * way[0], 0.1 * way[1]);
    event.preventDefault();
  });
  return element("figure", {}, element("h3", {}, word("surface_view_3d")), canvas,
    element("figcaption", {}, word("surface_turn", { times: shortest(factor) })));
}
