/** The wall of the mined collection: outlines come as they are scrolled into sight; search, class, order. */

import {json} from './link.js';
import {state, watch} from './store.js';
import {find, html, svg} from './dom.js';

const CHUNK = 200;
const BOX = '-1300 -1300 2600 2600';

/** @typedef {{number: number, name: string, kind: number, score: number | null, item: HTMLLIElement, picture: SVGPathElement}} Entry */

/** @type {Entry[]} */
let entries = [];
/** @type {string[]} */
let classes = [];
const asked = new Set();
/** @type {{number: number, picture: SVGPathElement}[]} pictures that wait for their outline */
let pending = [];

/** @param {number} number */
export const nameOf = number => entries[number]?.name ?? `shape ${number}`;

/**
 * The silhouette of a shape, which comes when it is there.
 * @param {number} number
 */
export function pictureOf(number) {
  void outlines(number);
  const picture = svg('path');
  pending.push({number, picture});
  fill();
  return svg('svg', {viewBox: BOX, 'aria-hidden': 'true', class: 'lone'}, picture);
}

/** @param {{take: (number: number) => void}} options */
export function beginCollection({take}) {
  let begun = false;
  watch(['session'], () => {
    if (state.session?.collection && !begun) {
      begun = true;
      void load(take);
    }
    press();
  });
}

/** @param {(number: number) => void} take */
async function load(take) {
  const answer = await json('/api/collection');
  if (!answer) return;
  classes = answer.classes;
  const seen = new IntersectionObserver(found => {
    for (const {isIntersecting, target} of found) if (isIntersecting) void outlines(Number(target.getAttribute('data-number')));
  }, {rootMargin: '300px'});
  entries = answer.shapes.map((/** @type {[string, number, number | null]} */ [name, kind, score], /** @type {number} */ number) => {
    const picture = svg('path');
    const button = html('button', {'aria-pressed': 'false'}, svg('svg', {viewBox: BOX, 'aria-hidden': 'true'}, picture), name);
    button.addEventListener('click', () => take(number));
    const item = html('li', {'data-number': number}, button);
    seen.observe(item);
    return {number, name, kind, score, item, picture};
  });
  const form = find('.controls');
  find('[name=class]', form).append(...classes.map((name, k) => html('option', {value: String(k)}, name)));
  form.addEventListener('input', arrange);
  form.addEventListener('submit', event => event.preventDefault());
  keys(find('.wall'));
  find('#collection').hidden = false;
  arrange();
  press();
}

function arrange() {
  const field = /** @type {any} */ (find('.controls')).elements;
  const words = field.q.value.toLowerCase().split(/\s+/).filter(Boolean);
  const shown = entries.filter(({name, kind}) => (!field.class.value || kind === Number(field.class.value)) &&
    words.every((/** @type {string} */ word) => `${name} ${classes[kind] ?? ''}`.toLowerCase().includes(word)));
  if (field.sort.value === 'reversibility') shown.sort((a, b) => (b.score ?? -1) - (a.score ?? -1) || a.number - b.number);
  else shown.sort((a, b) => a.name.localeCompare(b.name, undefined, {numeric: true}));
  find('.wall').replaceChildren(...shown.map(({item}) => item));
  find('.controls .shown').textContent = shown.length === entries.length ? `${entries.length} shapes`
    : `${shown.length} of ${entries.length} shapes`;
}

/**
 * Fetch the outlines of the chunk that a shape is in.
 * @param {number} number
 */
async function outlines(number) {
  const first = Math.floor(number / CHUNK) * CHUNK;
  if (asked.has(first)) return;
  asked.add(first);
  const answer = await json(`/api/collection/outlines?first=${first}&count=${CHUNK}`);
  if (!answer) asked.delete(first);
  answer?.paths.forEach((/** @type {string} */ path, /** @type {number} */ k) => entries[answer.first + k]?.picture.setAttribute('d', path));
  fill();
}

/** Give outlines to the pictures that wait for them. */
function fill() {
  pending = pending.filter(({number, picture}) => {
    const path = entries[number]?.picture.getAttribute('d');
    if (path) picture.setAttribute('d', path);
    return !path;
  });
}

/** Mark the shapes that are taken. */
function press() {
  const taken = [state.session?.p, state.session?.q].map(input => input?.shape ?? -1);
  for (const {item, number} of entries) item.firstElementChild?.setAttribute('aria-pressed', String(taken.includes(number)));
}

/**
 * One stop of the tab key for the whole wall; arrows lead through it.
 * @param {HTMLElement} wall
 */
function keys(wall) {
  const buttons = () => /** @type {HTMLButtonElement[]} */ ([...wall.querySelectorAll('button')]);
  wall.addEventListener('keydown', event => {
    const all = buttons(), now = all.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    if (now < 0) return;
    const top = all[0].offsetTop, row = Math.max(1, all.findIndex(button => button.offsetTop > top));
    const next = {ArrowLeft: now - 1, ArrowRight: now + 1, ArrowUp: now - row, ArrowDown: now + row, Home: 0, End: all.length - 1}[event.key];
    if (next === undefined) return;
    event.preventDefault();
    all[Math.max(0, Math.min(all.length - 1, next))].focus();
  });
  const stop = () => {
    const all = buttons(), at = document.activeElement;
    const one = all.find(button => button === at) ?? all[0];
    for (const button of all) button.tabIndex = button === one ? 0 : -1;
  };
  wall.addEventListener('focusin', stop);
  new MutationObserver(stop).observe(wall, {childList: true});
}
