/** Make: parts as they will be printed, what the certificate found, pinned to the piece, and files. Loaded when it is opened. */

import {ask, base, hear} from './link.js';
import {change, state, watch} from './store.js';
import {find, html, say} from './dom.js';
import {fillSettings, titled} from './settings.js';
import {placed, poseAt} from './pose.js';
import {Viewer} from './viewer.js';

/** @typedef {import('./types.js').Made} Made */
/** @typedef {import('./types.js').Part} Part */

const DRAWN = /** @type {const} */ ([['riot', '.riot'], ['svg', 'SVG'], ['png', 'PNG'], ['pdf', 'PDF'], ['gif', 'GIF'], ['mp4', 'MP4'], ['swing.svg', 'swinging SVG']]);
const BUILT = /** @type {const} */ ([['stl', 'STL'], ['3mf', '3MF'], ['dxf', 'DXF'], ['laser.svg', 'laser SVG'], ['paper.pdf', 'paper PDF'], ['zip', 'everything, as a zip']]);
const PLAIN = [0.62, 0.63, 0.65];
const ROW_GAP = 8;

/** @type {Viewer | null} */
let viewer = null;
/** @type {Made | null} */
let made = null;
let request = 0;
let tried = '';

export async function beginMake() {
  const form = /** @type {HTMLFormElement} */ (find('#settings'));
  hear('made', message => {
    made = message;
    change({busy: '', problem: null});
    void show(message);
  });
  hear('made_not', ({seq, words, parameter, value}) => {
    if (seq !== request) return;
    complain(words);
    find('#findings').replaceChildren(finding({severity: 'failure', piece: null, words, parameter, value}));
  });
  await fillSettings(form, (settings, fix) => {
    clear();
    request = ask({type: 'make', settings, fix});
    if (request) change({busy: 'Building the parts…', problem: null});
  });
  watch(['scene', 'step', 'connected'], () => renew(form));
  renew(form);
}

/**
 * Build what is shown, once, as soon as somebody looks: parts of another transform are no use.
 * @param {HTMLFormElement} form
 */
function renew(form) {
  files();
  const {scene, step, draft, connected} = state;
  if (step !== 'make' || !scene || draft || !connected || scene.id === tried || scene.id === made?.transform) return;
  tried = scene.id;
  form.requestSubmit();
}

/** Take away what was built before. */
function clear() {
  made = null;
  viewer?.clear();
  viewer?.draw();
  for (const list of ['.labels', '#parts']) find(list).replaceChildren();
  find('#findings').replaceChildren(html('li', {class: 'note'}, 'Nothing is built yet.'));
  files();
}

/**
 * Say why there are no parts.
 * @param {string} words
 */
function complain(words) {
  change({busy: '', problem: {seq: 0, draft: false, side: null, where: [], pin: null, words}});
  say(words);
}

/** @param {Made} message */
async function show(message) {
  const failures = message.findings.filter(({severity}) => severity === 'failure').length;
  say(message.passed ? 'The parts are built, and every check holds.' : `The parts are built; ${failures} checks fail.`);
  const changes = message.changes.map(words =>
    html('li', {}, html('span', {class: 'severity'}, 'changed'), html('span', {class: 'grow'}, words.replace(/^[a-z_]+/, titled))));
  const verdict = html('li', {class: message.passed ? null : 'failure'}, html('b', {}, message.passed ? 'Every check holds.' : 'It does not hold yet.'));
  find('#findings').replaceChildren(verdict, ...changes, ...message.findings.map(finding));
  find('#parts').replaceChildren(...message.parts.map(part => html('li', {},
    html('span', {class: 'grow'}, `${part.count > 1 ? `${part.count} × ` : ''}${part.name.replaceAll('-', ' ')}`),
    html('span', {class: 'note'}, `${part.size_mm.map(size => size.toFixed(1)).join(' × ')} mm`))));
  files();
  const busy = 'Loading the parts…';
  change({busy});
  await solids(message);
  if (state.busy === busy) change({busy: ''});
}

/** @param {Pick<import('./types.js').Finding, 'severity' | 'piece' | 'words' | 'parameter' | 'value'>} one */
function finding({severity, piece, words, parameter, value}) {
  const item = html('li', {class: severity}, html('span', {class: 'severity'}, severity), html('span', {class: 'grow'}, words));
  if (piece !== null) {
    const button = html('button', {'aria-label': `Show piece ${piece + 1}: ${words}`}, `piece ${piece + 1}`);
    button.addEventListener('click', () => choose(piece));
    item.append(button);
  }
  if (parameter && value !== null) item.append(remedy(parameter, value));
  return item;
}

