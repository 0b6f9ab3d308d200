// SPDX-License-Identifier: Apache-2.0
// A drawing of the plane of the panel on a canvas: x right, y up, both alike, mm; what all maps share.
import { colour } from "../base/colours.js";
import { extremes } from "../base/columns.js";
import { element } from "../base/dom.js";
import { roundLevels, shortest } from "../base/format.js";
import { showHint } from "./pointed.js";

/** @typedef {[number, number]} Point */
/** @typedef {{low: Point, high: Point}} Extent */

/**
 * `press` says what dragging does; without it `isMovable` lets one pan and zoom, by keys and wheel too.
 * @typedef {{extent: Extent, label: string, most_px?: number, isMovable?: boolean, isReadOften?: boolean,
 *   draw: (plane: Plane) => void,
 *   hint?: (place: Point, plane: Plane) => import("../base/dom.js").Child[] | null,
 *   press?: (place: Point, plane: Plane) => ((place: Point) => void) | null,
 *   key?: (event: KeyboardEvent) => boolean}} PlaneOptions
 */

/** Ways of the arrow keys. @type {Record<string, Point>} */
export const arrowKeys = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const planeMargin = { left: 46, right: 12, top: 10, bottom: 26 };
export const zoomStep = 1.4;

/**
 * The rectangle about points, with some room.
 * @param {Point[]} points
 * @returns {Extent}
 */
export function extentOf(points) {
  return boxExtent(extremes(points.map(([x]) => x)), extremes(points.map(([, y]) => y)));
}

/**
 * The same from the ranges of x and y.
 * @param {Point | null} x
 * @param {Point | null} y
 * @returns {Extent}
 */
export function boxExtent(x, y) {
  if (!x || !y) return { low: [0, 0], high: [1, 1] };
  const size = Math.max(x[1] - x[0], y[1] - y[0], 1e-3);
  // A line has some width, too.
  const room = [x, y].map(([low, high]) => 0.06 * size + Math.max(0, 0.1 * size - (high - low)) / 2);
  return { low: [x[0] - room[0], y[0] - room[1]], high: [x[1] + room[0], y[1] + room[1]] };
}

/**
 * The place nearest to a point, or -1 where none is in reach; of a million places in a few milliseconds.
 * @param {ArrayLike<number | null>} x_mm
 * @param {ArrayLike<number | null>} y_mm
 * @param {Point} at
 * @param {number} reach_mm
 */
export function nearestPlace(x_mm, y_mm, [x, y], reach_mm) {
  let best = -1, least = reach_mm * reach_mm;
  for (let i = 0; i < x_mm.length; i++) {
    const square = (Number(x_mm[i]) - x) ** 2 + (Number(y_mm[i]) - y) ** 2;
    if (square > least) continue;
    least = square;
    best = i;
  }
  return best;
}

/**
 * Makes a canvas as sharp as the screen, and clears it.
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height
 * @param {boolean} [isReadOften]
 */
export function preparedContext(canvas, width, height, isReadOften = false) {
  const ratio = window.devicePixelRatio || 1;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: isReadOften }));
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
  let isDue = false, width = 0;
  const now = () => {
    isDue = false;
    if (canvas.isConnected && canvas.clientWidth > 0) draw();
  };
  const later = () => {
    if (!isDue) requestAnimationFrame(now);
    isDue = true;
  };
  new ResizeObserver(() => {
    if (canvas.clientWidth !== width) later();
    width = canvas.clientWidth;
  }).observe(canvas);
  for (const query of ["(prefers-color-scheme: dark)", "print"]) matchMedia(query).addEventListener("change", now);
  return later;
}

/** The canvas, what of the panel it shows, and what draws on it. Lengths without a unit in their name are px. */
export class Plane {
  /** @param {PlaneOptions} options */
  constructor(options) {
    this.options = options;
    this.canvas = element("canvas", { role: "img", "aria-label": options.label });
    if (options.key || options.isMovable) this.canvas.tabIndex = 0;
    if (options.press || options.isMovable) this.canvas.classList.add("dragged");
    this.hint = element("div", { class: "hint", hidden: true });
    this.node = element("div", { class: "plane" }, this.canvas, this.hint);
    this.context = preparedContext(this.canvas, 1, 1, options.isReadOften);
    this.width = this.height = this.left = this.right = this.top = this.bottom = 0;
    /** Pixels per mm. */
    this.scale = 0;
    /** In the middle of the frame. @type {Point} */
    this.centre_mm = [0, 0];
    this.isMoved = false;
    /** @type {((place: Point) => void) | null | undefined} */
    this.dragged = null;
    /** @type {Map<number, Point>} */
    this.pointers = new Map();
    this.redraw = redrawn(this.canvas, () => this.draw());
    this.listen();
  }

