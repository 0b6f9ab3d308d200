// SPDX-License-Identifier: Apache-2.0
// The map of a job: every place on a canvas, with pan, zoom and hover; over it the targets with
// their residuals. A million places are drawn as pixels, a few as discs of their true size.
import { extremes } from "../base/columns.js";
import { colourScale, element } from "../base/dom.js";
import { mapSigma } from "../base/leverage.js";
import { word } from "../base/words.js";
import { fixed, micrometres, place, probability, roundStep, shortest } from "../base/format.js";
import { categoryColour, colour, scaleColour, scaleCss } from "../base/colours.js";
import { paintField, sampledField } from "./field.js";
import { colouring, mapColumns } from "./map_colours.js";
import { arrowPath } from "./panel_arrows.js";
import { boxExtent, nearestPlace, Plane, zoomStep } from "./plane.js";

/** @typedef {import("./map_colours.js").MapColumns} MapColumns */
/** @typedef {ReturnType<typeof colouring>} Colouring */

/** More places than this in view are drawn as squares of whole pixels. */
const maxDiscs = 20000;
/** A place is meant from as near as this. */
const reach_px = 9;
/** Residuals: the longest arrow in px. */
const longestArrow_px = 60;

/** What the map shows, and how. */
class JobMap {
  constructor(facts) {
    this.facts = facts;
    const table = facts.places?.table, tools = facts.places?.tools ?? [];
    this.columns = table ? mapColumns(table) : null;
    this.tools = tools.map((tool) => tool.number);
    this.diameters = new Map(tools.map((tool) => [tool.number, tool.diameter_mm]));
    const range = (k) => extremes([...(this.columns ? extremes(k ? this.columns.y_mm : this.columns.x_mm) ?? [] : []),
      ...facts.targets.map((target) => target.nominal_mm[k])]);
    this.ranges = [range(0), range(1)];
    this.mode = "tool";
    this.showsResiduals = true;
    this.legend = element("ul", { class: "legend" });
    this.plane = new Plane({
      extent: boxExtent(this.ranges[0], this.ranges[1]), label: word("map_label"), most_px: 0.85 * innerHeight, isMovable: true,
      isReadOften: (this.columns?.n ?? 0) > maxDiscs, draw: () => this.draw(), hint: (at) => this.hover(at),
    });
    this.plane.node.classList.add("map");
  }

  /** @param {import("./plane.js").Point} at */
  hover(at) {
    const { columns } = this;
    const i = columns ? nearestPlace(columns.x_mm, columns.y_mm, at, reach_px / this.plane.scale) : -1;
    return columns && i >= 0 ? this.described(columns, i) : null;
  }

  /**
   * @param {MapColumns} columns
   * @param {number} i
   */
  described(columns, i) {
    const kind = ["map_hole", "map_slot_end", "map_rout_corner"][Number(columns.kind[i])];
    const file = columns.files[Number(columns.file[i])];
    const board = columns.boards[Number(columns.board[i])];
    const nominal = /** @type {[number, number]} */ ([columns.x_mm[i], columns.y_mm[i]]);
    const actual = /** @type {[number, number]} */ (
      [nominal[0] + Number(columns.shift_x_um[i]) / 1e3, nominal[1] + Number(columns.shift_y_um[i]) / 1e3]);
    const risk = columns.risk[i];
    const row = (/** @type {import("../base/words.js").WordKey} */ key, /** @type {string} */ value) =>
      [element("span", { class: "quiet" }, `${word(key)} `), value];
    return [
      element("b", {}, word(/** @type {any} */ (kind), { tool: Number(columns.tool[i]) })),
      row("line", `${columns.line[i]}${file ? ` (${file})` : ""}${board.length ? `, ${word("board")} [${board}]` : ""}`),
      row("nominal", place(nominal)),
      row("corrected", place(actual)),
      row("shift", `${fixed(Number(columns.shift_x_um[i]), 1, { signed: true })}, ` +
        `${fixed(Number(columns.shift_y_um[i]), 1, { signed: true })}\u00a0\u00b5m`),
      row("sigma", micrometres(Number(columns.sigma_um[i]), 3)),
      risk !== null && Number.isFinite(risk) ? row("risk", probability(Number(risk))) : null,
    ].filter(Boolean);
  }

