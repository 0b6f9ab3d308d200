// SPDX-License-Identifier: Apache-2.0
// The report of a job: verdict first, then the panel, the targets, the fits, and all that they rest on.
import { chip, element, english, meter, number, rowList, section, table, tile } from "../base/dom.js";
import { word, wordOf } from "../base/words.js";
import { fixed, micrometres, millimetres, percent, place, probability, shortest, whole } from "../base/format.js";
import { jobMap } from "../figures/job_map.js";
import { shiftPlans } from "../figures/shift_plans.js";
import { depthMap, focusCurve, riskChart } from "../figures/job_charts.js";
import { boardText, lineText, targetCards, targetLink } from "./job_targets.js";
import { fitBlocks, gateLimit, gateRatio, gateValue, worstGate } from "./job_fits.js";

/** @type {Record<string, [string, string]>} */
const jobVerdictMarks = {
  drill: ["\u2713", "drill"], warned: ["\u26a0", "forced"], hold: ["\u2717", "hold"], forced: ["\u26a0", "forced"],
};

function gateTiles(facts) {
  const remark = (/** @type {{gate: any}} */ worst) => {
    const ratio = gateRatio(worst.gate);
    return [meter(ratio, worst.gate.is_accepted ? "good" : "refused"), ratio < 100
      ? word("of_limit", { percent: percent(ratio, 0), limit: gateLimit(worst.gate) })
      : word("beyond_limit", { limit: gateLimit(worst.gate) })];
  };
  const residual = worstGate(facts.series, (gate) => gate.gate === "residual");
  const other = worstGate(facts.series, (gate) => gate.gate !== "residual");
  const length = (target) => target.residual_um ? Math.hypot(...target.residual_um) : -1;
  const largest = facts.targets.reduce((best, t) =>
    length(t) > (best ? length(best) : -1) ? t : best, null);
  const first = residual
    ? tile(word("worst_residual"), gateValue(residual.gate),
      [remark(residual), residual.gate.target !== null && ["; ", targetLink(residual.gate.target)]])
    : largest
      ? tile(word("worst_residual"), micrometres(length(largest), 2), [targetLink(largest.seq), `; ${word("no_limit")}`])
      : tile(word("worst_residual"), word("none"), word("nothing_fitted"));
  return [first, other && tile(word("worst_other_gate", { gate: wordOf("gate", other.gate.gate) }),
    gateValue(other.gate), [remark(other), `; ${word("line")} ${other.series.line}${boardText(other.series)}`])];
}

function placeTiles(facts) {
  const { places, truth } = facts;
  if (!places) return [tile(word("holes"), word("none_written"), word("was_refused"))];
  const sigma = places.sigma_leaves_out ? [word("of_the_fit_only"), " ", english(places.sigma_leaves_out)]
    : word("worst_direction");
  return [
    tile(word("holes"), whole(places.n_holes), facts.output === null ? word("was_held")
      : word("n_tools", { n: places.tools.length })),
    places.n_slots + places.n_routs > 0 && tile(word("slots_and_routs"), `${whole(places.n_slots)} / ${whole(places.n_routs)}`,
      millimetres(places.routed_length_mm, 1)),
    facts.targets.length > 0 && tile(word("largest_shift"), micrometres(places.max_shift_um, 1), word("nominal_to_corrected")),
    facts.targets.length > 0 && tile(word("largest_sigma"), micrometres(places.max_sigma_um, 3), sigma),
    truth && truth.all.n > 0 && tile(word("largest_error"), micrometres(truth.all.corrected_max_um, 2),
      word("without_correction", { um: fixed(truth.all.uncorrected_max_um, 1) })),
  ];
}

function riskTiles(facts) {
  const { tolerance, depth } = facts;
  const link = (/** @type {string} */ id, /** @type {string} */ text) => element("a", { href: `#${id}` }, text);
  return [
    tolerance && tolerance.n_judged > 0 && (tolerance.basis === "stated"
      ? tile(word("expected_broken"), probability(tolerance.expected_broken),
        [word("of_places", { n: whole(tolerance.n_judged) }), "; ", link("tolerance", word("worst_risk")), " ",
          probability(tolerance.worst_risk)])
      : tile(word("risk_of_breaking"),
        tolerance.basis === "bounded" ? word("at_least", { risk: probability(tolerance.worst_risk) }) : word("no_figure"),
        [link("tolerance", word("why")), ": ", english(tolerance.basis_words)])),
    depth && depth.n_judged > 0 && tile(word("depths_expected_broken"), probability(depth.expected_broken),
      [word("of_places", { n: whole(depth.n_judged) }), "; ", link("depth", word("worst_risk")), " ",
        probability(depth.worst_risk)]),
  ];
}

