// SPDX-License-Identifier: Apache-2.0
// What `panelcal surface` states: a map of heights, the difference of two, or where to probe.
import { colour, differenceColour } from "../base/colours.js";
import { columnOf, wordsOf } from "../base/columns.js";
import { element, english, rowList, section, table, tile, unfolding } from "../base/dom.js";
import { fixed, micrometres, millimetres, percent, place, probability, whole, withSigma } from "../base/format.js";
import { word } from "../base/words.js";
import { fieldAt, fieldOf } from "../figures/field.js";
import { drawBlanks, drawCrosses, drawProbes, fieldFigure, fromLowToHigh, residualFigure, spaceFigure, zoneFigure } from "../figures/surface_map.js";

/** @typedef {import("../figures/plane.js").Point} Point */

/** "probes.jsonl:13" */
const readAt = (probe) => (probe.file ? `${probe.file}:${probe.line}` : "");

/** @param {Record<string, unknown>[] | string[]} names */
const columnsOf = (...names) => names.map((name) => ({ title: word(/** @type {any} */ (name)), number: !["probe", "surface_read_at", "why"].includes(String(name)) }));

function zoneTiles(zone) {
  const { lowest, highest, worst_sigma: worst } = zone;
  return element("dl", { class: "tiles" },
    tile(word("surface_heights_tile"), `${fixed(lowest.height_mm, 3)} \u2026 ${millimetres(highest.height_mm)}`,
      word("surface_range", { um: micrometres(1e3 * (highest.height_mm - lowest.height_mm)) })),
    tile(word("surface_sigma_tile"), micrometres(worst.sigma_um, 2), word("surface_sigma_text", { place: place(worst.at_mm), usual: micrometres(zone.usual_sigma_um, 2) })),
    tile(word("surface_residual_tile"), micrometres(zone.residual_rms_um, 2), word("surface_residual_text", { um: micrometres(zone.stated_rms_um, 2) })),
    tile(word("surface_left_out"), whole(zone.left_out.length), word("surface_of_probes", { n: whole(zone.probes) })),
    tile(word("surface_filled_tile"), percent(zone.filled_share), word("surface_filled_text", { n: zone.filled.length })),
    tile(word("surface_lattice_tile"), micrometres(zone.lattice_error_um, 2), word("surface_lattice_text")));
}

function leftOutTable(zone) {
  if (zone.left_out.length === 0) return element("p", {}, word("surface_none_left_out"));
  return [element("h3", {}, word("surface_left_out")),
    table(columnsOf("probe", "surface_read_at", "surface_place", "height_mm", "surface_deviation", "history_sigmas", "surface_chance"),
      zone.left_out.map((one) => [one.name, readAt(one), place(one.place_mm), fixed(one.height_mm, 4),
        fixed(one.deviation_mm, 4, { signed: true }), fixed(Math.abs((1e3 * one.deviation_mm) / one.sigma_um), 1), probability(one.chance)]))];
}

function keptTable(zone) {
  const { kept } = zone, names = wordsOf(kept.name), files = wordsOf(kept.file);
  const [x_mm, y_mm, height_mm, residual_um, deviation_um, chance, line] =
    ["x_mm", "y_mm", "height_mm", "residual_um", "deviation_um", "chance", "line"].map((key) => columnOf(kept[key]));
  return unfolding(word("surface_all_probes", { n: whole(names.length) }), () => table(columnsOf("probe", "surface_read_at", "surface_place", "height_mm", "surface_off_surface", "surface_off_others", "surface_chance"),
    names.map((name, i) => [name, readAt({ file: files[i], line: line[i] }), place([x_mm[i], y_mm[i]]), fixed(height_mm[i], 4),
      fixed(residual_um[i], 2, { signed: true }), fixed(deviation_um[i], 2, { signed: true }), probability(chance[i])])));
}

