// SPDX-License-Identifier: Apache-2.0
// Pages of a ledger: its entries over time, one entry, and what a change of calibration does to a job.
import { chip, element, number, rowList, section, table, tile, unfolding } from "../base/dom.js";
import { absolute, amount, fixed, micrometres, minuteText, place, secondsOf, timeText, whole } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { chart, chartLegend } from "../figures/chart.js";
import { nightsChart, nightsLegend } from "../figures/nights.js";
import { panelArrows } from "../figures/panel_arrows.js";
import { differencePage } from "./surface.js";

const ledgerKinds = { installed: "good", refused: "refused", "rolled-back": "suspect" };
/** @type {Record<string, "filled" | "hollow" | "cross">} */
const ledgerMarks = { installed: "filled", "rolled-back": "filled", refused: "cross" };

function verdictChips(entry) {
  const kind = ledgerKinds[/** @type {keyof typeof ledgerKinds} */ (entry.verdict)] ?? "plain";
  return [chip(kind, wordOf("history_verdict", entry.verdict)),
    entry.in_force ? [" ", chip("good", word("history_in_force"))] : null];
}

function subjectOf(entry) {
  return `${entry.kind} ${entry.subject}, ${entry.machine}`;
}

/** The entry's parameter, and its sigma.
 * @param {any} entry @param {string} name */
function parameterOf(entry, name) {
  const i = entry.parameters.findIndex((one) => one.name === name);
  if (i < 0) return null;
  return { ...entry.parameters[i], sigma: entry.covariance ? Math.sqrt(entry.covariance[i][i]) : null };
}

/** Entries by what they calibrate: first what has been in force, then what was only measured.
 * @returns {Map<string, any[]>} */
function entriesBySubject(entries) {
  const groups = new Map();
  for (const entry of entries) {
    const subject = subjectOf(entry);
    groups.set(subject, [...(groups.get(subject) ?? []), entry]);
  }
  const wasInForce = (group) => group.some((entry) => entry.verdict === "installed");
  return new Map([...groups].sort(([, a], [, b]) => Number(wasInForce(b)) - Number(wasInForce(a))));
}

function entryLines(entry) {
  return [minuteText(entry.time), subjectOf(entry),
    word("chart_entry", { state: wordOf("history_verdict", entry.verdict), entry: entry.id }),
    word("chart_who", { who: entry.asked_by }), entry.reason].filter(Boolean);
}

/** A lane for each thing that is calibrated, and a mark for each entry.
 * @param {Map<string, any[]>} groups */
function timeline(groups) {
  const points = [...groups.values()].flatMap((entries, lane) => entries.map((entry) => ({
    x: secondsOf(entry.time), y: lane, mark: ledgerMarks[entry.verdict] ?? "hollow", ring: entry.in_force,
    lines: entryLines(entry) })));
  return [chart({ label: word("history_timeline"), yTitle: "", points, lanes: [...groups.keys()] }),
    chartLegend([["filled", word("history_verdict_installed")], ["cross", word("history_verdict_refused")],
      ["hollow", word("history_verdict_measured")], ["ringed", word("history_in_force")]])];
}

/** The charts of one thing's parameters.
 * @param {string} title @param {any[]} entries @param {string[]} names */
function parameterCharts(title, entries, names) {
  let inForce = /** @type {any} */ (null);
  const byId = new Map(entries.map((entry) => [entry.id, entry]));
  const rows = entries.map((entry) => {
    if (entry.verdict === "installed") inForce = entry;
    if (entry.verdict === "rolled-back") inForce = byId.get(entry.restores) ?? null;
    return { entry, inForce };
  });
  const charts = names.map((name) => {
    const found = rows.filter(({ entry }) => parameterOf(entry, name) || entry.verdict === "rolled-back").map((row) => {
      const { value, sigma } = parameterOf(row.entry, name) ?? { value: null, sigma: null };
      return { time: row.entry.time, value, sigma, mark: ledgerMarks[row.entry.verdict] ?? "hollow",
        state: wordOf("history_verdict", row.entry.verdict), who: row.entry.asked_by, entry: row.entry.id,
        inForce: row.inForce && parameterOf(row.inForce, name)?.value };
    });
    const unit = entries.map((entry) => parameterOf(entry, name)?.unit).find(Boolean) ?? "";
    return nightsChart({ title, name, unit, found });
  }).filter(Boolean);
  return charts.length
    ? [element("div", { class: "figures" }, charts), nightsLegend([...entries.map((entry) =>
      ledgerMarks[entry.verdict] ?? "hollow"), inForce ? "step" : ""])] : null;
}

