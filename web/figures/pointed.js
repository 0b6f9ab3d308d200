// SPDX-License-Identifier: Apache-2.0
// Figures that fill the width they are given and say their points in words, and their scales.
import { element, svg } from "../base/dom.js";

/** A picture at some width, with the places (px of its own) that can be pointed at.
 * @typedef {{picture: SVGSVGElement, drawn: {x: number, y: number, lines: string[]}[]}} Drawn */

/** @param {number} step */
export function decimalsOf(step) {
  return Math.min(9, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
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
    hint.hidden = !one;
    shown.picture.querySelector(".chosen")?.remove();
    if (!one) return;
    hint.replaceChildren(...one.lines.map((line) => element("div", {}, line)));
    shown.picture.append(svg("circle", { class: "chosen", cx: one.x, cy: one.y, r: 9 }));
    // Beside the place, on the side that has room.
    const scale = shown.picture.clientWidth / shown.picture.viewBox.baseVal.width || 1;
    const left = one.x * scale + 12;
    const isOver = left + hint.offsetWidth > holder.clientWidth;
    hint.style.left = `${Math.max(0, isOver ? one.x * scale - 12 - hint.offsetWidth : left)}px`;
    hint.style.top = `${Math.max(0, one.y * scale - 10)}px`;
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
