// SPDX-License-Identifier: Apache-2.0
// The plan of a program's targets: what their noise does to the holes, and what would help.
import { colour } from "../base/colours.js";
import { element, number, rowList, section, table, tile } from "../base/dom.js";
import { fixed, micrometres, millimetres, percent, place, whole } from "../base/format.js";
import { greatestSigma } from "../base/leverage.js";
import { word, wordOf } from "../base/words.js";
import { inForce, leverageFigure, timesText, Trial } from "../figures/leverage_map.js";
import { extentOf, Plane } from "../figures/plane.js";

/** @typedef {import("../figures/plane.js").Point} Point */

// Of longer lists the page shows the first; the facts have all.
const mostErrorRows = 60;
const reachOfStop_px = 12;

/** "hole (10.000, 5.000) mm, line 17, T2, copy 0,1" */
function placeText(at) {
  const parts = [place(at.nominal_mm), word("plan_line", { line: at.line })];
  if (at.file) parts.push(at.file);
  if (at.is !== "target" && at.tool) parts.push(`T${at.tool}`);
  if (at.path) parts.push(word("plan_copy", { path: `[${at.path.join(",")}]` }));
  return parts.join(", ");
}

function seriesTitle(series) {
  const lines = series.targets.map((one) => one.line);
  const path = series.targets[0]?.path;
  return word(series.level === "base" ? "plan_panel" : "plan_board", {
    copy: path ? ` [${path.join(",")}]` : "", n: series.targets.length, model: wordOf("model", series.model),
    lines: `${Math.min(...lines)}\u2013${Math.max(...lines)}`,
  });
}

/** What stands in the series' place among the others. */
function seriesNote(facts, series) {
  if (series.places_are === "targets") return word("plan_serves_targets");
  if (series.level === "base" || facts.nested_series < 2) return null;
  if (series !== facts.series.at(-1)) return word("plan_first_board", { n: facts.nested_series });
  if (facts.like_worst === facts.nested_series) return word("plan_all_boards", { n: facts.nested_series });
  return word("plan_worst_board", { n: facts.nested_series, others: facts.like_worst - 1 });
}

/** The size of an error of one target from which on it is noticed, where that is largest. */
function noticedText(error) {
  if (!error) return "\u2013";
  return error.noticed_from_um === null ? word("plan_never_noticed") : micrometres(error.noticed_from_um);
}

function seriesTiles(facts, series) {
  const model = inForce(series);
  const latest = series.targets.map((one) => one.error).filter(Boolean)
    .reduce((most, one) => (most === null || most.noticed_from_um === null ? most ?? one :
      one.noticed_from_um === null || one.noticed_from_um > most.noticed_from_um ? one : most), null);
  const best = series.additions.find((one) => one.determined);
  const hasPlaces = series.places > 0;
  return element("dl", { class: "tiles" },
    model.determined && hasPlaces ? tile(word("worst_place"), timesText(model.worst_leverage),
      `${micrometres(model.worst_um, 2)}; ${placeText(model.worst_at)}`) : null,
    model.determined && hasPlaces ? tile(word("plan_total_tile"), micrometres(model.total_um, 2),
      word("plan_mean_tile", { mean: timesText(model.mean_leverage) })) : null,
    series.worst_leverage_if_chosen ? tile(word("plan_chosen_tile"),
      series.worst_leverage_if_chosen.map(timesText).join(" \u2026 "), word("plan_chosen_text")) : null,
    latest ? tile(word("plan_noticed_tile"), noticedText(latest), latest.at_once ?
      word("plan_named_tile", { once: percent(latest.at_once.named / latest.at_once.cases, 0),
        twice: latest.at_twice ? percent(latest.at_twice.named / latest.at_twice.cases, 0) : "\u2013" }) : "") : null,
    hasPlaces ? tile(word("plan_outside_tile"), `${whole(series.outside)} / ${whole(series.places)}`,
      series.outside > 0 ? word("plan_farthest", { mm: millimetres(series.farthest_mm, 1), place: placeText(series.farthest_at) }) :
        word("plan_all_inside")) : null,
    best ? tile(word("plan_best_tile"), `${timesText(best.worst_leverage)}`,
      word("plan_best_text", { n: best.pads.length, places: best.pads.map(placeText).join("; "), model: wordOf("model", best.model) })) : null);
}