/** Names of the parameters that two entries or more have. */
function sharedNames(entries) {
  const names = entries.flatMap((entry) => entry.parameters.map((one) => one.name));
  return [...new Set(names)].filter((name, i) => names.indexOf(name, names.indexOf(name) + 1) > 0);
}

/** Charts, made when they are asked for: a ledger of years has thousands of points.
 * @param {string} title @param {any[]} entries @param {boolean} isOpen */
function chartsOnDemand(title, entries, isOpen) {
  const names = sharedNames(entries);
  if (!names.length) return null;
  return unfolding(`${title}: ${names.join(", ")}`, () => parameterCharts(title, entries, names), { open: isOpen });
}

function entriesTable(entries) {
  return table([number(word("history_entry")), { title: word("history_time") },
    { title: word("history_subject") }, { title: word("history_verdict") }, { title: word("asked_by") },
    { title: word("history_reason"), text: true }],
  [...entries].reverse().map((entry) => [entry.id, timeText(secondsOf(entry.time)), subjectOf(entry),
    verdictChips(entry), entry.asked_by, entry.reason]));
}

/** All of one entry. */
function entrySection(entry) {
  /** @type {[import("../base/words.js").WordKey, any][]} */
  const rows = [["history_time", minuteText(entry.time)], ["asked_by", entry.asked_by],
    ["night_made_by", entry.software], ["history_reason", entry.reason],
    ["night_temperature", entry.temperature_degC === null ? "" : `${fixed(entry.temperature_degC, 1)}\u00a0\u00b0C`],
    ["history_replaces", entry.replaces], ["history_restores", entry.restores], ["history_hash", entry.hash],
    ["history_result_digest", entry.result_sha256]];
  return section(`entry-${entry.id}`, element("span", {}, word("history_entry_of", { id: entry.id, subject: subjectOf(entry) }),
    " ", verdictChips(entry)),
  rowList(rows.map(([key, value]) => [word(key), value]), ""),
  entry.parameters.length ? table([{ title: word("history_parameter") }, number(word("value")),
    number(word("sigma"))], entry.parameters.map((one) => {
    const sigma = parameterOf(entry, one.name)?.sigma;
    return [one.name, absolute(one.value, one.unit), sigma ? amount(sigma, one.unit) : "\u2013"];
  })) : null,
  entry.inputs.length ? element("details", {}, element("summary", {}, word("history_inputs", { n: whole(entry.inputs.length) })),
    table([{ title: word("history_file") }, number(word("history_bytes")), { title: "SHA-256" }],
      entry.inputs.map((input) => [input.name, whole(input.bytes), element("code", {}, input.sha256)]))) : null,
  entry.result === undefined ? null : element("details", {}, element("summary", {}, word("history_result")),
    element("pre", { class: "mono" }, JSON.stringify(entry.result, null, 1))));
}

function changesTable(difference) {
  return table([{ title: word("history_parameter") },
    number(word("history_before", { id: difference.before })),
    number(word("history_after", { id: difference.after })),
    number(word("night_change")), number(word("history_sigmas"))],
  difference.parameters.map((one) => [one.name, absolute(one.before, one.unit),
    absolute(one.after, one.unit), one.change === null ? "\u2013" : amount(one.change, one.unit, true),
    one.change_sigma ? fixed(one.change / one.change_sigma, 1, { signed: true }) : "\u2013"]));
}