  draw() {
    if (this.mode === "sigma") this.drawFitSigma();
    if (this.columns) {
      const paint = colouring(this.mode, this.columns, this.tools);
      this.drawPlaces(this.columns, paint);
      this.showLegend(paint);
    }
    this.drawTargets();
  }

  /** The sigma of the panel's fit, behind the holes. */
  drawFitSigma() {
    const panel = this.facts.series.filter((one) => one.level === "panel" && one.fit).pop();
    const range = this.columns && extremes(this.columns.sigma_um);
    if (!panel || !range) return;
    const field = sampledField(this.plane, (x, y) => 1e3 * mapSigma(panel.fit.map.covariance, x, y));
    this.plane.context.globalAlpha = 0.28;
    paintField(this.plane, field, (sigma) => scaleColour((sigma - range[0]) / Math.max(1e-9, range[1] - range[0])));
    this.plane.context.globalAlpha = 1;
  }

  /**
   * @param {MapColumns} columns
   * @param {Colouring} paint
   */
  drawPlaces(columns, paint) {
    const { plane } = this, { context } = plane;
    const [left, top] = plane.place(plane.left - 20, plane.top - 20);
    const [right, bottom] = plane.place(plane.right + 20, plane.bottom + 20);
    const seen = [];
    for (let i = 0; i < columns.n && seen.length <= maxDiscs; i++) {
      const x = Number(columns.x_mm[i]);
      const y = Number(columns.y_mm[i]);
      if (x >= left && x <= right && y >= bottom && y <= top) seen.push(i);
    }
    if (seen.length > maxDiscs) {
      this.drawPixels(columns, paint);
      return;
    }
    const least_px = seen.length > 4000 ? 1 : 1.6;
    for (const i of seen) {
      const diameter_mm = Number(columns.kind[i]) === 2 ? 0 : Number(this.diameters.get(Number(columns.tool[i])) ?? 0);
      context.fillStyle = paint.css(i);
      context.beginPath();
      plane.traceCircle([Number(columns.x_mm[i]), Number(columns.y_mm[i])], Math.max(least_px, diameter_mm * plane.scale / 2));
      context.fill();
    }
  }

  /**
   * @param {MapColumns} columns
   * @param {Colouring} paint
   */
  drawPixels(columns, paint) {
    const { plane } = this, ratio = devicePixelRatio || 1, scale = plane.scale * ratio;
    const { width, height } = plane.canvas;
    const picture = plane.context.getImageData(0, 0, width, height);
    const pixels = new Uint32Array(picture.data.buffer);
    const from_u = ratio * plane.x(0), from_v = ratio * plane.y(0);
    const [left, right, top, bottom] = [plane.left, plane.right, plane.top, plane.bottom].map((at) => Math.round(ratio * at));
    for (let i = 0; i < columns.n; i++) {
      const u = Math.round(from_u + Number(columns.x_mm[i]) * scale);
      const v = Math.round(from_v - Number(columns.y_mm[i]) * scale);
      if (u < left || v < top || u + 1 >= right || v + 1 >= bottom) continue;
      const value = paint.pixel(i);
      const at = v * width + u;
      pixels[at] = pixels[at + 1] = pixels[at + width] = pixels[at + width + 1] = value;
    }
    plane.context.putImageData(picture, 0, 0);
  }

  /** Rings of the panel's targets, squares of a board's, diamonds of measured holes, and residuals. */
  drawTargets() {
    const { facts: { targets, series }, plane } = this, { context } = plane;
    const longest_um = Math.max(0, ...targets.map((target) => target.residual_um ? Math.hypot(...target.residual_um) : 0));
    const px_per_um = longest_um > 0 ? longestArrow_px / longest_um : 0;
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "left";
    for (const target of targets) {
      const u = plane.x(target.nominal_mm[0]), v = plane.y(target.nominal_mm[1]);
      const isBad = target.state !== "good";
      context.strokeStyle = colour(target.state === "refused" ? "bad" : isBad ? "warn" : "ink");
      context.lineWidth = isBad ? 2.4 : 1.3;
      const level = target.series === null ? "hole" : series[target.series].level;
      context.beginPath();
      if (level === "panel") plane.traceCircle(target.nominal_mm, 7);
      else if (level === "board") context.rect(u - 4.5, v - 4.5, 9, 9);
      else for (const [a, b] of [[0, -6], [6, 0], [0, 6], [-6, 0], [0, -6]]) context.lineTo(u + a, v + b);
      context.stroke();
      if (targets.length <= 60 || isBad) {
        context.fillStyle = colour("ink");
        context.fillText(`#${target.seq}`, u + 9, v - 7);
      }
      if (this.showsResiduals && target.residual_um) {
        const [dx, dy] = target.residual_um;
        plane.stroke(colour(isBad ? "bad" : "link"), new Path2D(arrowPath(u, v, dx * px_per_um, -dy * px_per_um)), 1.8);
      }
    }
    if (this.showsResiduals && longest_um > 0) this.drawReference(longest_um, px_per_um);
  }