function firstScreen(facts) {
  const [mark, kind] = jobVerdictMarks[facts.verdict.word];
  const written = facts.output === null ? word("nothing_written")
    : facts.output === "-" ? word("written_to_standard_output") : word("written_to", { file: facts.output });
  return [
    element("h1", {}, element("b", {}, facts.program), " ", word("job_head", { machine: facts.machine, source: facts.source }),
      "; ", written),
    element("div", { class: `verdict ${kind}` },
      element("div", { class: "top" }, element("div", { class: "word" }, `${mark} ${wordOf("verdict", facts.verdict.word)}`),
        element("p", { lang: "en" }, facts.verdict.grounds)),
      element("p", { class: "next" }, element("b", {}, word("next")), " ", english(facts.verdict.next)),
      element("dl", { class: "tiles" },
        facts.targets.length > 0 && [gateTiles(facts), tile(word("targets_found"),
          word("n_of_m", { n: facts.n_found, m: facts.targets.length }),
          [word("n_fits", { n: facts.series.length }), facts.n_left_out > 0 &&
            ["; ", chip("suspect", word("n_left_out", { n: facts.n_left_out }))]])],
        placeTiles(facts), riskTiles(facts))),
  ];
}

function toleranceSection(tolerance) {
  if (!tolerance) return null;
  const hasTruth = tolerance.tools.some((tool) => tool.actual);
  const risk = (tool) => tool.n_judged === 0 ? element("span", { class: "quiet" }, word("not_judged"))
    : chip(tool.n_held > 0 ? "refused" : tool.n_warned > 0 ? "suspect" : "good",
      tool.risk === null ? word("no_figure") : probability(tool.risk));
  const columns = [{ title: word("tool") }, { title: word("risk") }, number(word("places")), number(word("tolerance_um")),
    number(word(tolerance.is_of_fit_only ? "largest_sigma_of_fit" : "largest_sigma_um")), number(word("radius_95")),
    number(word("mean")), number(word("mean_3_sigma")), number("Cpk"),
    ...hasTruth ? [number(word("true_max")), number(word("true_mean_3_sigma")), number(word("true_cpk"))] : [],
    number(word("warn_hold")), { title: word("worst_place") }];
  const rows = tolerance.tools.map((tool) => [`T${tool.tool}`, risk(tool), whole(tool.n_places),
    fixed(tool.tolerance_um, 1), fixed(tool.largest_sigma_um, 2), fixed(tool.largest_radius_95_um, 2),
    fixed(tool.predicted.mean_um, 2), fixed(tool.predicted.mean_plus_3_sigma_um, 2), fixed(tool.predicted.cpk, 2),
    ...hasTruth ? [fixed(tool.actual?.max_um, 2), fixed(tool.actual?.mean_plus_3_sigma_um, 2), fixed(tool.actual?.cpk, 2)] : [],
    tool.n_judged === 0 ? "" : `${whole(tool.n_warned)} / ${whole(tool.n_held)}`,
    tool.worst ? `${lineText(tool.worst)}, ${place(tool.worst.nominal_mm)}` : ""]);
  return section("tolerance", word("tolerance"), sentence(tolerance.sentence), table(columns, rows), riskChart(tolerance),
    element("p", { class: "quiet text" }, word("tolerance_note"), tolerance.basis !== "unknown" && ` ${word("cpk_note")}`,
      tolerance.basis === "stated" && ` ${word("expected_note")}`, hasTruth && ` ${word("truth_column_note")}`));
}

/** @param {string} text a sentence of the program, in English */
function sentence(text) {
  return element("p", { lang: "en" }, element("b", {}, `${text.charAt(0).toUpperCase()}${text.slice(1)}.`));
}

