/** Small pictures of a transform: both shapes, and between them the chain, which swings when it comes and when looked at. */

import {Figure} from './figure.js';
import {calm, svg} from './dom.js';
import {timeOf} from './swing.js';

const GREETING_MS = 4800;

/** @type {Map<Figure, number>} when each began to swing */
const swinging = new Map();
const STILL = 0.5;

/**
 * Three pictures side by side.
 * @param {import('./types.js').Scene} scene
 * @returns {HTMLSpanElement}
 */
export function thumbnail(scene) {
  const box = document.createElement('span'), looked = {now: false};
  box.className = 'thumbnail';
  const figures = /** @type {const} */ (['p', undefined, 'q']).map(side => {
    const root = svg('svg', {'aria-hidden': 'true'});
    const figure = new Figure(root, {side, plain: true});
    if (!side) figure.time = STILL;
    figure.show(scene);
    box.append(root);
    return figure;
  });
  const chain = figures[1];
  if (!calm.matches) begin(chain, () => looked.now);
  queueMicrotask(() => {
    const owner = box.closest('button') ?? box;
    const look = (/** @type {boolean} */ wanted) => () => {
      looked.now = wanted;
      if (wanted && !calm.matches) begin(chain, () => looked.now);
    };
    for (const name of ['pointerenter', 'focus']) owner.addEventListener(name, look(true));
    for (const name of ['pointerleave', 'blur']) owner.addEventListener(name, look(false));
  });
  return box;
}

/**
 * @param {Figure} figure
 * @param {() => boolean} looked whether it goes on after its greeting
 */
function begin(figure, looked) {
  if (swinging.has(figure)) return;
  const start = performance.now();
  swinging.set(figure, start);
  const tick = (/** @type {number} */ now) => {
    const shown = figure.root.isConnected && figure.root.getClientRects().length;
    const done = now - start > GREETING_MS && !looked() && Math.abs(figure.time - STILL) < 0.03;
    if (done || (!figure.root.isConnected && now - start > 1000)) {
      swinging.delete(figure);
      return;
    }
    if (shown) figure.pose(timeOf(1350 + now - start));
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}