  listen() {
    const release = (event) => {
      this.dragged = null;
      this.pointers.delete(event.pointerId);
    };
    const listeners = {
      pointerdown: (event) => this.press(event), pointermove: (event) => this.move(event), pointerup: release,
      pointercancel: release,
      // A finger leaves as soon as it is lifted; what it has touched stays said.
      pointerleave: (event) => { this.hint.hidden = this.hint.hidden || event.pointerType !== "touch"; },
      keydown: (event) => {
        if (this.options.key?.(event) || (this.options.isMovable && this.key(event))) event.preventDefault();
      },
    };
    for (const [name, listener] of Object.entries(listeners)) this.canvas.addEventListener(name, listener);
    this.canvas.addEventListener("wheel", (event) => {
      // A page is scrolled over the map; with a key held, or while it has the focus, it zooms.
      const isMeant = event.ctrlKey || event.shiftKey || document.activeElement === this.canvas;
      if (!this.options.isMovable || !isMeant) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
    }, { passive: false });
  }

  x(x_mm) {
    return (this.left + this.right) / 2 + this.scale * (x_mm - this.centre_mm[0]);
  }

  y(y_mm) {
    return (this.top + this.bottom) / 2 - this.scale * (y_mm - this.centre_mm[1]);
  }

  /** The place under a pixel, mm.
   * @returns {Point} */
  place(x, y) {
    return [this.centre_mm[0] + (x - (this.left + this.right) / 2) / this.scale,
      this.centre_mm[1] - (y - (this.top + this.bottom) / 2) / this.scale];
  }

  /** Shows the whole extent, and nothing else until somebody moves it. */
  fit() {
    this.isMoved = false;
    this.redraw();
  }

  layout() {
    const { extent: { low, high }, most_px = 620, isMovable } = this.options;
    const size_mm = [high[0] - low[0], high[1] - low[1]];
    const wide = this.canvas.clientWidth - planeMargin.left - planeMargin.right;
    const fitting = Math.min(wide / size_mm[0], most_px / size_mm[1]);
    const tall = isMovable ? Math.max(fitting * size_mm[1], Math.min(most_px, 0.45 * wide)) : fitting * size_mm[1];
    const aside = isMovable ? 0 : (wide - fitting * size_mm[0]) / 2;
    this.width = this.canvas.clientWidth;
    this.left = planeMargin.left + aside;
    this.right = this.width - planeMargin.right - aside;
    this.top = planeMargin.top;
    this.bottom = this.top + tall;
    this.height = this.bottom + planeMargin.bottom;
    if (this.isMoved) return;
    this.scale = fitting;
    this.centre_mm = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  }

  draw() {
    this.layout();
    this.context = preparedContext(this.canvas, this.width, this.height, this.options.isReadOften);
    const { context } = this;
    context.save();
    context.beginPath();
    this.traceFrame();
    context.clip();
    this.options.draw(this);
    context.restore();
    this.drawAxes();
  }

