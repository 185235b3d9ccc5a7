/** Start: two places for a shape each, filled by a file that is dropped or chosen, or by a shape of the collection. */

import {ask, base, begun, hear, json} from './link.js';
import {change, state, watch} from './store.js';
import {find, html, say, svg} from './dom.js';
import {Figure} from './figure.js';
import {beginCollection} from './collection.js';
import {beginPartners} from './partners.js';

/** @typedef {import('./types.js').Side} Side */

const PICTURES = '.png,.jpg,.jpeg,.gif,.bmp,.tif,.tiff,.svg,.riot';
const NAMES = {p: 'First shape', q: 'Second shape'};
const touched = matchMedia('(pointer: coarse)');
const SIDES = /** @type {Side[]} */ (['p', 'q']);

/** @type {Record<Side, {box: HTMLElement, figure: Figure, name: HTMLElement, bad: HTMLElement, pick: HTMLButtonElement}>} */
const slots = /** @type {any} */ ({});
/** @type {Side | null} which place the collection fills next; null is the first empty one */
let chosen = null;
/** Whether this page gave a shape and waits for what becomes of it. */
let waiting = false;

/** The place that the next shape of the collection goes to. @returns {Side} */
export function active() {
  return chosen ?? (!state.session?.p ? 'p' : 'q');
}

export function beginStart() {
  for (const side of SIDES) slots[side] = slot(side);
  watch(['session', 'connected'], show);
  hear('transform', () => {
    if (!waiting || !state.session?.p || !state.session.q) return;
    waiting = false;
    if (state.step === 'start') location.hash = 'look';
  });
  find('#swap').addEventListener('click', () => ask({type: 'edit', phase: 'release', edit: {kind: 'swap'}}));
  find('#new').addEventListener('click', async () => {
    const made = await json('/api/sessions', {method: 'POST'});
    if (made) location.assign(`/?session=${encodeURIComponent(made.id)}`);
  });
  drops();
  beginCollection({take});
  beginPartners({take, active});
  void earlier();
}

/**
 * Give a shape of the collection.
 * @param {number} number
 * @param {Side} [side]
 */
export async function take(number, side = active()) {
  waiting = true;
  slots[side].bad.textContent = '';
  await begun;
  const answer = await fetch(`${base()}/shape/${side}/${number}`, {method: 'POST'});
  if (!answer.ok) complain(side, 'The collection has no such shape.');
}

/**
 * Give a file.
 * @param {File} file
 * @param {Side} side
 */
async function upload(file, side) {
  slots[side].bad.textContent = '';
  change({busy: `Reading ${file.name}…`});
  waiting = true;
  await begun;
  try {
    const answer = await fetch(`${base()}/input/${side}?name=${encodeURIComponent(file.name)}`, {method: 'PUT', body: file});
    if (!answer.ok) {
      const {words} = await answer.json().catch(() => ({words: `the studio answers ${answer.status}`}));
      complain(side, `${file.name}: ${words}`);
    } else {
      chosen = null;
      const {doubts = []} = await answer.json();
      slots[side].bad.textContent = doubts.join(' ');
      if (doubts.length) say(doubts.join(' '));
      if (state.busy.startsWith('Reading')) change({busy: ''});
    }
  } catch {
    complain(side, `${file.name} could not be sent: the studio does not answer.`);
  }
}

/**
 * @param {Side} side
 * @param {string} words
 */
function complain(side, words) {
  waiting = false;
  slots[side].bad.textContent = words;
  change({busy: ''});
  say(words);
}

/** @param {Side} side */
function slot(side) {
  const box = find(`.slot[data-side=${side}]`), id = `file-${side}`;
  const picture = svg('svg', {role: 'img', 'aria-label': `${NAMES[side]}: none yet`, viewBox: '-1 -1 2 2'});
  const name = html('b', {}, NAMES[side]), bad = html('p', {class: 'bad'});
  const file = html('input', {type: 'file', id, accept: PICTURES, multiple: true});
  const pick = html('button', {hidden: true, 'aria-pressed': 'false'}, 'Pick below');
  const button = html('label', {for: id, class: 'button'}, file, 'Choose a picture', html('span', {class: 'unseen'}, ` for the ${NAMES[side].toLowerCase()}`));
  file.addEventListener('change', () => {
    give([...(file.files ?? [])], side);
    file.value = '';
  });
  pick.addEventListener('click', () => {
    chosen = side;
    show();
    dispatchEvent(new Event('studio-active'));
  });
  box.append(picture, name, html('span', {class: 'note hint'}, 'Drop a picture here, or'), html('div', {class: 'choices'}, button, pick), bad);
  return {box, figure: new Figure(picture, {side}), name, bad, pick};
}

/**
 * One file goes where it is asked for, two fill both places.
 * @param {File[]} files
 * @param {Side} side
 */
function give(files, side) {
  const [first, second] = files;
  if (first) void upload(first, second ? 'p' : side);
  if (second) void upload(second, 'q');
}

function drops() {
  let depth = 0;
  const veil = find('#drop');
  const show = (/** @type {number} */ change) => {
    depth = Math.max(0, depth + change);
    veil.hidden = depth === 0;
  };
  addEventListener('dragenter', event => { if (event.dataTransfer?.types.includes('Files')) show(1); });
  addEventListener('dragleave', () => show(-1));
  addEventListener('dragover', event => event.preventDefault());
  addEventListener('drop', event => {
    event.preventDefault();
    depth = 0;
    show(0);
    const at = event.target instanceof Element ? event.target.closest('.slot')?.getAttribute('data-side') : null;
    give([...(event.dataTransfer?.files ?? [])], at === 'p' || at === 'q' ? at : active());
  });
}

function show() {
  const {session} = state;
  for (const side of SIDES) {
    const input = session?.[side] ?? null, {box, figure, name, pick} = slots[side];
    figure.showInput(input);
    figure.root.setAttribute('aria-label', `${NAMES[side]}: ${input ? input.name : 'none yet'}`);
    name.textContent = input ? input.name : NAMES[side];
    box.classList.toggle('filled', Boolean(input));
    box.classList.toggle('active', Boolean(session?.collection) && side === active());
    pick.hidden = !session?.collection;
    pick.setAttribute('aria-pressed', String(side === active()));
    pick.replaceChildren('Pick below', html('span', {class: 'unseen'}, ` the ${NAMES[side].toLowerCase()}`));
  }
  const both = Boolean(session?.p && session.q);
  /** @type {HTMLButtonElement} */ (find('#swap')).disabled = !both;
  find('#onward').hidden = !both || !state.session?.transform;
  find('#start-note').textContent = both ? '' : session?.collection
    ? 'Drop pictures anywhere on this page, choose files, or pick from the collection below.'
    : `${touched.matches ? 'Choose two pictures' : 'Drop one or two pictures anywhere on this page'}: PNG, JPEG, SVG, or a photo with a plain background.`;
}

/** Links to pieces of work that are saved. */
async function earlier() {
  const answer = await json('/api/sessions');
  const list = (answer?.sessions ?? []).filter((/** @type {any} */ one) => one.p || one.q);
  find('#earlier').hidden = !list.length;
  find('#earlier ul').append(...list.slice(0, 30).map((/** @type {{id: string, p: string?, q: string?, changed: string}} */ one) =>
    html('li', {}, html('a', {href: `/?session=${encodeURIComponent(one.id)}`}, [one.p, one.q].filter(Boolean).join(' and ')),
      ` ${new Date(one.changed).toLocaleString()}`)));
}
