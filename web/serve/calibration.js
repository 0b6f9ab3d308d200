// SPDX-License-Identifier: Apache-2.0
// Calibrations and nights: start, watch, read the page of the morning, and the ledger with the way back.
import { chip, element, english } from "../base/dom.js";
import { minuteText } from "../base/format.js";
import { language, word, wordOf } from "../base/words.js";
import { actionButton, command, desk, fieldValue, form, isMine } from "./desk.js";

const runChips = { running: "suspect", done: "good", failed: "refused" };
/** Of a longer ledger the screen shows the newest. */
const mostEntries = 60;

/** No job is in the way of the machine. */
function isFree() {
  const { job, calibration } = desk.state;
  return !["measuring", "asking"].includes(job?.state) && calibration?.state !== "running";
}

export function calibrationPart() {
  const { calibration, kinds = [] } = desk.state;
  const start = (/** @type {string} */ kind) => actionButton(`calibrate-${kind}`, wordOf("serve_kind", kind), () => command({ do: "calibrate", kind }));
  const buttons = isMine() && (isFree() && kinds.length > 0 ? kinds.map(start)
    : calibration?.state === "running" && actionButton("stop-calibration", word("serve_order_stop"), () => command({ do: "stop" })));
  if (!buttons && !calibration) return null;
  return [element("h2", {}, word("serve_calibrate")),
    buttons && element("div", { class: "controls" }, buttons),
    calibration && [
      element("p", {}, element("b", {}, wordOf("serve_kind", calibration.kind)), " ",
        chip(runChips[/** @type {keyof typeof runChips} */ (calibration.state)] ?? "plain", wordOf("serve_run", calibration.state))),
      element("ul", { lang: "en", class: "lines", "aria-live": "polite" },
        (calibration.lines ?? []).map((/** @type {string} */ line) => element("li", {}, line))),
      calibration.verdict && element("p", { lang: "en", class: "next" }, calibration.verdict),
      calibration.has_page && element("p", {}, element("a", { href: `api/calibration/report.html?language=${language()}`, target: "_blank", rel: "noopener" },
        word("serve_morning"))),
    ]];
}

/** @param {any} entry */
function rollBack(entry) {
  const id = `reason-${entry.kind}-${entry.entry}`;
  const send = () => command({ do: "roll_back", kind: entry.kind, to: entry.entry, reason: fieldValue(id) });
  return element("details", { id: `back-${entry.kind}-${entry.entry}` }, element("summary", {}, word("serve_roll_back")),
    form(send, element("label", { class: "field" }, word("history_reason"), " ", element("textarea", { id, required: true, rows: 2 })),
      element("button", { class: "action", id: `do-${id}` }, word("serve_roll_back_now"))));
}

export function historyPart() {
  const { history = [] } = desk.state;
  if (history.length === 0) return null;
  return [element("h2", {}, word("history_entries")),
    element("ul", { class: "history" }, history.slice(0, mostEntries).map((entry) => element("li", {},
      element("b", {}, wordOf("serve_kind", entry.kind)), " ", element("span", { class: "quiet" }, minuteText(entry.when)), " ",
      entry.in_force && chip("good", word("history_in_force")), " ", english(entry.words),
      isMine() && isFree() && !entry.in_force && rollBack(entry)))),
    history.length > mostEntries && element("p", { class: "quiet" }, word("serve_more_entries", { n: history.length - mostEntries }))];
}
