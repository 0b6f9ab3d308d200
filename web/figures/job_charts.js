// SPDX-License-Identifier: Apache-2.0
// Small charts of a job: risks by decade, sharpness over height, shares of the error budget, the
// surface that depths are judged by.
import { element, svg } from "../base/dom.js";
import { word } from "../base/words.js";
import { fixed, micrometres, millimetres, whole } from "../base/format.js";
import { scaleColour, scaleCss } from "../base/colours.js";
import { extremes } from "./place_index.js";

/**
 * How many places have which risk; heights are logarithms, so that one beside a million is seen.
 * @param {any} tolerance facts.tolerance
 */
export function riskChart(tolerance) {
  const decades = tolerance.decades;
  if (decades.length === 0) return null;
  const [bar, plot, top, left] = [46, 120, 20, 14];
  const count = (/** @type {any} */ d) => d.n_good + d.n_warned + d.n_held;
  const most = Math.max(1, ...decades.map(count));
  const height = (/** @type {number} */ n) => n === 0 ? 0 : Math.max(4, plot * Math.log10(1 + n) / Math.log10(1 + most));
  const width = 2 * left + bar * decades.length;
  const limit = (/** @type {number} */ probability, /** @type {string} */ name) => {
    const at = Math.log10(Math.max(probability, 1e-13)) - decades[0].below_exponent + 1;
    const x = left + bar * Math.min(decades.length, Math.max(0, at));
    return [svg("path", { class: "dashed", d: `M${x} ${top - 4}V${top + plot}` }),
      svg("text", { class: "middle", x, y: top + plot + 34 }, name)];
  };
  return element("figure", {},
    svg("svg", { viewBox: `0 0 ${width} ${top + plot + 40}`, width, role: "img", "aria-label": word("risk_chart") },
      decades.map((/** @type {any} */ decade, /** @type {number} */ i) => {
        const n = count(decade);
        const x = left + bar * i;
        let y = top + plot - height(n);
        const parts = [["bad", decade.n_held], ["warn", decade.n_warned], ["good", decade.n_good]];
        return svg("g", {},
          n > 0 && svg("text", { class: "middle", x: x + bar / 2, y: y - 4 }, whole(n)),
          parts.filter(([, part]) => part > 0).map(([kind, part]) => {
            const part_height = height(n) * part / n;
            y += part_height;
            return svg("rect", { x: x + 3, y: y - part_height, width: bar - 6, height: part_height, class: `fill-${kind}` });
          }),
          i > 0 && svg("text", { class: "middle", x, y: top + plot + 16 }, `1e${decade.below_exponent - 1}`));
      }),
      svg("path", { class: "axis", d: `M${left} ${top + plot}H${width - left}` }),
      limit(tolerance.warn_above, word("limit_warn")), limit(tolerance.hold_above, word("limit_hold"))),
    element("figcaption", {}, word("risk_chart_caption")));
}

/**
 * Sharpness of an autofocus over the camera's height, and where it was found sharpest.
 * @param {any} focus
 */
export function focusCurve(focus) {
  const heights = extremes(focus.curve.map((/** @type {any} */ s) => s.z_mm));
  const most = extremes(focus.curve.map((/** @type {any} */ s) => s.sharpness));
  if (!heights || !most || !(most[1] > 0)) return null;
  const [width, height, margin] = [420, 160, 28];
  const x = (/** @type {number} */ z) => margin + (width - 2 * margin) * (z - heights[0]) / Math.max(1e-9, heights[1] - heights[0]);
  const y = (/** @type {number} */ s) => height - margin - (height - 2 * margin) * Math.max(0, s / most[1]);
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, width, role: "img", "aria-label": word("focus_chart") },
    svg("path", { class: "axis", d: `M${margin} ${margin}V${height - margin}H${width - margin}` }),
    focus.curve.map((/** @type {any} */ s) => s.z_mm !== null &&
      svg("circle", { class: "point", cx: x(s.z_mm), cy: y(s.sharpness), r: 2.4 },
        svg("title", {}, `${millimetres(s.z_mm, 4)}: ${fixed(s.sharpness, 2)}`))),
    focus.z_mm !== null && svg("path", { class: "dashed", d: `M${x(focus.z_mm)} ${margin}V${height - margin}` }),
    heights.map((z) => svg("text", { class: "middle", x: x(z), y: height - 8 }, millimetres(z))));
}

/**
 * The surface of the board within what was probed, hover tells height and sigma; crosses are where
 * each tool is likeliest to be too shallow or too deep.
 * @param {any} map one of facts.depth.maps
 * @param {any[]} tools facts.depth.tools
 * @param {boolean} hasAxes
 */
export function depthMap(map, tools, hasAxes) {
  const range = extremes(map.height_mm);
  if (!range) return null;
  const span = Math.max(1e-9, range[1] - range[0]);
  const canvas = element("canvas", { width: map.n_x, height: map.n_y, class: "field", role: "img",
    "aria-label": word("depth_map") });
  const context = canvas.getContext("2d");
  if (!context) return null;
  const picture = context.createImageData(map.n_x, map.n_y);
  map.height_mm.forEach((/** @type {number | null} */ height, /** @type {number} */ i) => {
    if (height === null) return;
    const at = 4 * ((map.n_y - 1 - Math.floor(i / map.n_x)) * map.n_x + i % map.n_x);
    picture.data.set([...scaleColour((height - range[0]) / span), 255], at);
  });
  context.putImageData(picture, 0, 0);
  const readout = element("p", { class: "quiet", role: "status" }, word("depth_map_hover"));
  const cell = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    const column = Math.min(map.n_x - 1, Math.floor((event.clientX - box.left) / box.width * map.n_x));
    const row = map.n_y - 1 - Math.min(map.n_y - 1, Math.floor((event.clientY - box.top) / box.height * map.n_y));
    return row * map.n_x + column;
  };
  canvas.addEventListener("pointermove", (event) => {
    const i = cell(event);
    if (map.height_mm[i] === undefined || map.height_mm[i] === null) return;
    readout.textContent = word("depth_map_at", {
      x: fixed(map.low_mm[0] + (i % map.n_x) * map.step_mm, 1), y: fixed(map.low_mm[1] + Math.floor(i / map.n_x) * map.step_mm, 1),
      height: millimetres(map.height_mm[i], 4), sigma: micrometres(map.sigma_um[i], 2),
    });
  });
  const width_mm = Math.max(1e-9, (map.n_x - 1) * map.step_mm);
  const height_mm = Math.max(1e-9, (map.n_y - 1) * map.step_mm);
  const crosses = tools.filter((tool) => tool.worst && (!hasAxes || tool.worst.axis === map.axis)).map((tool) => {
    const [x, y] = tool.worst.nominal_mm;
    return element("span", { class: "cross", title: `T${tool.tool}`, style: {
      left: `${100 * (x - map.low_mm[0]) / width_mm}%`, bottom: `${100 * (y - map.low_mm[1]) / height_mm}%`,
    } }, `\u00d7\u00a0T${tool.tool}`);
  });
  const stops = Array.from({ length: 9 }, (_, i) => scaleCss(i / 8)).join(", ");
  return element("figure", {},
    element("div", { class: "overlay" }, canvas, crosses),
    element("ul", { class: "legend" }, element("li", {}, `${millimetres(range[0], 4)} `,
      element("span", { class: "scale", style: { background: `linear-gradient(to right, ${stops})` } }),
      ` ${millimetres(range[1], 4)}`)),
    readout,
    element("figcaption", {}, hasAxes && word("z_axis", { axis: map.axis }), map.zone && word("zone", { zone: map.zone }),
      word("depth_map_caption")));
}
