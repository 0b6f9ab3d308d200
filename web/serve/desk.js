// SPDX-License-Identifier: Apache-2.0
// What all parts of the screen share: what the server has said, and the way in which a person answers.
import { append, element } from "../base/dom.js";
import { language } from "../base/words.js";
import { Connection } from "./connection.js";

/** How long a command waits for the state that it leads to, before another one may follow. */
const longestEffect_ms = 3000;

/** What the server has said. Nothing else is kept. */
export const desk = {
  /** @type {any} the document "screen" */
  state: null,
  /** @type {{held_by?: string | null, mine?: boolean}} */
  controls: {},
  /** @type {import("./connection.js").Condition} */
  condition: "connecting",
  /** @type {{what: string, expected: string} | null} why the last command was refused */
  refusal: null,
  isBusy: false,
  /** States so far, so that a command can wait for the next one. */
  n_states: 0,
};

/** The job that is open.
 * @returns {any} */
export const job = () => desk.state?.job;

/** Calls for everything that has changed to be shown. */
let show = () => {};
/** @type {(number: number) => void} */
let showFrame = () => {};

export const connection = new Connection({
  state: (document) => {
    desk.state = document;
    desk.n_states += 1;
    show();
  },
  frame: (number) => showFrame(number),
  controls: (controls) => {
    desk.controls = controls;
    show();
  },
  condition: (condition) => {
    desk.condition = condition;
    show();
  },
});

/**
 * @param {() => void} all
 * @param {(number: number) => void} frame
 */
export function openDesk(all, frame) {
  show = all;
  showFrame = frame;
  connection.open();
}

/** This screen may give commands: it has the controls. */
export function isMine() {
  return Boolean(desk.controls.mine && connection.key);
}

/**
 * Sends what a person wants. Until the next state no other command goes.
 * @param {() => Promise<any>} request
 */
export async function act(request) {
  if (desk.isBusy || desk.condition === "lost") return;
  const before = desk.n_states;
  desk.isBusy = true;
  desk.refusal = null;
  show();
  try {
    await request();
    for (let waited_ms = 0; desk.n_states === before && waited_ms < longestEffect_ms; waited_ms += 50) {
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  } catch (error) {
    const { message, expected } = /** @type {any} */ (error);
    desk.refusal = { what: message, expected: expected ?? "" };
  }
  desk.isBusy = false;
  show();
}

/** @param {Record<string, unknown>} order */
export function command(order) {
  return act(() => connection.send("api/command", order));
}

/**
 * A button that sends; `name` stays the same while it means the same, so that it keeps the focus.
 * @param {string} name
 * @param {import("../base/dom.js").Child} text
 * @param {() => void} press
 * @param {import("../base/dom.js").Attributes} [attributes]
 */
export function actionButton(name, text, press, attributes = {}) {
  return element("button", { type: "button", id: `do-${name}`, class: "action", onclick: press, ...attributes }, text);
}

/**
 * A field with its name before it, in what is sent by Enter.
 * @param {string} id
 * @param {import("../base/dom.js").Child} title
 * @param {import("../base/dom.js").Attributes} attributes
 */
export function field(id, title, attributes) {
  return element("label", { class: "field" }, title, " ", element("input", { id, autocomplete: "off", ...attributes }));
}

/** @param {string} id of a field */
export function fieldValue(id) {
  return /** @type {HTMLInputElement} */ (document.getElementById(id)).value.trim();
}

/**
 * A form whose button sends it.
 * @param {() => void} send
 * @param {...import("../base/dom.js").Child} children
 */
export function form(send, ...children) {
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    send();
  };
  return element("form", { class: "controls", onsubmit: submit }, children);
}

/**
 * A part of the screen, made anew when what it shows has changed, and only then. What has the focus keeps it, and
 * fields keep what is typed.
 * @template {HTMLElement} T
 * @param {T} node
 * @param {() => any[]} depends
 * @param {() => import("../base/dom.js").Child} make
 */
export function part(node, depends, make) {
  let before = "";
  return { node, show: () => {
    const now = JSON.stringify([language(), ...depends()]);
    if (now === before) return;
    before = now;
    const focus = node.contains(document.activeElement) ? document.activeElement?.id : "";
    const typed = [...node.querySelectorAll("input, textarea")].map((one) => /** @type {HTMLInputElement} */ (one))
      .filter((one) => one.value !== one.defaultValue).map((one) => ({ id: one.id, value: one.value }));
    const open = [...node.querySelectorAll("details[open]")].map((one) => one.id);
    node.replaceChildren();
    append(node, make());
    node.hidden = node.childNodes.length === 0;
    for (const { id, value } of typed) {
      const again = /** @type {HTMLInputElement | null} */ (document.getElementById(id));
      if (again && again.type !== "file") again.value = value;
    }
    for (const id of open) document.getElementById(id)?.setAttribute("open", "");
    if (focus) document.getElementById(focus)?.focus();
  } };
}
