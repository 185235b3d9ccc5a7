/** Begins the page: which work, which step, the messages that concern all steps, and the keys. */

import {ask, connect, hear, json} from './link.js';
import {change, state, watch} from './store.js';
import {find, say, typing} from './dom.js';
import {beginStart} from './start.js';
import {beginStage} from './stage.js';
import {beginChoose} from './choose.js';
import {beginEdit} from './edit.js';
import {beginSnapshots} from './snapshots.js';

const STEPS = ['start', 'look', 'choose', 'edit', 'make'];
const TITLES = {look: 'Look', choose: 'Choose', edit: 'Edit', make: 'Make', start: 'Start'};
const STAGED = ['look', 'choose', 'edit'];
let making = false;

/** @param {string} step */
const allowed = step => step === 'start' || Boolean(state.scene);

function route() {
  const wanted = location.hash.slice(1);
  const step = STEPS.includes(wanted) && allowed(wanted) ? wanted : 'start';
  document.body.dataset.step = step;
  document.title = `${TITLES[/** @type {keyof typeof TITLES} */ (step)]} – RIOT studio`;
  find('#start').hidden = step !== 'start';
  find('#work').hidden = !STAGED.includes(step);
  for (const tool of ['#tools', '#hint']) find(tool).hidden = step !== 'edit';
  find('#make').hidden = step !== 'make';
  for (const name of STAGED) find(`#${name}`).hidden = name !== step;
  if (step !== state.step) scrollTo(0, 0);
  // What had the focus may be hidden now.
  if (document.activeElement?.closest('[hidden]')) find('#main').focus({preventScroll: true});
  change({step});
  marks();
  if (step === 'make' && !making) {
    making = true;
    void import('./make.js').then(({beginMake}) => beginMake());
  }
}

/** Say in the row of steps where one is, and which cannot be taken yet. */
function marks() {
  for (const link of document.querySelectorAll('nav a')) {
    const step = (link.getAttribute('href') ?? '').slice(1);
    if (step === state.step) link.setAttribute('aria-current', 'step');
    else link.removeAttribute('aria-current');
    if (allowed(step)) link.removeAttribute('aria-disabled');
    else link.setAttribute('aria-disabled', 'true');
  }
}

function status() {
  const line = find('#status');
  const words = !state.connected ? 'The studio does not answer. Your work is saved: start “riot studio” again, and open the address that it prints.'
    : state.problem ? state.problem.words : state.busy;
  line.hidden = !words;
  line.textContent = words;
  line.classList.toggle('problem', Boolean(state.problem) || !state.connected);
}

function history() {
  const {session} = state;
  for (const name of /** @type {const} */ (['undo', 'redo'])) {
    const button = find(/** @type {string} */ (`#${name}`)), step = session?.[name];
    /** @type {HTMLButtonElement} */ (button).disabled = !step;
    button.title = step ? `${name === 'undo' ? 'Undo' : 'Redo'}: ${step}` : '';
  }
  find('#saved').textContent = !session ? '' : session.saved ? 'Saved' : 'Saving…';
}

function messages() {
  hear('session', session => change({session}));
  hear('transform', ({scene, draft}) => {
    change({scene, draft, problem: null, ...(draft ? {} : {busy: ''})});
    if (!draft) say(scene.words);
  });
  hear('motion', ({transform, motion}) => {
    const scene = state.scene;
    if (scene && scene.id === transform) change({scene: {...scene, motion, words: worded(scene, motion)}});
  });
  hear('problem', problem => {
    change({problem, busy: ''});
    if (!problem.draft) say(problem.words);
  });
  hear('refused', ({words}) => {
    change({problem: {seq: 0, draft: false, side: null, where: [], pin: null, words}, busy: ''});
    say(words);
  });
  hear('progress', ({work, words, done, of}) => {
    if (work === 'transform' || work === 'make') change({busy: of ? `${words} (${done} of ${of})` : `${words}…`});
  });
}

/**
 * @param {import('./types.js').Scene} scene
 * @param {import('./types.js').Motion} motion
 */
function worded(scene, motion) {
  return !motion.words || scene.words.includes(motion.words) ? scene.words : `${scene.words}, ${motion.words}`;
}

function keys() {
  addEventListener('keydown', event => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || typing(event)) return;
    const key = event.key.toLowerCase();
    const wanted = key === 'z' ? (event.shiftKey ? 'redo' : 'undo') : key === 'y' ? 'redo' : '';
    if (!wanted) return;
    event.preventDefault();
    if (state.session?.[/** @type {'undo' | 'redo'} */ (wanted)]) ask({type: wanted});
  });
  find('#undo').addEventListener('click', () => ask({type: 'undo'}));
  find('#redo').addEventListener('click', () => ask({type: 'redo'}));
  find('nav').addEventListener('click', event => {
    const link = event.target instanceof Element ? event.target.closest('a') : null;
    if (link?.hasAttribute('aria-disabled')) {
      event.preventDefault();
      say('First give two pictures.');
    }
  });
}

async function begin() {
  messages();
  keys();
  watch(['connected', 'problem', 'busy'], status);
  watch(['session'], history);
  watch(['scene'], () => {
    const wanted = location.hash.slice(1);
    if (!state.scene && state.step !== 'start') location.hash = 'start';
    else if (state.scene && wanted !== state.step && STEPS.includes(wanted)) route();
    marks();
  });
  beginStart();
  beginStage();
  beginChoose();
  beginEdit();
  beginSnapshots();
  addEventListener('hashchange', route);
  route();
  const chosen = new URLSearchParams(location.search).get('session');
  const id = chosen ?? (await json('/api/sessions'))?.current ?? (await json('/api/sessions', {method: 'POST'}))?.id;
  if (!id) {
    status();
    return;
  }
  // So that the page loaded again is the same piece of work.
  window.history.replaceState(null, '', `/?session=${encodeURIComponent(id)}${location.hash}`);
  connect(id);
}

void begin();
