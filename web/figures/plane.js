// SPDX-License-Identifier: Apache-2.0
// A drawing of the plane of the panel on a canvas: x right, y up, both alike, mm.
import { colour } from "../base/colours.js";
import { element } from "../base/dom.js";
import { shortest } from "../base/format.js";
import { niceAbove } from "./pointed.js";

/** @typedef {[number, number]} Point */
/** @typedef {{low: Point, high: Point}} Extent */

/**
 * Where things are on the canvas, in CSS pixels.
 * @typedef {{width: number, height: number, left: number, top: number, right: number, bottom: number,
 *   scale: number, x: (x_mm: number) => number, y: (y_mm: number) => number,
 *   place: (x: number, y: number) => Point}} PlaneView
 */

/**
 * @typedef {{extent: Extent, label: string, most_px?: number,
 *   draw: (context: CanvasRenderingContext2D, view: PlaneView) => void,
 *   hint?: (place: Point, view: PlaneView) => string[] | null,
 *   press?: (place: Point, view: PlaneView) => ((place: Point) => void) | null,
 *   key?: (event: KeyboardEvent) => boolean}} PlaneOptions
 */

/**
 * The rectangle about points, with some room.
 * @param {Iterable<Point>} points
 * @returns {Extent}
 */
export function extentOf(points) {
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const point of points) {
    for (const k of [0, 1]) {
      low[k] = Math.min(low[k], point[k]);
      high[k] = Math.max(high[k], point[k]);
    }
  }
  if (!Number.isFinite(low[0])) return { low: [0, 0], high: [1, 1] };
  const size = Math.max(high[0] - low[0], high[1] - low[1], 1e-3);
  // A line has some width, too.
  const room = [0, 1].map((k) => 0.06 * size + Math.max(0, 0.1 * size - (high[k] - low[k])) / 2);
  return { low: [low[0] - room[0], low[1] - room[1]], high: [high[0] + room[0], high[1] + room[1]] };
}

const planeMargin = { left: 46, right: 12, top: 10, bottom: 26 };

/**
 * @param {Extent} extent
 * @param {number} width
 * @param {number} most_px
 * @returns {PlaneView}
 */
function planeView(extent, width, most_px) {
  const size = [extent.high[0] - extent.low[0], extent.high[1] - extent.low[1]];
  const wide = width - planeMargin.left - planeMargin.right;
  const scale = Math.min(wide / size[0], most_px / size[1]);
  const height = scale * size[1] + planeMargin.top + planeMargin.bottom;
  const left = planeMargin.left + (wide - scale * size[0]) / 2;
  const bottom = height - planeMargin.bottom;
  return {
    width, height, left, top: planeMargin.top, right: left + scale * size[0], bottom, scale,
    x: (x_mm) => left + scale * (x_mm - extent.low[0]),
    y: (y_mm) => bottom - scale * (y_mm - extent.low[1]),
    place: (x, y) => [extent.low[0] + (x - left) / scale, extent.low[1] + (bottom - y) / scale],
  };
}

/**
 * Ticks and frame over what was drawn.
 * @param {CanvasRenderingContext2D} context
 * @param {PlaneView} view
 */
function drawAxes(context, view) {
  const low = view.place(view.left, view.bottom), high = view.place(view.right, view.top);
  const step = niceAbove(70 / view.scale);
  context.strokeStyle = colour("quiet");
  context.fillStyle = colour("quiet");
  context.lineWidth = 0.8;
  context.strokeRect(view.left, view.top, view.right - view.left, view.bottom - view.top);
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "top";
  for (let i = Math.ceil(low[0] / step); i * step <= high[0]; ++i) {
    context.fillRect(view.x(i * step) - 0.4, view.bottom, 0.8, 4);
    context.fillText(shortest(i * step || 0), view.x(i * step), view.bottom + 6);
  }
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (let i = Math.ceil(low[1] / step); i * step <= high[1]; ++i) {
    context.fillRect(view.left - 4, view.y(i * step) - 0.4, 4, 0.8);
    context.fillText(shortest(i * step || 0), view.left - 7, view.y(i * step));
  }
}

/**
 * Makes a canvas as sharp as the screen, and clears it.
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height
 */
export function preparedContext(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = `${height}px`;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = colour("paper");
  context.fillRect(0, 0, width, height);
  return context;
}

/**
 * Calls `draw` when a canvas has a size, another size, or other colours.
 * @param {HTMLCanvasElement} canvas
 * @param {() => void} draw
 */
export function redrawn(canvas, draw) {
  let isDue = false;
  const later = () => {
    if (isDue) return;
    isDue = true;
    requestAnimationFrame(() => {
      isDue = false;
      if (canvas.isConnected && canvas.clientWidth > 0) draw();
    });
  };
  let width = 0;
  new ResizeObserver(() => {
    if (canvas.clientWidth !== width) later();
    width = canvas.clientWidth;
  }).observe(canvas);
  for (const query of ["(prefers-color-scheme: dark)", "print"]) {
    matchMedia(query).addEventListener("change", () => {
      if (canvas.isConnected && canvas.clientWidth > 0) draw();
    });
  }
  return later;
}

/**
 * The canvas, and how to have it drawn again.
 * @param {PlaneOptions} options
 */
