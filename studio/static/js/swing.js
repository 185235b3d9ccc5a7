/** The swing: play and pause, a slider, and pieces that turn about their hinge as they are dragged. */

import {placed, poseAt, unplaced} from './pose.js';
import {calm} from './dom.js';
import {state} from './store.js';

const WAY_MS = 2600;
const REST_MS = 500;
const HOME_MS = 300;
const REACH = 0.5;
const STEP = 0.004;

export class Swing {
  /**
   * @param {import('./figure.js').Figure} figure the chain
   * @param {import('./figure.js').Figure[]} ends both shapes: their pieces can be dragged, too, and go back when let go
   * @param {HTMLButtonElement} button
   * @param {HTMLInputElement} slider from 0 to 1
   */
  constructor(figure, ends, button, slider) {
    this.figure = figure;
    this.button = button;
    this.slider = slider;
    this.plays = false;
    this.clock = 0;
    this.last = 0;
    button.addEventListener('click', () => this.play(!this.plays));
    slider.addEventListener('input', () => {
      this.play(false);
      this.show(slider.valueAsNumber);
    });
    for (const one of [figure, ...ends]) this.#drags(one);
  }

  /** @param {boolean} wanted */
  play(wanted) {
    if (wanted === this.plays) return;
    this.plays = wanted;
    this.button.textContent = wanted ? 'Pause' : 'Play';
    if (!wanted) return;
    this.clock = clockOf(this.figure.time);
    this.last = performance.now();
    requestAnimationFrame(now => this.#tick(now));
  }

  /** Begin to play where nobody asked for less motion. */
  greet() {
    if (calm.matches) this.show(0.35);
    else this.play(true);
  }

  /** @param {number} time */
  show(time) {
    this.figure.pose(time);
    this.slider.value = String(time);
    this.slider.setAttribute('aria-valuetext', words(time));
  }

  /** @param {number} now */
  #tick(now) {
    if (!this.plays) return;
    this.clock += Math.min(now - this.last, 100);
    this.last = now;
    if (this.figure.root.getClientRects().length) this.show(timeOf(this.clock));
    requestAnimationFrame(next => this.#tick(next));
  }

  /** @param {import('./figure.js').Figure} figure */
  #drags(figure) {
    /** @type {{piece: number, x: number, y: number} | null} */
    let held = null;
    figure.root.addEventListener('pointerdown', event => {
      const piece = figure.pieceAt(event);
      if (piece === null || event.button || !figure.scene || (figure.side && state.step === 'edit')) return;
      this.play(false);
      const {x, y} = figure.point(event);
      held = {piece, ...unplaced(poseAt(figure.scene, figure.time), piece, x, y)};
      figure.root.setPointerCapture(event.pointerId);
      figure.root.classList.add('held');
      event.preventDefault();
    });
    figure.root.addEventListener('pointermove', event => {
      if (!held || !figure.scene) return;
      const time = timeNear(figure.scene, held, figure.point(event), figure.time);
      figure.pose(time);
      this.show(time);
    });
    for (const name of ['pointerup', 'pointercancel']) {
      figure.root.addEventListener(name, () => {
        if (!held) return;
        held = null;
        figure.root.classList.remove('held');
        if (figure.side) goHome(figure);
      });
    }
  }
}

/**
 * Let a picture of one shape show that shape again.
 * @param {import('./figure.js').Figure} figure
 */
function goHome(figure) {
  const from = figure.time, start = performance.now();
  const tick = (/** @type {number} */ now) => {
    if (figure.root.classList.contains('held')) return;
    const share = calm.matches ? 1 : Math.max(0, Math.min(1, (now - start) / HOME_MS));
    figure.pose(from + share * (figure.rest - from));
    if (share < 1) requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
}

/**
 * The time, near the present one, that brings the held point of a piece nearest to the pointer. The point's way there is
 * not long: it may pass the same place twice. A time in which it rests is passed over.
 * @param {import('./types.js').Scene} scene
 * @param {{piece: number, x: number, y: number}} held
 * @param {{x: number, y: number}} pointer
 * @param {number} now
 */
export function timeNear(scene, held, pointer, now) {
  const at = (/** @type {number} */ time) => placed(poseAt(scene, time), held.piece, held.x, held.y);
  const here = at(now);
  let best = now, least = Math.hypot(here.x - pointer.x, here.y - pointer.y);
  for (const step of [-STEP, STEP]) {
    let time = now, last = here, way = 0;
    while (way < REACH && time !== Math.round(0.5 + Math.sign(step) / 2)) {
      time = Math.max(0, Math.min(1, time + step));
      const next = at(time), far = Math.hypot(next.x - pointer.x, next.y - pointer.y);
      if (far < least - 1e-6) [best, least] = [time, far];
      way += Math.hypot(next.x - last.x, next.y - last.y);
      last = next;
    }
  }
  return best;
}

/**
 * The time of the swing after so many milliseconds of play: there, a rest, and back.
 * @param {number} clock
 */
export function timeOf(clock) {
  const lap = WAY_MS + REST_MS, within = clock % (2 * lap);
  const share = Math.min(1, (within % lap) / WAY_MS), eased = 0.5 - 0.5 * Math.cos(Math.PI * share);
  return within < lap ? eased : 1 - eased;
}

/** @param {number} time */
const clockOf = time => (WAY_MS * Math.acos(1 - 2 * Math.max(0, Math.min(1, time)))) / Math.PI;

/** @param {number} time */
function words(time) {
  if (time <= 0) return 'the first shape';
  return time >= 1 ? 'the second shape' : `${Math.round(100 * time)} percent of the way`;
}
