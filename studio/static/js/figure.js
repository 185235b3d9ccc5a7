/** A transform as SVG: pieces that only their `transform` attribute moves, and what lies under and over them. */

import {boundsOf, pathOf} from './geometry.js';
import {levelsAt, poseAt, swept} from './pose.js';
import {set, svg} from './dom.js';

/** @typedef {import('./types.js').Scene} Scene */
/** @typedef {import('./types.js').Side} Side */

const FRAMES = [0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1];
const MARGIN = 0.08;
const LIFTED = 0.02;
const RING = 0.09;

/**
 * @param {number} x
 * @param {number} y
 */
const ring = (x, y) => `M${x - RING} ${y}a${RING} ${RING} 0 1 0 ${2 * RING} 0a${RING} ${RING} 0 1 0 ${-2 * RING} 0`;

export class Figure {
  /**
   * @param {SVGSVGElement} root
   * @param {{side?: Side, plain?: boolean}} [options] `side` shows that shape, with its input and trunk;
   *   `plain` has pieces alone
   */
  constructor(root, {side, plain = false} = {}) {
    this.root = root;
    this.side = side;
    this.plain = plain;
    /** @type {Scene | null} */
    this.scene = null;
    /** The time at which it stands still. */
    this.rest = side === 'q' ? 1 : 0;
    this.time = this.rest;
    /** @type {SVGGElement[]} */
    this.groups = [];
    this.under = svg('g', {class: 'under'});
    this.pieces = svg('g', {class: 'pieces'});
    this.over = svg('g', {class: 'over'});
    this.marks = svg('g', {class: 'marks'});
    root.replaceChildren(svg('g', {transform: 'scale(1 -1)'}, this.under, this.pieces, this.over, this.marks));
  }

  /**
   * Show a scene; the frame of the picture stays while `steady`, as while something is dragged.
   * @param {Scene} scene
   * @param {boolean} [steady]
   */
  show(scene, steady = false) {
    this.scene = scene;
    this.groups = scene.pieces.map((piece, k) => this.#piece(piece, k));
    this.pieces.replaceChildren(...scene.motion.order.map(k => this.groups[k]));
    if (this.side) this.#surround(scene[this.side]);
    if (!steady || !this.root.hasAttribute('viewBox')) this.frame();
    this.pose(this.time);
  }

  /**
   * An input by itself, before there is a transform.
   * @param {import('./types.js').Input | null} input
   */
  showInput(input) {
    this.scene = null;
    this.groups = [];
    this.pieces.replaceChildren();
    this.over.replaceChildren();
    this.under.replaceChildren(...(input ? [svg('path', {class: 'silhouette', d: pathOf(input.outline, true)})] : []));
    if (input) this.#view(boundsOf(input.outline));
  }

  /** Fit the picture to what it shows, in all poses if it swings. */
  frame() {
    if (!this.scene) return;
    const times = this.side ? [this.rest] : FRAMES;
    const given = this.side ? [this.scene[this.side].input, this.scene[this.side].bent ?? []] : [];
    this.#view(boundsOf(...swept(this.scene, times), ...given));
  }

  /** @param {{left: number, low: number, right: number, high: number}} bounds */
  #view({left, low, right, high}) {
    const width = right - left + 2 * MARGIN, height = high - low + 2 * MARGIN;
    set(this.root, {viewBox: `${left - MARGIN} ${-high - MARGIN} ${width} ${height}`});
  }

  /**
   * Move the pieces to a time of the swing.
   * @param {number} time
   */
  pose(time) {
    this.time = time;
    if (!this.scene) return;
    const pose = poseAt(this.scene, time), lifts = this.scene.motion.lifted.length > 0;
    const levels = lifts && !this.plain ? levelsAt(this.scene, time) : null;
    this.groups.forEach((group, k) => {
      const turn = (pose.turn[k] * 180) / Math.PI;
      group.setAttribute('transform', `translate(${pose.x[k].toFixed(4)} ${pose.y[k].toFixed(4)})rotate(${turn.toFixed(3)})`);
      if (levels) group.classList.toggle('lifted', levels[k] > LIFTED);
    });
  }

  /**
   * Paint the pieces that are shown.
   * @param {import('./types.js').Texture[] | undefined} textures
   */
  paint(textures) {
    if (!this.scene || !textures) return;
    const {pieces} = this.scene, view = this.side ?? 'chain';
    this.groups.forEach((group, k) => {
      const [left, low, right, high] = textures[k].box, id = `texture-${view}-${k}`;
      group.querySelector('.texture')?.remove();
      // The picture's first row is its highest, and up is up.
      const image = svg('image', {
        href: textures[k].href, x: left, y: -high, width: right - left, height: high - low,
        preserveAspectRatio: 'none', transform: 'scale(1 -1)',
      });
      const clip = svg('clipPath', {id}, svg('path', {d: pathOf(pieces[k].outline, true)}));
      group.firstElementChild?.after(svg('g', {class: 'texture'}, clip, svg('g', {'clip-path': `url(#${id})`}, image)));
    });
  }

  /**
   * @param {import('./types.js').Piece} piece
   * @param {number} k
   */
  #piece(piece, k) {
    const path = svg('path', {d: pathOf(piece.outline, true), class: `piece c${piece.colour}`});
    const group = svg('g', {'data-piece': k}, path);
    if (!this.plain) {
      const cut = this.side === 'q' ? piece.outline.slice(0, 2 * piece.lower)
        : [...piece.outline.slice(2 * piece.lower - 2), 0, 0];
      if (this.side) group.append(svg('path', {class: 'cut', d: pathOf(cut, false)}));
      group.append(svg('path', {class: 'edge', d: `M0 0H${piece.length}`}), svg('path', {class: 'hinge', d: 'M0 0h0'}));
      // Where the chain is open there is no hinge: a ring.
      if (!this.side && k === this.scene?.motion.open) group.append(svg('path', {class: 'gap', d: 'M0 0h0'}));
    }
    return group;
  }

  /** @param {import('./types.js').ShapeScene} shape */
  #surround(shape) {
    this.under.replaceChildren(svg('path', {class: 'silhouette', d: pathOf(shape.input, true)}));
    if (this.plain) return;
    const {lost} = shape.fidelity, rings = [];
    for (let k = 0; k < lost.length; k += 2) rings.push(svg('path', {class: 'lost', d: ring(lost[k], lost[k + 1])}));
    this.over.replaceChildren(
      svg('path', shape.bent ? {class: 'bent', d: pathOf(shape.bent, true)} : {class: 'ghost', d: pathOf(shape.input, true)}),
      ...rings, svg('path', {class: 'trunk', d: pathOf(shape.trunk, true)}),
    );
  }

  /**
   * A point of the screen in the shape's frame.
   * @param {{clientX: number, clientY: number}} event
   */
  point(event) {
    const matrix = this.root.getScreenCTM();
    if (!matrix) return {x: 0, y: 0};
    const {x, y} = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return {x, y: -y};
  }

  /**
   * The number of the piece at an event, or null.
   * @param {Event} event
   */
  pieceAt(event) {
    const group = event.target instanceof Element ? event.target.closest('[data-piece]') : null;
    return group ? Number(group.getAttribute('data-piece')) : null;
  }

  /** How long a pixel of the screen is in the shape's frame. */
  get pixel() {
    const matrix = this.root.getScreenCTM();
    return matrix ? 1 / matrix.a : 0.005;
  }
}
