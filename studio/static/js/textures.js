/** Textures: the pieces in the colours of the pictures that were given, where these have several. */

import {base, json} from './link.js';
import {state, watch} from './store.js';

/** @typedef {import('./types.js').Texture} Texture */

/**
 * @param {Record<import('./types.js').Side | 'chain', import('./figure.js').Figure>} figures
 * @param {HTMLElement} toggle
 */
export function beginTextures(figures, toggle) {
  /** @type {{id: string, images: Promise<{p?: Texture[], q?: Texture[]} | null>}} */
  let known = {id: '', images: Promise.resolve(null)};
  const label = toggle.closest('label');
  watch(['scene', 'draft', 'session'], async () => {
    const {scene, draft, session} = state;
    const colours = Boolean(session?.p?.colours || session?.q?.colours);
    if (label) label.hidden = !colours;
    if (!scene || draft || !colours || session?.transform !== scene.id) return;
    if (known.id !== scene.id) known = {id: scene.id, images: json(`${base()}/textures/${scene.id}`)};
    const images = await known.images;
    if (state.scene !== scene || state.draft) return;
    figures.p.paint(images?.p);
    figures.chain.paint(images?.p);
    figures.q.paint(images?.q);
  });
  if (label) label.hidden = true;
}
