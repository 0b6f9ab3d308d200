// SPDX-License-Identifier: Apache-2.0
// The job: from the choice of a program over its targets to the verdict and the program that is written.
import { chip, element, english } from "../base/dom.js";
import { fixed, micrometres, place, secondsOf, timeText, whole } from "../base/format.js";
import { language, word, wordOf } from "../base/words.js";
import { panelArrows } from "../figures/panel_arrows.js";
import { act, actionButton, command, connection, desk, field, fieldValue, form, isMine, job, part } from "./desk.js";

const stateChips = { checked: "plain", measuring: "suspect", asking: "refused", done: "good", held: "refused", failed: "refused",
  stopped: "suspect", resumable: "suspect" };
const targetChips = { waiting: "plain", looking: "suspect", found: "good", skipped: "suspect", board_left_out: "suspect" };

/**
 * What a job has left behind, in a window of its own.
 * @param {string} name
 * @param {import("../base/dom.js").Child} text
 */
function jobLink(name, text) {
  return element("a", { href: `api/jobs/${encodeURIComponent(job().id)}/${name}?language=${language()}`, target: "_blank", rel: "noopener" }, text);
}

/** Programs of the folder, and one from this device. */
export function programsPart() {
  if (job()) return null;
  const upload = element("input", { type: "file", id: "upload", onchange: () => {
    const file = upload.files?.[0];
    if (!file) return;
    act(() => connection.send(`api/programs?name=${encodeURIComponent(file.name)}`, file));
    upload.value = "";
  } });
  const { programs = [] } = desk.state;
  return [element("h2", {}, word("serve_programs")),
    programs.length === 0 && element("p", { class: "quiet" }, word("serve_no_programs")),
    element("ul", { class: "programs" }, programs.map((one) => element("li", {},
      isMine() ? actionButton(`open-${one.name}`, one.name, () => command({ do: "open", program: one.name })) : element("b", {}, one.name),
      " ", element("span", { class: "quiet" }, word("serve_bytes", { n: whole(one.size_bytes) }))))),
    isMine() && element("label", { class: "field" }, word("serve_upload"), " ", upload)];
}

function findings() {
  const { findings: found = [] } = job();
  if (found.length === 0) return element("p", {}, chip("good", word("serve_no_findings")));
  return element("ul", { class: "messages" }, found.map((one) => element("li", {},
    chip(one.severity, word(one.severity === "error" ? "error" : "warning")), " ",
    one.line && element("span", { class: "quiet" }, `${word("line")} ${one.line}: `),
    element("span", { lang: "en" }, one.what, one.expected && `; expected ${one.expected}`), " ", element("code", {}, one.code))));
}

/** What may be done with the job now. */
function jobButtons() {
  const { state, findings: found = [] } = job();
  const may = {
    start: state === "checked" && !found.some((one) => one.severity === "error"),
    resume: ["stopped", "failed", "resumable"].includes(state),
    stop: state === "measuring",
    close: ["checked", "done", "held", "failed", "stopped", "resumable"].includes(state),
  };
  const orders = /** @type {const} */ (["start", "resume", "stop", "close"]);
  return element("div", { class: "controls" }, orders.filter((order) => may[order]).map((order) =>
    actionButton(order, word(`serve_order_${order}`), () => command({ do: order }))));
}

/** Targets that are found or left out. */
export function n_decided() {
  return job()?.targets.filter((one) => ["found", "skipped", "board_left_out"].includes(one.status)).length ?? 0;
}

export function jobPart() {
  if (!job()) return null;
  const { program, state, targets = [], again } = job();
  const done = n_decided();
  return [element("h2", {}, program, " ", chip(stateChips[/** @type {keyof typeof stateChips} */ (state)] ?? "plain", wordOf("serve_job", state))),
    targets.length > 0 && state !== "checked" && element("progress", { max: targets.length, value: done, "aria-label": word("targets") }),
    element("p", {}, word("serve_progress", { done: whole(done), all: whole(targets.length) }),
      job().n_holes > 0 && `; ${word("map_counts", { holes: whole(job().n_holes) })}`),
    again && element("p", { lang: "en" }, again.words),
    isMine() && jobButtons(),
    (state === "checked" || job().findings?.length > 0) && findings()];
}

/** A target in the list: what became of it, by whom.
 * @param {any} target */
