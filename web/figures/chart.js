// SPDX-License-Identifier: Apache-2.0
// A chart of values over time, or over minutes, that says each point where one points at it.
import { element, svg } from "../base/dom.js";
import { decimalsOf, fixed, roundLevels, timeText } from "../base/format.js";
import { pointedFigure } from "./pointed.js";

/**
 * A value, shown as `mark`; `lines` say it in words. Points that do not count, and crosses where there
 * are others, leave the range as it is: beyond it they stand on the edge.
 * @typedef {{x: number, y: number, sigma?: number | null, mark: "filled" | "hollow" | "cross",
 *            ring?: boolean, counts?: boolean, beyond?: string, lines: string[]}} ChartPoint
 *
 * `x` is in seconds since 1970, or with `xTitle` in its unit; `least` is the shortest range of it. `steps` hold from their x on; `band` is
 * over the whole width, `box` at one x; `limits` are drawn where they lie near the values, `marks` are
 * upright lines.
 * @typedef {{label: string, yTitle: string, xTitle?: string, least?: number, points: ChartPoint[],
 *            steps?: {x: number, y: number}[], curves?: {x: number, y: number}[][],
 *            band?: {low: number, high: number}, box?: {x: number, low: number, high: number} | null,
 *            limits?: number[], marks?: number[], lanes?: string[]}} ChartContent
 *
 * With `lanes` y is the number of one, from above.
 */

const plainEdge = { left: 66, right: 16, top: 12 };
const plainHeight = 240;
const laneHeight = 40;
const boxHalfWidth = 6;
const timeSteps_s = [1, 3, 6, 12, 24, 48, 168, 336, 720, 2184, 4368, 8760, 17520].map((hours) => 3600 * hours);

/** @param {number[]} values */
function spanOf(values) {
  const finite = values.filter(Number.isFinite);
  return finite.length ? { low: Math.min(...finite), high: Math.max(...finite) } : { low: 0, high: 0 };
}

/** The range of y: of what counts, and of limits that lie near it.
 * @param {ChartContent} content */
function valueRange(content) {
  const counted = content.points.filter((point) => point.counts !== false && point.mark !== "cross");
  const points = counted.length ? counted : content.points;
  const around = points.flatMap(({ y, sigma }) => [y - (sigma ?? 0), y + (sigma ?? 0)]);
  const others = [content.band, content.box].flatMap((one) => (one ? [one.low, one.high] : []));
  const inner = spanOf([...around, ...others, ...(content.steps ?? []).map((step) => step.y)]);
  const size = inner.high - inner.low;
  const near = (content.limits ?? []).filter((limit) =>
    limit >= inner.low - 2 * size && limit <= inner.high + 2 * size);
  const span = spanOf([inner.low, inner.high, ...near]);
  const margin = Math.max(0.08 * (span.high - span.low), 1e-9 * Math.abs(span.high), 1e-9);
  return { low: span.low - margin, high: span.high + margin };
}

/** @param {ChartContent} content */
function positionRange(content) {
  const range = spanOf([...content.points, ...(content.steps ?? []), ...(content.curves ?? []).flat()].map((one) => one.x));
  const least = content.least ?? (content.xTitle ? 1 : 86400);
  const missing = Math.max(0, least - (range.high - range.low)) / 2;
  return { low: range.low - missing, high: range.high + missing };
}

/**
 * The picture at a width, and where its points are.
 * @param {ChartContent} content
 * @param {number} width
 */
