// SPDX-License-Identifier: Apache-2.0
// What the camera sees now: the picture with search window, outline, centre and candidates. A person points at
// places of it, in px of the camera: the centre of the top left pixel is (0, 0), y runs down.
import { element, meter } from "../base/dom.js";
import { fixed, percent, place } from "../base/format.js";
import { word } from "../base/words.js";
import { arrowKeys, preparedContext, redrawn } from "../figures/plane.js";
import { ellipse95, magnificationOf } from "../figures/target_picture.js";
import { desk, job } from "./desk.js";

/** @typedef {[number, number]} Pixel */

/** Colours that show on any picture, whatever the theme is. */
const ink = { search: "#56b4e9", found: "#3ddc84", ellipse: "#ffd166", candidate: "#ffd166", cross: "#ff8ad8", middle: "#ffffff90" };
/** The part about the cross is shown this many times larger, in a square of this part of the width. */
const loupe = { times: 3, share: 0.28 };
const fineStep_px = 0.25;

/** The ellipse that holds the true centre in 95 of 100 pictures, from one standard deviation.
 * @param {any} ellipse */
const halfAxes = (ellipse) => ellipse.axes_px.map((/** @type {number} */ sigma_px) => ellipse95 * sigma_px);

export class LivePicture {
  /** @param {{answer: (choice: "search" | "hand", at_px: Pixel) => void, jog: (way: [number, number]) => void, changed: () => void}} asked */
  constructor(asked) {
    this.asked = asked;
    /** What a click means: nothing, a new place to search, or the place of the target.
     * @type {"" | "search" | "hand"} */
    this.mode = "";
    /** Where the target is placed by hand.
     * @type {Pixel | null} */
    this.cross_px = null;
    /** @type {HTMLImageElement | null} */
    this.image = null;
    /** Numbers of the picture that is shown, and of the newest. */
    this.shown = -1;
    this.newest = -1;
    this.isLoading = false;
    /** Pixels of the camera that one of the picture has along each side: large ones are sent smaller. */
    this.factor = 1;
    /** Size of the camera's picture, px. */
    this.across = this.up = 1;
    /** On the page: its px for one of the camera, and where the picture begins. */
    this.scale = 1;
    this.left = 0;
    this.canvas = element("canvas", { id: "picture", role: "img", tabindex: 0,
      onpointerdown: (/** @type {PointerEvent} */ event) => this.press(event),
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.key(event) });
    this.node = element("div", { class: "live" }, this.canvas);
    this.redraw = redrawn(this.canvas, () => this.draw());
  }

  /** @param {"" | "search" | "hand"} mode */
  choose(mode) {
    this.mode = this.mode === mode ? "" : mode;
    // To where the stage has brought it.
    this.cross_px = this.mode === "hand" ? [(this.across - 1) / 2, (this.up - 1) / 2] : null;
    if (this.mode) this.canvas.focus();
    this.redraw();
    this.asked.changed();
  }

  /** Loads the newest picture; those that come meanwhile are passed over.
   * @param {number} number */
  async load(number) {
    this.newest = number;
    if (this.isLoading) return;
    this.isLoading = true;
    while (this.shown !== this.newest) {
      const wanted = this.newest, image = new Image();
      image.src = `api/frame.jpg?n=${wanted}`;
      try {
        await image.decode();
      } catch {
        break;
      }
      const isFirst = this.image === null;
      this.image = image;
      this.shown = wanted;
      this.redraw();
      if (isFirst) this.asked.changed();
    }
    this.isLoading = false;
  }

  /** A place may be pointed at: the server knows by the number of the picture whether the stage has moved since. */
  isLive() {
    return Boolean(desk.state?.view && this.image && desk.condition === "open");
  }

  /** @param {Pixel} at_px @returns {Pixel} css px of the canvas */
  point([x, y]) {
    return [this.left + this.scale * (x + 0.5), this.scale * (y + 0.5)];
  }

