// SPDX-License-Identifier: Apache-2.0
// Quality certificate of a machine: repeatability, gauge study, stage, traceability and uncertainty budget.
import { chip, element, english, number, rowList, section, table, tile } from "../base/dom.js";
import { fixed, micrometres, millimetres, minuteText, percent, whole } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { nightsChart, nightsLegend } from "../figures/nights.js";

/** Below the first a measuring system is good, above the second it is not (AIAG, Measurement Systems Analysis). */
const gaugeLimits_percent = [10, 30];

/** @param {number} share_percent */
function gaugeWord(share_percent) {
  const i = gaugeLimits_percent.filter((limit) => share_percent > limit).length;
  return { kind: ["good", "suspect", "refused"][i], text: word(/** @type {const} */ (["certificate_good", "certificate_marginal", "certificate_bad"])[i]) };
}

/** @param {number | null} degrees */
function degreesText(degrees) {
  return degrees === null ? "\u221e" : fixed(degrees, degrees < 100 ? 1 : 0);
}

/** @param {number} low @param {number} high @param {number} decimals */
function intervalText(low, high, decimals) {
  return `${fixed(low, decimals)} \u2026 ${fixed(high, decimals)}`;
}

/** @param {string} unit of the facts */
function unitText(unit) {
  return unit === "um" ? "\u00b5m" : unit;
}

function repeatabilitySection(rows) {
  if (rows.length === 0) return null;
  return section("repeatability", word("certificate_repeatability"), element("p", { class: "quiet" }, word("certificate_repeatability_text")),
    table([{ title: word("history_subject") }, { title: word("certificate_scatter") }, number(word("sigma")), number(word("calibration_row_degrees_of_freedom")),
      number("95 %"), number(word("certificate_nights"))],
    rows.map((row) => [row.subject, wordOf("certificate_scatter", row.name), `${fixed(row.sigma, 3)}\u00a0${unitText(row.unit)}`,
      degreesText(row.degrees_of_freedom), intervalText(row.low, row.high, 3), whole(row.nights)])));
}

function gaugeShare(share_percent, tolerance) {
  const { kind, text } = gaugeWord(share_percent);
  return element("p", {}, word("certificate_share", { share: percent(share_percent / 100), tolerance: micrometres(tolerance.limit_um) }),
    " ", chip(kind, text), " ", english(tolerance.origin));
}

function gaugeTable(gauge, tolerance) {
  const row = (name, sigma_um, degrees, interval) => [name, micrometres(sigma_um, 3), degrees, interval];
  const seen = (name, scatter) => row(name, scatter.sigma, degreesText(scatter.degrees_of_freedom), intervalText(scatter.low, scatter.high, 3));
  return [table([{ title: word("certificate_gauge") }, number(word("sigma")), number(word("calibration_row_degrees_of_freedom")), number("95 %")],
    [seen(word("certificate_ev"), gauge.repeatability_um), seen(word("certificate_over_nights"), gauge.over_nights_um),
      row(word("certificate_within"), gauge.within_um, "", ""), row(word("certificate_av"), gauge.reproducibility_um, "", ""),
      seen("R&R", gauge.both_um)]),
  tolerance && gaugeShare(gauge.percent_of_tolerance, tolerance)];
}

function certifiedBudget(budget) {
  const both = (values, decimals) => values.map((/** @type {number} */ one) => fixed(one, decimals));
  const total = (/** @type {import("../base/words.js").WordKey} */ key, texts) => [element("b", {}, word(key)), "", ...texts, "", ""];
  return table([{ title: word("certificate_budget") }, { title: word("certificate_type") }, number("x, \u00b5m"), number("y, \u00b5m"),
    number(word("calibration_row_degrees_of_freedom")), { title: word("certificate_from") }],
  [...budget.rows.map((row) => [wordOf("certificate_source", row.source), row.type, ...both(row.sigma_um, 3),
    degreesText(row.degrees_of_freedom), english(row.origin)]),
  total("certificate_combined", both(budget.combined_um, 3)),
  total("certificate_effective", budget.degrees_of_freedom.map(degreesText)),
  total("certificate_factor", both(budget.coverage_factor, 2)),
  total("certificate_expanded", both(budget.expanded_um, 2))]);
}

/** Sources of which nothing is known. */
function withoutText(budget) {
  return budget.missing.map((/** @type {string} */ one) => ` ${word("certificate_without", { source: wordOf("certificate_source", one) })}`);
}

function certifiedNights(spindle) {
  const charts = ["x", "y"].map((name, k) => nightsChart({ title: spindle.subject, name, unit: "mm", found: spindle.nights.map((night) =>
    ({ time: night.time, value: night.offset_mm[k], sigma: night.sigma_um[k] / 1e3, mark: "filled", entry: night.entry,
      state: word("history_verdict_installed"), who: night.asked_by })) }));
  return charts.some(Boolean) ? [element("div", { class: "figures" }, charts), nightsLegend(["filled"])] : null;
}