function modelTable(series) {
  const columns = [{ title: word("model") }, number(word("plan_dof")),
    number(word("plan_worst_column")), number("\u00b5m"),
    number(word("plan_total_column")), number(word("plan_mean_column")),
    number(word("plan_noticed_column")), { title: word("plan_where_column") }];
  return table(columns, series.models.map((one) => {
    const name = one.model === series.model ? element("b", {}, `\u25b8\u00a0${wordOf("model", one.model)}`) : wordOf("model", one.model);
    if (!one.determined) return [name, "\u2013", "", "", "", "", "", wordOf("plan_reason", one.reason)];
    const isEven = one.worst_leverage <= one.mean_leverage * (1 + 1e-9);
    return [name, one.dof, fixed(one.worst_leverage, 2), fixed(one.worst_um, 2), fixed(one.total_um, 2), fixed(one.mean_leverage, 2),
      "noticed_from_um" in one ? noticedText(one) : "\u2013",
      !one.worst_at ? "\u2013" : isEven && series.places > 1 ? word("plan_even") : placeText(one.worst_at)];
  }));
}

/** What a wrong target does, and from which size it is noticed. */
function errorTable(facts, series) {
  if (!series.targets.some((one) => one.error)) return null;
  const trial = new Trial(facts, series);
  const share = (tried) => (tried ? percent(tried.named / tried.cases, 0) : "\u2013");
  const columns = [{ title: word("target") }, number(word("plan_noticed_column")),
    { title: word("plan_noticed_by") }, number(word("plan_moves_column")),
    number(word("plan_named_column")), number(word("plan_named_twice"))];
  const rows = series.targets.slice(0, mostErrorRows).map((one, /** @type {number} */ i) => {
    const { most_um, isNoticed } = trial.shiftOf(i);
    return [placeText(one), noticedText(one.error), one.error?.noticed_by ? wordOf("gate", one.error.noticed_by) : "\u2013",
      isNoticed && series.places > 0 ? micrometres(most_um) : "\u2013", share(one.error?.at_once), share(one.error?.at_twice)];
  });
  return [element("h3", {}, word("plan_errors")), element("p", { class: "quiet text" },
    word("plan_errors_text", { share: percent(facts.noticed_share, 0) })), table(columns, rows),
    series.targets.length > mostErrorRows ? element("p", { class: "quiet" }, word("plan_more", { n: series.targets.length - mostErrorRows })) : null];
}

/** @param {number} i */
function seriesSection(facts, series, i) {
  const model = inForce(series), note = seriesNote(facts, series);
  return section(`series-${i}`, seriesTitle(series), note ? element("p", { class: "quiet" }, note) : null,
    model.determined ? null : element("p", { class: "next" },
      word("plan_refused", { model: wordOf("model", series.model), reason: wordOf("plan_reason", model.reason) })),
    seriesTiles(facts, series), element("h3", {}, word("plan_map")), leverageFigure(facts, series),
    element("p", { class: "quiet text" }, additionTexts(series).join(" ")),
    element("h3", {}, word("plan_models")), modelTable(series), errorTable(facts, series));
}

/** Why there is no further pad, or how far the search went. */
function additionTexts(series) {
  const out = [];
  if (series.has_slots) out.push(word("plan_no_slots"));
  else if (series.models_with.length === 0 && series.places > 0) out.push(word("plan_no_pattern"));
  for (const one of series.additions) {
    if (!one.determined) out.push(word("plan_pads_do_not_determine", { n: one.pads.length }));
    if (one.worst_leverage_if_model_kept && one.worst_leverage_if_model_kept < 0.99 * one.worst_leverage) {
      out.push(word("plan_if_kept", { n: one.pads.length, model: wordOf("model", series.model), leverage: timesText(one.worst_leverage_if_model_kept),
        other: wordOf("model", one.model) }));
    }
    if (!one.best) out.push(word("plan_by_search", { n: one.pads.length }));
  }
  if (series.thinned) out.push(word("plan_thinned", { n: whole(series.candidates.x_mm.length) }));
  return out;
}

