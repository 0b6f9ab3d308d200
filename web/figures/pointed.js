// SPDX-License-Identifier: Apache-2.0
// Figures that fill the width they are given and say their points in words, and their scales.
import { element, svg } from "../base/dom.js";

/** A picture at some width, with the places (px of its own) that can be pointed at.
 * @typedef {{picture: SVGSVGElement, drawn: {x: number, y: number, lines: string[]}[]}} Drawn */

/**
 * What is said of a place: beside it, on the side that has more room; nothing hides it.
 * @param {HTMLElement} hint
 * @param {import("../base/dom.js").Child[] | null | undefined} lines
 * @param {number} x of the place, px
 * @param {number} y
 * @param {number} width of the figure, px
 */
export function showHint(hint, lines, x, y, width) {
  hint.hidden = !lines;
  if (!lines) return;
  hint.replaceChildren(...lines.map((line) => element("div", {}, line)));
  const isLeft = x < width / 2;
  hint.style.left = isLeft ? `${x + 14}px` : "auto";
  hint.style.right = isLeft ? "auto" : `${width - x + 14}px`;
  hint.style.top = `${Math.max(0, y - 20)}px`;
}

/**
 * Draws again when its width changes. The pointer and the arrow keys choose a place, whose lines show.
 * @param {(width: number) => Drawn} draw
 * @param {number} weight of y in how far away a place is, against x
 * @param {import("../base/dom.js").Child[]} caption
 */
export function pointedFigure(draw, weight, caption) {
  const hint = element("div", { class: "hint", role: "status", hidden: true });
  const holder = element("div", { class: "pointed-holder" }, hint);
  let shown = draw(560);
  let chosen = -1;

  const choose = (/** @type {number} */ i) => {
    chosen = i;
    const one = shown.drawn[i];
    shown.picture.querySelector(".chosen")?.remove();
    const scale = shown.picture.clientWidth / shown.picture.viewBox.baseVal.width || 1;
    showHint(hint, one?.lines, one?.x * scale, one?.y * scale, holder.clientWidth);
    if (one) shown.picture.append(svg("circle", { class: "chosen", cx: one.x, cy: one.y, r: 9 }));
  };
  const nearest = (/** @type {PointerEvent} */ event) => {
    const box = shown.picture.getBoundingClientRect();
    const scale = shown.picture.viewBox.baseVal.width / box.width;
    const away = shown.drawn.map((one) => Math.hypot(one.x - scale * (event.clientX - box.left),
      weight * (one.y - scale * (event.clientY - box.top))));
    choose(away.indexOf(Math.min(...away)));
  };
  const key = (/** @type {KeyboardEvent} */ event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const last = shown.drawn.length - 1;
    if (event.key === "Escape") choose(-1);
    if (!step || last < 0) return;
    event.preventDefault();
    choose(chosen < 0 && step < 0 ? last : Math.min(last, Math.max(0, chosen + step)));
  };
  const show = (/** @type {number} */ width) => {
    shown.picture.remove();
    shown = draw(Math.max(280, Math.round(width)));
    shown.picture.addEventListener("pointermove", nearest);
    shown.picture.addEventListener("pointerdown", nearest);
    shown.picture.addEventListener("pointerleave", () => choose(-1));
    shown.picture.addEventListener("keydown", key);
    shown.picture.addEventListener("blur", () => choose(-1));
    holder.prepend(shown.picture);
    choose(-1);
  };
  show(560);
  new ResizeObserver(([entry]) => {
    const width = Math.round(entry.contentRect.width);
    if (width > 0 && width !== shown.picture.viewBox.baseVal.width) show(width);
  }).observe(holder);
  return element("figure", {}, holder, caption.length ? element("figcaption", {}, caption) : null);
}
