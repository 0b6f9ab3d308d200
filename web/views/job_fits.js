// SPDX-License-Identifier: Apache-2.0
// The fits of a job: in words and numbers, with gates, models, causes and what targets would hide.
import { chip, element, english, meter, number, table, unfolding } from "../base/dom.js";
import { word, wordOf } from "../base/words.js";
import { fixed, place, probability, shortest, withSigma } from "../base/format.js";
import { panelArrows } from "../figures/panel_arrows.js";
import { arrowLines } from "../figures/shift_plans.js";
import { seriesName, targetLink } from "./job_targets.js";

/** More accepted board fits than this are folded into one line. */
const maxLooseFits = 12;

export function gateRatio(gate) {
  if (gate.value === 0 && gate.limit >= 0) return 0;
  const ratio = gate.value === null || gate.limit === null ? Infinity : gate.value / gate.limit;
  return ratio >= 0 ? ratio : Infinity;
}

function gateUnit(gate) {
  return gate.unit === "um" ? "\u00b5m" : gate.unit;
}

export function gateLimit(gate) {
  return `${shortest(gate.limit)}\u00a0${gateUnit(gate)}`;
}

/** The value in as many decimals as tell a refused one from its limit. */
export function gateValue(gate) {
  let decimals = gate.unit === "mm" || gate.unit === "mrad" ? 3 : gate.unit === "um" ? 2 : 1;
  while (!gate.is_accepted && decimals < 12 && fixed(gate.value, decimals) === fixed(gate.limit, decimals)) decimals++;
  return `${fixed(gate.value, decimals)}\u00a0${gateUnit(gate)}`;
}

/**
 * The gate with the largest ratio over all series; a refused one goes before any accepted one.
 * @param {(gate: any) => boolean} isWanted
 */
export function worstGate(series, isWanted) {
  /** @type {{gate: any, series: any} | null} */
  let worst = null;
  for (const one of series) {
    for (const gate of one.gates.filter(isWanted)) {
      const isWorse = worst === null || (worst.gate.is_accepted && !gate.is_accepted) ||
        (worst.gate.is_accepted === gate.is_accepted && gateRatio(gate) > gateRatio(worst.gate));
      if (isWorse) worst = { gate, series: one };
    }
  }
  return worst;
}

function chiSquareText(chiSquare) {
  const p = chiSquare.p === null ? "" : chiSquare.p < 0.001 ? " (p < 0.001)" : ` (p = ${fixed(chiSquare.p, 3)})`;
  return word("chi_square_text", {
    value: fixed(chiSquare.value, 2), n: chiSquare.degrees_of_freedom, means: wordOf("chi_square", chiSquare.means) + p,
  });
}

