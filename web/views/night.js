// SPDX-License-Identifier: Apache-2.0
// The page of the morning: may the machine drill, what has moved, and every calibration of the night.
import { chip, element, english, number, rowList, section, table, tile } from "../base/dom.js";
import { absolute, amount, fixed, millimetres, minuteText, place, whole } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { panelArrows } from "../figures/panel_arrows.js";
import { chart } from "../figures/chart.js";
import { fieldOf } from "../figures/field.js";
import { nightsChart, nightsLegend } from "../figures/nights.js";
import { residualFigure, zoneFigure } from "../figures/surface_map.js";

const stateKinds = { installed: "good", "kept old": "suspect", "would run": "suspect" };

/** @param {string} state */
function stateChip(state) {
  return chip(stateKinds[/** @type {keyof typeof stateKinds} */ (state)] ?? "refused", wordOf("night_state", state));
}

/** @param {string[]} texts */
function textList(texts) {
  return texts.length ? element("ul", { lang: "en" }, texts.map((text) => element("li", {}, text))) : null;
}

/**
 * Lines with a mark before each.
 * @param {{kind: string, state: string, name: string, text: string}[]} rows
 */
function checkList(rows) {
  return element("ul", { class: "messages" }, rows.map((row) =>
    element("li", {}, chip(row.kind, row.state), " ", element("b", {}, english(row.name)), " ", english(row.text))));
}

/** What a person does next; empty if all is well. */
function nextStep(facts) {
  const command = `panelcal nightly -m ${facts.config_file}`;
  if (facts.dry_run) return word("night_next_dry");
  if (facts.outcome === "installed" && facts.may_drill) return "";
  if (facts.outcome === "failed") return word("night_next_failed", { command });
  return facts.may_drill ? word("night_next_refused") : word("night_next_hold", { command: `${command} --again` });
}

function stepCounts(facts) {
  /** @type {Map<string, number>} */
  const counts = new Map();
  for (const { state } of facts.steps) counts.set(state, (counts.get(state) ?? 0) + 1);
  return [...counts].map(([state, n]) => `${n} ${wordOf("night_state", state)}`).join(", ") || word("none");
}

function surfaceTile(facts) {
  const step = facts.steps.find((one) => one.kind === "surface");
  if (!step?.axes.length || step.axes[0].new === null) return null;
  const { unit } = step.axes[0];
  return step.change === null
    ? tile(word("night_surface"), word("night_surface_mapped"), word("night_surface_first"))
    : tile(word("night_surface"), word("night_surface_moved", { change: amount(step.change, unit) }),
      word("night_surface_sigma", { sigma: amount(step.change_sigma, unit) }));
}

function nightTiles(facts) {
  const passed = facts.checks.filter((check) => check.passed).length;
  const until = !facts.may_drill ? word("night_until_hold")
    : facts.drill_until ? minuteText(facts.drill_until) : word("night_until_open");
  return element("dl", { class: "tiles" },
    tile(word("night_until"), until, facts.may_drill ? word("night_until_report") : word("night_until_confirmed")),
    tile(word("night_calibrations"), stepCounts(facts), word("night_calibrations_remark")),
    tile(word("night_self_test"), word("night_checks_of", { passed, all: facts.checks.length }),
      passed === facts.checks.length ? word("night_checks_passed") : word("night_checks_failed")),
    surfaceTile(facts),
    tile(word("night_temperature"),
      facts.temperature_c === null ? word("night_not_known") : `${fixed(facts.temperature_c, 1)}\u00a0\u00b0C`,
      word("night_temperature_of")));
}

function nightVerdict(facts) {
  const isGood = facts.may_drill && facts.outcome === "installed" && !facts.dry_run;
  const kind = facts.dry_run || (facts.may_drill && !isGood) ? " forced" : isGood ? "" : " hold";
  const said = facts.dry_run ? word("night_dry_run") : facts.may_drill ? word("verdict_drill") : word("verdict_hold");
  const next = nextStep(facts);
  return element("div", { class: `verdict${kind}` },
    element("div", { class: "top" }, element("div", { class: "word" }, said), element("p", { lang: "en" }, facts.verdict)),
    next && element("p", { class: "next" }, element("b", {}, word("next")), " ", next),
    nightTiles(facts));
}

/** Not as a ratio: what is predicted has wider tails than a normal distribution. */
function surpriseText(step, axis) {
  if (step.series[step.series.length - 1]?.fresh_start) return word("chart_event");
  if ([axis.new, axis.expected, axis.expected_sigma].includes(null)) return "\u2013";
  return word("night_predicted_to", { off: amount(axis.new - axis.expected, axis.unit, true),
    sigma: amount(axis.expected_sigma, axis.unit) });
}

