// SPDX-License-Identifier: Apache-2.0
// Maps of a surface: colours and contours, probes, hatching where none vouches for a height; and a view of it in space.
import { colour, scaleColour } from "../base/colours.js";
import { columnOf } from "../base/columns.js";
import { element } from "../base/dom.js";
import { fixed, micrometres, place, shortest } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { drawContours, fieldAt, paintField, rangeOf, roundLevels, widenedField } from "./field.js";
import { drawDots, extentOf, planeFigure, preparedContext, redrawn, strokeMark, tracePolygon, traceWay } from "./plane.js";
import { decimalsOf } from "./pointed.js";

/** @typedef {import("./plane.js").Point} Point */
/** @typedef {import("./plane.js").PlaneView} View */
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
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} zone
 * @param {(context: CanvasRenderingContext2D) => void} paint of all within
 */
function paintWithin(context, view, zone, paint) {
  const layer = document.createElement("canvas"), ratio = window.devicePixelRatio || 1;
  layer.width = Math.ceil(view.width * ratio);
  layer.height = Math.ceil(view.height * ratio);
  const inner = /** @type {CanvasRenderingContext2D} */ (layer.getContext("2d"));
  inner.setTransform(ratio, 0, 0, ratio, 0, 0);
  tracePolygon(inner, view, zone.hull_mm);
  inner.lineJoin = "round";
  inner.lineWidth = 2 * zone.max_extrapolation_mm * view.scale;
  inner.fill();
  if (zone.max_extrapolation_mm > 0) inner.stroke();
  inner.globalCompositeOperation = "source-atop";
  paint(inner);
  context.drawImage(layer, 0, 0, view.width, view.height);
}

/**
 * Extrapolated places thinly hatched, filled ones densely.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} zone
 */
function drawHatching(context, view, zone) {
  paintWithin(context, view, zone, (inner) => {
    inner.globalCompositeOperation = "source-in";
    inner.fillStyle = hatch(11, 1);
    inner.fillRect(0, 0, view.width, view.height);
    inner.globalCompositeOperation = "destination-out";
    inner.fillStyle = "#000";
    inner.beginPath();
    tracePolygon(inner, view, zone.hull_mm);
    inner.fill();
  });
  paintWithin(context, view, { ...zone, max_extrapolation_mm: 0 }, (inner) => {
    inner.globalCompositeOperation = "source-in";
    inner.fillStyle = hatch(6, -1);
    inner.fillRect(0, 0, view.width, view.height);
    inner.globalCompositeOperation = "destination-out";
    inner.fillStyle = "#000";
    const [dx, dy] = zone.reach_mm.map((/** @type {number} */ reach) => reach * view.scale);
    const x_mm = columnOf(zone.kept.x_mm), y_mm = columnOf(zone.kept.y_mm);
    for (let i = 0; i < x_mm.length; ++i) {
      inner.fillRect(view.x(x_mm[i] ?? 0) - dx - 0.5, view.y(y_mm[i] ?? 0) - dy - 0.5, 2 * dx + 1, 2 * dy + 1);
    }
  });
  context.setLineDash([5, 4]);
  strokeMark(context, colour("ink"), () => tracePolygon(context, view, zone.hull_mm), 1.1);
  context.setLineDash([]);
}

/**
 * Covers what has no surface: voids, and what lies beyond the border of a zone.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any} voids
 * @param {Point[] | undefined} border
 */