  /** @param {PointerEvent} event */
  press(event) {
    const box = this.canvas.getBoundingClientRect();
    if (!this.mode || !this.isLive()) return;
    // The canvas has whole pixels, its place on the page may be a fraction wider.
    const x = (event.clientX - box.left) * this.canvas.clientWidth / box.width, y = event.clientY - box.top;
    const at = /** @type {Pixel} */ ([(x - this.left) / this.scale - 0.5, y / this.scale - 0.5]);
    if (at[0] < -0.5 || at[1] < -0.5 || at[0] > this.across - 0.5 || at[1] > this.up - 0.5) return;
    if (this.mode === "search") this.asked.answer("search", at);
    else this.moveCross(at);
  }

  /** @param {Pixel} at_px */
  moveCross([x, y]) {
    this.cross_px = [Math.min(this.across - 1, Math.max(0, x)), Math.min(this.up - 1, Math.max(0, y))];
    this.redraw();
    this.asked.changed();
  }

  /** Arrows move the cross by a fraction of a pixel (with Shift by ten), or else the stage.
   * @param {KeyboardEvent} event */
  key(event) {
    const way = arrowKeys[event.key], cross = this.cross_px;
    if (way && cross) {
      const step = event.shiftKey ? 10 : fineStep_px;
      this.moveCross([cross[0] + step * way[0], cross[1] - step * way[1]]);
    } else if (way) {
      this.asked.jog(way);
    } else if (event.key === "Enter" && cross && this.isLive()) {
      this.asked.answer("hand", cross);
    } else {
      return;
    }
    event.preventDefault();
  }

