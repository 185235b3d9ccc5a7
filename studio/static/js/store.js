/** What the page knows, and who wants to hear when it changes. */

/**
 * @typedef {object} State
 * @property {import('./types.js').Session | null} session
 * @property {import('./types.js').Scene | null} scene the transform on the screen, exact or a draft
 * @property {boolean} draft
 * @property {import('./types.js').Problem | null} problem
 * @property {boolean} connected
 * @property {string} busy what is being worked on, in words; empty if nothing is
 * @property {string} step
 */

/** @type {State} */
export const state = {
  session: null, scene: null, draft: false, problem: null, connected: false, busy: '', step: 'start',
};

/** @type {{keys: string[], listener: () => void}[]} */
const listeners = [];

/**
 * Call `listener` whenever one of the keys has changed.
 * @param {(keyof State)[]} keys
 * @param {() => void} listener
 */
export function watch(keys, listener) {
  listeners.push({keys, listener});
}

/** @param {Partial<State>} changes */
export function change(changes) {
  const before = {...state};
  Object.assign(state, changes);
  const changed = Object.keys(changes).filter(key => before[/** @type {keyof State} */ (key)] !== state[/** @type {keyof State} */ (key)]);
  for (const {keys, listener} of listeners) if (keys.some(key => changed.includes(key))) listener();
}