function depthSection(depth) {
  if (!depth) return null;
  const risk = (/** @type {number | undefined} */ p) => p === undefined ? ""
    : chip(p > depth.hold_above ? "refused" : p > depth.warn_above ? "suspect" : "good", probability(p));
  const hasAxes = new Set(depth.maps.map((map) => map.axis)).size > 1;
  const rows = depth.tools.map((tool) => [`T${tool.tool}`, whole(tool.n_depths),
    `${fixed(tool.too_shallow_um, 1)} / ${fixed(tool.too_deep_um, 1)}`,
    tool.n_judged === 0 ? word("not_judged") : fixed(tool.largest_mean_um, 2, { signed: true }),
    fixed(tool.largest_sigma_um, 2),
    tool.n_judged === 0 ? "" : `${probability(tool.expected_too_shallow)} / ${probability(tool.expected_too_deep)}`,
    tool.n_judged === 0 ? "" : `${whole(tool.n_warned)} / ${whole(tool.n_held)}`,
    risk(tool.worst?.risk_too_shallow), risk(tool.worst?.risk_too_deep),
    tool.worst ? `${lineText(tool.worst)}, ${place(tool.worst.nominal_mm)}: ` +
      `${fixed(tool.worst.mean_um, 1, { signed: true })} \u00b1 ${micrometres(tool.worst.sigma_um, 1)}` : ""]);
  return section("depth", word("depth"), sentence(depth.sentence),
    rows.length > 0 && table([{ title: word("tool") }, number(word("depths")), number(word("shallow_deep")),
      number(word("farthest_off")), number(word("largest_sigma_um")), number(word("expected_shallow_deep")),
      number(word("warn_hold")), { title: word("too_shallow") }, { title: word("too_deep") }, { title: word("worst_place") }], rows),
    element("div", { class: "figures" }, depth.maps.map((map) => depthMap(map, depth.tools, hasAxes))),
    element("ul", { lang: "en" }, depth.surface_lines.map((/** @type {string} */ line) => element("li", {}, line))),
    element("p", { class: "quiet text" }, word("depth_note", { um: shortest(depth.machine_sigma_um) })));
}

function budgetSection(budget) {
  if (!budget) return null;
  const trace = (/** @type {number[]} */ c) => c[0] + c[2];
  const sigma = (/** @type {number} */ variance) => fixed(Math.sqrt(Math.max(0, variance)), 2);
  const all = trace(budget.covariance_um2);
  const row = (/** @type {string} */ name, /** @type {number[]} */ c, /** @type {string} */ common) => [name, sigma(c[0]),
    sigma(c[2]), percent(all > 0 ? trace(c) / all : 0), meter(all > 0 ? trace(c) / all : 0), common];
  const counted = budget.terms.filter((term) => term.counts);
  const missing = budget.terms.filter((term) => !term.counts).map((term) => wordOf("source", term.source));
  const common = counted.filter((term) => term.common_to === "all holes");
  const sum = (/** @type {number} */ k) => common.reduce((/** @type {number} */ s, term) => s + term.covariance_um2[k], 0);
  const shared = sum(0) + sum(2) > 0 ? word("budget_common", { x: sigma(sum(0)), y: sigma(sum(2)) }) : word("budget_common_unknown");
  const why = !budget.is_likeliest_to_break ? word("budget_least_certain")
    : budget.risk === null ? word("budget_likeliest") : word("budget_likeliest_risk", { risk: probability(budget.risk) });
  return section("budget", word("budget"),
    element("p", {}, `${why}: ${lineText(budget)}, T${budget.tool}, ${word("nominal")} ${place(budget.nominal_mm)}.`),
    table([{ title: word("source") }, number(word("sigma_x")), number(word("sigma_y")),
      number(word("share")), { title: "" }, { title: word("common_to") }],
    [...counted.map((term) => row(wordOf("source", term.source), term.covariance_um2, wordOf("common", term.common_to))),
      row(word("total"), budget.covariance_um2, "")]),
    missing.length > 0 && element("p", { class: "quiet" }, word("budget_missing"), ` ${missing.join(", ")}.`),
    element("p", { class: "text" }, shared));
}