function movedLines(moved) {
  const path = moved.path.length ? ` [${moved.path.join(",")}]` : "";
  return [place(moved.nominal_mm), word("history_moves", { x: fixed(1e3 * moved.shift_mm[0], 2, { signed: true }),
    y: fixed(1e3 * moved.shift_mm[1], 2, { signed: true }), length: fixed(1e3 * Math.hypot(...moved.shift_mm), 2) }),
  word("history_line", { file: moved.file ?? "", line: moved.line, tool: moved.tool }) + path];
}

/** How far the job's places move. */
function jobSection(job) {
  const shift = (/** @type {number[]} */ v) =>
    `(${v.map((one) => fixed(1e3 * one, 2, { signed: true })).join(", ")})\u00a0\u00b5m`;
  return section("job", word("history_job", { program: job.program }),
    element("dl", { class: "tiles" },
      tile(word("largest_shift"), micrometres(1e3 * job.max_mm, 2),
        job.uniform ? word("history_uniform") : word("history_at", { place: place(job.worst.nominal_mm) })),
      tile(word("history_p95"), micrometres(1e3 * job.p95_mm, 2), word("history_rms", { rms: micrometres(1e3 * job.rms_mm, 2) })),
      tile(word("history_mean_shift"), shift(job.mean_shift_mm), word("history_mean_remark")),
      tile(word("places"), whole(job.places), word("history_places_remark", { holes: whole(job.holes),
        targets: whole(job.targets) })),
      job.uncorrected ? tile(word("history_still"), whole(job.uncorrected), word("history_still_remark")) : null),
    panelArrows({ label: word("history_job", { program: job.program }), outline_mm: job.outline_mm, crosses_mm: job.targets_mm,
      places: [...job.sample, ...(job.uniform ? [] : [{ ...job.worst, isWorst: true }])].map((moved) => ({
        at_mm: moved.nominal_mm, vector_mm: moved.shift_mm, kind: moved.isWorst ? "refused" : "", lines: movedLines(moved) })) },
    word("history_arrows", { shown: whole(job.sample.length), all: whole(job.places) }),
    job.uniform ? "" : ` ${word("history_arrows_worst")}`),
    job.rout_moves_left_out ? element("p", { class: "quiet" }, word("history_no_routs")) : null,
    job.notes.map((/** @type {string} */ note) => element("p", { class: "quiet text", lang: "en" }, note)));
}

function verifySection(verification) {
  return section("verification", element("span", {}, word("history_verified"), " ", chip("good", word("history_undamaged"))),
    rowList([[word("history_entries"), whole(verification.entries)], [word("history_hash"), verification.head],
      [word("history_without_head"), whole(verification.without_head)]]),
    verification.held_against.length ? table([{ title: word("history_file") }, number(word("history_entry"))],
      verification.held_against.map((one) => [one.file, one.entry])) : null);
}

function entrySections(facts) {
  const { command, difference, entries, parameter } = facts;
  if (!entries?.length) return command === "verify" ? null : section("entries", word("history_entries"), word("history_no_entries"));
  if (difference) {
    return [section("parameters", word("history_parameters", { subject: subjectOf(entries[1]) }), changesTable(difference)),
      difference.job && jobSection(difference.job), difference.surface && differencePage(difference.surface),
      ...entries.map(entrySection)];
  }
  if (entries.length === 1 && !parameter) return entrySection(entries[0]);
  const groups = entriesBySubject(entries);
  if (parameter) {
    const subject = subjectOf(entries[0]);
    return [section("chart", `${parameter}: ${subject}`, parameterCharts(subject, entries, [parameter])),
      section("entries", word("history_entries"), entriesTable(entries))];
  }
  return [section("timeline", word("history_timeline"), timeline(groups)),
    section("charts", word("history_charts"), [...groups].map(([subject, group], i) => chartsOnDemand(subject, group, i === 0))),
    section("entries", word("history_entries"), entriesTable(entries))];
}

export const historyView = {
  facts: "history",
  show(facts) {
    document.title = word("history_title", { ledger: facts.ledger_file });
    return element("div", {}, element("h1", {}, document.title), entrySections(facts),
      facts.verification && verifySection(facts.verification),
      section("origin", word("origin"), rowList(Object.entries(facts.provenance))));
  },
};
