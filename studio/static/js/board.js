/** A shape that is edited: gestures by pointer, pen, finger or keys, and marks for pins, corners and problems. */

import {hold} from './stage.js';
import {change, state} from './store.js';
import {lengthOf, nearestOn, pathOf, pointAt} from './geometry.js';
import {assembled} from './pose.js';
import {say, svg} from './dom.js';
import {snap} from './tools.js';
import {steadily} from './steadily.js';

/** @typedef {import('./tools.js').Ground} Ground */
/** @typedef {import('./tools.js').Gesture} Gesture */
/** @typedef {{x: number, y: number}} Place */

const STEP = 0.02;
const FAST = 5;

export class Board {
  /**
   * @param {import('./figure.js').Figure} figure
   * @param {import('./types.js').Side} side
   * @param {() => {tool: import('./tools.js').Tool, options: Record<string, number>}} chosen
   */
  constructor(figure, side, chosen) {
    this.figure = figure;
    this.side = side;
    this.chosen = chosen;
    /** @type {Gesture | null} */
    this.gesture = null;
    /** @type {Place | null} */
    this.cursor = null;
    this.sender = steadily();
    this.marks = svg('g');
    this.trace = svg('g');
    figure.marks.append(this.marks, this.trace);
    const {root} = figure;
    root.addEventListener('pointerdown', event => this.#down(event));
    root.addEventListener('pointermove', event => {
      if (!this.gesture) return;
      for (const one of event.getCoalescedEvents?.() ?? []) this.gesture.move(figure.point(one));
      this.#moved(figure.point(event));
    });
    root.addEventListener('pointerup', event => this.#end(figure.point(event)));
    root.addEventListener('pointercancel', () => this.cancel());
    root.addEventListener('keydown', event => this.#key(event));
    root.addEventListener('blur', () => this.cancel());
  }

  /** @returns {Ground | null} */
  ground() {
    const {scene} = state;
    if (!scene) return null;
    const shape = scene[this.side];
    return {side: this.side, outlines: [shape.bent ?? shape.input, assembled(scene, this.side)], feet: shape.feet, options: this.chosen().options};
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (state.step !== 'edit' || event.button || !event.isPrimary) return;
    this.figure.root.setPointerCapture(event.pointerId);
    this.figure.root.focus({preventScroll: true});
    this.cursor = null;
    event.preventDefault();
    if (this.gesture) this.#moved(this.figure.point(event));
    else this.#begin(this.figure.point(event));
  }

  /** @param {Place} point */
  #begin(point) {
    const ground = this.ground();
    if (!ground) return;
    const gesture = this.chosen().tool.begin(ground, point);
    if (typeof gesture === 'string') {
      this.#complain(gesture, point);
      return;
    }
    this.gesture = gesture;
    hold.now = true;
    change({problem: null});
    this.#preview();
  }

  /** @param {Place} point */
  #moved(point) {
    this.gesture?.move(point);
    const draft = this.gesture?.draft();
    if (draft) this.sender.move(draft);
    this.#preview();
  }

  /** @param {Place} point */
  #end(point) {
    if (!this.gesture) return;
    const edit = this.gesture.end(point);
    if (edit === 'more') {
      this.#preview();
      return;
    }
    this.gesture = null;
    hold.now = false;
    if (edit && typeof edit === 'object') this.sender.release(edit);
    else this.cancel();
    if (typeof edit === 'string') this.#complain(edit, point);
  }

  /** Leave off what has been begun; the picture is that of before. */
  cancel() {
    const begun = this.gesture;
    this.gesture = null;
    hold.now = false;
    this.sender.drop();
    this.clear();
    if (begun && state.draft) dispatchEvent(new Event('studio-cancelled'));
  }

  /** Take the trace of a gesture away. */
  clear() {
    if (!this.gesture) this.trace.replaceChildren();
    this.#show();
  }

  /**
   * @param {string} words
   * @param {Place} point
   */
  #complain(words, {x, y}) {
    change({problem: {seq: 0, draft: false, side: this.side, where: [x, y], pin: null, words}});
    say(words);
  }

  #preview() {
    const {line, brush} = this.gesture?.preview() ?? {};
    this.trace.replaceChildren();
    if (line) this.trace.append(svg('path', {class: 'mark-line', d: pathOf(line.length > 2 ? line : [...line, ...line], false)}));
    if (brush) {
      const d = pathOf(brush.line.length > 2 ? brush.line : [...brush.line, ...brush.line], false);
      this.trace.append(svg('path', {class: `mark-brush ${brush.paint}`, d, 'stroke-width': 2 * brush.radius}));
    }
    this.#show();
  }

  #show() {
    this.figure.root.querySelector('.mark-cursor')?.remove();
    if (this.cursor) this.trace.append(svg('path', {class: 'mark-cursor', d: `M${this.cursor.x} ${this.cursor.y}h0`}));
  }

  /**
   * Arrows lead a cursor along the outline, or, while something is held, anywhere; Enter takes hold and lets go.
   * @param {KeyboardEvent} event
   */
  #key(event) {
    const ground = this.ground();
    if (state.step !== 'edit' || !ground || event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = /** @type {[number, number] | undefined} */ ({ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key]);
    if (event.key === 'Escape') this.cancel();
    else if (arrow) this.#step(ground, arrow, event.shiftKey ? FAST * STEP : STEP);
    else if (event.key === 'Enter' || event.key === ' ') this.#enter(ground);
    else return;
    event.preventDefault();
  }

  /**
   * @param {Ground} ground
   * @param {[number, number]} arrow
   * @param {number} length
   */
  #step(ground, [right, up], length) {
    const at = this.cursor ?? this.#home(ground);
    if (this.gesture) {
      this.cursor = {x: at.x + right * length, y: at.y + up * length};
      this.#moved(this.cursor);
      return;
    }
    if (this.chosen().tool.label === 'Corner') this.cursor = nextCorner(ground.feet, at, right + up);
    else {
      const [outline] = ground.outlines, {position} = nearestOn(outline, at.x, at.y);
      this.cursor = pointAt(outline, position + (right || up) * length + lengthOf(outline));
    }
    this.#show();
  }

  /** @param {Ground} ground */
  #enter(ground) {
    const at = this.cursor ?? this.#home(ground);
    this.cursor = at;
    if (this.gesture) this.#end(at);
    else {
      this.#begin(at);
      if (this.gesture) say('Held. Arrows move it, Enter lets go, Escape leaves off.');
    }
    this.#show();
  }

  /** @param {Ground} ground */
  #home(ground) {
    const [x, y] = ground.feet.length ? ground.feet : ground.outlines[0];
    return snap(ground, {x, y});
  }
}

/**
 * The corner after, or before, the one nearest to a place.
 * @param {import('./types.js').Flat} feet
 * @param {Place} at
 * @param {number} way
 */
function nextCorner(feet, at, way) {
  const n = feet.length / 2, far = feet.map((_, k) => (k < n ? Math.hypot(feet[2 * k] - at.x, feet[2 * k + 1] - at.y) : Infinity));
  const k = (far.indexOf(Math.min(...far)) + (way > 0 ? 1 : n - 1)) % n;
  return {x: feet[2 * k], y: feet[2 * k + 1]};
}