function measuredSections(facts) {
  const { calibrations, focus, surface } = facts;
  return [
    calibrations.length > 0 && section("calibrations", word("calibrations"),
      element("p", { class: "text" }, word("calibrations_note")),
      table([number(word("line")), { title: word("order") }, { title: word("status_found") }],
        calibrations.map((one) => [one.line, one.command, english(one.text)]), "prose")),
    focus.length > 0 && section("focus", word("focus"), element("div", { class: "figures" },
      focus.map((one) => focusCurve(one, `${word("line")} ${one.line}, ${place(one.expected_mm)}: `, one.is_found
        ? word("focused", { z: millimetres(one.z_mm, 4), sigma: micrometres(one.sigma_um, 1) })
        : [element("b", {}, word("not_focused")), " ", english(one.reason)])))),
    surface && section("surface", word("surface"),
      surface.use && element("p", { lang: "en" }, `${surface.use}.`), probesTable(surface)),
  ];
}

function probesTable(surface) {
  if (surface.probes.length === 0) return null;
  const n_axes = Math.max(1, ...surface.probes.map((probe) => probe.axes.length));
  const axes = Array.from({ length: n_axes }, (_, axis) => axis);
  const heights = (values) => axes.map((axis) => fixed(values[axis]?.height_mm, 4));
  return table([{ title: word("probe") }, { title: word("asked_by") }, { title: "" }, number(word("nominal")),
    ...axes.map((axis) => ({ title: n_axes === 1 ? word("height_mm") : word("height_of_axis", { axis }), number: true })),
    number(word("from_expected"))],
  [...surface.probes.map((probe) => [`#${probe.seq}`, `${probe.command}, ${lineText(probe)}`,
    probe.memory === null ? "" : `L${probe.memory}`, place(probe.nominal_mm),
    ...(probe.is_found ? heights(probe.axes) : [[element("b", {}, word("status_not_found")), " ", english(probe.reason)], ...axes.slice(1).map(() => "")]),
    probe.is_found ? fixed(1e3 * (probe.axes[0].height_mm - probe.reference_mm), 1, { signed: true }) : ""]),
  ...surface.filled.map((node) => ["", [element("b", {}, word("not_probed")),
    `, ${wordOf("height", node.height_from)}: \u03c3 ${micrometres(node.axes[0]?.sigma_um, 1)}`], "", place(node.place_mm), ...heights(node.axes), ""])]);
}

function messagesSection(facts) {
  return section("messages", word("messages"), facts.messages.length === 0
    ? element("p", { class: "quiet" }, word("no_messages"))
    : element("ul", { class: "messages" }, facts.messages.map((message) => element("li", {},
      chip(message.severity, word(message.severity === "error" ? "error" : "warning")), " ",
      element("code", { lang: "en" }, message.text), element("div", { class: "quiet", lang: "en" }, message.advice)))));
}

function truthSection(truth) {
  if (!truth) return null;
  const row = (/** @type {string} */ name, errors) => [name, whole(errors.n), fixed(errors.uncorrected_max_um, 1),
    fixed(errors.uncorrected_rms_um, 1), fixed(errors.corrected_max_um, 3), fixed(errors.corrected_rms_um, 3)];
  return section("truth", word("truth"),
    table([{ title: word("tool") }, number(word("holes")), number(word("uncorrected_max")), number(word("rms")),
      number(word("corrected_max")), number(word("rms"))],
    [...truth.tools.map((tool) => row(`T${tool.tool}`, tool)), row(word("all"), truth.all)]),
    truth.mean_normalized_square !== null && element("p", { class: "quiet text" },
      word("truth_note", { square: fixed(truth.mean_normalized_square, 2) })));
}

export const jobView = {
  facts: "job",
  /** @param {Record<string, string>} pictures */
  show(facts, pictures) {
    document.title = `${wordOf("verdict", facts.verdict.word)}: ${facts.program} - panelcal`;
    const shifts = shiftPlans(facts);
    return element("div", {}, firstScreen(facts),
      section("panel", word("panel"), jobMap(facts) ?? element("p", { class: "quiet" }, word("nothing_to_draw")),
        shifts.length > 0 && element("div", { class: "figures" }, shifts)),
      toleranceSection(facts.tolerance), depthSection(facts.depth),
      section("targets", word("targets"), targetCards(facts, pictures)),
      section("fits", word("fits"), fitBlocks(facts)),
      budgetSection(facts.budget), measuredSections(facts), messagesSection(facts), truthSection(facts.truth),
      section("origin", word("origin"), element("p", { class: "quiet text" }, word("conventions")),
        rowList(facts.provenance.map((row) => [row.key, row.value]))));
  },
};
