// SPDX-License-Identifier: Apache-2.0
// Elements of the page. Every text becomes a text node, so that no fact can become markup.

/** @typedef {Node | string | number | null | undefined | false | any[]} Child */
/** @typedef {Record<string, unknown>} Attributes */

/**
 * @param {Element} made
 * @param {Attributes} attributes
 * @param {Child[]} children
 */
function fill(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") {
      made.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
    } else if (name === "style") {
      // By property: the page's policy refuses style as text.
      const style = /** @type {HTMLElement} */ (made).style;
      for (const [key, one] of Object.entries(value)) style.setProperty(key, String(one));
    } else {
      made.setAttribute(name, value === true ? "" : String(value));
    }
  }
  append(made, children);
}

/**
 * Appends children; null, undefined and false are left out.
 * @param {Element | DocumentFragment} parent
 * @param {Child} child
 */
export function append(parent, child) {
  if (Array.isArray(child)) {
    for (const one of child) append(parent, one);
  } else if (child instanceof Node) {
    parent.append(child);
  } else if (child !== null && child !== undefined && child !== false) {
    parent.append(visible(String(child)));
  }
}

/**
 * Control characters, and those that turn the direction of writing and could make a name look like
 * another one, as their codes.
 * @param {string} text
 */
function visible(text) {
  return text.replace(/[\u0000-\u0008\u000b-\u001f\u007f-\u009f\u202a-\u202e\u2066-\u2069]/g,
    (one) => `\\u${one.charCodeAt(0).toString(16).padStart(4, "0")}`);
}

/**
 * An element of HTML. `style` is an object of properties; `onclick` and the like are functions.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  fill(made, attributes, children);
  return made;
}

/**
 * An element of SVG, in the same way.
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {SVGElementTagNameMap[T]}
 */
export function svg(tag, attributes = {}, ...children) {
  const made = /** @type {SVGElementTagNameMap[T]} */ (
    document.createElementNS("http://www.w3.org/2000/svg", tag));
  fill(made, attributes, children);
  return made;
}

/** A sentence of the program, which is English on every page.
 * @param {Child} text */
export function english(text) {
  return element("span", { lang: "en" }, text);
}

/**
 * A section with its heading, that links can name.
 * @param {string} id
 * @param {Child} title
 * @param {...Child} children
 */
export function section(id, title, ...children) {
  return element("section", { id }, element("h2", {}, title), children);
}

/**
 * A table that scrolls in itself where it is too wide. Numbers stand at the right; columns of
 * text have more than one line where they need it.
 * @param {{title: Child, number?: boolean, text?: boolean}[]} columns
 * @param {Child[][]} rows
 * @param {string} [className]
 */
export function table(columns, rows, className = "") {
  const cellClass = (/** @type {number} */ i) => (columns[i]?.number ? "number" : columns[i]?.text ? "text" : undefined);
  return element("div", { class: "scroll", tabindex: 0 },
    element("table", { class: className },
      element("thead", {}, element("tr", {}, columns.map((column, i) =>
        element("th", { scope: "col", class: cellClass(i) }, column.title)))),
      element("tbody", {}, rows.map((row) =>
        element("tr", {}, row.map((cell, i) => element("td", { class: cellClass(i) }, cell)))))));
}

/** @param {Child} title of a column of numbers */
export function number(title) {
  return { title, number: true };
}

/**
 * Names and values, one below the other; what has no value is left out.
 * @param {Child[][]} rows
 * @param {string} [className] of the values
 */
export function rowList(rows, className = "mono") {
  return element("dl", { class: "rows" }, rows.filter(([, value]) => value).map(([name, value]) =>
    [element("dt", {}, name), element("dd", { class: className }, value)]));
}

/**
 * What is made when it is opened, since many pages have more than one looks at; `isMade`: at once, for links and print.
 * @param {Child} summary
 * @param {() => Child} make
 * @param {Attributes} [attributes]
 * @param {boolean} [isMade]
 */
export function unfolding(summary, make, attributes = {}, isMade = false) {
  const details = element("details", attributes, element("summary", {}, summary));
  const fill = () => {
    if ((isMade || details.open) && details.childElementCount === 1) append(details, make());
  };
  details.addEventListener("toggle", fill);
  fill();
  return details;
}

/**
 * A tile of the first screen: name, value, remark.
 * @param {Child} name
 * @param {Child} value
 * @param {Child} remark
 */
export function tile(name, value, remark) {
  return element("div", { class: "tile" }, element("dt", {}, name),
    element("dd", {}, value, element("small", {}, remark)));
}

/**
 * A short mark of a state; `kind`: good, suspect, refused or plain.
 * @param {string} kind
 * @param {Child} text
 */
export function chip(kind, text) {
  return element("span", { class: `chip ${kind}` }, text);
}

/**
 * A bar of a share from 0 to 1.
 * @param {number} share
 * @param {string} [kind]
 */
export function meter(share, kind = "good") {
  const width = `${Math.round(100 * Math.min(1, Math.max(0, share)))}%`;
  return element("span", { class: `meter ${kind}`, "aria-hidden": "true" },
    element("span", { style: { width } }));
}

/**
 * The colours of a map between what their ends mean.
 * @param {Child} low
 * @param {Child} high
 * @param {(share: number) => string} css
 */
export function colourScale(low, high, css) {
  const stops = Array.from({ length: 11 }, (_, i) => css(i / 10)).join(", ");
  return element("span", { class: "colour-bar", "aria-hidden": "true" }, low,
    element("span", { style: { background: `linear-gradient(to right, ${stops})` } }), high);
}