function drawChart(content, width) {
  const { lanes } = content;
  const edge = { ...plainEdge, left: lanes ? 8 : plainEdge.left, bottom: content.xTitle ? 38 : 24 };
  const height = lanes ? edge.top + edge.bottom + laneHeight * lanes.length : plainHeight;
  const right = width - edge.right;
  const bottom = height - edge.bottom;
  const xs = positionRange(content);
  const ys = lanes ? { low: 0, high: lanes.length } : valueRange(content);
  const room = right - edge.left - 2 * boxHalfWidth;
  const x = (/** @type {number} */ at) => edge.left + boxHalfWidth + room * (at - xs.low) / (xs.high - xs.low);
  const y = (/** @type {number} */ at) => lanes ? edge.top + laneHeight * (at + 0.7)
    : bottom - (bottom - edge.top) * (Math.min(ys.high, Math.max(ys.low, at)) - ys.low) / (ys.high - ys.low);
  const across = (/** @type {string} */ name, /** @type {number} */ at) =>
    svg("path", { class: name, d: `M${edge.left} ${y(at)}H${right}` });
  const rows = lanes ? lanes.map((lane, i) => [across("gridline", i),
    svg("text", { class: "lane", x: edge.left + 4, y: y(i) - 12 }, lane)]) : valueTicks(ys, y, across);
  const columns = content.xTitle ? numberTicks(xs, x, bottom) : timeTicks(xs, x, edge.left, right, bottom);
  const drawn = content.points.map((point) => ({ point, lines: point.lines, x: x(point.x), y: y(point.y) }));
  const inside = (content.limits ?? []).filter((limit) => limit > ys.low && limit < ys.high);
  const picture = svg("svg", { class: "chart", viewBox: `0 0 ${width} ${height}`, role: "img",
    tabindex: 0, "aria-label": content.label },
  content.band && bandRect(edge.left, right, y(content.band.high), y(content.band.low)),
  rows, columns,
  svg("rect", { class: "axis", x: edge.left, y: edge.top, width: right - edge.left, height: bottom - edge.top }),
  svg("text", { class: "middle", transform: `translate(13 ${(edge.top + bottom) / 2}) rotate(-90)` }, content.yTitle),
  inside.map((limit) => across("limit", limit)),
  content.box && bandRect(x(content.box.x) - boxHalfWidth, x(content.box.x) + boxHalfWidth,
    y(content.box.high), y(content.box.low)),
  (content.marks ?? []).map((at) => svg("path", { class: "event", d: `M${x(at)} ${edge.top}V${bottom}` })),
  stepPath(content.steps ?? [], x, y),
  (content.curves ?? []).map((curve) => svg("path", { class: "step",
    d: curve.map((at, i) => `${i ? "L" : "M"}${x(at.x)} ${y(at.y)}`).join("") })),
  drawn.map((one) => pointMark(one, y, edge.top, bottom, width)),
  content.xTitle && svg("text", { class: "end", x: right, y: height - 4 }, content.xTitle));
  return { picture, drawn };
}

/**
 * @param {{low: number, high: number}} range
 * @param {(at: number) => number} y
 * @param {(name: string, at: number) => Element} across
 */
function valueTicks(range, y, across) {
  const levels = roundLevels(range.low, range.high, 4), digits = decimalsOf(levels[1] - levels[0]);
  return levels.map((at) => [across("gridline", at),
    svg("text", { class: "end", x: plainEdge.left - 6, y: y(at) + 4 }, fixed(at, digits))]);
}

/** @param {number} left @param {number} right @param {number} top @param {number} bottom */
function bandRect(left, right, top, bottom) {
  return svg("rect", { class: "band", x: left, y: top, width: right - left, height: Math.max(1, bottom - top) });
}

/** @param {{x: number, y: number}[]} steps @param {(at: number) => number} x @param {(at: number) => number} y */
function stepPath(steps, x, y) {
  if (!steps.length) return null;
  const [first, ...rest] = steps;
  return svg("path", { class: "step", d: `M${x(first.x)} ${y(first.y)}` +
    rest.map((one) => `H${x(one.x)}V${y(one.y)}`).join("") });
}

/**
 * @param {{low: number, high: number}} range
 * @param {(at: number) => number} x
 * @param {number} bottom
 */
function numberTicks(range, x, bottom) {
  const levels = roundLevels(range.low, range.high, 5), digits = decimalsOf(levels[1] - levels[0]);
  return levels.map((at) => svg("text", { class: "middle", x: x(at), y: bottom + 16 }, fixed(at, digits)));
}

