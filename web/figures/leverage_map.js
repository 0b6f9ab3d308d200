// SPDX-License-Identifier: Apache-2.0
// The leverage of places over the panel, which follows as targets are dragged and pads are added.
import { colour, scaleColour, scaleCss } from "../base/colours.js";
import { element } from "../base/dom.js";
import { fixed, micrometres, percent, place, shortest } from "../base/format.js";
import { greatestSigma, predictedFit } from "../base/leverage.js";
import { word, wordOf } from "../base/words.js";
import { drawContours, paintField, sampledField } from "./field.js";
import { arrowKeys, extentOf, nearestPlace, Plane } from "./plane.js";
import { arrowPath } from "./panel_arrows.js";

/** @typedef {import("./plane.js").Point} Point */
/** @typedef {import("../base/leverage.js").Target} Target */

// Borders of the colours, times the noise: the same in every picture, so that two can be compared.
const leverageLevels = [0.5, 0.6, 0.7, 0.85, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5, 7, 10];
const touch_px = 12;
const mostArrows = 250;

/** @param {number} leverage */
function bandOf(leverage) {
  const i = leverageLevels.findIndex((level) => leverage < level * (1 - 1e-9));
  return i < 0 ? leverageLevels.length : i;
}

/** @param {number} band */
const bandShare = (band) => band / leverageLevels.length;

/** @param {number} leverage */
export const timesText = (leverage) => `${fixed(leverage, 2)}\u00a0\u00d7`;

export const inForce = (series) => series.models.find((one) => one.model === series.model);

/** The targets, the model and the pads that a series has on the page: as written, and as moved. */
export class Trial {
  constructor(facts, series) {
    this.facts = facts;
    this.series = series;
    /** @type {Target[]} */
    this.targets = [];
    /** @type {number[]} indices of candidates */
    this.pads = [];
    this.model = "";
    this.worst = 0;
    /** @type {Point | null} */
    this.worstAt = null;
    this.reset();
  }

  reset() {
    this.targets = this.series.targets.map((one) => (
      { x: one.nominal_mm[0], y: one.nominal_mm[1], weight: one.weight }));
    this.pads = [];
    this.model = "";
    this.fit();
  }

  /** The model that a job would fit, or the chosen one. */
  modelInForce() {
    if (this.model) return this.model;
    return this.pads.length > 0 ? this.series.models_with[this.pads.length] : this.series.model;
  }

  fit() {
    const { x_mm, y_mm } = this.series.candidates;
    const added = this.pads.map((i) => ({ x: x_mm[i], y: y_mm[i], weight: /** @type {any} */ ([1, 0, 1]) }));
    this.found = predictedFit([...this.targets, ...added], this.facts.jacobians[this.modelInForce()],
      this.series.base_cov);
    // Leverage is convex: of all places it is greatest at a corner of their hull.
    this.worst = 0;
    this.worstAt = null;
    for (const at of this.series.places_hull_mm) {
      const leverage = this.found ? this.found.leverage(at[0], at[1]) : 0;
      if (leverage <= this.worst) continue;
      this.worst = leverage;
      this.worstAt = at;
    }
  }

  /** With what the machine adds to a hole, um. */
  total_um() {
    if (!this.found || !this.worstAt) return null;
    const own = this.found.covariance(...this.worstAt);
    const machine = this.series.places_are === "targets" ? [0, 0, 0] : this.facts.noise.hole_um2;
    const scale = this.series.noise_um ** 2;
    return greatestSigma(/** @type {any} */ (own.map((value, i) => scale * value + machine[i])));
  }

  /** How all places move if a target is off as little as is noticed; um.
   * @param {number} i */
  shiftOf(i) {
    const error = this.series.targets[i]?.error;
    const size_um = error?.noticed_from_um ?? 100;
    const direction = error?.direction ?? [1, 0];
    const shift = this.found?.shift(i, [size_um * direction[0], size_um * direction[1]]);
    const moves = this.series.places_hull_mm.map((/** @type {Point} */ at) => Math.hypot(...(shift?.(...at) ?? [0, 0])));
    return { size_um, isNoticed: typeof error?.noticed_from_um === "number", shift, most_um: Math.max(0, ...moves) };
  }