  /**
   * How long an arrow of a round length is.
   * @param {number} longest_um
   * @param {number} px_per_um
   */
  drawReference(longest_um, px_per_um) {
    const { context, right, top } = this.plane, x = right - 150, y = top + 18;
    const length_um = roundStep(0.4 * longest_um);
    context.fillStyle = colour("paper");
    context.globalAlpha = 0.8;
    context.fillRect(x - 12, y - 14, 158, 28);
    context.globalAlpha = 1;
    this.plane.stroke(colour("link"), new Path2D(arrowPath(x, y, length_um * px_per_um, 0)), 1.8);
    context.fillStyle = colour("ink");
    context.textAlign = "right";
    context.fillText(word("map_residual_scale", { length: shortest(length_um) }), right - 8, y + 4);
  }

  /** @param {ReturnType<typeof colouring>} paint */
  showLegend(paint) {
    if (!paint.range) {
      this.legend.replaceChildren(...this.facts.places.tools.map((tool, /** @type {number} */ i) =>
        element("li", {}, element("span", { class: "dot", style: { background: categoryColour(i) } }),
          `T${tool.number}${tool.diameter_mm === null ? "" : ` \u00f8\u00a0${fixed(tool.diameter_mm, 3)} mm`}, `,
          [tool.n_holes > 0 && word("map_counts", { holes: fixed(tool.n_holes, 0) }),
            tool.n_slots > 0 && word("map_slots", { n: fixed(tool.n_slots, 0) }),
            tool.n_routs > 0 && word("map_routs", { n: fixed(tool.n_routs, 0) })].filter(Boolean).join(", "))));
      return;
    }
    const end = (/** @type {number} */ value) => paint.isLogarithm ? probability(10 ** value) : micrometres(value, 2);
    this.legend.replaceChildren(element("li", {}, colourScale(end(paint.range[0]), end(paint.range[1]), scaleCss)));
  }
}

/** The figure with its controls; null where there is nothing to draw. */
export function jobMap(facts) {
  const map = new JobMap(facts);
  if (!map.ranges[0]) return null;
  const { plane } = map;
  const columns = map.columns;
  const has = (/** @type {string} */ mode) => columns && (mode === "tool" ||
    (mode === "risk" ? extremes(columns.risk) !== null
      : (extremes(mode === "shift" ? columns.shift_um : columns.sigma_um)?.[1] ?? 0) > 0));
  const modes = /** @type {const} */ (["tool", "shift", "sigma", "risk"]).filter(has);
  const choice = element("select", {
    onchange: () => {
      map.mode = choice.value;
      plane.redraw();
    },
  }, modes.map((mode) => element("option", { value: mode }, word(`colour_${mode}`))));
  const button = (/** @type {string} */ sign, /** @type {string} */ label, /** @type {() => void} */ act) =>
    element("button", { type: "button", title: label, "aria-label": label, onclick: act }, sign);
  const hasResiduals = facts.targets.some((target) => target.residual_um);
  const residuals = element("input", { type: "checkbox", checked: true, onchange: () => {
    map.showsResiduals = residuals.checked;
    plane.redraw();
  } });
  return element("figure", {},
    element("div", { class: "controls" },
      modes.length > 1 && element("label", {}, `${word("map_colour_by")} `, choice),
      hasResiduals && element("label", {}, residuals, ` ${word("surface_residual_tile")}`),
      button("+", word("zoom_in"), () => plane.zoom(zoomStep)),
      button("\u2212", word("zoom_out"), () => plane.zoom(1 / zoomStep)),
      button("\u2922", word("zoom_fit"), () => plane.fit())),
    plane.node, map.legend,
    element("figcaption", {}, word("map_caption")));
}
