// SPDX-License-Identifier: Apache-2.0
// A batch of jobs: how many were drilled, what was found and how well, and why the others were not drilled.
import { chip, element, english, number, rowList, section, svg, table, tile } from "../base/dom.js";
import { fixed, micrometres, minuteText, percent, roundLevels, whole } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { targetThumbnail } from "../figures/target_picture.js";

const batchStates = { drilled: "good", held: "suspect", failed: "refused" };
const histogramWidth = 640;
const histogramEdge = { left: 56, right: 24, top: 10, bottom: 36 };
const histogramHeight = 170;

/**
 * Bars of counts, with a line of what is predicted of them.
 * @param {{label: string, caption: string, from: number, step: number, counts: number[], predicted: number[]}} content
 */
function histogram({ label, caption, from, step, counts, predicted }) {
  const { left, right, top, bottom } = histogramEdge;
  const most = Math.max(1, ...counts, ...predicted);
  const width = (histogramWidth - left - right) / counts.length;
  const x = (/** @type {number} */ i) => left + width * i;
  const y = (/** @type {number} */ n) => top + histogramHeight * (1 - n / most);
  const end = top + histogramHeight;
  const named = roundLevels(from, from + step * counts.length, 8);
  const line = predicted.map((n, i) => `${i === 0 ? "M" : "L"}${x(i)} ${y(n)}h${width}`).join("");
  return element("figure", {},
    svg("svg", { viewBox: `0 0 ${histogramWidth} ${end + bottom}`, width: histogramWidth, role: "img", "aria-label": label },
      roundLevels(0, most, 4).map((n) => [svg("path", { class: "gridline", d: `M${left} ${y(n)}H${histogramWidth - right}` }),
        svg("text", { x: left - 8, y: y(n) + 4, "text-anchor": "end" }, whole(n))]),
      counts.map((n, i) => n > 0 && svg("rect", { class: "fill-good", x: x(i) + 1, y: y(n), width: Math.max(1, width - 2), height: end - y(n) },
        svg("title", {}, `${fixed(from + step * i, 2)} \u2026 ${fixed(from + step * (i + 1), 2)}: ${whole(n)} (${fixed(predicted[i], 1)})`))),
      svg("path", { class: "axis", fill: "none", d: line }),
      named.map((at) => svg("text", { class: "middle", x: x((at - from) / step), y: end + 16 }, fixed(at, step < 0.1 ? 2 : 1))),
      svg("text", { class: "middle", x: (left + histogramWidth - right) / 2, y: end + 32 }, label)),
    element("figcaption", {}, caption));
}

/** Of a standard normal variable, below x. Abramowitz and Stegun 7.1.26: to 1.5e-7.
 * @param {number} x */
function normalBelow(x) {
  const t = 1 / (1 + 0.3275911 * Math.abs(x) / Math.SQRT2);
  const tail = t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))) * Math.exp(-x * x / 2);
  return x < 0 ? tail / 2 : 1 - tail / 2;
}

function batchTiles(facts) {
  const { jobs, targets, error, fits, holes } = facts;
  const seconds = facts.sessions.reduce((sum, one) => sum + one.seconds, 0);
  const done = facts.sessions.reduce((sum, one) => sum + one.n_jobs, 0);
  const pictures = facts.sessions.reduce((sum, one) => sum + one.n_pictures, 0);
  return element("dl", { class: "tiles" },
    tile(word("batch_drilled"), `${whole(jobs.drilled)} / ${whole(facts.n_jobs)}`,
      word("batch_not_drilled", { held: whole(jobs.held), failed: whole(jobs.failed), missing: whole(jobs.missing) })),
    tile(word("batch_found"), percent(targets.n ? targets.n_found / targets.n : null, 2),
      word("batch_found_of", { n: whole(targets.n_found), all: whole(targets.n) })),
    error && tile(word("truth"), micrometres(error.rms_um, 2),
      word("batch_error_text", { predicted: micrometres(error.predicted_rms_um, 2), max: micrometres(error.max_um, 2) })),
    fits.degrees_of_freedom > 0 && tile(word("batch_fits"), fixed(fits.chi_square / fits.degrees_of_freedom, 3), word("batch_fits_text", { n: whole(fits.n) })),
    tile(word("holes"), whole(holes.n_holes), word("batch_holes_text", { um: micrometres(holes.max_sigma_um, 2) })),
    seconds > 0 && tile(word("batch_rate"), word("batch_jobs_per_s", { n: fixed(done / seconds, 1) }),
      word("batch_rate_text", { pictures: fixed(pictures / seconds, 0), s: fixed(seconds, 1) })));
}