function axesTable(step) {
  if (!step.axes.length) return null;
  const titles = ["night_old", "night_new", "sigma", "night_change", "night_off"];
  return table([{ title: word("night_axis") }, ...titles.map((title) => ({ title: word(/** @type {any} */ (title)), number: true }))],
    step.axes.map((axis) => [axis.name, absolute(axis.old, axis.unit), absolute(axis.new, axis.unit),
      amount(axis.sigma, axis.unit),
      axis.old === null || axis.new === null ? "\u2013" : amount(axis.new - axis.old, axis.unit, true),
      surpriseText(step, axis)]));
}

/** Charts of all axes over the nights, with their key. */
function stepCharts(step, facts) {
  const charts = step.axes.map((axis, /** @type {number} */ i) => nightsChart({
    title: `${step.kind} ${step.subject}`, name: axis.name, unit: axis.unit, tolerance: step.tolerance,
    expected: axis.expected, expectedSigma: axis.expected_sigma,
    found: step.series.map((night) => ({
      time: night.time, value: night.value[i] ?? null, sigma: night.sigma[i], mark: night.refused ? "cross" : "filled",
      state: night.refused ? word("history_verdict_refused") : night.by_hand ? word("chart_by_hand") : word("night_state_installed"),
      who: night.asked_by || facts.asked_by, entry: night.ledger_id ?? step.ledger_id, inForce: night.in_force[i],
      alarm: night.alarm, freshStart: night.fresh_start,
    })),
  })).filter(Boolean);
  const holes = holesFigure(step);
  if (!charts.length) return holes && element("div", { class: "figures" }, holes);
  const has = (/** @type {string} */ key) => step.series.some((night) => night[key]);
  const marks = ["filled", has("refused") && "cross", has("alarm") && "ring", "step", has("fresh_start") && "event",
    step.tolerance && "limit", step.axes.some((axis) => axis.expected !== null) && "band"];
  return [element("h3", {}, word("night_last_nights", { n: whole(step.series.length) })),
    element("div", { class: "figures" }, charts, holes),
    nightsLegend(/** @type {string[]} */ (marks.filter(Boolean)))];
}

/** Holes of the coupon about the fit. */
function holesFigure(step) {
  const holes = step.holes.filter((hole) => ![...hole.place_mm, ...hole.residual_mm].includes(null));
  if (!holes.length) return null;
  return panelArrows({ label: word("night_holes"), mostHeight: 400,
    places: holes.map((hole) => {
      const [x, y] = hole.residual_mm.map((/** @type {number} */ one) => fixed(1e3 * one, 2, { signed: true }));
      return { at_mm: hole.place_mm, vector_mm: hole.residual_mm, kind: hole.outlier ? "refused" : "",
        lines: [place(hole.place_mm), word("night_holes_off", { x, y, length: fixed(1e3 * Math.hypot(...hole.residual_mm), 2) }),
          hole.outlier ? word("night_hole_outlier") : ""].filter(Boolean) };
    }) }, word("night_holes"));
}

function stepReasons(step) {
  const isSaid = (/** @type {string} */ reason) => step.summary.includes(reason);
  const reasons = step.decision && step.decision.verdict !== "install" ? step.decision.reasons : [];
  return [
    step.problem && element("p", { class: "bad", lang: "en" }, step.problem.text),
    reasons.every(isSaid) ? null : textList(reasons),
    step.alarms.map((/** @type {string} */ alarm) => element("p", { class: "bad", lang: "en" }, alarm)),
    step.since_when && element("p", { lang: "en" }, step.since_when),
    step.forecast.text && element("p", {}, element("b", {},
      // If tonight speaks against what is in force, the nights before it are no answer.
      step.state === "hold" ? word("night_by_nights_before") : word("night_may_it_be_used")), " ", english(step.forecast.text)),
  ];
}

/** The map that the night probed. */
function surfaceFigures(surface) {
  if (!surface) return null;
  const [zone] = surface.zones;
  const heights = fieldOf(zone.field, zone.field.height_mm), sigmas = fieldOf(zone.field, zone.field.sigma_um);
  const all = { zone, facts: surface, heights, sigmas };
  return [element("h3", {}, word("night_surface_tonight")), element("div", { class: "figures" },
    zoneFigure({ ...all, isHeights: true }), zoneFigure({ ...all, isHeights: false }), residualFigure(zone)),
  element("p", { class: "quiet text" }, word("surface_map_text", { mm: millimetres(zone.max_extrapolation_mm, 1) }))];
}