function visitSection(facts) {
  const { visits } = facts;
  const n = visits.x_mm.length;
  if (n < 2) return null;
  const places = /** @type {Point[]} */ (visits.x_mm.map((/** @type {number} */ x, /** @type {number} */ i) => [x, visits.y_mm[i]]));
  let order = visits.free;
  const figure = new Plane({
    extent: extentOf(places), label: word("plan_visits"), most_px: 480,
    draw: (plane) => {
      plane.stroke(colour("quiet"), () => plane.traceWay(places), 1.4, [2, 5]);
      plane.drawTour(order.map((/** @type {number} */ i) => places[i]));
    },
    hint: (at, plane) => {
      const k = order.findIndex((/** @type {number} */ i) => Math.hypot(places[i][0] - at[0], places[i][1] - at[1]) < reachOfStop_px / plane.scale);
      return k < 0 ? null : [word("plan_stop", { k: k + 1, line: visits.line[order[k]], seq: order[k] }), place(places[order[k]])];
    },
  });
  const choose = element("select", { "aria-label": word("plan_visits"), onchange: () => {
    order = choose.value === "free" ? visits.free : visits.within_series;
    figure.redraw();
  } }, element("option", { value: "free" }, word("plan_order_free")), element("option", { value: "within" }, word("plan_order_within")));
  const length = (/** @type {number} */ mm) => millimetres(mm, 1) +
    (visits.programmed_mm > 0 ? ` (${percent(mm / visits.programmed_mm - 1, 0)})` : "");
  return section("visits", word("plan_visits"), element("dl", { class: "tiles" },
    tile(word("plan_way_written"), millimetres(visits.programmed_mm, 1), ""),
    tile(word("plan_order_within"), length(visits.within_series_mm), word("plan_way_within")),
    tile(word("plan_order_free"), length(visits.free_mm), word(visits.exact ? "plan_way_exact" : "plan_way_search"))),
    element("figure", {}, element("div", { class: "controls" }, choose), figure.node, element("figcaption", {}, word("plan_visits_text"))));
}

function noiseText(facts) {
  const { noise } = facts;
  const machine_um = greatestSigma(noise.hole_um2);
  return [noise.recorded ? word("plan_noise_recorded", { source: noise.source }) :
    word(noise.assumed ? "plan_noise_assumed" : "plan_noise", { um: micrometres(noise.target_um, 2) }),
  noise.stage_um > 0 || noise.table_um > 0 ? word("plan_noise_machine", { stage: micrometres(noise.stage_um, 2), table: micrometres(noise.table_um, 2) }) : null,
  machine_um > 0 ? word("plan_noise_hole", { um: micrometres(machine_um, 2) }) : null,
  facts.model_rule === "auto" ? word("plan_rule_auto") : facts.model_rule === "smooth" ? word("plan_rule_smooth") : null,
  word("plan_x_means")].filter(Boolean).join(" ");
}

export const planView = {
  facts: "plan",
  show(facts) {
    const shown = facts.series.filter((one) => one.level === "base").length;
    return element("div", {}, element("h1", {}, word("plan_title"), " ", element("b", {}, facts.program),
      facts.machine ? [" ", word("plan_on"), " ", element("b", {}, facts.machine)] : null),
    section("noise", word("plan_knows"), element("p", { class: "text" }, noiseText(facts)),
      facts.series.length === 0 ? element("p", { class: "next" }, word("plan_no_series")) : null,
      facts.uncorrected > 0 && facts.series.length > 0 ? element("p", {}, word("plan_uncorrected", { n: whole(facts.uncorrected) })) : null,
      facts.own_target > 0 ? element("p", {}, word("plan_own_target", { n: whole(facts.own_target) })) : null,
      facts.base_series > shown ? element("p", {}, word("plan_left_out", { n: facts.base_series - shown })) : null),
    facts.series.map((series, /** @type {number} */ i) => seriesSection(facts, series, i)),
    visitSection(facts),
    section("provenance", word("origin"), rowList(facts.provenance)));
  },
};
