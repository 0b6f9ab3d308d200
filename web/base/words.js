// SPDX-License-Identifier: Apache-2.0
// All words of the front end, [English, German]. {name} stands for a value.

/** @typedef {"en" | "de"} Language */

const words = {
  // Every page.
  language_switch: ["Deutsch", "English"],
  made_by: ["made by panelcal {version}", "erzeugt von panelcal {version}"],
  unknown_facts: [
    "This page cannot show facts of the kind \u201c{kind}\u201d.",
    "Diese Seite kann Angaben der Art \u201e{kind}\u201c nicht zeigen.",
  ],
};

/** @typedef {keyof typeof words} WordKey */

/** @type {Language} */
let spoken = startLanguage();

/** The language chosen on this page before, or else the browser's; English where it is neither. */
function startLanguage() {
  const asked = new URLSearchParams(location.search).get("language") ?? navigator.language;
  return asked.startsWith("de") ? "de" : "en";
}

/** @returns {Language} */
export function language() {
  return spoken;
}

/** @param {Language} wanted */
export function speak(wanted) {
  spoken = wanted;
  document.documentElement.lang = wanted;
}

/**
 * The words of a key in the language of the page.
 * @param {WordKey} key
 * @param {Record<string, string | number>} [values]
 * @returns {string}
 */
export function word(key, values = {}) {
  const text = words[key][spoken === "de" ? 1 : 0];
  return text.replace(/\{(\w+)\}/g, (whole, name) => String(values[name] ?? whole));
}

/**
 * The same for a word that facts name, such as a status; the fact itself where there is none.
 * @param {string} prefix
 * @param {string} name
 */
export function wordOf(prefix, name) {
  const key = `${prefix}_${name.replace(/[^a-z0-9]+/gi, "_")}`;
  return key in words ? word(/** @type {WordKey} */ (key)) : name;
}
