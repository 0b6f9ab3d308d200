// SPDX-License-Identifier: Apache-2.0
// Arrows at places of a panel or a table, so many times longer than true that they are seen.
import { svg } from "../base/dom.js";
import { decimalsOf, fixed, roundLevels, roundStep, shortest } from "../base/format.js";
import { word } from "../base/words.js";
import { extentOf } from "./plane.js";
import { pointedFigure } from "./pointed.js";
import { ellipseOf } from "./target_picture.js";

/**
 * Places in mm, x right and y up; `kind` is a class of the style sheet, or empty; `name` stands beside
 * the place. An ellipse of 95 % is drawn at the arrow's head where the covariance is known.
 * @typedef {{at_mm: number[], vector_mm: number[], kind?: string, lines: string[], name?: string,
 *            covariance_um2?: [number, number, number]}} Arrow
 * @typedef {{label: string, places: Arrow[], outline_mm?: number[][], crosses_mm?: number[][],
 *            mostHeight?: number}} ArrowContent
 */

const arrowEdge = { left: 50, right: 14, top: 12, bottom: 78 };
/** The longest arrow as a part of the shorter side. */
const longestShare = 0.12;
/** Of more places than this names would cover each other. */
const mostNames = 12;

/**
 * The path of an arrow with its head, px.
 * @param {number} u
 * @param {number} v
 * @param {number} du
 * @param {number} dv
 */
export function arrowPath(u, v, du, dv) {
  const length = Math.hypot(du, dv);
  if (!(length > 0.1)) return "";
  const head = Math.min(6, 0.4 * length) / length, [a, b] = [du * head, dv * head];
  const points = [[u, v], [u + du, v + dv], [u + du - a - b / 2, v + dv - b + a / 2], [u + du - a + b / 2, v + dv - b - a / 2]];
  const [tail, tip, left, right] = points.map((point) => point.map((value) => value.toFixed(1)).join(" "));
  return `M${tail}L${tip}M${left}L${tip}L${right}`;
}

/** @param {ArrowContent} content @param {number} width */
function drawPanelArrows(content, width) {
  const all = [...content.places.map((one) => one.at_mm), ...(content.outline_mm ?? []), ...(content.crosses_mm ?? [])];
  const { low, high } = extentOf(/** @type {[number, number][]} */ (all));
  const room = [width - arrowEdge.left - arrowEdge.right, (content.mostHeight ?? 620) - arrowEdge.top - arrowEdge.bottom];
  const scale = Math.min(room[0] / (high[0] - low[0]), room[1] / (high[1] - low[1]));
  const plot = [scale * (high[0] - low[0]), scale * (high[1] - low[1])];
  const height = plot[1] + arrowEdge.top + arrowEdge.bottom;
  const right = arrowEdge.left + plot[0];
  const bottom = arrowEdge.top + plot[1];
  const x = (/** @type {number} */ at) => arrowEdge.left + scale * (at - low[0]);
  const y = (/** @type {number} */ at) => bottom - scale * (at - low[1]);

  const ellipses = content.places.map((one) => one.covariance_um2 && ellipseOf(one.covariance_um2));
  const longest = Math.max(0, ...content.places.map((one, i) => Math.hypot(...one.vector_mm) + (ellipses[i]?.major ?? 0) / 1e3));
  const most = longestShare * Math.min(...plot) / (scale * longest);
  const magnification = longest > 0 && most > 1 ? roundStep(most) / (roundStep(most) > most ? 2 : 1) : 1;
  const reference = longest > 0 ? roundStep(0.6 * longest) : 0;
  const px_per_mm = scale * magnification;

  const digits = decimalsOf(roundStep(Math.max(high[0] - low[0], high[1] - low[1]) / 6));
  const levels = (axis) => roundLevels(low[axis], high[axis], 6 * (high[axis] - low[axis]) / Math.max(high[0] - low[0], high[1] - low[1]));
  const ticks = [levels(0).map((at) => [svg("path", { class: "gridline", d: `M${x(at)} ${arrowEdge.top}V${bottom}` }),
    svg("text", { class: "middle", x: x(at), y: bottom + 15 }, fixed(at, digits))]),
  levels(1).map((at) => [svg("path", { class: "gridline", d: `M${arrowEdge.left} ${y(at)}H${right}` }),
    svg("text", { class: "end", x: arrowEdge.left - 5, y: y(at) + 4 }, fixed(at, digits))])];
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
  drawn.map(({ x: u, y: v, one }, i) => {
    const [du, dv] = [px_per_mm * one.vector_mm[0], -px_per_mm * one.vector_mm[1]], ellipse = ellipses[i];
    return [svg("path", { class: `arrow ${one.kind ?? ""}`, d: arrowPath(u, v, du, dv) }),
      ellipse && svg("ellipse", { class: "ellipse", cx: u + du, cy: v + dv, rx: ellipse.major * px_per_mm / 1e3,
        ry: ellipse.minor * px_per_mm / 1e3, transform: `rotate(${-ellipse.angle_deg} ${u + du} ${v + dv})` }),
      one.name && drawn.length <= mostNames && svg("text", { x: u + 6, y: v - 6 }, one.name)];
  }),
  reference > 0 && [
    svg("path", { class: "arrow", d: arrowPath(arrowEdge.left, bottom + 48, px_per_mm * reference, 0) }),
    svg("text", { x: arrowEdge.left + px_per_mm * reference + 8, y: bottom + 52 }, `${shortest(1e3 * reference)}\u00a0\u00b5m`),
    svg("text", { x: arrowEdge.left, y: bottom + 70 }, word("arrows_times", { times: shortest(magnification) }))]);
  return { picture, drawn };
}

/**
 * @param {ArrowContent} content
 * @param {...(import("../base/dom.js").Child)} caption
 */
export function panelArrows(content, ...caption) {
  return pointedFigure((width) => drawPanelArrows(content, width), 1, caption);
}
