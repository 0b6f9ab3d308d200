// SPDX-License-Identifier: Apache-2.0
// Reads the facts of the page and shows them by the view of their kind.
import { element } from "./base/dom.js";
import { language, speak, word } from "./base/words.js";
import { batchView } from "./views/batch.js";
import { calibrationView } from "./views/calibration.js";
import { fleetView } from "./views/fleet.js";
import { certificateView } from "./views/certificate.js";
import { historyView } from "./views/history.js";
import { jobView } from "./views/job.js";
import { nightView } from "./views/night.js";
import { planView } from "./views/plan.js";
import { surfaceView } from "./views/surface.js";

/**
 * A view of one kind of facts. `pictures` are data: addresses by the names that the facts use.
 * @typedef {{facts: string, show: (facts: any, pictures: Record<string, string>) => Element}} View
 */

/** @type {View[]} */
const views = [
  batchView,
  calibrationView,
  fleetView,
  certificateView,
  historyView,
  jobView,
  nightView,
  planView,
  surfaceView,
];

/** @param {string} id */
function embedded(id) {
  return JSON.parse(document.getElementById(id)?.textContent || "{}");
}

function languageButton() {
  const choose = () => {
    speak(language() === "de" ? "en" : "de");
    render();
  };
  return element("button", { class: "language", onclick: choose }, word("language_switch"));
}

const pageFacts = embedded("facts");
const pagePictures = embedded("pictures");

function render() {
  const view = views.find((one) => one.facts === pageFacts.facts);
  document.querySelector("main")?.remove();
  document.body.append(element("main", { class: `view-${pageFacts.facts}` },
    languageButton(),
    view ? view.show(pageFacts, pagePictures) : word("unknown_facts", { kind: pageFacts.facts }),
    element("footer", {}, word("made_by", { version: pageFacts.panelcal }))));
}

speak(language());
render();
