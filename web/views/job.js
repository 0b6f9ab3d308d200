// SPDX-License-Identifier: Apache-2.0
// The report of a job.
import { element } from "../base/dom.js";

export const jobView = {
  facts: "job",
  /**
   * @param {any} facts
   * @param {Record<string, string>} pictures
   */
  show(facts, pictures) {
    return element("pre", {}, JSON.stringify(facts, null, 1), Object.keys(pictures).length);
  },
};
