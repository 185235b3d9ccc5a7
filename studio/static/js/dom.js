/** Short words for what the page does with elements. */

const SVG = 'http://www.w3.org/2000/svg';

/**
 * The one element that a selector finds.
 * @template {Element} [T=HTMLElement]
 * @param {string} selector
 * @param {ParentNode} [within]
 * @returns {T}
 */
export function find(selector, within = document) {
  const element = within.querySelector(selector);
  if (!element) throw new Error(`the page has no ${selector}`);
  return /** @type {T} */ (element);
}

/**
 * A new HTML element with attributes and children.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} name
 * @param {Record<string, string | boolean | number | null>} [attributes] null and false leave an attribute out
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function html(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  set(element, attributes);
  element.append(...children);
  return element;
}

/**
 * A new SVG element with attributes and children.
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} name
 * @param {Record<string, string | boolean | number | null>} [attributes]
 * @param {...Node} children
 * @returns {SVGElementTagNameMap[K]}
 */
export function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, name);
  set(element, attributes);
  element.append(...children);
  return element;
}

/**
 * @param {Element} element
 * @param {Record<string, string | boolean | number | null>} attributes
 */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === false) element.removeAttribute(name);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
}

/** Whether nothing should move by itself. */
export const calm = matchMedia('(prefers-reduced-motion: reduce)');

/**
 * Tell those who listen rather than look.
 * @param {string} words
 */
export function say(words) {
  const live = find('#says');
  live.textContent = live.textContent === words ? `${words} ` : words;
}

/**
 * Whether a key is meant for a field.
 * @param {KeyboardEvent} event
 */
export function typing(event) {
  return event.target instanceof Element && event.target.matches('input:not([type=checkbox],[type=radio],[type=range]),select,textarea');
}