export function planeFigure(options) {
  const canvas = element("canvas", { role: "img", "aria-label": options.label });
  const hint = element("div", { class: "hint", hidden: true });
  const node = element("div", { class: "plane" }, canvas, hint);
  if (options.key) canvas.tabIndex = 0;
  /** @type {PlaneView | null} */
  let view = null;
  /** @type {((place: Point) => void) | null} */
  let dragged = null;
  const redraw = redrawn(canvas, () => {
    view = planeView(options.extent, canvas.clientWidth, options.most_px ?? 620);
    const context = preparedContext(canvas, view.width, view.height);
    context.save();
    context.beginPath();
    context.rect(view.left, view.top, view.right - view.left, view.bottom - view.top);
    context.clip();
    options.draw(context, view);
    context.restore();
    drawAxes(context, view);
  });
  const placeOf = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    return view ? view.place(event.clientX - box.left, event.clientY - box.top) : null;
  };
  canvas.addEventListener("pointerdown", (event) => {
    const at = placeOf(event);
    if (!at || !view || !options.press) return;
    dragged = options.press(at, view);
    if (dragged) canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointerup", () => { dragged = null; });
  canvas.addEventListener("pointerleave", () => { hint.hidden = true; });
  canvas.addEventListener("pointermove", (event) => {
    const at = placeOf(event);
    if (!at || !view) return;
    if (dragged) dragged(at);
    const lines = options.hint?.(at, view);
    hint.hidden = !lines;
    if (!lines) return;
    hint.replaceChildren(...lines.map((line) => element("div", {}, line)));
    const x = view.x(at[0]), y = view.y(at[1]);
    // On the side that has more room.
    hint.style.setProperty("left", x < view.width / 2 ? `${x + 14}px` : "auto");
    hint.style.setProperty("right", x < view.width / 2 ? "auto" : `${view.width - x + 14}px`);
    hint.style.setProperty("top", `${Math.max(0, y - 20)}px`);
  });
  canvas.addEventListener("keydown", (event) => {
    if (options.key?.(event)) event.preventDefault();
  });
  return { node, redraw };
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {PlaneView} view
 * @param {Point[]} places
 */
export function traceWay(context, view, places) {
  places.forEach(([x, y], i) => context[i === 0 ? "moveTo" : "lineTo"](view.x(x), view.y(y)));
}

/** The same, closed.
 * @param {CanvasRenderingContext2D} context
 * @param {PlaneView} view
 * @param {Point[]} corners */
export function tracePolygon(context, view, corners) {
  traceWay(context, view, corners);
  context.closePath();
}

/**
 * A mark with a rim in the colour of the paper, so that it shows on any colour.
 * @param {CanvasRenderingContext2D} context
 * @param {string} css
 * @param {() => void} trace
 * @param {number} [width]
 */
export function strokeMark(context, css, trace, width = 2) {
  for (const [style, line] of /** @type {[string, number][]} */ ([[colour("paper"), width + (width < 2 ? 1.6 : 3)], [css, width]])) {
    context.strokeStyle = style;
    context.lineWidth = line;
    context.lineCap = context.lineJoin = "round";
    context.beginPath();
    trace();
    context.stroke();
  }
}

/**
 * Dots that show on any colour of a map.
 * @param {CanvasRenderingContext2D} context
 * @param {PlaneView} view
 * @param {ArrayLike<number | null>} x_mm
 * @param {ArrayLike<number | null>} y_mm
 * @param {number} radius
 */
export function drawDots(context, view, x_mm, y_mm, radius) {
  for (const [css, wider] of /** @type {[string, number][]} */ ([["#0008", 0.8], ["#fff", 0]])) {
    context.fillStyle = css;
    context.beginPath();
    for (let i = 0; i < x_mm.length; ++i) {
      const x = view.x(x_mm[i] ?? 0), y = view.y(y_mm[i] ?? 0);
      context.moveTo(x, y);
      context.arc(x, y, radius + wider, 0, 7);
    }
    context.fill();
  }
}

/**
 * A way from place to place; stops have their numbers where there are not too many.
 * @param {CanvasRenderingContext2D} context
 * @param {PlaneView} view
 * @param {Point[]} stops
 */
export function drawTour(context, view, stops) {
  const isNumbered = stops.length <= 150;
  strokeMark(context, colour("link"), () => traceWay(context, view, stops), isNumbered ? 2 : 1.4);
  context.font = "10px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  stops.forEach(([x, y], k) => {
    context.beginPath();
    context.arc(view.x(x), view.y(y), isNumbered ? 9 : 2.5, 0, 7);
    context.fillStyle = colour(k === 0 ? "link" : "paper");
    context.fill();
    context.strokeStyle = colour("link");
    context.lineWidth = 1.6;
    context.stroke();
    context.fillStyle = colour(k === 0 ? "paper" : "link");
    if (isNumbered) context.fillText(String(k + 1), view.x(x), view.y(y) + 0.5);
  });
}

/**
 * Text with a rim.
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} css
 */
export function markText(context, text, x, y, css) {
  context.font = "600 12px system-ui, sans-serif";
  context.lineWidth = 3.5;
  context.lineJoin = "round";
  context.strokeStyle = colour("paper");
  context.strokeText(text, x, y);
  context.fillStyle = css;
  context.fillText(text, x, y);
}