  /** Ticks and frame over what was drawn. */
  drawAxes() {
    const { context } = this, quiet = colour("quiet");
    const low = this.place(this.left, this.bottom), high = this.place(this.right, this.top);
    const ticks = (k) => roundLevels(low[k], high[k], ((high[k] - low[k]) * this.scale) / 70);
    context.fillStyle = context.strokeStyle = quiet;
    context.lineWidth = 0.8;
    context.strokeRect(this.left, this.top, this.right - this.left, this.bottom - this.top);
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const at of ticks(0)) {
      context.fillRect(this.x(at) - 0.4, this.bottom, 0.8, 4);
      context.fillText(shortest(at), this.x(at), this.bottom + 6);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const at of ticks(1)) {
      context.fillRect(this.left - 4, this.y(at) - 0.4, 4, 0.8);
      context.fillText(shortest(at), this.left - 7, this.y(at));
    }
  }

  /**
   * Zooms so that a pixel keeps its place; without one, the middle.
   * @param {number} factor
   */
  zoom(factor, x = (this.left + this.right) / 2, y = (this.top + this.bottom) / 2) {
    const before = this.place(x, y);
    this.scale = Math.min(1e5, Math.max(1e-3, this.scale * factor));
    const after = this.place(x, y);
    this.pan(before[0] - after[0], before[1] - after[1]);
  }

  pan(dx_mm, dy_mm) {
    this.isMoved = true;
    this.centre_mm = [this.centre_mm[0] + dx_mm, this.centre_mm[1] + dy_mm];
    this.redraw();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const way = arrowKeys[event.key], step_mm = 60 / this.scale;
    if (way) this.pan(step_mm * way[0], step_mm * way[1]);
    else if (event.key === "+") this.zoom(zoomStep);
    else if (event.key === "-") this.zoom(1 / zoomStep);
    else if (event.key === "0") this.fit();
    else return false;
    return true;
  }

  /** @param {PointerEvent} event
   * @returns {Point} */
  pixelOf(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  /** @param {PointerEvent} event */
  press(event) {
    const { press, isMovable } = this.options, pixel = this.pixelOf(event);
    if (this.scale === 0) return;
    this.dragged = press?.(this.place(...pixel), this);
    if (isMovable) this.pointers.set(event.pointerId, pixel);
    if (this.dragged || isMovable) this.canvas.setPointerCapture(event.pointerId);
    this.say(pixel);
  }

  /** Says what is at a pixel.
   * @param {Point} pixel */
  say(pixel) {
    const [x, y] = pixel;
    showHint(this.hint, this.options.hint?.(this.place(x, y), this), x, y, this.width);
  }

  /** @param {PointerEvent} event */
  move(event) {
    if (this.scale === 0) return;
    const pixel = this.pixelOf(event), at = this.place(...pixel), before = this.pointers.get(event.pointerId);
    this.dragged?.(at);
    if (before) this.follow(event.pointerId, before, pixel);
    else this.say(pixel);
  }

  /**
   * One pointer moves the panel, two zoom it.
   * @param {number} id
   * @param {Point} before
   * @param {Point} now
   */
  follow(id, before, now) {
    this.hint.hidden = true;
    const other = [...this.pointers].find(([one]) => one !== id)?.[1];
    this.pointers.set(id, now);
    if (other) {
      const was = Math.hypot(before[0] - other[0], before[1] - other[1]);
      if (was > 0) this.zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / was, ...other);
    } else {
      this.pan((before[0] - now[0]) / this.scale, (now[1] - before[1]) / this.scale);
    }
  }

  traceFrame() {
    this.context.rect(this.left, this.top, this.right - this.left, this.bottom - this.top);
  }

  /** @param {Point[]} places */
  traceWay(places) {
    places.forEach(([x, y], i) => this.context[i === 0 ? "moveTo" : "lineTo"](this.x(x), this.y(y)));
  }

  /** @param {Point[]} corners */
  tracePolygon(corners) {
    this.traceWay(corners);
    this.context.closePath();
  }

  /**
   * A circle; many make one path.
   * @param {Point} centre
   * @param {number} radius
   */
  traceCircle([x_mm, y_mm], radius) {
    this.context.moveTo(this.x(x_mm) + radius, this.y(y_mm));
    this.context.arc(this.x(x_mm), this.y(y_mm), radius, 0, 7);
  }

  /**
   * A line with a rim in the colour of the paper, so that it shows on any colour.
   * @param {string} css
   * @param {Path2D | (() => void)} shape
   * @param {number} [width]
   * @param {number[]} [dashes]
   */
  stroke(css, shape, width = 2, dashes = []) {
    const { context } = this;
    context.setLineDash(dashes);
    context.lineCap = context.lineJoin = "round";
    context.beginPath();
    if (typeof shape === "function") shape();
    for (const [style, line] of /** @type {[string, number][]} */ ([[colour("paper"), width + (width < 2 ? 1.6 : 3)], [css, width]])) {
      context.strokeStyle = style;
      context.lineWidth = line;
      if (shape instanceof Path2D) context.stroke(shape);
      else context.stroke();
    }
    context.setLineDash([]);
  }

  /**
   * Dots that show on any colour of a map.
   * @param {ArrayLike<number | null>} x_mm
   * @param {ArrayLike<number | null>} y_mm
   * @param {number} radius
   */
  drawDots(x_mm, y_mm, radius) {
    for (const [css, wider] of /** @type {[string, number][]} */ ([["#0008", 0.8], ["#fff", 0]])) {
      this.context.fillStyle = css;
      this.context.beginPath();
      for (let i = 0; i < x_mm.length; ++i) this.traceCircle([x_mm[i] ?? 0, y_mm[i] ?? 0], radius + wider);
      this.context.fill();
    }
  }

  /**
   * A way from place to place; stops have their numbers where there are not too many.
   * @param {Point[]} stops
   */
  drawTour(stops) {
    const { context } = this, isNumbered = stops.length <= 150;
    this.stroke(colour("link"), () => this.traceWay(stops), isNumbered ? 2 : 1.4);
    context.font = "10px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    stops.forEach((stop, k) => {
      context.beginPath();
      this.traceCircle(stop, isNumbered ? 9 : 2.5);
      context.fillStyle = colour(k === 0 ? "link" : "paper");
      context.fill();
      context.strokeStyle = colour("link");
      context.lineWidth = 1.6;
      context.stroke();
      context.fillStyle = colour(k === 0 ? "paper" : "link");
      if (isNumbered) context.fillText(String(k + 1), this.x(stop[0]), this.y(stop[1]) + 0.5);
    });
  }

  /**
   * Text with a rim.
   * @param {string} text
   * @param {number} x
   * @param {number} y
   * @param {string} css
   */
  drawText(text, x, y, css) {
    const { context } = this;
    context.font = "600 12px system-ui, sans-serif";
    context.lineWidth = 3.5;
    context.lineJoin = "round";
    context.strokeStyle = colour("paper");
    context.strokeText(text, x, y);
    context.fillStyle = css;
    context.fillText(text, x, y);
  }

  /**
   * Draws on a layer of its own, and lays it over the picture.
   * @param {() => void} draw
   */
  drawLayer(draw) {
    const below = this.context, layer = document.createElement("canvas");
    this.context = preparedContext(layer, this.width, this.height);
    this.context.clearRect(0, 0, this.width, this.height);
    draw();
    this.context = below;
    below.drawImage(layer, 0, 0, this.width, this.height);
  }
}
