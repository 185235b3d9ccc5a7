/** Look: both shapes in pieces, the chain between them that swings, and what of it all is shown. */

import {state, watch} from './store.js';
import {find, html} from './dom.js';
import {Figure} from './figure.js';
import {Swing} from './swing.js';
import {beginTextures} from './textures.js';

/** @typedef {import('./types.js').Side} Side */

const TOGGLES = /** @type {const} */ ([
  ['input', 'input'], ['bent', 'bend'], ['trunk', 'trunk'], ['cuts', 'dissection lines'], ['textures', 'textures'],
]);

/** @type {Record<Side | 'chain', Figure>} */
export const figures = /** @type {any} */ ({});

/** Whether something is dragged: then pictures keep their frame. */
export const hold = {now: false};

export function beginStage() {
  for (const view of /** @type {const} */ (['p', 'chain', 'q'])) {
    const root = /** @type {SVGSVGElement} */ (find(/** @type {string} */ (`[data-view=${view}] svg`)));
    figures[view] = new Figure(root, view === 'chain' ? {} : {side: view});
  }
  const swing = new Swing(figures.chain, [figures.p, figures.q], find('#play'), find('#slider'));
  toggles();
  let greeted = false;
  watch(['scene', 'step'], () => {
    if (state.step === 'look' && state.scene && !greeted) {
      greeted = true;
      swing.greet();
    }
    if (state.step !== 'look') swing.play(false);
  });
  watch(['scene', 'draft'], show);
  beginTextures(figures, find('.toggles [name=textures]'));
}

function show() {
  const {scene, draft} = state;
  if (!scene) return;
  const steady = draft || hold.now;
  for (const figure of Object.values(figures)) figure.show(scene, steady);
  find('.stage').classList.toggle('draft', draft);
  for (const side of /** @type {const} */ (['p', 'q'])) {
    const shape = scene[side];
    find(`[data-view=${side}] figcaption`).replaceChildren(html('b', {}, shape.name), html('span', {}, shape.fidelity.words));
    find(`[data-view=${side}] svg`).setAttribute('aria-label', `${shape.name}, made of ${scene.pieces.length} pieces: ${shape.fidelity.words}`);
  }
  find('#certificate').textContent = draft ? 'A draft; the exact one follows.'
    : [`${scene.pieces.length} pieces`, scene.motion.words, scene.certificate.passed ? 'certified exact' : scene.certificate.words]
      .filter(Boolean).join(', ');
  for (const [name] of TOGGLES) {
    const label = find(`.toggles [name=${name}]`).closest('label');
    if (name === 'bent' && label) label.hidden = !scene.p.bent && !scene.q.bent;
  }
}

function toggles() {
  const stage = find('.stage'), box = find('.toggles');
  for (const [name, words] of TOGGLES) {
    const field = html('input', {type: 'checkbox', name, checked: name === 'input' || name === 'bent' || name === 'textures'});
    const apply = () => stage.classList.toggle(`hide-${name}`, !field.checked);
    field.addEventListener('change', apply);
    apply();
    box.append(html('label', {}, field, words));
  }
}