/**
 * A button that sets what would do.
 * @param {string} parameter
 * @param {number} value
 */
function remedy(parameter, value) {
  const words = `Set ${titled(parameter)} to ${Number(value.toPrecision(4))}`, button = html('button', {}, words);
  button.addEventListener('click', () => {
    const field = document.querySelector(`#settings [name="${CSS.escape(parameter)}"]`);
    if (!(field instanceof HTMLInputElement)) return;
    field.value = String(value);
    field.closest('details')?.setAttribute('open', '');
    field.focus();
  });
  return button;
}

/** @param {number} piece */
function choose(piece) {
  for (const label of document.querySelectorAll('.labels li')) label.classList.toggle('chosen', label.getAttribute('data-piece') === String(piece));
  find('.solid canvas').focus();
}

/** @param {Made} message */
async function solids({parts, scale, thickness, findings}) {
  const {scene} = state, canvas = /** @type {HTMLCanvasElement} */ (find('.solid canvas'));
  if (!scene) return;
  try {
    viewer ??= new Viewer(canvas, label);
  } catch (error) {
    find('.solid .note').textContent = `No view in three dimensions: ${/** @type {Error} */ (error).message}.`;
    return;
  }
  const bodies = await Promise.all(parts.map(async part => ({part, stl: await (await fetch(part.url)).arrayBuffer()})));
  const pose = poseAt(scene, 0), style = getComputedStyle(document.documentElement);
  const lowest = Math.min(...scene.p.input.filter((_, k) => k % 2)) * scale;
  let right = Math.min(...scene.p.input.filter((_, k) => k % 2 === 0)) * scale;
  viewer.clear();
  for (const {part, stl} of bodies) {
    const over = part.upside_down ? part.size_mm[2] : undefined;
    if (part.piece !== null && part.kind === 'piece') {
      const k = part.piece, colour = rgb(style.getPropertyValue(`--c${scene.pieces[k].colour}`));
      viewer.add(part.name, stl, colour, {x: pose.x[k] * scale, y: pose.y[k] * scale, turn: pose.turn[k], height: 0}, over);
    } else {
      const [width, depth] = part.size_mm;
      viewer.add(part.name, stl, PLAIN, {x: right + width / 2, y: lowest - ROW_GAP - depth, turn: 0, height: 0});
      right += width + ROW_GAP;
    }
  }
  labels(scene, findings);
  const reach = Math.max(...scene.p.input.map(value => Math.abs(value * scale)));
  viewer.fit(reach + thickness + ROW_GAP);
}

/**
 * A number on each piece; red where a check fails.
 * @param {import('./types.js').Scene} scene
 * @param {import('./types.js').Finding[]} findings
 */
function labels(scene, findings) {
  find('.labels').replaceChildren(...scene.pieces.map((_, k) => {
    const bad = findings.some(({piece, severity}) => piece === k && severity === 'failure');
    return html('li', {'data-piece': k, class: bad ? 'failure' : null}, html('span', {}, String(k + 1)));
  }));
}

/** Keep the numbers on their pieces. */
function label() {
  const {scene} = state;
  if (!viewer || !made || !scene) return;
  const pose = poseAt(scene, 0);
  for (const item of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll('.labels li'))) {
    const k = Number(item.dataset.piece), points = scene.pieces[k].outline;
    let [x, y] = [0, 0];
    for (let i = 0; i < points.length; i += 2) [x, y] = [x + points[i], y + points[i + 1]];
    const at = placed(pose, k, (2 * x) / points.length, (2 * y) / points.length);
    const spot = viewer.project([at.x * made.scale, at.y * made.scale, made.thickness]);
    item.style.transform = `translate(${spot.x}px, ${spot.y}px)`;
  }
}

function files() {
  const built = made?.transform === state.scene?.id ? made : null;
  const query = built ? `?make=${encodeURIComponent(built.key)}` : '';
  const link = (/** @type {readonly [string, string]} */ [kind, words]) =>
    html('a', {class: 'button', href: `${base()}/download/${kind}${query}`, download: true}, words);
  find('#files').replaceChildren(...DRAWN.map(link), ...(built ? BUILT.map(link) : []));
}

/** @param {string} hex */
function rgb(hex) {
  const value = parseInt(hex.trim().slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255].map(part => part / 255);
}
