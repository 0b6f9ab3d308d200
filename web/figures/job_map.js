// SPDX-License-Identifier: Apache-2.0
// The map of a job: every place on a canvas, with pan, zoom and hover; over it the targets with
// their residuals. A million places are drawn as pixels, a few as discs of their true size.
import { element } from "../base/dom.js";
import { word } from "../base/words.js";
import { fixed, micrometres, place, probability, shortest } from "../base/format.js";
import { categoryColour, colour, scaleCss } from "../base/colours.js";
import { extremes, placeIndex } from "./place_index.js";
import { colouring, fitSigma_um, mapColumns } from "./map_colours.js";

/** More places than this in view are drawn as squares of whole pixels. */
const maxDiscs = 20000;
/** Residuals: the longest arrow in px. */
const longestArrow_px = 60;

/**
 * The box around all places and targets, mm.
 * @param {import("./map_colours.js").MapColumns | null} columns
 * @param {any[]} targets
 */
function mapBox(columns, targets) {
  const x = extremes([...(columns ? extremes(columns.x_mm) ?? [] : []), ...targets.map((t) => t.nominal_mm[0])]);
  const y = extremes([...(columns ? extremes(columns.y_mm) ?? [] : []), ...targets.map((t) => t.nominal_mm[1])]);
  if (!x || !y) return null;
  return { left: x[0], bottom: y[0], width: x[1] - x[0], height: y[1] - y[0] };
}