/** @param {string} text */
function capitalized(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/**
 * "Panel rotated by 2.0131 +/- 0.0004 mrad counter-clockwise, ..."
 * @param {any} one a series with a fit
 */
function fitSentence(one) {
  const { fit } = one;
  const subject = word(one.level === "panel" ? "panel" : "series_board");
  const scaled = (v, /** @type {number} */ k, /** @type {string} */ unit, signed = true) =>
    withSigma(v.value === null ? null : k * v.value, v.sigma === null ? null : k * v.sigma, unit, signed);
  const isSmall = Math.hypot(fit.shift_x_mm.value, fit.shift_y_mm.value) < 1;
  const [k, unit] = isSmall ? [1e3, "\u00b5m"] : [1, "mm"];
  const shifted = word("fit_shifted", { x: scaled(fit.shift_x_mm, k, unit), y: scaled(fit.shift_y_mm, k, unit) });
  if (one.model === "offset") return `${subject} ${shifted}.`;
  const turn = { value: Math.abs(fit.rotation_rad.value), sigma: fit.rotation_rad.sigma };
  const parts = [word(fit.rotation_rad.value < 0 ? "fit_rotated_clockwise" : "fit_rotated",
    { angle: scaled(turn, 1e3, "mrad", false) })];
  const x = scaled(fit.stretch_x_ppm, 1, "ppm");
  if (one.model === "similarity") parts.push(word("fit_stretched_both", { x }));
  else if (one.model !== "rigid") parts.push(word("fit_stretched", { x, y: scaled(fit.stretch_y_ppm, 1, "ppm") }));
  if (one.model === "affine" || one.model === "smooth") {
    parts.push(word("fit_sheared", { shear: scaled(fit.shear_ppm, 1, "ppm") }));
  }
  if (fit.is_mirrored) parts.push(word("cause_mirrored"));
  return `${subject} ${parts.join(", ")}, ${word("fit_at_centre", { shifted })}.`;
}

function gatesTable(one) {
  const limits = element("p", { class: "quiet" }, `${word("gates")}: `, english(one.limits), ".");
  if (one.gates.length === 0) return limits;
  return [table([{ title: word("gate") }, number(word("value")), number(word("limit")),
    { title: "" }, { title: "" }],
  one.gates.map((gate) => {
    const kind = gate.is_accepted ? "good" : "refused";
    return [[wordOf("gate", gate.gate), gate.target !== null && [" ", targetLink(gate.target)]], gateValue(gate),
      gateLimit(gate), meter(gateRatio(gate), kind), chip(kind, word(gate.is_accepted ? "pass" : "fail"))];
  })), limits];
}

function modelsTable(one) {
  if (one.models.length < 2) return null;
  const least = Math.min(...one.models.map((model) => model.criterion));
  const marks = (model) => [
    model.is_in_force && [chip("good", word("history_in_force")), " "],
    model.is_chosen && !model.is_in_force && [chip("suspect", word("model_favoured")), " "],
    !model.is_eligible && element("span", { class: "quiet" }, word("model_unchecked")),
  ];
  const chosen = one.models.find((model) => model.is_chosen);
  const smooth = one.models.find((model) => model.name === "smooth");
  return element("details", { open: chosen && !chosen.is_in_force },
    element("summary", {}, word("models_compared")),
    table([{ title: word("model") }, number(word("parameters")),
      number(word("chi_square")), number(word("criterion")),
      number(word("left_out_rms")), { title: "" }],
    one.models.map((model) => [wordOf("model", model.name),
      fixed(model.parameters, model.name === "smooth" ? 1 : 0), fixed(model.chi_square, 2),
      fixed(model.criterion - least, 2, { signed: true }), fixed(model.left_out_um, 2), marks(model)])),
    element("p", { class: "quiet text" }, word("criterion_note")),
    chosen && !chosen.is_in_force && element("p", { class: "text" },
      word("model_advice", { chosen: wordOf("model", chosen.name), taken: wordOf("model", one.model) })),
    one.lacks_smooth_model && chosen && smooth && element("p", { class: "text" },
      word("smooth_advice", { smooth: fixed(smooth.left_out_um, 2), best: fixed(chosen.left_out_um, 2) })));
}

function causesTable(one) {
  const { fault } = one;
  const leftOut = one.left_out.map((/** @type {number} */ seq) =>
    element("p", {}, element("b", {}, word("left_out_of_fit")), " ", targetLink(seq)));
  if (!fault) return leftOut;
  const chance = (/** @type {number} */ p) => p > 0.999 ? "> 0.999" : p < 0.001 ? "< 0.001" : fixed(p, 3);
  const test = fault.degrees_of_freedom <= 0 ? word("fault_unchecked")
    : word("fault_test", { p: fault.p < 1e-4 ? "< 0.0001" : fixed(fault.p, 4) });
  return [leftOut, element("p", { class: "text" }, test,
    fault.false_alarm > 0 && ` ${word("fault_alarm", { p: probability(fault.false_alarm) })}`,
    !fault.weighs_taken_pads && ` ${word("fault_pads")}`,
    ` ${word(fault.is_named ? "fault_named" : fault.is_outlier_certain ? "fault_outlier" : "fault_open")}`),
  table([{ title: word("cause") }, { title: word("evidence") }, number(word("probability"))],
    fault.causes.map((cause) => [
      [wordOf("cause", cause.cause), cause.target !== null && [" ", targetLink(cause.target)]],
      english(cause.text), chance(cause.probability)]), "prose"),
  element("p", { class: "quiet" }, word("causes_note"))];
}

/** What an error of one target would do unseen: the leverage of each. */
function leverageTable(one) {
  const known = one.reliability;
  if (!known || known.unseen.length === 0) return null;
  return element("details", {}, element("summary", {}, word("leverage")),
    table([{ title: word("target") }, number(word("unseen_error"))],
      known.unseen.map((row) => [row.target === null ? "" : targetLink(row.target),
        row.is_unlimited ? word("unlimited") : `${fixed(Math.hypot(row.error_um[0], row.error_um[1]), 1)}\u00a0\u00b5m`])),
    element("p", { class: "quiet text" }, word(known.can_be_stated ? "leverage_note" : "leverage_weak")));
}

function covarianceTable(one) {
  const names = ["l00", "l01", "l10", "l11", "tx", "ty"];
  const { map } = one.fit;
  const exponential = (/** @type {number | null} */ value) => value === null ? "\u2013" : value.toExponential(3);
  const values = [...map.linear[0], ...map.linear[1], ...map.translation_mm];
  return element("details", {}, element("summary", {}, word("covariance")),
    table([{ title: "" }, number(word("value")), ...names.map((title) => ({ title, number: true }))],
      names.map((name, i) => [name, values[i] === null ? "\u2013" : values[i].toFixed(9), ...map.covariance[i].map(exponential)]),
      "mono"),
    element("p", { class: "quiet text" }, word("covariance_note")));
}

function residualsPlan(one, targets) {
  const known = targets.filter((target) => one.points.includes(target.seq) && target.residual_um);
  if (known.length < 2) return null;
  return panelArrows({ label: word("residuals_caption"), mostHeight: 360, places: known.map((target) => ({
    at_mm: target.nominal_mm, vector_mm: target.residual_um.map((one) => one / 1e3), kind: target.state === "good" ? "" : "refused",
    name: `#${target.seq}`, lines: [`#${target.seq}`, ...arrowLines(target.nominal_mm, target.residual_um)],
    covariance_um2: target.measured?.covariance_um2 })) }, word("residuals_caption"));
}

/** @param {boolean} isOpen */
function seriesBlock(one, facts, isOpen) {
  const missing = facts.targets.filter((t) => one.targets.includes(t.seq) && t.status !== "found");
  const words = one.is_left_out ? word("board_not_drilled") : one.fit ? fitSentence(one)
    : missing.length > 0 ? [`${word("no_fit_missing")} `, missing.map((t) => [targetLink(t.seq), " "])]
      : word("no_fit");
  const verdict = one.is_left_out ? chip("suspect", word("status_board_left_out"))
    : chip(one.is_accepted ? "good" : "refused", word(one.is_accepted ? "pass" : "fail"));
  const summary = [verdict, " ", element("b", {}, seriesName(one)), " ", words];
  return unfolding(summary, () => {
    const text = one.fit && element("p", { class: "text" },
      word("fit_text", { n: one.points.length, model: wordOf("model", one.model) }), " ", capitalized(chiSquareText(one.fit.chi_square)),
      one.fit.misfit_ratio !== 1 && one.fit.misfit_ratio !== null &&
        ` ${word("fit_grown", { ratio: fixed(one.fit.misfit_ratio, 1) })}`,
      ` ${word("fit_centre")} ${place(one.fit.centroid_mm)}.`,
      one.fit.layer_spread_um !== null && ` ${word("fit_layers", { um: fixed(one.fit.layer_spread_um, 2) })}`);
    const assignment = one.assignment && element("p", { class: "text" },
      element("b", {}, word(one.assignment.is_certain ? "chosen_jointly" : "not_separable")), " ",
      word("candidates_that_count", { list: one.assignment.n_candidates.join(", ") }), " ",
      english(one.assignment.text), ".");
    return [element("div", { class: "columns" }, element("div", {}, text, one.fit && gatesTable(one), assignment),
      residualsPlan(one, facts.targets)), modelsTable(one), causesTable(one), leverageTable(one), one.fit && covarianceTable(one)];
  }, { class: "fit", open: isOpen || !one.is_accepted });
}

/** Fits of many boards, as ranges. */
function boardRanges(boards) {
  const range = (/** @type {(fit: any) => number | null} */ of, /** @type {number} */ decimals) => {
    const values = boards.map((one) => of(one.fit) ?? 0);
    return word("range", { low: fixed(Math.min(...values), decimals, { signed: true }),
      high: fixed(Math.max(...values), decimals, { signed: true }) });
  };
  const shifts = word("boards_shifted", { x: range((fit) => 1e3 * fit.shift_x_mm.value, 1),
    y: range((fit) => 1e3 * fit.shift_y_mm.value, 1) });
  const turns = boards.every((one) => one.model === "offset") ? ""
    : `, ${word("boards_rotated", { mrad: range((fit) => 1e3 * fit.rotation_rad.value, 3) })}`;
  return `${shifts}${turns}.`;
}

/** @returns {import("../base/dom.js").Child[]} */
export function fitBlocks(facts) {
  const { series } = facts;
  if (series.length === 0) return [element("p", { class: "quiet" }, word("nothing_fitted"))];
  const refused = series.filter((one) => !one.is_accepted);
  const panels = series.filter((one) => one.is_accepted && one.level === "panel");
  const boards = series.filter((one) => one.is_accepted && one.level !== "panel");
  const boardBlocks = boards.map((one) => seriesBlock(one, facts, false));
  return [
    facts.all_series && series.length > 1 && element("p", {}, `${word("all_fits")} `, chiSquareText(facts.all_series)),
    boards.some((one) => one.is_on_panel_fit) && element("p", {}, word("boards_on_panel")),
    refused.map((one) => seriesBlock(one, facts, true)),
    panels.map((one) => seriesBlock(one, facts, series.length <= maxLooseFits)),
    boards.length > maxLooseFits
      ? element("details", { class: "fit" }, element("summary", {}, chip("good", word("pass")), " ",
        element("b", {}, word("n_board_fits", { n: boards.length })), " ", boardRanges(boards)), boardBlocks)
      : boardBlocks,
  ];
}
