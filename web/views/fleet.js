// SPDX-License-Identifier: Apache-2.0
// The machines of a shop: which of them may drill now, until when, and why not.
import { chip, element, english, number, section, table, tile } from "../base/dom.js";
import { minuteText, whole } from "../base/format.js";
import { word, wordOf } from "../base/words.js";

const fleetStates = { drill: "good", hold: "refused", unknown: "suspect" };

export const fleetView = {
  facts: "fleet",
  show(facts) {
    const count = (/** @type {string} */ state) => whole(facts.machines.filter((one) => one.state === state).length);
    const time = (/** @type {string | null} */ iso) => (iso ? minuteText(iso) : "\u2013");
    return element("div", {}, element("h1", {}, word("fleet_title"), " ", element("b", {}, facts.store)),
      section("summary", minuteText(facts.time), element("dl", { class: "tiles" },
        Object.keys(fleetStates).map((state) => tile(wordOf("fleet", state), count(state), "")))),
      section("machines", word("fleet_machines"),
        table([{ title: word("batch_machine") }, { title: word("batch_state") }, { title: word("fleet_until") }, { title: word("why"), text: true },
          { title: word("fleet_night") }, number(word("fleet_since")), { title: word("fleet_pushed") }],
        facts.machines.map((one) => [element("b", {}, one.machine), chip(fleetStates[/** @type {"hold"} */ (one.state)], wordOf("fleet", one.state)),
          time(one.until), english(one.why), one.night ?? "\u2013", whole(one.n_entries_since), time(one.pushed)]))));
  },
};