function smallPrint(step) {
  const texts = [step.ledger_id && word("night_entry", { id: step.ledger_id }),
    step.in_force_id && word("night_in_force", { id: step.in_force_id }),
    step.file && word("night_file", { file: step.file }), step.from_earlier_run && word("night_earlier_run")];
  return [
    element("p", { class: "quiet" }, texts.filter(Boolean).join("; ")),
    step.fit_report.length ? element("details", {}, element("summary", {}, word("night_fit_in_full")),
      element("pre", { class: "mono", lang: "en" }, step.fit_report.join("\n"))) : null,
  ];
}

/** @param {number} i */
function nightStep(step, i, facts) {
  const gates = step.decision?.gates ?? [];
  return section(`step-${i + 1}`, element("span", {}, `${step.kind} ${step.subject} `, stateChip(step.state)),
    step.summary && element("p", { lang: "en" }, step.summary), stepReasons(step), axesTable(step),
    gates.length ? [element("h3", {}, word("gates")), checkList(gates.map((gate) => ({
      kind: gate.passed ? "good" : "refused", state: word(gate.passed ? "night_passed" : "history_verdict_refused"),
      name: gate.name, text: gate.text })))] : null,
    step.qualities.length ? [element("h3", {}, word("night_qualities")),
      checkList(step.qualities.map((quality) => ({
        kind: quality.alarm ? "refused" : "good", state: word(quality.alarm ? "night_unusual" : "night_usual"),
        name: quality.name, text: quality.text })))] : null,
    surfaceFigures(step.surface), stepCharts(step, facts), smallPrint(step));
}

/** The mark while the machine warmed up. */
function warmUpChart(warmUp) {
  const { looks, fit, limit_mm: limit } = warmUp;
  if (looks.length < 2) return null;
  const warm = fit?.warm_mm ?? looks[looks.length - 1].slice(1, 3);
  const points = [0, 1].flatMap((axis) => looks.map((/** @type {number[]} */ look) => ({
    x: look[0] / 60, y: 1e3 * (look[1 + axis] - warm[axis]), sigma: 1e3 * look[3], mark: axis ? "hollow" : "filled",
    lines: [word("night_warm_up_at", { minutes: fixed(look[0] / 60, 1) }),
      `${"xy"[axis]} ${amount(look[1 + axis] - warm[axis], "mm", true)} \u00b1 ${amount(look[3], "mm")}`],
  })));
  const end = looks[looks.length - 1][0];
  const curves = !fit ? [] : [0, 1].map((axis) => Array.from({ length: 101 }, (_, i) => ({
    x: (end * i) / 6000, y: 1e3 * fit.cold_offset_mm[axis] * Math.exp(-(end * i) / 100 / fit.time_constant_s) })));
  return chart({ label: word("night_warm_up_caption"), yTitle: word("night_warm_up_axis"), xTitle: word("night_minutes"),
    points, curves, band: { low: -1e3 * limit, high: 1e3 * limit }, marks: warmUp.warm && fit ? [fit.wait_s / 60] : [] },
  word("night_warm_up_caption"));
}

function nightProvenance(facts) {
  const rows = [["night_started", facts.started], ["night_finished", facts.finished], ["asked_by", facts.asked_by],
    ["night_made_by", facts.software], ["night_machine_file", facts.config_file], ["night_ledger", facts.ledger_file],
    ["night_ledger_head", facts.ledger_head.id ? `${facts.ledger_head.id} ${facts.ledger_head.hash}` : ""]]
    .map(([key, value]) => [word(/** @type {any} */ (key)), value]);
  return section("origin", word("origin"), rowList([...rows, ...Object.entries(facts.provenance)]));
}

export const nightView = {
  facts: "night",
  show(facts) {
    document.title = word("night_title", { night: facts.night, machine: facts.machine });
    const { warm_up: warmUp } = facts;
    return element("div", {},
      element("h1", {}, document.title),
      nightVerdict(facts),
      section("changes", word("night_since_last_week"),
        textList(facts.changes) ?? element("p", { class: "quiet" }, word("night_nothing_to_compare"))),
      facts.notes.length ? section("notes", word("night_notes"), textList(facts.notes)) : null,
      facts.steps.map((step, /** @type {number} */ i) => nightStep(step, i, facts)),
      warmUp && section("warm-up", element("span", {}, word("night_warm_up"), " ", warmUp.warm
        ? chip("good", word("night_warm")) : chip("refused", word("night_not_known"))),
      element("p", { lang: "en" }, warmUp.text), warmUpChart(warmUp)),
      facts.checks.length ? section("self-test", word("night_self_test"), checkList(facts.checks.map(
        (check) => ({ kind: check.passed ? "good" : "refused",
          state: word(check.passed ? "night_passed" : "night_state_failed"), name: check.name, text: check.text })))) : null,
      nightProvenance(facts));
  },
};