function spindleSection(spindle, tolerance, i) {
  const { nights } = spindle;
  const left = [spindle.refused ? word("certificate_refused", { n: whole(spindle.refused) }) : "",
    spindle.rolled_back ? word("certificate_rolled_back", { n: whole(spindle.rolled_back) }) : "",
    spindle.fresh_start ? word("certificate_fresh", { entry: spindle.fresh_start }) : ""].filter(Boolean);
  return section(`spindle-${i + 1}`, spindle.subject,
    nights.length > 0 && element("p", {}, word("certificate_period", { n: whole(nights.length), from: minuteText(nights[0].time),
      to: minuteText(nights[nights.length - 1].time) }), left.map((one) => ` ${one}`)),
    spindle.gauge && gaugeTable(spindle.gauge, tolerance), spindle.budget && certifiedBudget(spindle.budget),
    spindle.budget && element("p", { class: "quiet" }, word("certificate_coverage", { share: percent(spindle.budget.coverage, 2) }),
      withoutText(spindle.budget)),
    certifiedNights(spindle));
}

/** @param {any} figure */
function stageAmount(figure, key) {
  const value = figure[key];
  if (value === null) return "\u2013";
  const signed = key === "value" && !["range", "repeatability"].includes(figure.quantity);
  const { factor, name } = figure.unit === "mm" ? { factor: 1e3, name: "\u00b5m" } : { factor: 1e6, name: figure.unit === "rad" ? "\u00b5rad" : "ppm" };
  return `${fixed(factor * value, 2, { signed })}\u00a0${name}`;
}

function stageSection(facts) {
  if (facts.stage.length === 0) return null;
  return section("stage", word("certificate_stage"), element("p", { class: "quiet" }, word("certificate_stage_text")),
    table([{ title: word("night_axis") }, { title: word("certificate_quantity") }, number(word("value")), number(word("sigma")),
      number(word("certificate_nights")), { title: word("certificate_from") }],
    facts.stage.map((figure) => [figure.axis, wordOf("certificate_quantity", figure.quantity), stageAmount(figure, "value"),
      stageAmount(figure, "sigma"), whole(figure.nights), english(figure.origin)])));
}

function plateSection(plate) {
  if (!plate) return null;
  return section("plate", word("certificate_plate"), element("p", {}, chip(plate.certified ? "good" : "suspect",
    word(plate.certified ? "certificate_certified" : "certificate_uncertified"))),
  rowList([[word("certificate_source_plate"), plate.name], [word("certificate_plate_paper"), plate.certificate],
    [word("certificate_plate_u"), plate.expanded_uncertainty_um !== null &&
      `U = ${micrometres(plate.expanded_uncertainty_um, 3)}, k = ${fixed(plate.coverage_factor, 2)}`],
    [word("certificate_plate_dots"), `${whole(plate.columns)} \u00d7 ${whole(plate.rows)}, ${millimetres(plate.pitch_mm)}`],
    [word("certificate_plate_entry"), plate.entry], [word("history_file"), plate.file], ["SHA-256", plate.sha256]], ""));
}

function certificateTiles(facts) {
  const [first] = facts.spindles.filter((one) => one.budget).sort((a, b) => Math.max(...b.budget.expanded_um) - Math.max(...a.budget.expanded_um));
  const gauges = facts.spindles.map((one) => one.gauge?.percent_of_tolerance ?? null).filter((one) => one !== null);
  const worst = gauges.length ? Math.max(...gauges) : null;
  const kind = worst === null ? "suspect" : gaugeWord(worst).kind;
  return element("div", { class: `verdict${kind === "refused" ? " hold" : kind === "suspect" || !facts.plate?.certified ? " forced" : ""}` }, element("dl", { class: "tiles" },
    first && tile(word("certificate_expanded"), micrometres(Math.max(...first.budget.expanded_um), 2),
      [word("certificate_expanded_text", { k: fixed(Math.max(...first.budget.coverage_factor), 2) }), withoutText(first.budget)]),
    worst !== null && tile(word("certificate_gauge"), percent(worst / 100), gaugeWord(worst).text),
    tile(word("certificate_plate"), facts.plate?.certified ? word("certificate_certified") : word("certificate_untraceable"),
      facts.plate?.certificate ?? ""),
    tile(word("certificate_not_measured"), whole(facts.not_measured.length), element("a", { href: "#not-measured" }, word("certificate_see")))));
}

export const certificateView = {
  facts: "certificate",
  /** @param {any} facts */
  show(facts) {
    const { verification } = facts;
    document.title = word("certificate_title", { machine: facts.machine });
    return element("div", {}, element("h1", {}, document.title), certificateTiles(facts),
      repeatabilitySection(facts.repeatability), facts.spindles.map((spindle, i) => spindleSection(spindle, facts.tolerance, i)),
      stageSection(facts), plateSection(facts.plate),
      section("not-measured", word("certificate_not_measured"), table([{ title: word("certificate_quantity"), text: true },
        { title: word("history_reason"), text: true }], facts.not_measured.map((one) => [english(one.what), english(one.why)]))),
      section("origin", word("origin"), rowList([[word("history_file"), facts.ledger_file], [word("history_entries"), whole(verification.entries)],
        [word("history_hash"), verification.head], [word("certificate_held"), whole(verification.held_against.length)],
        ...Object.entries(facts.provenance)])));
  },
};
