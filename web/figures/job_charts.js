// SPDX-License-Identifier: Apache-2.0
// Small charts of a job: risks by decade, sharpness over height, shares of the error budget, the
// surface that depths are judged by.
import { element, svg } from "../base/dom.js";
import { word } from "../base/words.js";
import { fixed, micrometres, millimetres, place, whole } from "../base/format.js";
import { colour } from "../base/colours.js";
import { chart } from "./chart.js";
import { fieldAt, fieldOf } from "./field.js";
import { drawCrosses, fieldFigure, fromLowToHigh } from "./surface_map.js";

/**
 * How many places have which risk; heights are logarithms, so that one beside a million is seen.
 * @param {any} tolerance facts.tolerance
 */
export function riskChart(tolerance) {
  const decades = tolerance.decades;
  if (decades.length === 0) return null;
  const [bar, plot, top, left] = [46, 120, 20, 14];
  const count = (d) => d.n_good + d.n_warned + d.n_held;
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
      decades.map((decade, /** @type {number} */ i) => {
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
      limit(tolerance.warn_above, word("limit_warn")), limit(tolerance.hold_above, word("night_state_hold"))),
    element("figcaption", {}, word("risk_chart_caption")));
}

/** Sharpness of an autofocus over the camera's height, and where it was found sharpest. */
export function focusCurve(focus, ...caption) {
  const looks = focus.curve.filter((look) => look.z_mm !== null && look.sharpness !== null);
  if (!looks.some((look) => look.sharpness > 0)) return element("figure", {}, element("figcaption", {}, caption));
  return chart({
    label: word("focus_chart"), yTitle: word("focus_sharpness"), xTitle: "z, mm", least: 1e-6,
    points: looks.map((look) => ({ x: look.z_mm, y: look.sharpness, mark: "filled",
      lines: [`${millimetres(look.z_mm, 4)}: ${fixed(look.sharpness, 2)}`] })),
    marks: focus.z_mm === null ? [] : [focus.z_mm],
  }, ...caption);
}

/**
 * The surface of the board within what was probed; crosses are where each tool is likeliest to be too shallow or too deep.
 * @param {boolean} hasAxes
 */
export function depthMap(map, tools, hasAxes) {
  const shape = { first_mm: map.low_mm, step_mm: [map.step_mm, map.step_mm], columns: map.n_x, rows: map.n_y };
  const heights = fieldOf(shape, map.height_mm), sigmas = fieldOf(shape, map.sigma_um);
  const worst = tools.filter((tool) => tool.worst && (!hasAxes || tool.worst.axis === map.axis));
  const corner = (column, row) => /** @type {[number, number]} */ ([map.low_mm[0] + column * map.step_mm, map.low_mm[1] + row * map.step_mm]);
  return fieldFigure({
    field: heights, outline: [corner(0, 0), corner(map.n_x - 1, 0), corner(map.n_x - 1, map.n_y - 1), corner(0, map.n_y - 1)], title: "", label: word("depth_map"), unit: "mm",
    n_levels: 8, paint: fromLowToHigh, caption: [hasAxes && word("z_axis", { axis: map.axis }), map.zone && word("zone", { zone: map.zone }),
      word("depth_map_caption")],
    over: (plane) => {
      drawCrosses(plane, worst.map((tool) => ({ place_mm: tool.worst.nominal_mm })), colour("bad"));
      plane.context.textAlign = "left";
      for (const { tool, worst: { nominal_mm: [x, y] } } of worst) plane.drawText(`T${tool}`, plane.x(x) + 8, plane.y(y), colour("bad"));
    },
    hint: (at) => {
      const height = fieldAt(heights, at);
      return Number.isNaN(height) ? null : [place(at),
        word("surface_height_at", { mm: millimetres(height, 4), um: micrometres(fieldAt(sigmas, at), 2) })];
    },
  });
}