/** One canvas with its view of the panel. */
class JobMap {
  /** @param {any} facts */
  constructor(facts) {
    this.facts = facts;
    const table = facts.places?.table;
    this.columns = table ? mapColumns(table) : null;
    this.tools = (facts.places?.tools ?? []).map((/** @type {any} */ tool) => tool.number);
    this.diameters = new Map((facts.places?.tools ?? []).map((/** @type {any} */ t) => [t.number, t.diameter_mm]));
    this.box = mapBox(this.columns, facts.targets);
    this.mode = "tool";
    this.showsResiduals = true;
    this.index = null;
    this.canvas = element("canvas", {
      tabindex: 0, role: "img", "aria-label": word("map_label"),
      onkeydown: (/** @type {KeyboardEvent} */ e) => this.key(e),
      onpointerdown: (/** @type {PointerEvent} */ e) => this.press(e),
      onpointermove: (/** @type {PointerEvent} */ e) => this.move(e),
      onpointerup: (/** @type {PointerEvent} */ e) => this.release(e),
      onpointercancel: (/** @type {PointerEvent} */ e) => this.release(e),
      onpointerleave: () => this.hint.remove(),
    });
    this.canvas.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    this.hint = element("div", { class: "hint", role: "status" });
    this.legend = element("ul", { class: "legend" });
    this.frame = element("div", { class: "map" }, this.canvas);
    /** @type {Map<number, [number, number]>} */
    this.pointers = new Map();
    this.px_per_mm = 1;
    this.center = [0, 0];
    this.isAsked = false;
    new ResizeObserver(() => this.resize()).observe(this.frame);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  resize() {
    const width = this.frame.clientWidth;
    if (width === 0 || !this.box) return;
    const shape = (this.box.height + 1) / (this.box.width + 1);
    const height = Math.round(Math.min(width * Math.min(1.2, Math.max(0.45, shape)), innerHeight * 0.85));
    const ratio = devicePixelRatio || 1;
    const isFirst = !this.width;
    this.width = width;
    this.height = height;
    this.canvas.style.height = `${height}px`;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    if (isFirst) this.fit();
    this.draw();
  }

  fit() {
    const box = this.box;
    if (!box || !this.width || !this.height) return;
    const margin_px = 46;
    this.px_per_mm = Math.min((this.width - 2 * margin_px) / Math.max(1e-3, box.width),
      (this.height - 2 * margin_px) / Math.max(1e-3, box.height), 200);
    this.center = [box.left + box.width / 2, box.bottom + box.height / 2];
  }

  /**
   * Pixel of a place.
   * @param {number} x
   * @param {number} y
   * @returns {[number, number]}
   */
  at(x, y) {
    return [(this.width ?? 0) / 2 + (x - this.center[0]) * this.px_per_mm,
      (this.height ?? 0) / 2 - (y - this.center[1]) * this.px_per_mm];
  }

  /**
   * Place under a pixel.
   * @param {number} px
   * @param {number} py
   * @returns {[number, number]}
   */
  under(px, py) {
    return [this.center[0] + (px - (this.width ?? 0) / 2) / this.px_per_mm,
      this.center[1] - (py - (this.height ?? 0) / 2) / this.px_per_mm];
  }

  /**
   * Zooms so that a pixel keeps its place.
   * @param {number} factor
   * @param {number} px
   * @param {number} py
   */
  zoom(factor, px, py) {
    const [x, y] = this.under(px, py);
    this.px_per_mm = Math.min(1e5, Math.max(1e-3, this.px_per_mm * factor));
    const [u, v] = this.at(x, y);
    this.center[0] += (u - px) / this.px_per_mm;
    this.center[1] -= (v - py) / this.px_per_mm;
    this.ask();
  }

  /** Draws once for all that happens before the next frame. */
  ask() {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame(() => {
      this.isAsked = false;
      this.draw();
    });
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    // A page is scrolled over the map; with a key held, or while it has the focus, it zooms.
    if (!event.ctrlKey && !event.shiftKey && document.activeElement !== this.canvas) return;
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const step_mm = 60 / this.px_per_mm;
    const middle = [(this.width ?? 0) / 2, (this.height ?? 0) / 2];
    /** @type {Record<string, () => void>} */
    const actions = {
      ArrowLeft: () => { this.center[0] -= step_mm; },
      ArrowRight: () => { this.center[0] += step_mm; },
      ArrowUp: () => { this.center[1] += step_mm; },
      ArrowDown: () => { this.center[1] -= step_mm; },
      "+": () => this.zoom(1.4, middle[0], middle[1]),
      "-": () => this.zoom(1 / 1.4, middle[0], middle[1]),
      0: () => this.fit(),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
    this.ask();
  }

  /** @param {PointerEvent} event */
  press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
  }

  /** @param {PointerEvent} event */
  release(event) {
    this.pointers.delete(event.pointerId);
  }

  /** @param {PointerEvent} event */
  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) {
      this.hover(event);
      return;
    }
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    if (others.length > 0) {
      const [ox, oy] = others[0];
      const was = Math.hypot(before[0] - ox, before[1] - oy);
      const is = Math.hypot(event.offsetX - ox, event.offsetY - oy);
      if (was > 0) this.zoom(is / was, ox, oy);
    } else {
      this.center[0] -= (event.offsetX - before[0]) / this.px_per_mm;
      this.center[1] += (event.offsetY - before[1]) / this.px_per_mm;
    }
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    this.ask();
  }

  /** @param {PointerEvent} event */
  hover(event) {
    const columns = this.columns;
    this.hint.remove();
    if (!columns || !this.box) return;
    this.index = this.index ?? placeIndex(columns.x_mm, columns.y_mm, this.box);
    const [x, y] = this.under(event.offsetX, event.offsetY);
    const i = this.index.nearest(x, y, 9 / this.px_per_mm);
    if (i < 0) return;
    this.hint.replaceChildren(...this.described(columns, i));
    this.frame.append(this.hint);
    const isRight = event.offsetX > (this.width ?? 0) / 2;
    this.hint.style.left = isRight ? "" : `${event.offsetX + 14}px`;
    this.hint.style.right = isRight ? `${(this.width ?? 0) - event.offsetX + 14}px` : "";
    this.hint.style.top = `${Math.max(0, event.offsetY - 20)}px`;
  }

  /**
   * @param {import("./map_colours.js").MapColumns} columns
   * @param {number} i
   */
  described(columns, i) {
    const kind = ["map_hole", "map_slot_end", "map_rout_corner"][Number(columns.kind[i])];
    const file = columns.files[Number(columns.file[i])];
    const board = columns.boards[Number(columns.board[i])];
    const nominal = /** @type {[number, number]} */ ([columns.x_mm[i], columns.y_mm[i]]);
    const actual = /** @type {[number, number]} */ (
      [nominal[0] + Number(columns.shift_x_um[i]) / 1e3, nominal[1] + Number(columns.shift_y_um[i]) / 1e3]);
    const risk = columns.risk[i];
    const row = (/** @type {import("../base/words.js").WordKey} */ key, /** @type {string} */ value) =>
      element("div", {}, element("span", { class: "quiet" }, `${word(key)} `), value);
    return [
      element("b", {}, word(/** @type {any} */ (kind), { tool: Number(columns.tool[i]) })),
      row("line", `${columns.line[i]}${file ? ` (${file})` : ""}${board.length ? `, ${word("board")} [${board}]` : ""}`),
      row("nominal", place(nominal)),
      row("corrected", place(actual)),
      row("shift", `${fixed(Number(columns.shift_x_um[i]), 1, { signed: true })}, ` +
        `${fixed(Number(columns.shift_y_um[i]), 1, { signed: true })}\u00a0\u00b5m`),
      row("sigma", micrometres(Number(columns.sigma_um[i]), 3)),
      risk !== null && Number.isFinite(risk) ? row("risk", probability(Number(risk))) : "",
    ];
  }

  draw() {
    const context = this.canvas.getContext("2d", { willReadFrequently: (this.columns?.n ?? 0) > maxDiscs });
    if (!context || !this.width || !this.height) return;
    const ratio = devicePixelRatio || 1;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawGrid(context);
    if (this.mode === "sigma") this.drawFitSigma(context);
    if (this.columns) {
      const paint = colouring(this.mode, this.columns, this.tools);
      this.drawPlaces(context, this.columns, paint, ratio);
      this.showLegend(paint);
    }
    this.drawTargets(context);
  }

  /** @param {CanvasRenderingContext2D} context */
  drawGrid(context) {
    const raw = 90 / this.px_per_mm;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= raw) ?? raw;
    const [left, top] = this.under(0, 0);
    const [right, bottom] = this.under(this.width ?? 0, this.height ?? 0);
    context.strokeStyle = colour("line");
    context.fillStyle = colour("quiet");
    context.lineWidth = 0.7;
    context.font = "12px system-ui, sans-serif";
    const decimals = Math.max(0, -Math.floor(Math.log10(step)));
    for (let i = Math.ceil(left / step); i * step <= right; i++) {
      const [u] = this.at(i * step, 0);
      context.strokeRect(u, 0, 0, this.height ?? 0);
      context.fillText(fixed(i * step, decimals), u + 3, (this.height ?? 0) - 5);
    }
    for (let i = Math.ceil(bottom / step); i * step <= top; i++) {
      const [, v] = this.at(0, i * step);
      context.strokeRect(0, v, this.width ?? 0, 0);
      context.fillText(`${fixed(i * step, decimals)} mm`, 4, v - 4);
    }
  }

  /**
   * The sigma of the panel's fit, behind the holes.
   * @param {CanvasRenderingContext2D} context
   */
  drawFitSigma(context) {
    const panel = this.facts.series.filter((/** @type {any} */ one) => one.level === "panel" && one.fit).pop();
    const range = this.columns && extremes(this.columns.sigma_um);
    if (!panel || !range) return;
    const cell_px = 12;
    context.globalAlpha = 0.28;
    for (let u = 0; u < (this.width ?? 0); u += cell_px) {
      for (let v = 0; v < (this.height ?? 0); v += cell_px) {
        const [x, y] = this.under(u + cell_px / 2, v + cell_px / 2);
        const sigma = fitSigma_um(panel.fit.map.covariance, x, y);
        context.fillStyle = scaleCss((sigma - range[0]) / Math.max(1e-9, range[1] - range[0]));
        context.fillRect(u, v, cell_px, cell_px);
      }
    }
    context.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {import("./map_colours.js").MapColumns} columns
   * @param {ReturnType<typeof colouring>} paint
   * @param {number} ratio
   */
  drawPlaces(context, columns, paint, ratio) {
    const width = this.width ?? 0;
    const height = this.height ?? 0;
    const [left, top] = this.under(-20, -20);
    const [right, bottom] = this.under(width + 20, height + 20);
    const seen = [];
    for (let i = 0; i < columns.n && seen.length <= maxDiscs; i++) {
      const x = Number(columns.x_mm[i]);
      const y = Number(columns.y_mm[i]);
      if (x >= left && x <= right && y >= bottom && y <= top) seen.push(i);
    }
    if (seen.length > maxDiscs) {
      this.drawPixels(context, columns, paint, ratio);
      return;
    }
    const least_px = seen.length > 4000 ? 1 : 1.6;
    for (const i of seen) {
      const [u, v] = this.at(Number(columns.x_mm[i]), Number(columns.y_mm[i]));
      const diameter_mm = Number(columns.kind[i]) === 2 ? 0 : Number(this.diameters.get(Number(columns.tool[i])) ?? 0);
      context.fillStyle = paint.css(i);
      context.beginPath();
      context.arc(u, v, Math.max(least_px, diameter_mm * this.px_per_mm / 2), 0, 2 * Math.PI);
      context.fill();
    }
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {import("./map_colours.js").MapColumns} columns
   * @param {ReturnType<typeof colouring>} paint
   * @param {number} ratio
   */
  drawPixels(context, columns, paint, ratio) {
    const width = this.canvas.width;
    const height = this.canvas.height;
    const picture = context.getImageData(0, 0, width, height);
    const pixels = new Uint32Array(picture.data.buffer);
    const scale = this.px_per_mm * ratio;
    const from_u = width / 2 - this.center[0] * scale;
    const from_v = height / 2 + this.center[1] * scale;
    for (let i = 0; i < columns.n; i++) {
      const u = Math.round(from_u + Number(columns.x_mm[i]) * scale);
      const v = Math.round(from_v - Number(columns.y_mm[i]) * scale);
      if (u < 0 || v < 0 || u + 1 >= width || v + 1 >= height) continue;
      const value = paint.pixel(i);
      const at = v * width + u;
      pixels[at] = pixels[at + 1] = pixels[at + width] = pixels[at + width + 1] = value;
    }
    context.putImageData(picture, 0, 0);
  }

  /**
   * Rings of the panel's targets, squares of a board's, diamonds of measured holes, and residuals.
   * @param {CanvasRenderingContext2D} context
   */
  drawTargets(context) {
    const targets = this.facts.targets;
    const longest = Math.max(0, ...targets.map((/** @type {any} */ t) => t.residual_um ? Math.hypot(...t.residual_um) : 0));
    this.px_per_um = longest > 0 ? longestArrow_px / longest : 0;
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "left";
    for (const target of targets) {
      const [u, v] = this.at(target.nominal_mm[0], target.nominal_mm[1]);
      const isBad = target.state !== "good";
      context.strokeStyle = colour(target.state === "refused" ? "bad" : isBad ? "warn" : "ink");
      context.lineWidth = isBad ? 2.4 : 1.3;
      const level = target.series === null ? "hole" : this.facts.series[target.series].level;
      context.beginPath();
      if (level === "panel") context.arc(u, v, 7, 0, 2 * Math.PI);
      else if (level === "board") context.rect(u - 4.5, v - 4.5, 9, 9);
      else for (const [a, b] of [[0, -6], [6, 0], [0, 6], [-6, 0], [0, -6]]) context.lineTo(u + a, v + b);
      context.stroke();
      if (targets.length <= 60 || isBad) {
        context.fillStyle = colour("ink");
        context.fillText(`#${target.seq}`, u + 9, v - 7);
      }
      if (this.showsResiduals && target.residual_um) {
        drawArrow(context, u, v, target.residual_um[0] * this.px_per_um, -target.residual_um[1] * this.px_per_um,
          colour(isBad ? "bad" : "link"));
      }
    }
    if (this.showsResiduals && longest > 0) this.drawReference(context, longest);
  }

  /**
   * How long an arrow of a round length is.
   * @param {CanvasRenderingContext2D} context
   * @param {number} longest
   */
  drawReference(context, longest) {
    const power = 10 ** Math.floor(Math.log10(longest));
    const length_um = [5, 2, 1].map((k) => k * power).find((l) => l <= longest) ?? longest;
    const y = 18;
    const x = (this.width ?? 0) - 150;
    context.fillStyle = colour("paper");
    context.globalAlpha = 0.8;
    context.fillRect(x - 12, y - 14, 158, 28);
    context.globalAlpha = 1;
    drawArrow(context, x, y, length_um * (this.px_per_um ?? 0), 0, colour("link"));
    context.fillStyle = colour("ink");
    context.textAlign = "right";
    context.fillText(word("map_residual_scale", { length: shortest(length_um) }), (this.width ?? 0) - 8, y + 4);
    context.textAlign = "left";
  }

  /** @param {ReturnType<typeof colouring>} paint */
  showLegend(paint) {
    if (!paint.range) {
      this.legend.replaceChildren(...this.facts.places.tools.map((/** @type {any} */ tool, /** @type {number} */ i) =>
        element("li", {}, element("span", { class: "dot", style: { background: categoryColour(i) } }),
          `T${tool.number}${tool.diameter_mm === null ? "" : ` \u00f8\u00a0${fixed(tool.diameter_mm, 3)} mm`}, `,
          [tool.n_holes > 0 && word("map_counts", { holes: fixed(tool.n_holes, 0) }),
            tool.n_slots > 0 && word("map_slots", { n: fixed(tool.n_slots, 0) }),
            tool.n_routs > 0 && word("map_routs", { n: fixed(tool.n_routs, 0) })].filter(Boolean).join(", "))));
      return;
    }
    const stops = Array.from({ length: 9 }, (_, i) => scaleCss(i / 8)).join(", ");
    const end = (/** @type {number} */ value) => paint.isLogarithm ? probability(10 ** value) : micrometres(value, 2);
    this.legend.replaceChildren(element("li", {}, `${end(paint.range[0])} `,
      element("span", { class: "scale", style: { background: `linear-gradient(to right, ${stops})` } }),
      ` ${end(paint.range[1])}`));
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} u
 * @param {number} v
 * @param {number} du
 * @param {number} dv
 * @param {string} css
 */
function drawArrow(context, u, v, du, dv, css) {
  const length = Math.hypot(du, dv);
  if (!(length > 0.5)) return;
  const head = Math.min(7, 0.4 * length);
  const [a, b] = [du / length * head, dv / length * head];
  context.strokeStyle = css;
  context.lineWidth = 1.8;
  context.beginPath();
  context.moveTo(u, v);
  context.lineTo(u + du, v + dv);
  context.moveTo(u + du - a - b / 2, v + dv - b + a / 2);
  context.lineTo(u + du, v + dv);
  context.lineTo(u + du - a + b / 2, v + dv - b - a / 2);
  context.stroke();
}

/**
 * The figure with its controls; null where there is nothing to draw.
 * @param {any} facts
 */
export function jobMap(facts) {
  const map = new JobMap(facts);
  if (!map.box) return null;
  const columns = map.columns;
  const has = (/** @type {string} */ mode) => columns && (mode === "tool" ||
    (mode === "risk" ? extremes(columns.risk) !== null
      : (extremes(mode === "shift" ? columns.shift_um : columns.sigma_um)?.[1] ?? 0) > 0));
  const modes = /** @type {const} */ (["tool", "shift", "sigma", "risk"]).filter(has);
  const choice = element("select", {
    onchange: () => {
      map.mode = choice.value;
      map.draw();
    },
  }, modes.map((mode) => element("option", { value: mode }, word(`colour_${mode}`))));
  const button = (/** @type {string} */ sign, /** @type {string} */ label, /** @type {() => void} */ act) =>
    element("button", { type: "button", title: label, "aria-label": label, onclick: () => { act(); map.ask(); } }, sign);
  const middle = () => /** @type {[number, number]} */ ([(map.width ?? 0) / 2, (map.height ?? 0) / 2]);
  const hasResiduals = facts.targets.some((/** @type {any} */ target) => target.residual_um);
  const residuals = element("input", { type: "checkbox", checked: true, onchange: () => {
    map.showsResiduals = residuals.checked;
    map.draw();
  } });
  return element("figure", {},
    element("div", { class: "controls" },
      modes.length > 1 && element("label", {}, `${word("map_colour_by")} `, choice),
      hasResiduals && element("label", {}, residuals, ` ${word("map_show_residuals")}`),
      button("+", word("zoom_in"), () => map.zoom(1.4, ...middle())),
      button("\u2212", word("zoom_out"), () => map.zoom(1 / 1.4, ...middle())),
      button("\u2922", word("zoom_fit"), () => map.fit())),
    map.frame, map.legend,
    element("figcaption", {}, word("map_caption")));
}
