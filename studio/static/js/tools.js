/** The tools of Edit: what a gesture on an outline, by pointer or keys, asks for. Points are in the shape's frame. */

import {nearestOn, smooth} from './geometry.js';

/** @typedef {import('./types.js').Edit} Edit */
/** @typedef {import('./types.js').Flat} Flat */
/** @typedef {{x: number, y: number}} Place */

/**
 * @typedef {object} Ground what a gesture is made on
 * @property {import('./types.js').Side} side
 * @property {Flat[]} outlines the input's, bent if it is, and the one that the pieces make
 * @property {Flat} feet where the trunk's corners stand on the outline
 * @property {Record<string, number>} options
 */

/**
 * @typedef {object} Gesture
 * @property {(point: Place) => void} move
 * @property {() => Edit | null} draft what to ask for while it is moved
 * @property {(point: Place) => Edit | 'more' | string | null} end the edit; or words why there is none
 * @property {() => {line?: Flat, brush?: {line: Flat, radius: number, paint: string}}} preview
 */

/** @typedef {(ground: Ground, point: Place) => Gesture | string} Begin */

const NEAR = 0.12;
const STILL = 0.012;
const DENSE = 0.015;

/**
 * The place of any of the outlines nearest to a point.
 * @param {Ground} ground
 * @param {Place} point
 */
export function snap({outlines}, {x, y}) {
  return outlines.map(outline => nearestOn(outline, x, y)).reduce((best, one) => (one.distance < best.distance ? one : best));
}

/** @type {Begin} */
function pull(ground, point) {
  const {x, y, distance} = snap(ground, point), at = [x, y];
  let to = at;
  if (distance > NEAR) return 'Take hold of a point on the outline.';
  const edit = () => ({kind: 'pull', side: ground.side, at, to, reach: ground.options.reach});
  const moved = () => Math.hypot(to[0] - x, to[1] - y) > STILL;
  return {
    move(next) { to = [next.x, next.y]; },
    draft: () => (moved() ? edit() : null),
    end: () => (moved() ? edit() : null),
    preview: () => ({line: [...at, ...to]}),
  };
}

/** @type {Begin} */
function draw(ground, point) {
  const start = snap(ground, point);
  if (start.distance > NEAR) return 'Begin the line on the outline.';
  const line = [start.x, start.y];
  let strokes = 0;
  const add = (/** @type {Place} */ {x, y}) => {
    if (Math.hypot(x - line[line.length - 2], y - line[line.length - 1]) > DENSE) line.push(x, y);
  };
  return {
    move: add,
    draft: () => null,
    end(last) {
      add(last);
      strokes += 1;
      const stop = snap(ground, last), far = Math.hypot(stop.x - start.x, stop.y - start.y);
      if (stop.distance < NEAR / 2 && far > STILL && line.length >= 6) {
        line.splice(line.length - 2, 2, stop.x, stop.y);
        return {kind: 'draw', side: ground.side, line: smooth(line)};
      }
      return line.length <= 4 || strokes > 1 ? 'more' : 'End the line on the outline: it replaces the stretch between.';
    },
    preview: () => ({line}),
  };
}

/** @type {Begin} */
function keep(ground, point) {
  const [outline] = ground.outlines, first = nearestOn(outline, point.x, point.y);
  if (first.distance > 2 * NEAR) return 'Keep what is on the outline.';
  const points = [first.x, first.y];
  const move = (/** @type {Place} */ next) => {
    const {x, y} = nearestOn(outline, next.x, next.y);
    if (Math.hypot(x - points[points.length - 2], y - points[points.length - 1]) > 2 * DENSE) points.push(x, y);
  };
  return {
    move,
    draft: () => null,
    end(last) {
      move(last);
      return {kind: 'keep', side: ground.side, points};
    },
    preview: () => ({line: points}),
  };
}

/**
 * A brush; `edit` says what it does.
 * @param {string} paint how its trace looks
 * @param {(options: Record<string, number>) => Edit} edit
 * @returns {Begin}
 */
const brush = (paint, edit) => (ground, point) => {
  const stroke = [point.x, point.y], {radius} = ground.options;
  const move = (/** @type {Place} */ {x, y}) => {
    if (Math.hypot(x - stroke[stroke.length - 2], y - stroke[stroke.length - 1]) > DENSE) stroke.push(x, y);
  };
  return {
    move,
    draft: () => null,
    end(last) {
      move(last);
      return {side: ground.side, stroke, radius, ...edit(ground.options)};
    },
    preview: () => ({brush: {line: stroke, radius, paint}}),
  };
};

/** @type {Begin} */
function corner(ground, point) {
  let nearest = -1, least = 1.5 * NEAR;
  for (let k = 0; k < ground.feet.length / 2; k++) {
    const distance = Math.hypot(ground.feet[2 * k] - point.x, ground.feet[2 * k + 1] - point.y);
    if (distance < least) [nearest, least] = [k, distance];
  }
  if (nearest < 0) return 'Take hold of a corner: one of the dots on the outline.';
  let to = [ground.feet[2 * nearest], ground.feet[2 * nearest + 1]];
  const from = to;
  const edit = () => ({kind: 'corner', side: ground.side, corner: nearest, to});
  const moved = () => Math.hypot(to[0] - from[0], to[1] - from[1]) > STILL;
  return {
    move(next) {
      const {x, y} = nearestOn(ground.outlines[0], next.x, next.y);
      to = [x, y];
    },
    draft: () => (moved() ? edit() : null),
    end: () => (moved() ? edit() : null),
    preview: () => ({line: [...from, ...to]}),
  };
}

/**
 * @typedef {object} Tool
 * @property {string} label
 * @property {string} hint
 * @property {Begin} begin
 * @property {{name: string, words: string, least: number, greatest: number, step: number, value: number}[]} options
 */

const BRUSH = {name: 'radius', words: 'Brush', least: 0.03, greatest: 0.4, step: 0.01, value: 0.1};
const TIMES = {name: 'factor', least: 2, greatest: 100, step: 1, value: 20};

/** @type {Record<string, Tool>} */
export const TOOLS = {
  pull: {
    label: 'Pull', begin: pull, hint: 'Drag a point of the outline. Both shapes answer while you drag.',
    options: [{name: 'reach', words: 'Reach', least: 0.05, greatest: 0.6, step: 0.05, value: 0.15}],
  },
  draw: {
    label: 'Draw', begin: draw, options: [],
    hint: 'Draw a line from one point of the outline to another, in one stroke or click by click: it replaces the stretch between.',
  },
  keep: {
    label: 'Keep', begin: keep, options: [],
    hint: 'Click a point, or drag along a stretch, that must stay as it is. The other shape gives way.',
  },
  stiff: {
    label: 'Stiffen', begin: brush('stiff', ({factor}) => ({kind: 'stiff', factor})), options: [BRUSH, {...TIMES, words: 'Stiffness'}],
    hint: 'Paint what should bend less: a face, a wheel. It counts when the shapes bend.',
  },
  soft: {
    label: 'Soften', begin: brush('soft', ({factor}) => ({kind: 'stiff', factor: 1 / factor})), options: [BRUSH, {...TIMES, words: 'Softness'}],
    hint: 'Paint what may bend more: a tail, a leg. The rest then bends less.',
  },
  erase: {
    label: 'Erase', begin: brush('erase', () => ({kind: 'erase'})), options: [BRUSH],
    hint: 'Wipe over what is painted stiffer or softer: there it bends as before.',
  },
  corner: {
    label: 'Corner', begin: corner, options: [],
    hint: 'Drag a corner of the trunk along the outline: the pieces part elsewhere.',
  },
};