/**
 * Days or hours of UTC, as many as have room.
 * @param {{low: number, high: number}} range
 * @param {(at: number) => number} x
 * @param {number} left
 * @param {number} right
 * @param {number} bottom
 */
function timeTicks(range, x, left, right, bottom) {
  const most = Math.max(1, Math.floor((right - left) / 110));
  const step = timeSteps_s.find((one) => one >= (range.high - range.low) / most) ?? timeSteps_s[timeSteps_s.length - 1];
  const ticks = [];
  for (let k = Math.ceil(range.low / step); k * step <= range.high; k += 1) {
    const at = x(k * step);
    const atEdge = at > right - 34 ? "end" : at < left + 34 ? "" : "middle";
    ticks.push(svg("path", { class: "gridline", d: `M${at} ${bottom}v4` }),
      svg("text", { class: atEdge, x: at, y: bottom + 16 },
        step < 86400 ? timeText(k * step).slice(5) : timeText(k * step).slice(0, 10)));
  }
  return ticks;
}

/**
 * @param {{point: ChartPoint, x: number, y: number}} drawn
 * @param {(at: number) => number} y
 * @param {number} top
 * @param {number} bottom
 * @param {number} width
 */
function pointMark({ point, x: px, y: py }, y, top, bottom, width) {
  const bar = point.sigma
    ? svg("path", { class: "bar", d: `M${px} ${y(point.y - point.sigma)}V${y(point.y + point.sigma)}` }) : null;
  const isEdge = py <= top || py >= bottom;
  const isRight = px > width / 2;
  return svg("g", {},
    bar,
    point.ring && svg("circle", { class: "ring", cx: px, cy: py, r: 7 }),
    point.mark === "cross"
      ? svg("path", { class: "cross", d: `M${px - 4} ${py - 4}l8 8m0 -8l-8 8` })
      : svg("circle", { class: point.mark, cx: px, cy: py, r: point.mark === "filled" ? 2.8 : 3.2 }),
    isEdge && point.beyond && svg("text", { class: isRight ? "beyond end" : "beyond", x: px + (isRight ? -10 : 10),
      y: Math.min(bottom - 5, Math.max(top + 13, py + 4)) }, point.beyond));
}

/**
 * A chart that fills the width it is given. Pointing at it, or the arrow keys, say its points in words.
 * @param {ChartContent} content
 * @param {...(import("../base/dom.js").Child)} caption
 */
export function chart(content, ...caption) {
  // Along x a point is meant sooner than along y.
  return pointedFigure((width) => drawChart(content, width), 0.2, caption);
}

/**
 * The key of a chart: samples of its marks with their meaning.
 * @param {[string, string][]} rows name of a mark, its meaning
 */
export function chartLegend(rows) {
  const sample = {
    filled: () => [svg("path", { class: "bar", d: "M10 1V13" }), svg("circle", { class: "filled", cx: 10, cy: 7, r: 2.8 })],
    hollow: () => [svg("circle", { class: "hollow", cx: 10, cy: 7, r: 3.2 })],
    cross: () => [svg("path", { class: "cross", d: "M6 3l8 8m0 -8l-8 8" })],
    ring: () => [svg("circle", { class: "ring", cx: 10, cy: 7, r: 5.5 })],
    ringed: () => [svg("circle", { class: "ring", cx: 10, cy: 7, r: 5.5 }), svg("circle", { class: "filled", cx: 10, cy: 7, r: 2.8 })],
    step: () => [svg("path", { class: "step", d: "M1 7H19" })],
    event: () => [svg("path", { class: "event", d: "M10 1V13" })],
    limit: () => [svg("path", { class: "limit", d: "M1 7H19" })],
    band: () => [svg("rect", { class: "band", x: 4, y: 1, width: 12, height: 12 })],
  };
  return element("ul", { class: "legend" }, rows.map(([mark, meaning]) => element("li", {},
    svg("svg", { class: "chart sample", viewBox: "0 0 20 14", "aria-hidden": "true" },
      sample[/** @type {keyof typeof sample} */ (mark)]()), meaning)));
}