function targetRow(target) {
  const { seq, status, residual_um: residual, sigma_um: sigma, reason, by, who, when } = target;
  const path = target.path?.length ? `, ${word("board")} [${target.path.join(",")}]` : "";
  return element("li", { class: status, "aria-current": status === "looking" ? "step" : null },
    element("b", {}, `#${seq}`), " ", chip(targetChips[/** @type {keyof typeof targetChips} */ (status)] ?? "refused", wordOf("status", status)),
    element("span", { class: "quiet" }, `${target.command}, ${word("line")} ${target.line}${path}`),
    residual && element("span", {}, `${word("residual")} ${micrometres(Math.hypot(...residual), 2)}`),
    sigma && element("span", { class: "quiet" }, `${word("sigma")} ${micrometres(Math.max(...sigma), 2)}`),
    who && element("span", {}, word("serve_by", { how: wordOf("serve_by", by), who, when: timeText(secondsOf(when)).slice(11) })),
    target.has_picture && jobLink(`picture-${seq}.jpg`, word("serve_picture")),
    reason && element("span", { class: "reason", lang: "en" }, reason));
}

function seriesPart() {
  const { targets = [], series = [] } = job() ?? {};
  if (targets.length === 0) return null;
  const fitted = series.filter((one) => one.is_fitted);
  return [element("h2", {}, word("targets")), fitted.length > 0 && element("ul", { class: "messages" }, fitted.map((one) => element("li", {},
    chip(one.is_accepted ? "good" : "refused", word(one.is_accepted ? "pass" : "fail")), ` ${word("line")} ${one.line}`,
    one.path?.length > 0 && ` [${one.path.join(",")}]`, ", ", word("n_targets", { n: one.n_targets }), ": ", english(one.words))))];
}

/** The list of targets. A job may have thousands: a row is made anew only when its target has changed. */
export function targetsPart() {
  const head = part(element("div"), () => [job()?.id, job()?.targets?.length, job()?.series], seriesPart);
  const rows = element("ol", { class: "targets" });
  /** @type {string[]} */
  let shown = [];
  const show = () => {
    head.show();
    const { id, targets = [] } = job() ?? {};
    const now = targets.map((one) => JSON.stringify([language(), id, one]));
    now.forEach((key, i) => {
      if (key === shown[i]) return;
      const row = targetRow(targets[i]);
      if (i < shown.length) rows.children[i].replaceWith(row);
      else rows.append(row);
      // What is looked for now is seen without scrolling the page.
      if (targets[i].status === "looking") rows.scrollTop = row.offsetTop - rows.offsetTop - rows.clientHeight / 2;
    });
    while (rows.childElementCount > now.length) rows.lastChild?.remove();
    shown = now;
    node.hidden = now.length === 0;
  };
  const node = element("section", { id: "targets" }, head.node, rows);
  return { node, show };
}

/** How far the map has to follow: of a large job in a hundred steps. */
export function mapStep() {
  return Math.floor(n_decided() / Math.max(1, (job()?.targets.length ?? 0) / 100));
}

/** The panel with its targets: residuals as arrows, crosses where one is missing or still to come. */
export function panelPart() {
  const { targets = [] } = job() ?? {};
  if (targets.length < 2) return null;  // residuals of one say nothing on a map
  const places = targets.map((one) => {
    const { seq, nominal_mm: at_mm, residual_um: residual } = one;
    return { at_mm, vector_mm: (residual ?? [0, 0]).map((/** @type {number} */ um) => um / 1e3), name: `#${seq}`,
      lines: [`#${seq} ${place(at_mm)}`, wordOf("status", one.status), residual &&
        `(${residual.map((/** @type {number} */ um) => fixed(um, 1, { signed: true })).join(", ")})\u00a0\u00b5m`].filter(Boolean) };
  });
  const missing = targets.filter((one) => !one.measured_mm);
  return [element("h2", {}, word("panel")), panelArrows({ label: word("serve_panel"), places, mostHeight: 480,
    crosses_mm: missing.map((one) => one.nominal_mm) }, word("serve_panel"))];
}

export function verdictPart() {
  const { verdict, program, output_format: format, outputs = [], has_report: hasReport, has_facts: hasFacts } = job() ?? {};
  if (!verdict) return null;
  const mayDrill = verdict.may_drill;
  const links = [hasReport && jobLink("report.html", word("serve_report")), outputs.length > 0 && jobLink("output", outputs.join(", ")),
    hasFacts && jobLink("facts.json", "JSON")].filter(Boolean);
  return [element("div", { class: "top" },
    element("div", { class: "word" }, mayDrill ? `\u2713 ${word("verdict_drill")}` : `\u2717 ${word("verdict_hold")}`),
    element("p", { lang: "en", role: "status" }, verdict.words)),
  links.length > 0 && element("p", { class: "links" }, links.map((link) => [link, " "])),
  isMine() && mayDrill && form(() => command({ do: "write", name: fieldValue("output-name") }),
    field("output-name", word("serve_output"), { value: `${program.replace(/\.[^.]*$/, "")}.${format === "excellon" ? "drl" : "sm"}`, required: true }),
    element("button", { id: "do-write", class: "action" }, word("serve_write")))];
}
