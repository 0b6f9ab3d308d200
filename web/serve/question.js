// SPDX-License-Identifier: Apache-2.0
// A target that was not found or is rejected: the job waits, and a person decides how it goes on.
import { element, english, rowList } from "../base/dom.js";
import { fixed, millimetres } from "../base/format.js";
import { word, wordOf } from "../base/words.js";
import { actionButton, command, desk, field, fieldValue, isMine, job } from "./desk.js";

/** @typedef {import("./live_picture.js").LivePicture} LivePicture */

const jogSteps_mm = [0.01, 0.1, 1, 5];
/** The way of one press, mm. */
let jogStep_mm = 0.1;

/** @returns {any} the question that is open; undefined if none is, or another screen answers it */
function question() {
  return isMine() ? job()?.question : undefined;
}

/**
 * @param {string} choice
 * @param {Record<string, unknown>} [more]
 */
function answer(choice, more = {}) {
  return command({ do: "answer", question: question().id, choice, ...more });
}

/**
 * Answers with a place of the picture that is shown.
 * @param {LivePicture} picture
 * @param {"search" | "hand"} choice
 * @param {[number, number]} at_px
 */
export function answerAt(picture, choice, at_px) {
  if (!question()?.choices.includes(choice)) return;
  answer(choice, { at_px: at_px.map((one) => Math.round(1e3 * one) / 1e3), frame: picture.shown });
}

/** Moves the stage by one step.
 * @param {[number, number]} way */
export function jog([x, y]) {
  if (question()?.jog_mm) command({ do: "jog", by_mm: [x * jogStep_mm, y * jogStep_mm] });
}

/** Look again, as it is or in another light. Without a value a light stays as it is. */
function lookAgain() {
  const { why_not: whyNot = {}, exposure_us } = question();
  const now = /** @type {Record<string, number | undefined>} */ ({ lamp: desk.state.view?.lamp, exposure: exposure_us });
  const lights = /** @type {const} */ (["lamp", "exposure"]).filter((name) => !whyNot[name]);
  const again = () => {
    const chosen = lights.map((name) => [name, fieldValue(`light-${name}`)])
      .filter(([name, value]) => value !== "" && Number(value) !== now[name]);
    answer("again", Object.fromEntries(chosen.map(([name, value]) => [name, Number(value)])));
  };
  return [actionButton("again", word("serve_choice_again"), again),
    lights.map((name) => field(`light-${name}`, word(`serve_light_${name}`), { type: "number", min: 0, step: "any", value: now[name] }))];
}

/** @param {LivePicture} picture */
function jogPad(picture) {
  const longest_mm = question().jog_mm;
  const steps = jogSteps_mm.filter((step) => step <= longest_mm);
  jogStep_mm = Math.min(jogStep_mm, longest_mm);
  const arrow = (/** @type {string} */ name, /** @type {string} */ sign, /** @type {[number, number]} */ way) =>
    actionButton(`jog-${name}`, sign, () => jog(way), { class: `action ${name}`, "aria-label": word("serve_jog_way", { way: wordOf("serve_way", name) }) });
  return element("div", { class: "jog" },
    element("div", { class: "pad", role: "group", "aria-label": word("serve_jog") },
      arrow("up", "\u25b2", [0, 1]), arrow("left", "\u25c0", [-1, 0]), arrow("right", "\u25b6", [1, 0]), arrow("down", "\u25bc", [0, -1])),
    element("div", { class: "controls", role: "group", "aria-label": word("serve_jog_step") },
      element("span", { class: "quiet" }, word("serve_jog")),
      steps.map((step) => element("button", { type: "button", id: `step-${step}`, "aria-pressed": String(step === jogStep_mm),
        onclick: () => {
          jogStep_mm = step;
          picture.asked.changed();
        } }, millimetres(step, step < 0.1 ? 2 : step < 1 ? 1 : 0)))));
}

/** @param {LivePicture} picture */
function choices(picture) {
  const { choices: offered, candidates = [], jog_mm } = question(), cross = picture.cross_px;
  const has = (/** @type {string} */ choice) => offered.includes(choice);
  const aim = (/** @type {"search" | "hand"} */ mode, /** @type {import("../base/words.js").WordKey} */ text) => has(mode) &&
    element("button", { type: "button", id: `aim-${mode}`, "aria-pressed": String(picture.mode === mode), onclick: () => picture.choose(mode) }, word(text));
  const plain = (/** @type {"skip" | "leave_board_out" | "keep" | "done" | "stop"} */ choice) =>
    has(choice) && actionButton(choice, word(`serve_choice_${choice}`), () => answer(choice));
  return [
    element("div", { class: "controls" }, has("again") && lookAgain()),
    has("candidate") && element("div", { class: "controls" }, candidates.map((one, i) =>
      actionButton(`candidate-${i}`, word("serve_accept", { n: i + 1, score: fixed(one.score, 2) }), () => answer("candidate", { index: i })))),
    element("div", { class: "controls" }, aim("search", "serve_choice_search"), aim("hand", "serve_choice_hand")),
    picture.mode && element("p", {}, word(picture.mode === "search" ? "serve_click_search" : "serve_click_hand")),
    cross && element("div", { class: "controls" }, actionButton("place", word("serve_place_here", { x: fixed(cross[0], 2),
      y: fixed(cross[1], 2) }), () => answerAt(picture, "hand", cross))),
    jog_mm && jogPad(picture),
    element("div", { class: "controls" }, plain("done"), plain("skip"), plain("leave_board_out"), plain("keep"), plain("stop")),
  ];
}

/** The part of the screen that asks.
 * @param {LivePicture} picture */
export function questionPart(picture) {
  if (!job()?.question) return null;
  const { seq, reason, why_not: whyNot = {} } = job().question, target = job().targets.find((one) => one.seq === seq);
  return [
    element("h2", { role: "alert" }, target ? word("serve_question", { seq, line: target.line }) : word("serve_do_now"), " ", english(reason)),
    isMine() ? choices(picture) : element("p", {}, word("serve_question_elsewhere")),
    rowList(Object.entries(whyNot ?? {}).map(([choice, why]) => [wordOf("serve_choice", choice), english(why)]), "quiet"),
  ];
}
