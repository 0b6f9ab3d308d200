// SPDX-License-Identifier: Apache-2.0
// Arrows at places of a panel or a table, so many times longer than true that they are seen.
import { svg } from "../base/dom.js";
import { fixed, shortest } from "../base/format.js";
import { word } from "../base/words.js";
import { arrowPath } from "./arrows.js";
import { roundStep } from "./plane.js";
import { decimalsOf, pointedFigure } from "./pointed.js";

/**
 * Places in mm, x right and y up; `kind` is a class of the style sheet, or empty.
 * @typedef {{at_mm: number[], vector_mm: number[], kind?: string, lines: string[]}} Arrow
 * @typedef {{label: string, places: Arrow[], outline_mm?: number[][], crosses_mm?: number[][],
 *            mostHeight?: number}} ArrowContent
 */

const arrowEdge = { left: 50, right: 14, top: 12, bottom: 62 };
/** The longest arrow as a part of the shorter side. */
const longestShare = 0.12;

/** What is shown: low and high corner in mm, with a margin.
 * @param {ArrowContent} content */
function shownCorners(content) {
  const all = [...content.places.map((one) => one.at_mm), ...(content.outline_mm ?? []), ...(content.crosses_mm ?? [])];
  const low = [0, 1].map((axis) => Math.min(...all.map((one) => one[axis])));
  const high = [0, 1].map((axis) => Math.max(...all.map((one) => one[axis])));
  const size = Math.max(high[0] - low[0], high[1] - low[1], 1);
  // A narrow strip has a part of the table around it.
  const margin = [0, 1].map((axis) => 0.07 * size + Math.max(0, 0.3 * size - (high[axis] - low[axis])) / 2);
  return { low: low.map((one, axis) => one - margin[axis]), high: high.map((one, axis) => one + margin[axis]) };
}

/** @param {ArrowContent} content @param {number} width */
function drawPanelArrows(content, width) {
  const { low, high } = shownCorners(content);
  const room = [width - arrowEdge.left - arrowEdge.right, (content.mostHeight ?? 620) - arrowEdge.top - arrowEdge.bottom];
  const scale = Math.min(room[0] / (high[0] - low[0]), room[1] / (high[1] - low[1]));
  const plot = [scale * (high[0] - low[0]), scale * (high[1] - low[1])];
  const height = plot[1] + arrowEdge.top + arrowEdge.bottom;
  const right = arrowEdge.left + plot[0];
  const bottom = arrowEdge.top + plot[1];
  const x = (/** @type {number} */ at) => arrowEdge.left + scale * (at - low[0]);
  const y = (/** @type {number} */ at) => bottom - scale * (at - low[1]);

  const longest = Math.max(0, ...content.places.map((one) => Math.hypot(...one.vector_mm)));
  const most = longestShare * Math.min(...plot) / (scale * longest);
  const magnification = longest > 0 && most > 1 ? roundStep(most) / (roundStep(most) > most ? 2 : 1) : 1;
  const reference = longest > 0 ? roundStep(0.6 * longest) : 0;

  const step = roundStep(Math.max(high[0] - low[0], high[1] - low[1]) / 6);
  const ticks = [];
  for (let k = Math.ceil(low[0] / step); k * step <= high[0]; k += 1) {
    ticks.push(svg("path", { class: "gridline", d: `M${x(k * step)} ${arrowEdge.top}V${bottom}` }),
      svg("text", { class: "middle", x: x(k * step), y: bottom + 15 }, fixed(k * step, decimalsOf(step))));
  }
  for (let k = Math.ceil(low[1] / step); k * step <= high[1]; k += 1) {
    ticks.push(svg("path", { class: "gridline", d: `M${arrowEdge.left} ${y(k * step)}H${right}` }),
      svg("text", { class: "end", x: arrowEdge.left - 5, y: y(k * step) + 4 }, fixed(k * step, decimalsOf(step))));
  }
  const hull = content.outline_mm ?? [];
  const drawn = content.places.map((one) => ({ x: x(one.at_mm[0]), y: y(one.at_mm[1]), lines: one.lines, one }));
  const picture = svg("svg", { class: "arrows", viewBox: `0 0 ${width} ${height}`, role: "img", tabindex: 0,
    "aria-label": content.label },
  ticks,
  svg("rect", { class: "axis", x: arrowEdge.left, y: arrowEdge.top, width: plot[0], height: plot[1] }),
  svg("text", { class: "middle", x: (arrowEdge.left + right) / 2, y: bottom + 31 }, "x, mm"),
  svg("text", { class: "middle", transform: `translate(12 ${(arrowEdge.top + bottom) / 2}) rotate(-90)` }, "y, mm"),
  hull.length > 1 && svg("path", { class: "hull", d: `M${hull.map((at) => `${x(at[0])} ${y(at[1])}`).join("L")}Z` }),
  drawn.map((at) => svg("circle", { class: "place", cx: at.x, cy: at.y, r: 1.8 })),
  (content.crosses_mm ?? []).map((at) => svg("path", { class: "target", d: `M${x(at[0]) - 6} ${y(at[1])}h12m-6 -6v12` })),
  drawn.map((at) => svg("path", { class: `arrow ${at.one.kind ?? ""}`,
    d: arrowPath(at.x, at.y, scale * magnification * at.one.vector_mm[0], -scale * magnification * at.one.vector_mm[1]) })),
  reference > 0 && [
    svg("path", { class: "arrow", d: arrowPath(arrowEdge.left, bottom + 48, scale * magnification * reference, 0) }),
    svg("text", { x: arrowEdge.left + scale * magnification * reference + 8, y: bottom + 52 },
      word("arrows_scale", { length: shortest(1e3 * reference), times: shortest(magnification) }))]);
  return { picture, drawn };
}

/**
 * @param {ArrowContent} content
 * @param {...(import("../base/dom.js").Child)} caption
 */
export function panelArrows(content, ...caption) {
  return pointedFigure((width) => drawPanelArrows(content, width), 1, caption);
}