export function drawBlanks(context, view, voids, border) {
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
    context.rect(view.left, view.top, view.right - view.left, view.bottom - view.top);
    tracePolygon(context, view, corners);
  }, "evenodd");
  if (border) {
    around(border);
    strokeMark(context, colour("link"), () => tracePolygon(context, view, border), 1.4);
  }
  if (!voids) return;
  for (const track of voids.tracks) {
    for (const [css, wider] of /** @type {[string, number][]} */ ([[colour("quiet"), 1.6], [colour("page"), 0]])) {
      context.strokeStyle = css;
      context.lineWidth = Math.max(1, track.width_mm * view.scale) + wider;
      context.lineCap = context.lineJoin = "round";
      context.beginPath();
      traceWay(context, view, track.points_mm);
      context.stroke();
    }
  }
  for (const corners of voids.polygons_mm) cover(() => tracePolygon(context, view, corners));
  for (const corners of voids.panel_edges_mm) around(corners);
  const x_mm = columnOf(voids.circles.x_mm), y_mm = columnOf(voids.circles.y_mm), radius_mm = columnOf(voids.circles.radius_mm);
  cover(() => {
    for (let i = 0; i < x_mm.length; ++i) {
      const x = view.x(x_mm[i] ?? 0), y = view.y(y_mm[i] ?? 0), radius = Math.max(0.8, (radius_mm[i] ?? 0) * view.scale);
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 7);
    }
  });
}

/**
 * Colours with their values, beside or below a map.
 * @param {number} low
 * @param {number} high
 * @param {(value: number) => [number, number, number]} paint
 * @param {string} unit
 */
function colourBar(low, high, paint, unit) {
  const stops = Array.from({ length: 11 }, (_, i) => `rgb(${paint(low + (i / 10) * (high - low)).join(" ")})`);
  const decimals = decimalsOf((high - low) / 5);
  return element("div", { class: "colour-bar", "aria-hidden": "true" }, fixed(low, decimals),
    element("span", { style: { background: `linear-gradient(to right, ${stops.join(", ")})` } }), `${fixed(high, decimals)}\u00a0${unit}`);
}

/**
 * A map of one field with all that is drawn on it.
 * @param {{field: Field, outline: Point[], title: string, unit: string, caption?: string, n_levels: number, label: string,
 *   paint: (value: number, low: number, high: number) => [number, number, number], isCounted?: (i: number) => boolean,
 *   isSymmetric?: boolean, within?: any, over: (context: CanvasRenderingContext2D, view: View) => void,
 *   hint?: (at: Point, view: View) => string[] | null}} options
 */
export function fieldFigure(options) {
  const { field, paint } = options;
  const found = rangeOf(field.values.filter((_, i) => options.isCounted?.(i) !== false));
  if (!found) return null;
  const most = Math.max(Math.abs(found[0]), Math.abs(found[1]));
  const low = options.isSymmetric ? -most : found[0], high = Math.max(low + 1e-3, options.isSymmetric ? most : found[1]);
  const wide = widenedField(field), levels = roundLevels(low, high, options.n_levels);
  const decimals = decimalsOf(levels.length > 1 ? levels[1] - levels[0] : high - low);
  const figure = planeFigure({
    extent: extentOf(options.outline), label: options.label, most_px: 460,
    draw: (context, view) => {
      const within = options.within ?? { hull_mm: options.outline, max_extrapolation_mm: 0 };
      paintWithin(context, view, within, (inner) => {
        paintField(inner, view, wide, (value) => paint(value, low, high));
        drawContours(inner, view, wide, levels, (level) => fixed(level, decimals));
      });
      options.over(context, view);
    },
    hint: options.hint,
  });
  return element("figure", {}, element("h3", {}, options.title), figure.node, colourBar(low, high, (value) => paint(value, low, high), options.unit),
    options.caption ? element("figcaption", {}, options.caption) : null);
}

/** @type {(value: number, low: number, high: number) => [number, number, number]} */
export const fromLowToHigh = (value, low, high) => scaleColour((value - low) / (high - low));

/**
 * Dots where probes stand; `rings` instead for those of before.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {Point[]} places
 * @param {boolean} [rings]
 */
export function drawProbes(context, view, places, rings = false) {
  if (!rings) {
    drawDots(context, view, places.map(([x]) => x), places.map(([, y]) => y), 2.2);
    return;
  }
  for (const [x, y] of places) strokeMark(context, colour("ink"), () => context.arc(view.x(x), view.y(y), 5, 0, 7), 1.2);
}

