/** The shapes of the collection that go best with the one that is there, each as a small swing as soon as it is made. */

import {ask, hear} from './link.js';
import {state, watch} from './store.js';
import {find, html} from './dom.js';
import {nameOf, pictureOf} from './collection.js';
import {thumbnail} from './thumbnail.js';

/** @typedef {import('./types.js').Side} Side */

/** @type {Map<number, HTMLButtonElement>} */
const cards = new Map();
let request = 0;
let asked = '';
/** Whether pictures are to come still; when one goes on they are not needed. */
let running = false;

/** @param {{take: (number: number, side: Side) => void, active: () => Side}} options */
export function beginPartners({take, active}) {
  const panel = find('#partners'), list = find('#partners .cards'), note = find('#partners-note');
  const update = () => {
    const {session} = state, side = active(), other = side === 'p' ? 'q' : 'p', input = session?.[other];
    if (!session?.collection || !input || state.step !== 'start') return;
    const key = `${session.id} ${other} ${input.name} ${input.shape ?? input.outline.slice(0, 8)}`;
    if (key === asked && request) return;
    const wanted = typeof input.shape === 'number' ? {shape: input.shape} : {side: other};
    request = ask({type: 'partners', ...wanted});
    if (!request) return;
    asked = key;
    running = true;
    cards.clear();
    list.replaceChildren();
    note.textContent = `Looking for what goes well with ${input.name}…`;
    panel.hidden = false;
  };
  watch(['session', 'step', 'connected'], update);
  watch(['step'], () => {
    if (state.step === 'start' || !running) return;
    running = false;
    asked = '';
    ask({type: 'stop'});
  });
  hear('partners_end', ({seq}) => { if (seq === request) running = false; });
  addEventListener('studio-active', update);
  hear('partners', ({seq, partners}) => {
    if (seq !== request) return;
    for (const {shape, qcrs} of partners) {
      const name = nameOf(shape);
      const button = html('button', {}, pictureOf(shape), html('b', {}, name), html('small', {}, `score ${qcrs.toFixed(2)}`));
      button.addEventListener('click', () => take(shape, active()));
      cards.set(shape, button);
      list.append(html('li', {}, button));
    }
    note.textContent = partners.length ? 'Best first, by a quick score. Each picture comes as soon as it is made.' : 'No shape of the collection goes with it.';
  });
  hear('partner', ({seq, shape, scene}) => {
    const card = seq === request ? cards.get(shape) : null;
    if (!card) return;
    card.querySelector('.lone')?.replaceWith(thumbnail(scene));
    find('small', card).textContent = scene.words;
  });
}
