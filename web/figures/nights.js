// SPDX-License-Identifier: Apache-2.0
// One value over nights or entries of a ledger, against the one in force now.
import { absolute, amount, fixed, minuteText, secondsOf, shownUnit } from "../base/format.js";
import { word } from "../base/words.js";
import { chart, chartLegend } from "./chart.js";

/**
 * A value that was found: `state` in words, `who` and `entry` of its place in the ledger, `inForce` the
 * value that holes are drilled with after it. Without a value it only states that.
 * @typedef {{time: string, value: number | null, sigma?: number | null, mark: "filled" | "hollow" | "cross",
 *            state: string, who?: string, entry?: number | null, inForce?: number | null, alarm?: boolean,
 *            freshStart?: boolean}} Found
 *
 * `expected` is the last one as those before predicted it.
 * @typedef {{title: string, name: string, unit: string, found: Found[], tolerance?: number | null,
 *            expected?: number | null, expectedSigma?: number | null}} Nights
 */

/** Of what was predicted, this many standard deviations are shown. */
const predictedSigmas = 3;

/** @param {Found} one @param {string} unit @param {number} zero @param {number | null | undefined} tolerance */
function foundLines(one, unit, zero, tolerance) {
  const sigma = one.sigma ? ` \u00b1 ${amount(one.sigma, unit)}` : "";
  return [
    minuteText(one.time),
    `${absolute(one.value, unit)} (${amount((one.value ?? 0) - zero, unit, true)}${sigma})`,
    one.entry ? word("chart_entry", { state: one.state, entry: one.entry }) : one.state,
    one.who ? word("chart_who", { who: one.who }) : "",
    one.inForce !== null && one.inForce !== undefined
      ? word("chart_in_force_then", { value: absolute(one.inForce, unit) }) : "",
    tolerance ? word("chart_limit_line", { limit: amount(tolerance, unit) }) : "",
    one.alarm ? word("chart_alarm_line") : "",
    one.freshStart ? word("chart_fresh_line") : "",
  ].filter(Boolean);
}

/**
 * The chart, or null where fewer than two values are there.
 * @param {Nights} nights
 */
export function nightsChart(nights) {
  const { unit, tolerance } = nights;
  const found = nights.found.filter((one) => one.value !== null && Number.isFinite(one.value));
  const last = found[found.length - 1];
  if (found.length < 2) return null;
  // What came into force later without a value of its own: going back.
  const inForceNow = nights.found[nights.found.length - 1].inForce ?? null;
  const zero = inForceNow ?? last.value ?? 0;
  const shown = shownUnit(unit);
  const scaled = (/** @type {number} */ value) => (value - zero) * shown.factor;
  const lastFresh = found.map((one) => Boolean(one.freshStart)).lastIndexOf(true);
  const isShown = (/** @type {Found} */ one) => lastFresh < 0 || one.time >= found[lastFresh].time;
  const { expected, expectedSigma } = nights;
  const half = predictedSigmas * (expectedSigma ?? NaN) * shown.factor;
  // The nights before tell nothing of a fresh start.
  const isPredicted = expected !== null && expected !== undefined && Number.isFinite(half) && !last.freshStart;
  return chart({
    label: word("chart_label", { name: nights.name, title: nights.title, n: found.length }),
    yTitle: shown.name ? `${nights.name}, ${shown.name}` : nights.name,
    points: found.map((one, i) => ({
      x: secondsOf(one.time), y: scaled(one.value ?? 0), sigma: one.sigma && one.sigma * shown.factor,
      mark: one.mark, ring: one.alarm, counts: i >= lastFresh,
      beyond: amount((one.value ?? 0) - zero, unit, true), lines: foundLines(one, unit, zero, tolerance),
    })),
    steps: nights.found.filter((one) => isShown(one) && one.inForce !== null && one.inForce !== undefined)
      .map((one) => ({ x: secondsOf(one.time), y: scaled(one.inForce ?? 0) })),
    box: isPredicted ? { x: secondsOf(last.time), low: scaled(expected) - half, high: scaled(expected) + half } : null,
    limits: tolerance ? [-tolerance * shown.factor, tolerance * shown.factor] : [],
    marks: found.filter((one) => one.freshStart).map((one) => secondsOf(one.time)),
  }, word(inForceNow === null ? "chart_against_last" : "chart_against",
    { name: nights.name, zero: absolute(zero, unit) }),
  tolerance ? ` ${word("chart_tolerance", { limit: fixed(tolerance * shown.factor, 1), unit: shown.name })}` : null);
}

/** The key of those charts.
 * @param {string[]} marks those that occur */
export function nightsLegend(marks) {
  /** @type {[string, string][]} */
  const rows = [
    ["filled", word("chart_filled")], ["hollow", word("history_verdict_measured")], ["cross", word("history_verdict_refused")],
    ["ring", word("chart_ring")], ["ringed", word("history_in_force")], ["step", word("history_in_force")], ["event", word("chart_event")],
    ["limit", word("chart_limit")], ["band", word("chart_box")],
  ];
  return chartLegend(rows.filter(([mark]) => marks.includes(mark)));
}