  /** Pads may be added as long as the facts say what a job would fit to them. */
  takes() {
    return this.series.models_with.length - 1 - this.pads.length;
  }

  /** @param {number} i */
  toggle(i) {
    if (this.pads.includes(i)) {
      this.pads = this.pads.filter((pad) => pad !== i);
    } else if (this.takes() > 0) {
      this.pads.push(i);
    }
    this.fit();
  }

  /** Takes the pads of a proposal. */
  propose(addition) {
    const { x_mm, y_mm } = this.series.candidates;
    this.reset();
    for (const { nominal_mm: [x, y] } of addition.pads) {
      const i = x_mm.findIndex((/** @type {number} */ at, /** @type {number} */ k) =>
        Math.abs(at - x) < 1e-6 && Math.abs(y_mm[k] - y) < 1e-6);
      if (i >= 0) this.toggle(i);
    }
  }

  isAsWritten() {
    return this.pads.length === 0 && !this.model && this.targets.every((one, i) =>
      one.x === this.series.targets[i].nominal_mm[0] && one.y === this.series.targets[i].nominal_mm[1]);
  }
}

/**
 * Arrows of how places move if one target is off, the longest a fixed length.
 * @param {Plane} plane
 * @param {Trial} trial
 * @param {number} i
 */
function drawShift(plane, trial, i) {
  const { shift, most_um } = trial.shiftOf(i);
  if (!shift || most_um === 0) return;
  const { x_mm, y_mm } = trial.series.candidates, every = Math.ceil(x_mm.length / mostArrows);
  const scale = 46 / most_um;
  const places = x_mm.map((x, k) => [x, y_mm[k]]).filter((_, k) => k % every === 0);
  const arrows = [...places, ...trial.series.places_hull_mm].map((at) => {
    const [dx, dy] = shift(...at);
    return arrowPath(plane.x(at[0]), plane.y(at[1]), scale * dx, -scale * dy);
  });
  plane.stroke(colour("shift"), new Path2D(arrows.join("")), 1.4);
}

/**
 * @param {Plane} plane
 * @param {Trial} trial
 * @param {number} chosen index of the target that keys move
 */
function drawTargets(plane, trial, chosen) {
  const { series } = trial, { context } = plane;
  const traceCross = ([x_mm, y_mm], arm) => {
    const x = plane.x(x_mm), y = plane.y(y_mm);
    context.moveTo(x - arm, y);
    context.lineTo(x + arm, y);
    context.moveTo(x, y - arm);
    context.lineTo(x, y + arm);
  };
  trial.targets.forEach(({ x, y }, i) => {
    const written = series.targets[i].nominal_mm;
    if (x !== written[0] || y !== written[1]) plane.stroke(colour("ink"), () => plane.traceWay([written, [x, y]]), 1, [3, 3]);
    plane.stroke(colour(i === chosen ? "link" : "ink"), () => {
      plane.traceCircle([x, y], 7);
      traceCross([x, y], 3);
    });
  });
  trial.pads.forEach((i) => {
    const at = /** @type {Point} */ ([series.candidates.x_mm[i], series.candidates.y_mm[i]]);
    context.fillStyle = colour("link");
    context.beginPath();
    plane.traceCircle(at, 8);
    context.fill();
    context.strokeStyle = colour("paper");
    context.lineWidth = 2.2;
    context.beginPath();
    traceCross(at, 4.5);
    context.stroke();
  });
}