/** @param {number} i */
function zoneSection(facts, zone, i) {
  const heights = fieldOf(zone.field, zone.field.height_mm), sigmas = fieldOf(zone.field, zone.field.sigma_um);
  const all = { zone, facts, heights, sigmas };
  return section(`zone-${i}`, zone.name ? word("surface_zone", { name: zone.name }) : word("surface_whole"),
    element("p", { lang: "en" }, element("b", {}, zone.summary)), element("p", { class: "quiet", lang: "en" }, `${zone.reason}.`), zoneTiles(zone),
    element("div", { class: "figures" }, zoneFigure({ ...all, isHeights: true }), zoneFigure({ ...all, isHeights: false }),
      spaceFigure(zone, heights), residualFigure(zone)),
    element("p", { class: "quiet text" }, word("surface_map_text", { mm: millimetres(zone.max_extrapolation_mm, 1) })),
    leftOutTable(zone), keptTable(zone));
}

/**
 * Probes that make no surface, and why.
 * @param {string} id
 * @param {"surface_unused" | "surface_missing"} title
 */
function refusedSection(id, title, probes) {
  return probes.length === 0 ? null : section(id, word(title), table(columnsOf("probe", "surface_read_at", "surface_place", "why"),
    probes.map((one) => [one.name, readAt(one), place(one.place_mm), english(one.reason)])));
}

function mapPage(facts) {
  const { voids } = facts, round = columnOf(voids.circles.x_mm).length, routed = voids.tracks.length;
  return [element("h1", {}, word("surface_map_title"), " ", element("b", {}, facts.map)),
    facts.zones.map((zone, /** @type {number} */ i) => zoneSection(facts, zone, i)),
    voids.count === 0 ? null : section("voids", word("surface_voids"), element("p", {}, word("surface_voids_text", {
      n: whole(voids.count), round: whole(round), routed: whole(routed), other: whole(voids.count - round - routed), mm: millimetres(voids.margin_mm, 2) }))),
    refusedSection("unused", "surface_unused", facts.unused), refusedSection("missing", "surface_missing", facts.missing)];
}

export function differencePage(facts) {
  const chance = (part) => word(part.chance < 0.01 ? "surface_part_changed" : "surface_part_scatter", { chance: probability(part.chance) });
  const one = (name, value, /** @type {string} */ unit, part) =>
    value ? tile(word(name), withSigma(value.value, value.sigma, unit), chance(part)) : null;
  const field = fieldOf(facts.field, facts.field.difference_um);
  const places = facts.common_mm;
  return [element("h1", {}, word("surface_diff_title"), " ", element("b", {}, facts.before), " \u2192 ", element("b", {}, facts.after)),
    element("div", { class: `verdict ${facts.changed ? "forced" : ""}` },
      element("p", {}, word(facts.changed ? "surface_changed" : "surface_unchanged", { chance: probability(facts.all.chance) })),
      element("p", { class: "quiet" }, word("surface_compared", { n: whole(facts.probes), outside: whole(facts.outside) })),
      element("dl", { class: "tiles" }, one("surface_offset", facts.offset_um, "\u00b5m", facts.offset),
        one("surface_tilt_x", facts.tilt_x_um_m, "\u00b5m/m", facts.tilt), one("surface_tilt_y", facts.tilt_y_um_m, "\u00b5m/m", facts.tilt),
        one("surface_bow_x", facts.bow_x_um, "\u00b5m", facts.bow), one("surface_bow_y", facts.bow_y_um, "\u00b5m", facts.bow),
        one("surface_twist", facts.twist_um, "\u00b5m", facts.bow),
        facts.rest ? tile(word("surface_rest"), probability(facts.rest.chance), chance(facts.rest)) : null,
        tile(word("surface_greatest"), withSigma(facts.greatest_um, facts.greatest_sigma_um, "\u00b5m"),
          `${place(facts.greatest_at_mm)}; ${word("surface_rms", { um: micrometres(facts.rms_um, 2) })}`))),
    section("difference", word("surface_difference"), fieldFigure({
      field, outline: places, title: "", label: word("surface_difference"), unit: "\u00b5m", n_levels: 9, isSymmetric: true,
      caption: word("surface_difference_text"), paint: (value, low, high) => differenceColour(value / high),
      over: (plane) => {
        drawProbes(plane, facts.probes_before_mm, true);
        drawProbes(plane, facts.probes_after_mm);
        plane.stroke(colour("bad"), () => plane.traceCircle(facts.greatest_at_mm, 10), 2.2);
      },
      hint: (at) => {
        const value = fieldAt(field, at);
        return Number.isNaN(value) ? null : [place(at), `${fixed(value, 2, { signed: true })}\u00a0\u00b5m`];
      },
    }))];
}

