// SPDX-License-Identifier: Apache-2.0
// The targets of a job: a card each, with pictures and numbers; those that need a look first.
import { chip, element, number, table, unfolding } from "../base/dom.js";
import { word, wordOf } from "../base/words.js";
import { fixed, minuteText, place } from "../base/format.js";
import { targetThumbnail, viewsPlan } from "../figures/target_picture.js";

/** Up to this number of cards is shown unfolded. */
const shownUnfolded = 24;
/** Up to this number all are made, since links lead to them and they are printed. */
const madeAtOnce = 500;

export function boardText(target) {
  return target.board.length > 0 ? `, ${word("board")} [${target.board.join(",")}]` : "";
}

export function lineText(target) {
  return `${word("line")} ${target.line}${target.file ? ` (${target.file})` : ""}${boardText(target)}`;
}

/**
 * @param {number} seq
 * @returns {HTMLAnchorElement}
 */
export function targetLink(seq) {
  const open = () => {
    // A card inside of a closed group would not be scrolled to.
    for (let at = document.getElementById(`target-${seq}`)?.parentElement; at; at = at.parentElement) {
      if (at instanceof HTMLDetailsElement) at.open = true;
    }
  };
  return element("a", { href: `#target-${seq}`, onclick: open }, `#${seq}`);
}

function statusChip(target, series) {
  if (target.status !== "found") return chip(target.state === "left_out" ? "suspect" : "refused", wordOf("status", target.status));
  if (target.state === "refused") return chip("refused", word("target_refused"));
  if (target.state === "suspect") return chip("suspect", word(series?.fit ? "target_fit_refused" : "target_no_fit"));
  return target.state === "left_out" ? chip("suspect", word("target_left_out")) : chip("good", word("status_found"));
}

function numbersTable(target) {
  if (!target.measured) return null;
  const deviation = target.measured.place_mm.map((/** @type {number} */ v, /** @type {number} */ i) =>
    1e3 * (v - target.expected_mm[i]));
  const [xx, , yy] = target.measured.covariance_um2;
  const row = (/** @type {string} */ name, /** @type {number[]} */ v, /** @type {number} */ decimals, isSigned = true) => [
    name, fixed(v[0], decimals, { signed: isSigned }), fixed(v[1], decimals, { signed: isSigned }),
    isSigned ? fixed(Math.hypot(...v), decimals) : "",
  ];
  const rows = [row(word("measured_minus_expected"), deviation, 1)];
  if (target.residual_um) rows.push(row(word("residual"), target.residual_um, 2));
  rows.push(row(word("sigma"), [Math.sqrt(xx), Math.sqrt(yy)], 3, false));
  if (target.measured.scatter_um) rows.push(row(word("scatter_of_inspections"), target.measured.scatter_um, 3, false));
  return table([{ title: "\u00b5m" }, number("x"), number("y"),
    number(word("length"))], rows, "numbers");
}

/** @param {Record<string, string>} pictures */
function targetCard(target, facts, pictures) {
  const crops = target.pictures.filter((one) => one.crop && pictures[one.crop.name]);
  const thumbnails = crops.map((one) => targetThumbnail(one.crop, pictures[one.crop.name],
    word("picture_label", { seq: target.seq, view: one.view + 1 }), one.status === "found"));
  const kind = target.state === "left_out" ? "suspect" : target.state;
  const last = crops[crops.length - 1]?.crop;
  return element("article", { class: `card ${kind}`, id: `target-${target.seq}` },
    element("div", { class: "head" },
      thumbnails.length > 0 ? element("div", { class: "thumbnails" }, thumbnails)
        : element("div", { class: "nopicture" }, word("no_picture")),
      element("div", { class: "facts" },
        element("h3", {}, `#${target.seq} ${target.command} `,
          statusChip(target, target.series === null ? null : facts.series[target.series])),
        element("p", { class: "quiet" }, lineText(target)),
        element("p", {}, element("span", { class: "quiet" }, `${word("nominal")} `), place(target.nominal_mm)),
        target.score !== null && element("p", {}, element("span", { class: "quiet" }, `${word("score")} `),
          fixed(target.score, 3)),
        last && last.contrast !== null && element("p", {}, element("span", { class: "quiet" }, `${word("contrast")} `),
          `${fixed(100 * last.contrast, 0)}\u00a0%`, element("span", { class: "quiet" }, `, ${word("blur")} `),
          `${fixed(last.blur_px, 2)} px`),
        target.image && element("p", { class: "quiet mono" }, target.image))),
    target.decision && element("p", {}, chip("suspect", wordOf("serve_by", target.decision.by)),
      ` ${target.decision.who}, ${minuteText(target.decision.when)}`),
    target.reason && element("p", { class: "reason", lang: "en" }, target.reason),
    numbersTable(target), viewsPlan(target));
}

/**
 * @param {Record<string, string>} pictures
 * @returns {import("../base/dom.js").Child[]}
 */
export function targetCards(facts, pictures) {
  const { targets, series } = facts;
  if (targets.length === 0) return [element("p", { class: "quiet" }, word("no_targets"))];
  const cards = (some) => element("div", { class: "cards" },
    some.map((target) => targetCard(target, facts, pictures)));
  const out = [];
  for (const state of /** @type {const} */ (["refused", "suspect", "left_out"])) {
    const some = targets.filter((target) => target.state === state);
    if (some.length > 0) out.push(element("h3", {}, word(`targets_${state}`)), cards(some));
  }
  /** @type {Map<number | null, any[]>} */
  const groups = new Map();
  for (const target of targets) {
    if (target.state !== "good") continue;
    groups.set(target.series, [...(groups.get(target.series) ?? []), target]);
  }
  for (const [i, group] of groups) {
    const residuals = group.filter((target) => target.residual_um)
      .map((target) => Math.hypot(target.residual_um[0], target.residual_um[1]));
    const summary = [element("b", {}, i === null ? word("measured_holes") : seriesName(series[i])), " ",
      element("span", { class: "quiet" }, word("n_targets", { n: group.length }),
        residuals.length > 0 && `, ${word("largest_residual", { um: fixed(Math.max(...residuals), 2) })}`)];
    out.push(unfolding(summary, () => cards(group), { open: targets.length <= shownUnfolded }, targets.length <= madeAtOnce));
  }
  return out;
}

/**
 * "Panel, line 20", "Board [0,1], line 27".
 * @param {any} one a series
 */
export function seriesName(one) {
  const board = one.board.length > 0 ? ` [${one.board.join(",")}]` : "";
  const name = one.level === "panel" ? word("panel") : board ? word("series_board") : word("series_nested");
  return `${name}${board}, ${word("line")} ${one.line}`;
}