  draw() {
    const { canvas, image } = this, { view } = desk.state ?? {}, width = canvas.clientWidth;
    const size = image ? [image.naturalWidth, image.naturalHeight] : [4, 3];
    this.factor = image && view ? Math.max(1, Math.round(view.width_px / image.naturalWidth)) : 1;
    [this.across, this.up] = size.map((side) => this.factor * side);
    this.scale = Math.min(width / this.across, Math.max(240, 0.66 * innerHeight) / this.up);
    this.left = (width - this.scale * this.across) / 2;
    const shown = [this.scale * this.across, this.scale * this.up];
    const context = preparedContext(canvas, width, Math.round(shown[1]));
    context.fillStyle = "#000";
    context.fillRect(this.left, 0, shown[0], shown[1]);
    const label = [word("serve_live"), this.mode && word(this.mode === "search" ? "serve_click_search" : "serve_click_hand")];
    canvas.setAttribute("aria-label", label.filter(Boolean).join(". "));
    canvas.classList.toggle("aimed", Boolean(this.mode) && this.isLive());
    if (image) {
      context.globalAlpha = desk.condition === "open" ? 1 : 0.35;
      context.drawImage(image, this.left, 0, shown[0], shown[1]);
      context.globalAlpha = 1;
      canvas.dataset.frame = String(this.shown);
    }
    if (image && view && desk.condition === "open") this.drawFindings(context, view);
    if (image && this.cross_px) this.drawLoupe(context, image);
    const said = !image ? word("serve_no_picture_yet") : desk.condition !== "open" ? word("serve_old_picture") : "";
    this.drawWords(context, said, width / 2, shown[1] / 2, "center");
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {any} view
   */
  drawFindings(context, view) {
    const { scale } = this;
    const line = (/** @type {string} */ css, /** @type {() => void} */ trace, /** @type {number[]} */ dashes = []) => {
      context.beginPath();
      trace();
      context.setLineDash(dashes);
      for (const [style, width] of /** @type {[string, number][]} */ ([["#000a", 3.5], [css, 1.6]])) {
        context.strokeStyle = style;
        context.lineWidth = width;
        context.stroke();
      }
      context.setLineDash([]);
    };
    const ring = (/** @type {Pixel} */ at_px, /** @type {number} */ radius_px) => {
      const [x, y] = this.point(at_px);
      context.moveTo(x + scale * radius_px, y);
      context.arc(x, y, scale * radius_px, 0, 7);
    };
    const cross = (/** @type {Pixel} */ at_px, /** @type {number} */ arm) => {
      const [x, y] = this.point(at_px);
      context.moveTo(x - arm, y);
      context.lineTo(x + arm, y);
      context.moveTo(x, y - arm);
      context.lineTo(x, y + arm);
    };
    line(ink.middle, () => cross([(this.across - 1) / 2, (this.up - 1) / 2], 16));
    if (view.search?.radius_px) line(ink.search, () => ring(view.search.at_px, view.search.radius_px), [7, 5]);
    if (view.outline_px?.length > 1) {
      line(ink.found, () => {
        for (const at_px of view.outline_px) context.lineTo(...this.point(at_px));
        context.closePath();
      });
    }
    if (view.ellipse) {
      const { at_px, angle_rad } = view.ellipse, [major, minor] = halfAxes(view.ellipse);
      const grown = scale * magnificationOf(major, view.width_px);
      line(ink.found, () => cross(at_px, 10));
      if (grown > 0) line(ink.ellipse, () => context.ellipse(...this.point(at_px), grown * major, grown * minor, angle_rad, 0, 7));
    }
    job()?.question?.candidates?.forEach((one, i) => {
      const radius_px = Math.max(6 / scale, one.size_px / 2), [x, y] = this.point(one.at_px);
      line(ink.candidate, () => ring(one.at_px, radius_px));
      this.drawWords(context, String(i + 1), x + scale * radius_px + 4, y, "left");
    });
    if (this.cross_px) line(ink.cross, () => cross(/** @type {Pixel} */ (this.cross_px), 22));
  }

  /**
   * The pixels about the cross, in the corner that is away from it.
   * @param {CanvasRenderingContext2D} context
   * @param {HTMLImageElement} image
   */
  drawLoupe(context, image) {
    const [x_px, y_px] = /** @type {Pixel} */ (this.cross_px), { factor } = this, width = this.scale * this.across;
    const side = loupe.share * width, seen = side / this.scale / loupe.times / factor;
    const x = x_px > this.across / 2 ? this.left : this.left + width - side;
    context.imageSmoothingEnabled = false;
    context.fillStyle = "#000";
    context.fillRect(x, 0, side, side);
    context.drawImage(image, (x_px + 0.5) / factor - seen / 2, (y_px + 0.5) / factor - seen / 2, seen, seen, x, 0, side, side);
    context.strokeStyle = ink.cross;
    context.lineWidth = 1;
    context.strokeRect(x, 0, side, side);
    context.beginPath();
    for (const [dx, dy] of [[0.5, 0], [0, 0.5]]) {
      context.moveTo(x + side * (0.5 - dx), side * (0.5 - dy));
      context.lineTo(x + side * (0.5 + dx), side * (0.5 + dy));
    }
    context.stroke();
    context.imageSmoothingEnabled = true;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {string} text
   * @param {number} x
   * @param {number} y
   * @param {CanvasTextAlign} align
   */
  drawWords(context, text, x, y, align) {
    context.font = "600 16px system-ui, sans-serif";
    context.textAlign = align;
    context.textBaseline = "middle";
    context.lineWidth = 4;
    context.strokeStyle = "#000";
    context.strokeText(text, x, y);
    context.fillStyle = "#fff";
    context.fillText(text, x, y);
  }
}

/** What is known of the picture, in words and bars. */
export function pictureFacts() {
  const { view } = desk.state;
  if (!view) return null;
  const bar = (/** @type {import("../base/words.js").WordKey} */ title, /** @type {number | null | undefined} */ share) =>
    typeof share === "number" && element("div", { class: "bar" }, element("span", { class: "quiet" }, word(title)), meter(share),
      element("span", {}, percent(share, 0)));
  const ellipse = view.ellipse && magnificationOf(halfAxes(view.ellipse)[0], view.width_px);
  return [element("div", { class: "bars" }, bar("contrast", view.contrast), bar("focus", view.sharpness)),
    element("p", { class: "quiet" }, view.um_per_px > 0 && word("serve_place", { place: place(view.place_mm) }),
      ellipse > 0 && ` ${word("ellipse_note", { magnified: fixed(ellipse, 0) })}`)];
}