function planPage(facts) {
  const field = fieldOf(facts.field, facts.field.sigma_um), stops = /** @type {Point[]} */ (facts.probes_mm);
  const y_mm = columnOf(facts.pictured_places.y_mm), x_mm = columnOf(facts.pictured_places.x_mm);
  const values = { n: whole(stops.length), um: micrometres(facts.tolerance_um, 2), places: whole(facts.places) };
  const sigma = (worst) => micrometres(worst.sigma_um, 2);
  return [element("h1", {}, word("surface_plan_title")),
    element("div", { class: `verdict ${facts.reached ? "" : "hold"}` },
      element("p", {}, !facts.reached ? [word("surface_plan_unreached", values), " ", english(facts.reason)] :
        word(stops.length > 0 ? "surface_plan_made" : "surface_plan_enough", values)),
      !facts.worst ? null : element("dl", { class: "tiles" },
        tile(word("surface_worst_planned"), sigma(facts.worst), `${place(facts.worst.at_mm)}${facts.before ? `; ${word("surface_before", { um: sigma(facts.before) })}` : ""}`),
        stops.length === 0 ? null : tile(word("surface_grid_tile"), facts.grid ? whole(facts.grid.columns * facts.grid.rows) : "\u2013",
          facts.grid ? word("surface_grid_text", { columns: facts.grid.columns, rows: facts.grid.rows, um: sigma(facts.grid.worst) }) : word("surface_no_grid")),
        stops.length === 0 ? null : tile(word("surface_way"), millimetres(facts.way_mm, 0), word("surface_way_text")))),
    section("sigma", word("surface_planned_sigma"), fieldFigure({
      field, outline: facts.outline_mm, title: "", label: word("surface_planned_sigma"), unit: "\u00b5m", n_levels: 6,
      isCounted: (i) => facts.field.source[i] !== "b", paint: fromLowToHigh, caption: word("surface_plan_text", { belief: facts.belief }),
      over: (plane) => {
        drawBlanks(plane, facts.voids, facts.border_mm);
        plane.drawDots(x_mm, y_mm, 0.6);
        drawProbes(plane, facts.present_mm, true);
        plane.drawTour(stops);
      },
      hint: (at) => {
        const value = fieldAt(field, at);
        return Number.isNaN(value) ? null : [place(at), micrometres(value, 2)];
      },
    })),
    stops.length === 0 ? null : section("stops", word("surface_stops"), element("ol", { class: "columns" }, stops.map((at) => element("li", {}, place(at)))))];
}

const surfacePages = /** @type {Record<string, (facts: any) => any>} */ ({ fit: mapPage, diff: differencePage, plan: planPage });

export const surfaceView = {
  facts: "surface",
  show(facts) {
    const page = surfacePages[facts.command];
    return element("div", {}, page ? page(facts) : element("p", {}, word("surface_other")),
      section("provenance", word("origin"), rowList([...(facts.sources ?? []).map((/** @type {any} */ one) => [`read ${one.file}`, `format ${one.format}; unit ${one.unit}; from ${one.zero}`]), ...(facts.provenance ?? [])])));
  },
};