/** The colours with their leverages, and in um for the noise of the series. */
function leverageScale(series) {
  return element("div", { class: "bands", "aria-hidden": "true" },
    element("div", {}, element("b", {}, "\u00d7"), element("small", {}, "\u00b5m")),
    [...leverageLevels, null].map((level, i) => element("div", {},
      element("span", { style: { background: scaleCss(bandShare(i)) } }),
      level === null ? null : [element("b", {}, shortest(level)),
        element("small", {}, fixed(level * series.noise_um, level * series.noise_um < 10 ? 1 : 0))])));
}

/** The map that moves: fiducials are dragged, pads toggled. */
export function leverageFigure(facts, series) {
  const trial = new Trial(facts, series);
  const { candidates } = series;
  let chosen = -1, wrong = -1;
  const status = element("p", { class: "next", role: "status" });
  const models = element("select", { "aria-label": word("model"), onchange: () => {
    trial.model = models.value;
    changed();
  } }, element("option", { value: "" }, word("plan_model_of_job")),
    series.models.map((one) => element("option", { value: one.model }, wordOf("model", one.model))));
  const outliers = element("select", { "aria-label": word("plan_if_wrong"), onchange: () => {
    wrong = Number(outliers.value);
    changed();
  } }, element("option", { value: -1 }, word("plan_none_wrong")),
    series.targets.map((one, /** @type {number} */ i) =>
      element("option", { value: i }, word("plan_wrong_target", { line: one.line, place: place(one.nominal_mm) }))));
  const back = element("button", { onclick: () => {
    trial.reset();
    models.value = "";
    outliers.value = "-1";
    wrong = chosen = -1;
    changed();
  } }, word("plan_as_written"));
  const proposals = series.additions.map((one) => element("button", { onclick: () => {
    trial.propose(one);
    models.value = "";
    changed();
  } }, word(one.pads.length === 1 ? "plan_add_one" : "plan_add_several", { n: one.pads.length })));

  const padAt = (/** @type {Point} */ at, /** @type {Plane} */ plane) =>
    nearestPlace(candidates.x_mm, candidates.y_mm, at, touch_px / plane.scale);
  const targetAt = (/** @type {Point} */ at, /** @type {Plane} */ plane) =>
    nearestPlace(trial.targets.map(({ x }) => x), trial.targets.map(({ y }) => y), at, touch_px / plane.scale);
  const pads = /** @type {Point[]} */ (candidates.x_mm.map((/** @type {number} */ x, /** @type {number} */ i) => [x, candidates.y_mm[i]]));
  const targetPlaces = () => /** @type {Point[]} */ (trial.targets.map(({ x, y }) => [x, y]));
  const move = (/** @type {number} */ i, /** @type {Point} */ [x, y]) => {
    trial.targets[i] = { ...trial.targets[i], x: Math.round(1e3 * x) / 1e3, y: Math.round(1e3 * y) / 1e3 };
    changed();
  };

  const figure = new Plane({
    extent: extentOf([...pads, ...targetPlaces(), ...series.places_hull_mm]),
    label: word("plan_map_label"),
    draw: (plane) => {
      const { context } = plane;
      const field = sampledField(plane, (x, y) => trial.found?.leverage(x, y) ?? NaN);
      if (trial.found) {
        paintField(plane, field, (leverage) => scaleColour(bandShare(bandOf(leverage))));
        drawContours(plane, field, leverageLevels, shortest);
      }
      plane.drawDots(candidates.x_mm, candidates.y_mm, candidates.x_mm.length > 1500 ? 0.7 : 1.4);
      if (series.hull_mm.length > 1) {
        plane.stroke(colour("ink"), () => plane.tracePolygon(series.hull_mm), 1.2, [5, 4]);
      }
      if (wrong >= 0) drawShift(plane, trial, wrong);
      drawTargets(plane, trial, chosen);
      if (!trial.worstAt) return;
      const x = plane.x(trial.worstAt[0]), y = plane.y(trial.worstAt[1]);
      plane.stroke(colour("bad"), () => plane.traceCircle(/** @type {Point} */ (trial.worstAt), 10), 2.4);
      context.textAlign = x > (plane.left + plane.right) / 2 ? "right" : "left";
      context.textBaseline = "middle";
      plane.drawText(word("plan_worst_mark", { leverage: timesText(trial.worst) }),
        x + (context.textAlign === "right" ? -15 : 15), y + (y < (plane.top + plane.bottom) / 2 ? 16 : -16), colour("bad"));
    },
    hint: (at, plane) => {
      const lines = [place(at)];
      const leverage = trial.found?.leverage(...at);
      if (leverage !== undefined) lines.push(`${timesText(leverage)} = ${micrometres(leverage * series.noise_um, 2)}`);
      const target = targetAt(at, plane);
      if (target >= 0) return [word("plan_drag", { line: series.targets[target].line }), ...lines];
      const pad = padAt(at, plane);
      if (pad < 0) return lines;
      const tool = candidates.tool[pad] > 0 && !candidates.is_target[pad] ? `, T${candidates.tool[pad]}` : "";
      return [`${word("plan_line", { line: candidates.line[pad] })}${tool}${candidates.file?.[pad] ? `, ${candidates.file[pad]}` : ""}`,
        ...lines];
    },
    press: (at, plane) => {
      chosen = targetAt(at, plane);
      if (chosen < 0) {
        const pad = padAt(at, plane);
        if (pad >= 0) trial.toggle(pad);
      }
      changed();
      const held = chosen;
      return held < 0 ? null : (to) => move(held, to);
    },
    key: (event) => {
      const way = arrowKeys[event.key], step_mm = event.shiftKey ? 10 : 1;
      if (event.key === " ") {
        chosen = (chosen + 1) % trial.targets.length;
      } else if (way && chosen >= 0) {
        const { x, y } = trial.targets[chosen];
        move(chosen, [x + step_mm * way[0], y + step_mm * way[1]]);
      } else {
        return false;
      }
      changed();
      return true;
    },
  });

  const changed = () => {
    if (trial.model !== models.value) models.value = trial.model;
    trial.fit();
    status.replaceChildren(...trialText(trial, wrong));
    figure.redraw();
  };
  changed();
  const hints = [word("plan_map_text"), series.models_with.length > 1 ? word("plan_map_pads") : null];
  return element("figure", { class: "leverage" },
    element("div", { class: "controls" }, back, proposals, models, series.targets.length > 1 ? outliers : null),
    status, figure.node, leverageScale(series),
    element("figcaption", {}, hints.filter(Boolean).join(" "), " ", word("plan_map_keys")));
}

