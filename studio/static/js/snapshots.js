/** Named states of the work: kept, gone back to, and seen side by side. */

import {ask, base, json} from './link.js';
import {state, watch} from './store.js';
import {find, html, say} from './dom.js';
import {thumbnail} from './thumbnail.js';

export function beginSnapshots() {
  const form = /** @type {HTMLFormElement} */ (find('#snapshot'));
  const field = /** @type {HTMLInputElement} */ (find('[name=name]', form));
  form.addEventListener('submit', event => {
    event.preventDefault();
    if (!ask({type: 'snapshot', name: field.value.trim()})) return;
    say(`Kept as ${field.value}.`);
    field.value = '';
  });
  find('#compare').addEventListener('click', compare);
  let shown = '';
  watch(['session'], () => {
    const snapshots = state.session?.snapshots ?? [], key = JSON.stringify(snapshots);
    if (key === shown) return;
    shown = key;
    find('#compare').hidden = snapshots.length < 1;
    find('#snapshots').replaceChildren(...snapshots.map(({name, words}) => html('li', {},
      html('span', {class: 'grow'}, html('b', {}, name), ` ${words}`), action('Restore', 'restore', name), action('Forget', 'forget', name))));
  });
}

/**
 * @param {string} label
 * @param {'restore' | 'forget'} type
 * @param {string} name
 */
function action(label, type, name) {
  const button = html('button', {'aria-label': `${label} ${name}`}, label);
  button.addEventListener('click', () => ask({type, name}));
  return button;
}

/** The present state and every snapshot, each with its pictures. */
async function compare() {
  const dialog = /** @type {HTMLDialogElement} */ (find('#side-by-side')), list = find('.cards', dialog);
  const {session, scene} = state;
  if (!session) return;
  list.replaceChildren();
  dialog.showModal();
  if (scene) list.append(card('Now', scene.words, scene, null));
  for (const {name, transform, words} of session.snapshots) {
    const kept = await json(`${base()}/scene/${encodeURIComponent(transform)}`);
    if (kept) list.append(card(name, words, kept, () => {
      ask({type: 'restore', name});
      dialog.close();
    }));
  }
}

/**
 * @param {string} name
 * @param {string} words
 * @param {import('./types.js').Scene} scene
 * @param {(() => void) | null} restore
 */
function card(name, words, scene, restore) {
  const button = html('button', {disabled: !restore}, thumbnail(scene), html('b', {}, name), html('small', {}, words));
  if (restore) {
    button.append(html('small', {}, 'Restore'));
    button.addEventListener('click', restore);
  }
  return html('li', {}, button);
}
