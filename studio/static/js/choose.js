/** Choose: other transforms of the two shapes, best first, as they come; the weight of bending; how many pieces. */

import {ask, hear} from './link.js';
import {state, watch} from './store.js';
import {find, html} from './dom.js';
import {thumbnail} from './thumbnail.js';
import {steadily} from './steadily.js';

const RANGES = /** @type {const} */ ([[null, null], [3, 3], [4, 4], [5, 5], [6, 6], [3, 4], [4, 6]]);

let request = 0;
let asked = '';
/** Whether some are to come still; when one goes on to another step that has the machine for itself. */
let running = false;
/** @type {Map<string, {button: HTMLButtonElement, worth: number}>} */
const cards = new Map();

export function beginChoose() {
  watch(['session', 'step', 'connected'], update);
  watch(['step'], () => {
    if (state.step === 'choose' || !running) return;
    running = false;
    asked = '';
    ask({type: 'stop'});
  });
  watch(['session', 'scene'], () => {
    press();
    dials();
  });
  hear('alternative', add);
  hear('progress', ({seq, words, done, of}) => {
    if (seq === request) find('#choose-note').textContent = of ? `${words} (${done} of ${of})` : `${words}…`;
  });
  hear('alternatives_end', ({seq, count, words}) => {
    if (seq !== request) return;
    running = false;
    find('#choose-note').textContent = words || (count ? `${count} ways, best first.` : 'There is no other way.');
  });
  const weight = /** @type {HTMLInputElement} */ (find('#weight')), unbent = /** @type {HTMLInputElement} */ (find('#unbent'));
  const value = () => Number((10 ** weight.valueAsNumber).toPrecision(3));
  const {move, release} = steadily();
  weight.addEventListener('input', () => {
    unbent.checked = false;
    weight.setAttribute('aria-valuetext', `a strain costs ${value()} times what a cut costs`);
    move({kind: 'weight', weight: value()});
  });
  weight.addEventListener('change', () => release({kind: 'weight', weight: value()}));
  unbent.addEventListener('change', () => release({kind: 'weight', weight: unbent.checked ? null : value()}));
  const pieces = /** @type {HTMLSelectElement} */ (find('#pieces'));
  pieces.append(...RANGES.map(([least, most], k) => html('option', {value: String(k)}, least === null ? 'any number' : least === most ? `${least}` : `${least} to ${most}`)));
  pieces.addEventListener('change', () => {
    const [least, most] = RANGES[Number(pieces.value)];
    release({kind: 'pieces', least, most});
  });
}

/** Ask for alternatives where the inputs or the number of pieces are others than last time. */
function update() {
  const {session} = state;
  if (state.step !== 'choose' || !session?.p || !session.q) return;
  const key = JSON.stringify([session.id, session.p.outline.slice(0, 12), session.q.outline.slice(0, 12), session.pieces]);
  if (key === asked) return;
  request = ask({type: 'alternatives'});
  if (!request) return;
  asked = key;
  running = true;
  cards.clear();
  find('#alternatives').replaceChildren();
  find('#choose-note').textContent = 'Looking for other ways…';
}

/** @param {import('./types.js').Alternative & {seq: number}} alternative */
function add({seq, worth, transform, pieces, words, scene}) {
  if (seq !== request || cards.has(transform)) return;
  const button = html('button', {'aria-pressed': 'false'}, thumbnail(scene), html('b', {}, `${pieces} pieces`), html('small', {}, words));
  button.addEventListener('click', () => ask({type: 'edit', phase: 'release', edit: {kind: 'choose', transform}}));
  cards.set(transform, {button, worth});
  const list = find('#alternatives'), after = [...cards.values()].filter(card => card.worth < worth).sort((a, b) => b.worth - a.worth)[0];
  list.insertBefore(html('li', {}, button), after?.button.parentElement ?? null);
  press();
}

function press() {
  for (const [id, {button}] of cards) button.setAttribute('aria-pressed', String(id === state.session?.transform));
}

/** Show the weight and the number of pieces of the session, not while they are being set. */
function dials() {
  const {session} = state, weight = /** @type {HTMLInputElement} */ (find('#weight'));
  if (!session || document.activeElement === weight) return;
  /** @type {HTMLInputElement} */ (find('#unbent')).checked = session.weight === null;
  if (session.weight !== null) weight.value = String(Math.log10(session.weight));
  const wanted = JSON.stringify(session.pieces ?? [null, null]);
  const k = RANGES.findIndex(range => JSON.stringify(range) === wanted);
  /** @type {HTMLSelectElement} */ (find('#pieces')).value = String(Math.max(0, k));
}