/** Sentences of what the map shows now.
 * @param {Trial} trial
 * @param {number} wrong */
function trialText(trial, wrong) {
  const { series } = trial, before = inForce(series);
  const out = [];
  const model = wordOf("model", trial.modelInForce());
  if (!trial.found) return [word("plan_not_determined", { model })];
  if (!trial.worstAt) return [word("plan_nothing_drilled")];
  out.push(word("plan_worst_now", {
    leverage: timesText(trial.worst), um: micrometres(trial.worst * series.noise_um, 2), place: place(trial.worstAt), model }));
  if (trial.facts.noise.hole_um2[0] > 0) out.push(word("plan_total_now", { total: micrometres(trial.total_um(), 2) }));
  if (!trial.isAsWritten() && before.determined) {
    out.push(word("plan_worst_before", { leverage: timesText(before.worst_leverage), change: percent(trial.worst / before.worst_leverage - 1, 0) }));
  }
  if (trial.pads.length > 0) out.push(word("plan_pads_now", { n: trial.pads.length }));
  if (wrong >= 0) {
    const shift = trial.shiftOf(wrong);
    out.push(word(shift.isNoticed ? "plan_shift_noticed" : "plan_shift_any",
      { size: micrometres(shift.size_um), most: micrometres(shift.most_um) }));
  }
  return out.flatMap((text, i) => (i === 0 ? [text] : [" ", text]));
}
