// SPDX-License-Identifier: Apache-2.0
// A calibration made by hand: its values, what became of it, its residuals, and the map of a table.
import { element, english, rowList, section, table, tile } from "../base/dom.js";
import { absolute, amount, fixed, micrometres, millimetres, place, probability, secondsOf, shortest, timeText, whole } from "../base/format.js";
import { greatestSigma } from "../base/leverage.js";
import { word, wordOf } from "../base/words.js";
import { fieldAt, fieldOf } from "../figures/field.js";
import { focusCurve } from "../figures/job_charts.js";
import { panelArrows } from "../figures/panel_arrows.js";
import { fieldFigure, fromLowToHigh } from "../figures/surface_map.js";
import { differencePage } from "./surface.js";

const calibrationVerdicts = { refused: " hold", measured: " forced" };

/** @param {string} key its end is the unit @param {any} value */
function calibrationValue(key, value) {
  if (Array.isArray(value) && typeof value[0] === "string") return value.map((one) => element("div", { lang: "en" }, one));
  if (typeof value === "string") return english(value);
  if (typeof value === "boolean") return word(value ? "calibration_yes" : "calibration_no");
  if (key.endsWith("chance")) return probability(value);
  if (key === "before_mm") return place(value);
  const texts = [value].flat().map((one) => (key.endsWith("_um") ? micrometres(one, 2) : key.endsWith("_px") ? `${fixed(one, 3)}\u00a0px`
    : key.endsWith("_mm") ? millimetres(one, 4) : key.endsWith("_s") ? `${fixed(one, 3)}\u00a0s` : shortest(one)));
  return Array.isArray(value) ? `(${texts.join(", ")})` : texts[0];
}

/** Figures of the fit: what is no list and no object of its own.
 * @param {any} part */
function calibrationRows(part) {
  const isRow = (/** @type {any} */ value) => value !== null && value !== "" &&
    (typeof value !== "object" || (Array.isArray(value) && value.length > 0 && typeof value[0] !== "object"));
  return rowList(Object.entries(part).filter(([, value]) => isRow(value)).map(([key, value]) =>
    [wordOf("calibration_row", key), calibrationValue(key, value)]), "");
}

/** @param {any} facts */
function calibratedValues(facts) {
  return section("values", word("calibration_values"), table(
    [{ title: word("history_parameter") }, { title: word("value"), number: true }, { title: word("sigma"), number: true }],
    facts.parameters.map((one, i) =>
      [one.name, absolute(one.value, one.unit), facts.covariance ? amount(Math.sqrt(facts.covariance[i][i]), one.unit) : "\u2013"])));
}

/** @param {number[]} vector_um */
function vectorText(vector_um) {
  return `(${vector_um.map((one) => fixed(one, 2, { signed: true })).join(", ")})\u00a0\u00b5m`;
}

/** Residuals as arrows in mm: a picture's lie in the plane of the panel, from its lower left corner.
 * @param {any} facts @param {any} part */
function calibrationResiduals(facts, part) {
  if (!part.residuals?.length) return null;
  const isCamera = facts.kind === "camera";
  const scale_mm = isCamera ? facts.parameters.find((one) => one.name === "scale").value : 1;
  const [width_px, height_px] = part.picture_px ?? [0, 0];
  const places = part.residuals.map((one) => {
    const [x, y] = one.at_px ?? [], [u, v] = one.residual_px ?? [];
    const at_mm = isCamera ? [scale_mm * x, scale_mm * (height_px - y)] : one.at_mm ?? one.drilled_mm;
    const vector_um = isCamera ? [1e3 * scale_mm * u, -1e3 * scale_mm * v] : one.residual_um;
    const first = isCamera ? `${one.view} (${fixed(x, 2)}, ${fixed(y, 2)})\u00a0px` : place(at_mm);
    return { at_mm, vector_mm: vector_um.map((/** @type {number} */ each) => each / 1e3), kind: one.left_out ? "refused" : "",
      lines: [first, vectorText(vector_um), one.left_out ? word("surface_left_out") : ""].filter(Boolean) };
  });
  const [right, top] = [scale_mm * width_px, scale_mm * height_px];
  return section("residuals", word("calibration_residuals"), panelArrows({ label: word("calibration_residuals"), places,
    outline_mm: isCamera ? [[0, 0], [right, 0], [right, top], [0, top]] : undefined },
  word(isCamera ? "calibration_residuals_of_camera" : "calibration_residuals_text")));
}