function refusalSection(facts) {
  if (facts.refusals.length === 0) return null;
  return section("refusals", word("batch_refusals"),
    table([number(word("batch_jobs")), { title: word("batch_state") }, { title: word("batch_code") }, { title: word("batch_example"), text: true }],
      facts.refusals.map((one) => [whole(one.n_jobs), chip(batchStates[/** @type {"held"} */ (one.state)], wordOf("batch_state", one.state)),
        one.code, [one.example_id, ": ", english(one.example)]])),
    element("details", {}, element("summary", {}, word("batch_list", { n: whole(facts.not_drilled.length) })),
      table([{ title: word("batch_job") }, { title: word("batch_state") }, { title: word("batch_code") }, { title: "", text: true }],
        facts.not_drilled.map((one) => [one.id, wordOf("batch_state", one.state), one.code, english(one.message)]))));
}

function errorSection(facts) {
  const { error } = facts;
  if (!error) return null;
  const sum = 2 * error.n;
  const at = (/** @type {number} */ i) => normalBelow(error.normalized_from + error.normalized_step * i);
  return section("error", word("batch_errors"),
    histogram({ label: word("batch_error_axis"), caption: word("batch_error_caption", { beyond: whole(error.counts.at(-1)) }), from: 0, step: error.step_um,
      counts: error.counts.slice(0, -1), predicted: error.predicted.slice(0, -1) }),
    histogram({ label: word("batch_normalized_axis"), caption: word("batch_normalized_caption", { beyond: whole(error.normalized_beyond), ratio: fixed(error.chi_square / sum, 3) }),
      from: error.normalized_from, step: error.normalized_step, counts: error.normalized_counts,
      predicted: error.normalized_counts.map((/** @type {number} */ _, /** @type {number} */ i) => sum * (at(i + 1) - at(i))) }));
}

function fitSection({ fits }) {
  if (fits.n === 0) return null;
  const n = fits.exceedance_counts.length;
  return section("fits", word("batch_calibration"),
    histogram({ label: word("batch_exceedance_axis"), caption: word("batch_exceedance_caption", { n: whole(fits.n) }), from: 0, step: 1 / n,
      counts: fits.exceedance_counts, predicted: Array(n).fill(fits.n / n) }));
}

function conditionSection({ conditions, drift }) {
  return [conditions.length > 0 && section("conditions", word("batch_conditions"),
    table([{ title: word("batch_factor") }, number(word("batch_jobs")), number(word("batch_targets")), number(word("batch_found")), number(word("rms")), number(word("batch_predicted"))],
      conditions.map((one) => [`${one.factor} = ${one.value}`, whole(one.n_jobs), whole(one.n_targets), percent(one.found_rate, 2), fixed(one.error_rms_um, 3), fixed(one.predicted_rms_um, 3)]))),
  drift.length > 0 && section("drift", word("batch_drift"),
    table([{ title: word("batch_machine") }, { title: word("batch_day") }, number(word("batch_fits_column")), number("x mm"), number("y mm"), number("mrad"), number("x ppm"), number("y ppm"), number("\u03c7\u00b2 / n")],
      drift.map((one) => [one.machine, one.day, whole(one.n_fits), fixed(one.shift_x_mm, 4), fixed(one.shift_y_mm, 4), fixed(1e3 * one.rotation_rad, 4),
        fixed(one.stretch_x_ppm, 1), fixed(one.stretch_y_ppm, 1), fixed(one.chi_square_ratio, 3)])))];
}

function worstSection(facts, pictures) {
  if (facts.worst.length === 0) return null;
  return section("worst", word("batch_worst"),
    table([{ title: word("serve_picture") }, { title: word("batch_job") }, { title: word("target") }, { title: word("batch_state") },
      number(word("batch_error_column")), number(word("batch_residual")), number("\u03c3 \u00b5m")],
    facts.worst.map((one) => [one.crop && pictures[one.crop.name] ? targetThumbnail(one.crop, pictures[one.crop.name], `${one.id} #${one.seq}`, one.state === "good") : "\u2013",
      one.id, `#${one.seq} ${one.image}`, wordOf("status", one.status), fixed(one.error_um, 3), fixed(one.residual_um, 3), fixed(one.sigma_um, 3)])));
}

export const batchView = {
  facts: "batch",
  show(facts, pictures) {
    return element("div", {}, element("h1", {}, word("batch_title"), " ", element("b", {}, facts.manifest)),
      section("summary", word("batch_summary"), batchTiles(facts)),
      refusalSection(facts), errorSection(facts), fitSection(facts), conditionSection(facts), worstSection(facts, pictures),
      section("provenance", word("origin"), rowList([[word("batch_clock"), facts.clock], ["sha256", facts.manifest_sha256],
        ...facts.sessions.map((one) => [minuteText(one.started), word("batch_session", { jobs: whole(one.n_jobs), s: fixed(one.seconds, 1), threads: one.threads })])])));
  },
};
