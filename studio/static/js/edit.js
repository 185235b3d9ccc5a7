/** Edit: a row of tools, boards for both shapes, and what has been pinned, painted, or found impossible. */

import {ask, hear} from './link.js';
import {change, state, watch} from './store.js';
import {find, html, svg} from './dom.js';
import {Board} from './board.js';
import {TOOLS} from './tools.js';
import {figures} from './stage.js';
import {pathOf} from './geometry.js';

/** @typedef {import('./types.js').Side} Side */

const SIDES = /** @type {Side[]} */ (['p', 'q']);
const KEYS = 'With keys: arrows move along the outline, Enter takes hold, arrows drag, Enter lets go, Escape leaves off.';

/** @type {Record<string, Record<string, number>>} */
const options = Object.fromEntries(Object.entries(TOOLS).map(([name, tool]) => [name, Object.fromEntries(tool.options.map(one => [one.name, one.value]))]));
let tool = 'pull';
/** @type {Record<Side, Board>} */
const boards = /** @type {any} */ ({});
/** @type {import('./types.js').Scene | null} the last exact scene, to go back to from a draft that is left off */
let exact = null;

export function beginEdit() {
  for (const side of SIDES) boards[side] = new Board(figures[side], side, () => ({tool: TOOLS[tool], options: options[tool]}));
  toolbar();
  pick(tool);
  hear('transform', ({scene, draft}) => {
    if (!draft) exact = scene;
  });
  addEventListener('studio-cancelled', () => change({scene: exact, draft: false}));
  watch(['step'], focusable);
  watch(['scene', 'session', 'problem', 'step'], mark);
  watch(['session', 'scene'], list);
}

function mark() {
  for (const side of SIDES) {
    boards[side].clear();
    boards[side].marks.replaceChildren(...(state.step === 'edit' ? marks(side) : []));
  }
}

function toolbar() {
  const group = html('fieldset', {}, html('legend', {class: 'unseen'}, 'Tool'));
  for (const [name, {label}] of Object.entries(TOOLS)) {
    const field = html('input', {type: 'radio', name: 'tool', value: name, checked: name === tool});
    field.addEventListener('change', () => pick(name));
    group.append(html('label', {class: 'tool'}, field, label));
  }
  find('#tools').append(group, html('span', {class: 'options'}));
}

/** @param {string} name */
function pick(name) {
  tool = name;
  for (const side of SIDES) boards[side].cancel();
  find('#hint').replaceChildren(TOOLS[name].hint, html('span', {class: 'keys'}, ` ${KEYS}`));
  find('#tools .options').replaceChildren(...TOOLS[name].options.map(({name: option, words, least, greatest, step}) => {
    const field = html('input', {type: 'range', min: least, max: greatest, step, value: options[name][option]});
    field.addEventListener('input', () => { options[name][option] = field.valueAsNumber; });
    return html('label', {class: 'option'}, words, field);
  }));
  if (state.problem?.seq === 0) change({problem: null});
  mark();
}

/** While shapes are edited they take keys. */
function focusable() {
  const edits = state.step === 'edit';
  for (const side of SIDES) {
    const {root} = figures[side];
    root.setAttribute('role', edits ? 'application' : 'img');
    if (edits) {
      root.setAttribute('tabindex', '0');
      root.setAttribute('aria-describedby', 'hint');
    } else {
      root.removeAttribute('tabindex');
      root.removeAttribute('aria-describedby');
      boards[side].cancel();
    }
  }
}

/**
 * Stiff parts, pins, corners and where the problem is.
 * @param {Side} side
 */
function marks(side) {
  const {session, scene, problem} = state, paths = [];
  const here = problem?.side === side ? problem : null;
  for (const {polygon, factor} of session?.stiff[side] ?? []) {
    paths.push(svg('path', {class: factor < 1 ? 'mark-stiff soft' : 'mark-stiff', d: pathOf(polygon, true)}));
  }
  for (const [k, {kind, points}] of (session?.pins[side] ?? []).entries()) {
    const d = pathOf(points.length > 2 ? points : [...points, ...points], false);
    paths.push(svg('path', {class: `mark-pin ${kind}${here?.pin === k ? ' clash' : ''}`, d}));
  }
  const feet = scene?.[side].feet ?? [];
  if (tool === 'corner') for (let k = 0; k < feet.length; k += 2) {
    for (const kind of ['', ' inner']) paths.push(svg('path', {class: `mark-corner${kind}`, d: `M${feet[k]} ${feet[k + 1]}h0`}));
  }
  const where = here?.where ?? [];
  for (let k = 0; k < where.length; k += 2) paths.push(svg('path', {class: 'mark-problem', d: `M${where[k]} ${where[k + 1]}h0`}));
  return paths;
}

/** Pins and stiff parts, each with a way to take it away. */
function list() {
  const {session, scene} = state, items = [];
  for (const side of SIDES) {
    const name = scene?.[side].name ?? '';
    for (const [index, {kind, points}] of (session?.pins[side] ?? []).entries()) {
      const words = kind === 'draw' ? 'drawn line' : points.length > 2 ? 'kept stretch' : 'kept point';
      items.push(item(`${words} on ${name}`, {kind: 'unpin', side, index}, state.problem?.side === side && state.problem.pin === index));
    }
    for (const [index, {factor}] of (session?.stiff[side] ?? []).entries()) {
      const words = factor < 1 ? `softer part of ${name}, ${Math.round(1 / factor)} times` : `stiffer part of ${name}, ${factor} times`;
      items.push(item(words, {kind: 'unstiff', side, index}, false));
    }
  }
  find('#pins').replaceChildren(...(items.length ? items : [html('li', {class: 'note'}, 'Nothing is pinned.')]));
}

/**
 * @param {string} words
 * @param {import('./types.js').Edit} edit
 * @param {boolean} clashes
 */
function item(words, edit, clashes) {
  const button = html('button', {'aria-label': `Remove the ${words}`}, 'Remove');
  button.addEventListener('click', () => ask({type: 'edit', phase: 'release', edit}));
  return html('li', {class: clashes ? 'failure' : null}, html('span', {class: 'grow'}, words), button);
}