/** The error of a table, and what it is known to.
 * @param {any} map */
function tableMap(map) {
  const { columns, rows, first_mm: first, step_mm: step } = map;
  const sigmas = map.covariance_um2.map(greatestSigma);
  const at = (/** @type {number} */ i) => [first[0] + step[0] * (i % columns), first[1] + step[1] * Math.floor(i / columns)];
  const corners = /** @type {[number, number][]} */ ([0, columns - 1, columns * rows - 1, columns * (rows - 1)].map(at));
  const field = fieldOf(map, sigmas);
  return section("map", word("calibration_map"), element("div", { class: "figures" },
    panelArrows({ label: word("calibration_map"), outline_mm: corners, places: map.error_um.map((/** @type {number[]} */ error_um, /** @type {number} */ i) =>
      ({ at_mm: at(i), vector_mm: error_um.map((one) => one / 1e3), lines: [place(/** @type {any} */ (at(i))), vectorText(error_um),
        `${word("sigma")} ${micrometres(sigmas[i], 2)}`] })) }, word("calibration_map_text")),
    fieldFigure({ field, outline: corners, title: "", label: word("calibration_map_sigma"), unit: "\u00b5m", n_levels: 6,
      paint: fromLowToHigh, caption: word("calibration_map_sigma"), over: () => {},
      hint: (point) => [place(point), micrometres(fieldAt(field, point), 2)] })));
}

/** Lists of one kind: the columns are the keys of their rows.
 * @param {any} part @param {string} key */
function calibrationList(part, key) {
  const rows = [part[key] ?? []].flat().filter((row) => typeof row === "object");
  if (rows.length === 0) return null;
  const names = Object.keys(rows[0]);
  return section(key, wordOf("calibration_list", key), table(names.map((name) => ({ title: wordOf("calibration_row", name), text: ["reason", "text"].includes(name) })),
    rows.map((row) => names.map((name) => calibrationValue(name, row[name])))));
}

export const calibrationView = {
  facts: "calibration",
  /** @param {any} facts */
  show(facts) {
    const part = facts[facts.kind.replace("-", "_")];
    document.title = word("calibration_title", { subject: facts.subject });
    const kind = calibrationVerdicts[/** @type {keyof typeof calibrationVerdicts} */ (facts.verdict)] ?? (facts.objection ? " forced" : "");
    const lists = ["gates", "trend_over_coupon", "trend_over_picture", "samples", "aliases", "missed", "pictures_left_out"];
    return element("div", {}, element("h1", {}, document.title, " ", element("b", {}, facts.machine)),
      element("div", { class: `verdict${kind}` },
        element("p", {}, element("b", {}, wordOf("calibration_verdict", facts.verdict)), facts.objection ? [": ", english(facts.objection)] : ""),
        element("dl", { class: "tiles" }, tile(word("history_time"), timeText(secondsOf(facts.time)), facts.kind),
          facts.ledger_entry ? tile(word("history_entry"), whole(facts.ledger_entry), "") : null)),
      facts.parameters.length > 0 ? calibratedValues(facts) : null,
      part.map?.error_um ? tableMap(part.map) : null, calibrationResiduals(facts, part),
      part.curve?.length ? section("curve", word("focus_chart"), focusCurve({ z_mm: part.z_mm ?? null,
        curve: part.curve.map((/** @type {number[]} */ [z_mm, sharpness]) => ({ z_mm, sharpness })) })) : null,
      section("figures", word("calibration_figures"), calibrationRows(part)), lists.map((key) => calibrationList(part, key)),
      part.change ? differencePage(part.change) : null,
      section("origin", word("origin"), rowList([...Object.entries(facts.provenance), ...facts.inputs.map((input) => [input.name, input.sha256])])));
  },
};
