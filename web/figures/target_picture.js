// SPDX-License-Identifier: Apache-2.0
// A target as the camera saw it: the piece of picture with outline, centre, and the ellipse that
// holds the true centre in 95 of 100 pictures, magnified where it would be too small to see.
import { element, svg } from "../base/dom.js";
import { word } from "../base/words.js";
import { fixed } from "../base/format.js";

/** Of one standard deviation: chi square of two degrees of freedom exceeds its square in 5 %. */
export const ellipse95 = Math.sqrt(5.991);

/**
 * Half axes and direction of the 95 % ellipse of a covariance.
 * @param {[number, number, number]} covariance [xx, xy, yy]
 */
export function ellipseOf([xx, xy, yy]) {
  const mean = (xx + yy) / 2;
  const span = Math.hypot((xx - yy) / 2, xy);
  return {
    major: ellipse95 * Math.sqrt(Math.max(0, mean + span)),
    minor: ellipse95 * Math.sqrt(Math.max(0, mean - span)),
    angle_deg: 0.5 * Math.atan2(2 * xy, xx - yy) * 180 / Math.PI,
  };
}

/**
 * How many times larger an ellipse is drawn in a picture, so that it is seen; 0 if there is none.
 * @param {number} major its longer half axis
 * @param {number} side of the picture
 */
export function magnificationOf(major, side) {
  const times = 10 ** Math.floor(Math.log10(side / 5 / major));
  return major > 0 && Number.isFinite(times) ? Math.max(1, times) : 0;
}

/** @param {number[]} flat x and y in turn */
function outlinePath(flat) {
  let path = "";
  for (let i = 0; i + 1 < flat.length; i += 2) path += `${i === 0 ? "M" : "L"}${flat[i]} ${flat[i + 1]}`;
  return path;
}

/**
 * @param {any} crop of a picture in the facts
 * @param {string} source
 * @param {string} label
 * @param {boolean} isGood
 * @param {boolean} isLarge with the reasons of the other places as titles, and the magnification
 */
export function targetPicture(crop, source, label, isGood, isLarge) {
  const { left_px, top_px, width_px, height_px, centre_px } = crop;
  const side = Math.max(width_px, height_px);
  /** @type {SVGElement[]} */
  const children = [svg("image", {
    href: source, x: left_px, y: top_px, width: width_px, height: height_px, preserveAspectRatio: "none",
  })];
  for (const other of crop.others) {
    children.push(svg("g", { class: other.counts ? "candidate" : "other" },
      other.counts ? svg("title", {}, word("candidate_counts")) : svg("title", { lang: "en" }, other.reason),
      svg("circle", { cx: other.centre_px[0], cy: other.centre_px[1], r: Math.max(side / 40, other.size_px / 2) })));
  }
  const kind = isGood ? "outline" : "outline refused";
  for (const outline of crop.outlines_px) children.push(svg("path", { class: kind, d: outlinePath(outline) }));
  let magnified = 0;
  if (centre_px && centre_px[0] !== null) {
    const [x, y] = centre_px;
    const arm = side / 28;
    children.push(svg("path", { class: kind, d: `M${x - arm} ${y}h${2 * arm}M${x} ${y - arm}v${2 * arm}` }));
    const ellipse = ellipseOf(crop.covariance_px2);
    magnified = magnificationOf(ellipse.major, side);
    if (magnified > 0) {
      children.push(svg("ellipse", {
        class: "ellipse", cx: x, cy: y, rx: magnified * ellipse.major, ry: magnified * ellipse.minor,
        transform: `rotate(${ellipse.angle_deg} ${x} ${y})`,
      }));
    }
  }
  const drawing = svg("svg", {
    class: "target", viewBox: `${left_px} ${top_px} ${width_px} ${height_px}`, role: "img", "aria-label": label,
  }, children);
  if (!isLarge) return drawing;
  return element("div", {}, drawing, element("p", { class: "quiet" }, label, ". ",
    magnified > 0 && word("ellipse_note", { magnified: fixed(magnified, 0) })));
}

/**
 * A small picture that opens large in a dialog.
 * @param {string} source
 * @param {string} label
 * @param {boolean} isGood
 */
export function targetThumbnail(crop, source, label, isGood) {
  const open = () => {
    const dialog = element("dialog", { class: "large", onclick: () => dialog.close(), onclose: () => dialog.remove() },
      targetPicture(crop, source, label, isGood, true),
      element("button", { type: "button", autofocus: true }, word("close")));
    document.body.append(dialog);
    dialog.showModal();
  };
  return element("button", { type: "button", class: "thumbnail", title: word("show_large"), onclick: open },
    targetPicture(crop, source, label, isGood, false));
}

/** Where the views of a target lay, and what each saw: frames in mm from work zero. */
export function viewsPlan(target) {
  const views = target.pictures.filter((one) => one.frame_mm.length >= 3);
  if (views.length < 2) return null;
  const points = [target.expected_mm, ...views.flatMap((one) => one.frame_mm)];
  const xs = points.map((p) => p[0]);
  const ys = points.map((p) => -p[1]);
  const [left, top] = [Math.min(...xs), Math.min(...ys)];
  const width = Math.max(...xs) - left;
  const height = Math.max(...ys) - top;
  const arm = Math.max(width, height) / 40;
  const cross = (/** @type {number[]} */ [x, y], /** @type {string} */ kind, size = 1) => svg("path", {
    class: kind, d: `M${x - size * arm} ${-y}h${2 * size * arm}M${x} ${-y - size * arm}v${2 * size * arm}`,
  });
  const frames = views.map((view) => {
    const kind = view.status === "found" ? "seen" : view.status === "not_found" ? "axis" : "refused";
    const path = view.frame_mm.map((/** @type {number[]} */ p, /** @type {number} */ i) =>
      `${i === 0 ? "M" : "L"}${p[0]} ${-p[1]}`).join("");
    return svg("g", {}, svg("path", { class: kind, d: `${path}Z` }),
      svg("text", { x: view.frame_mm[0][0] + arm / 2, y: -view.frame_mm[0][1] - arm / 2, style: { "font-size": `${3 * arm}px` } },
        view.view + 1),
      view.seen_mm && cross(view.seen_mm, kind));
  });
  return element("figure", {},
    svg("svg", { class: "views", viewBox: `${left - arm} ${top - arm} ${width + 2 * arm} ${height + 2 * arm}`,
      role: "img", "aria-label": word("views_label") },
      frames,
      target.search_radius_mm && svg("circle", { class: "dashed", cx: target.expected_mm[0],
        cy: -target.expected_mm[1], r: target.search_radius_mm }),
      cross(target.expected_mm, "dashed", 0.7),
      target.measured && cross(target.measured.place_mm, "seen", 1.5)),
    element("figcaption", {}, word("views_caption", { n: views.length })));
}
