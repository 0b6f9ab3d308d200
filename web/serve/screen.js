// SPDX-License-Identifier: Apache-2.0
// The operator's screen. It shows what the server says, and sends what the person who has the controls wants.
import { element, english } from "../base/dom.js";
import { language, speak, word } from "../base/words.js";
import { calibrationPart, historyPart } from "./calibration.js";
import { act, actionButton, connection, desk, field, fieldValue, form, isMine, job, openDesk, part } from "./desk.js";
import { jobPart, mapStep, n_decided, panelPart, programsPart, targetsPart, verdictPart } from "./job.js";
import { LivePicture, pictureFacts } from "./live_picture.js";
import { answerAt, jog, questionPart } from "./question.js";

const picture = new LivePicture({ answer: (choice, at_px) => answerAt(picture, choice, at_px), jog, changed: () => showAll() });

/** The loss of the connection, a token that is asked for, what was refused. */
function noticePart() {
  if (desk.condition === "locked") {
    const login = () => act(() => connection.login(fieldValue("token")));
    return [element("h2", {}, word("serve_token")), form(login, field("token", word("serve_token_field"), { type: "password", required: true }),
      element("button", { class: "action" }, word("serve_log_in"))), refusalText()];
  }
  if (desk.condition === "lost") return element("h2", {}, word("serve_lost"));
  return desk.condition === "connecting" ? element("h2", {}, word("serve_connecting")) : refusalText();
}

function refusalText() {
  const { refusal } = desk;
  return refusal && element("p", {}, element("b", {}, word("serve_refused")), " ",
    element("span", { lang: "en" }, refusal.what, refusal.expected && `; expected ${refusal.expected}`));
}

function headPart() {
  const { machine = "", source = "", panelcal = "" } = desk.state ?? {};
  document.title = machine ? `${machine} - panelcal` : "panelcal";
  const turn = () => {
    speak(language() === "de" ? "en" : "de");
    showAll();
  };
  return [element("h1", {}, machine && [element("b", {}, machine), " ", english(source), " \u00b7 "], `panelcal ${panelcal}`),
    element("button", { type: "button", id: "language", onclick: turn }, word("language_switch")),
    connection.hasSession && desk.condition === "open" && actionButton("log-out", word("serve_log_out"), () => act(() => connection.leave(true))),
    desk.condition === "locked" ? null : controlsText()];
}

/** Who has the controls; one screen alone has them. */
function controlsText() {
  const { held_by: holder } = desk.controls;
  if (holder === undefined) return null;
  const take = () => act(() => connection.take(fieldValue("name"), holder));
  if (isMine()) {
    return element("div", { class: "controls" }, element("span", {}, word("serve_mine", { name: holder ?? "" })),
      actionButton("give", word("serve_give"), () => act(() => connection.leave(false))));
  }
  return form(take, element("span", {}, holder ? word("serve_held", { name: holder }) : word("serve_free")),
    field("name", word("serve_name"), { required: true, maxlength: 60 }),
    element("button", { class: "action", id: "do-take" }, holder ? word("serve_take_from", { name: holder }) : word("serve_take")));
}

/**
 * @param {string} id
 * @param {() => any[]} depends
 * @param {() => import("../base/dom.js").Child} make
 * @param {string} [className]
 */
function panel(id, depends, make, className = "") {
  return part(element("section", { id, class: className, hidden: true }), () => [isMine(), ...depends()], () => desk.state && make());
}


const head = part(element("header"), () => [desk.state?.machine, desk.state?.source, desk.controls, desk.condition, isMine(), connection.hasSession], headPart);
const notice = part(element("div", { class: "notice", role: "alert", hidden: true }), () => [desk.condition, desk.refusal], noticePart);
const view = panel("view", () => [desk.state?.view], pictureFacts);
const seen = element("div", { class: "seen", hidden: true }, picture.node, view.node);
const parts = {
  head, notice, view,
  question: panel("question", () => [job()?.question, job()?.targets?.length, desk.state?.view?.lamp, picture.mode, picture.cross_px, picture.isLive()], () => questionPart(picture)),
  verdict: panel("verdict", () => [job()?.id, job()?.verdict, job()?.outputs, job()?.has_report], verdictPart, "verdict"),
  job: panel("job", () => [{ ...job(), targets: job()?.targets.length, series: null, question: null }, n_decided()], jobPart),
  programs: panel("programs", () => [desk.state?.programs, job()?.id], programsPart),
  targets: targetsPart(),
  panel: panel("panel", () => [job()?.id, job()?.state, job()?.targets?.length, mapStep()], panelPart),
  calibration: panel("calibration", () => [desk.state?.calibration, desk.state?.kinds, job()?.state], calibrationPart),
  history: panel("history", () => [desk.state?.history, job()?.state, desk.state?.calibration?.state], historyPart),
};

/** A way of aiming belongs to one question. */
let asked = /** @type {number | undefined} */ (undefined);

function showAll() {
  const question = job()?.question?.id;
  if (question !== asked || !isMine()) {
    asked = question;
    picture.mode = "";
    picture.cross_px = null;
  }
  for (const one of Object.values(parts)) one.show();
  parts.verdict.node.classList.toggle("hold", job()?.verdict?.may_drill === false);
  seen.hidden = !desk.state?.view;
  picture.redraw();
  document.body.classList.toggle("busy", desk.isBusy);
  document.body.classList.toggle("lost", desk.condition === "lost");
  for (const button of document.querySelectorAll(".action")) {
    button.setAttribute("aria-disabled", String(desk.isBusy || desk.condition === "lost"));
  }
}

addEventListener("keydown", (event) => {
  if (event.key === "Escape" && picture.mode) picture.choose(picture.mode);
});
document.body.append(element("main", { class: "serve" }, head.node, notice.node,
  element("div", { class: "desk" },
    element("div", {}, seen, parts.panel.node),
    element("div", {}, parts.question.node, parts.verdict.node, parts.job.node, parts.programs.node, parts.targets.node),
    element("div", {}, parts.calibration.node, parts.history.node))));
speak(language());
openDesk(showAll, (number) => picture.load(number));
showAll();