/**
 * Crosses where a probe was left out, is not used, or is missing.
 * @param {CanvasRenderingContext2D} context
 * @param {View} view
 * @param {any[]} probes
 * @param {string} css
 */
export function drawCrosses(context, view, probes, css) {
  strokeMark(context, css, () => {
    for (const { place_mm: [x_mm, y_mm] } of probes) {
      const x = view.x(x_mm), y = view.y(y_mm);
      context.moveTo(x - 5, y - 5);
      context.lineTo(x + 5, y + 5);
      context.moveTo(x - 5, y + 5);
      context.lineTo(x + 5, y - 5);
    }
  });
}

/** Places of the probes that make the surface.
 * @param {any} zone
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
    over: (context, view) => {
      drawHatching(context, view, zone);
      drawBlanks(context, view, facts.voids, zone.border_mm);
      drawProbes(context, view, outline);
      drawCrosses(context, view, [...facts.unused, ...facts.missing], colour("shift"));
      drawCrosses(context, view, zone.left_out, colour("bad"));
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

/**
 * Residuals: the area of a mark shows the size, filled above the surface and open below.
 * @param {any} zone
 */
export function residualFigure(zone) {
  const places = keptPlaces(zone), residual_um = columnOf(zone.kept.residual_um);
  const most_um = Array.from(residual_um).reduce((/** @type {number} */ most, value) => Math.max(most, Math.abs(value ?? 0)), 0);
  if (most_um === 0) return null;
  const figure = planeFigure({
    extent: extentOf(places), label: word("surface_residuals"), most_px: 460,
    draw: (context, view) => {
      context.setLineDash([5, 4]);
      strokeMark(context, colour("quiet"), () => tracePolygon(context, view, zone.hull_mm), 1);
      context.setLineDash([]);
      places.forEach(([x, y], i) => {
        const value = residual_um[i] ?? 0;
        context.beginPath();
        context.arc(view.x(x), view.y(y), 1 + 11 * Math.sqrt(Math.abs(value) / most_um), 0, 7);
        context.strokeStyle = context.fillStyle = colour(value > 0 ? "category-1" : "category-0");
        context.lineWidth = 1.6;
        context[value > 0 ? "fill" : "stroke"]();
      });
    },
    hint: (at, view) => {
      const i = places.findIndex(([x, y]) => Math.hypot(x - at[0], y - at[1]) < 10 / view.scale);
      return i < 0 ? null : [place(places[i]), `${fixed(residual_um[i], 2, { signed: true })}\u00a0\u00b5m`];
    },
  });
  return element("figure", {}, element("h3", {}, word("surface_residuals")), figure.node,
    element("figcaption", {}, word("surface_residuals_text", { um: micrometres(most_um, 2) })));
}

/**
 * The surface in space, seen from above and aside; heights are drawn higher than they are.
 * @param {any} zone
 * @param {Field} heights
 */
export function spaceFigure(zone, heights) {
  const { columns, rows, values } = heights, sources = zone.field.source;
  const isShown = (/** @type {number} */ i) => !Number.isNaN(values[i]) && sources[i] !== "b";
  const [low, high] = rangeOf(values.filter((_, i) => isShown(i))) ?? [0, 0];
  if (!(high > low)) return null;
  const size = [(columns - 1) * heights.step[0], (rows - 1) * heights.step[1]], across = Math.hypot(size[0], size[1]);
  // A fifth of the panel, in a round factor.
  const raised = 10 ** Math.floor(Math.log10((0.2 * across) / (high - low)));
  const factor = raised * Math.max(1, Math.floor((0.2 * across) / (high - low) / raised));
  let turn = -0.6, tilt = 0.9;
  const canvas = element("canvas", { role: "img", "aria-label": word("surface_view_3d"), tabindex: 0 });
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
    const way = /** @type {Record<string, Point>} */ ({ ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] })[event.key];
    if (!way) return;
    by(...way);
    event.preventDefault();
  });
  return element("figure", {}, element("h3", {}, word("surface_view_3d")), canvas,
    element("figcaption", {}, word("surface_turn", { times: shortest(factor) })));
}
