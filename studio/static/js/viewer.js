/**
 * Parts in three dimensions, in plain WebGL. No Python wheel that is kept brings three.js alone, and its 700 kB would be
 * more than all of this page; shaded triangles that are turned and come nearer need what is here.
 */

import {readStl, turnedOver} from './stl.js';

const VERTEX = `attribute vec3 position, normal; uniform mat4 view; uniform vec4 place; uniform float height; varying vec3 n;
void main() {
  mat2 turn = mat2(place.z, place.w, -place.w, place.z);
  vec3 at = vec3(turn * position.xy + place.xy, position.z + height);
  n = vec3(turn * normal.xy, normal.z);
  gl_Position = view * vec4(at, 1.0);
}`;
const FRAGMENT = `precision mediump float; uniform vec3 colour; uniform vec3 light; varying vec3 n;
void main() { gl_FragColor = vec4(colour * (0.45 + 0.55 * max(0.0, dot(normalize(n), light))), 1.0); }`;
const LIGHT = [0.35, -0.45, 0.82];
const FIELD = 0.6;
const TURN = 0.008;

/** @typedef {{x: number, y: number, turn: number, height: number}} Place in mm */
/** @typedef {{vertices: WebGLBuffer, normals: WebGLBuffer, count: number, colour: number[], place: Place, bounds: {low: number[], high: number[]}}} Body */

export class Viewer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {() => void} drawn called when the view has changed
   */
  constructor(canvas, drawn) {
    this.canvas = canvas;
    this.drawn = drawn;
    const gl = canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
    if (!gl) throw new Error('this browser has no WebGL');
    this.gl = gl;
    this.program = program(gl);
    /** @type {Map<string, Body>} */
    this.bodies = new Map();
    this.yaw = -0.35;
    this.pitch = 0.85;
    this.distance = 300;
    this.middle = [0, 0, 0];
    this.frame = 0;
    this.#controls();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /**
   * @param {string} name
   * @param {ArrayBuffer} stl
   * @param {number[]} colour
   * @param {Place} place
   * @param {number} [over] the height of a part that is printed upside down
   */
  add(name, stl, colour, place, over) {
    const printed = readStl(stl), {positions, normals} = over === undefined ? printed : turnedOver(printed, over);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    positions.forEach((value, k) => {
      low[k % 3] = Math.min(low[k % 3], value);
      high[k % 3] = Math.max(high[k % 3], value);
    });
    const body = {vertices: buffer(this.gl, positions), normals: buffer(this.gl, normals), count: positions.length / 3, colour, place, bounds: {low, high}};
    this.bodies.set(name, body);
  }

  clear() {
    for (const body of this.bodies.values()) for (const one of [body.vertices, body.normals]) this.gl.deleteBuffer(one);
    this.bodies.clear();
  }

  /**
   * Look at all of it.
   * @param {number} radius
   */
  fit(radius) {
    this.middle = [0, 0, 0];
    this.distance = radius / Math.tan(FIELD / 2);
    this.draw();
  }

  draw() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.#draw();
    });
  }

  #draw() {
    const {gl, canvas} = this, ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(this.program);
    const at = (/** @type {string} */ name) => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix4fv(at('view'), false, this.matrix());
    gl.uniform3fv(at('light'), LIGHT);
    for (const {vertices, normals, count, colour, place} of this.bodies.values()) {
      gl.uniform4f(at('place'), place.x, place.y, Math.cos(place.turn), Math.sin(place.turn));
      gl.uniform1f(at('height'), place.height);
      gl.uniform3fv(at('colour'), colour);
      for (const [name, data] of /** @type {const} */ ([['position', vertices], ['normal', normals]])) {
        const slot = gl.getAttribLocation(this.program, name);
        gl.bindBuffer(gl.ARRAY_BUFFER, data);
        gl.enableVertexAttribArray(slot);
        gl.vertexAttribPointer(slot, 3, gl.FLOAT, false, 0, 0);
      }
      gl.drawArrays(gl.TRIANGLES, 0, count);
    }
    this.drawn();
  }

  /** From mm to the screen: turn about z, tilt, stand back, perspective; by columns. */
  matrix() {
    const [a, b] = [Math.cos(this.yaw), Math.sin(this.yaw)], [c, s] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    const ratio = this.canvas.clientWidth / this.canvas.clientHeight || 1, f = 1 / Math.tan(FIELD / 2);
    const [wide, high] = [f / Math.max(1, ratio), (f * ratio) / Math.max(1, ratio)];
    const near = this.distance / 20, far = 10 * this.distance, m = (far + near) / (far - near), q = (-2 * far * near) / (far - near);
    // How far right, up and away a point is, as rows over x, y, z and 1.
    const right = [a, -b, 0, 0], up = [b * s, a * s, c, 0], away = [b * c, a * c, -s, this.distance];
    const rows = [right.map(value => wide * value), up.map(value => high * value), away.map((value, k) => m * value + (k === 3 ? q : 0)), away];
    return new Float32Array([0, 1, 2, 3].flatMap(column => rows.map(row => row[column])));
  }

  /**
   * Where a point in mm is on the canvas, in pixels of the page.
   * @param {number[]} point
   */
  project([x, y, z]) {
    const m = this.matrix(), row = (/** @type {number} */ k) => m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k];
    const w = row(3);
    return {x: (0.5 + row(0) / w / 2) * this.canvas.clientWidth, y: (0.5 - row(1) / w / 2) * this.canvas.clientHeight};
  }

  #controls() {
    const {canvas} = this;
    /** @type {PointerEvent | null} */
    let last = null;
    canvas.addEventListener('pointerdown', event => {
      last = event;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', event => {
      if (!last) return;
      this.#turn((event.clientX - last.clientX) * TURN, (event.clientY - last.clientY) * TURN);
      last = event;
    });
    for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, () => { last = null; });
    canvas.addEventListener('wheel', event => {
      event.preventDefault();
      this.#zoom(Math.exp(event.deltaY * 0.001));
    }, {passive: false});
    canvas.addEventListener('keydown', event => {
      const turn = {ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15]}[event.key];
      const zoom = {'+': 0.85, '=': 0.85, '-': 1.18}[event.key];
      if (turn) this.#turn(turn[0], turn[1]);
      else if (zoom) this.#zoom(zoom);
      else return;
      event.preventDefault();
    });
  }

  /**
   * @param {number} right
   * @param {number} down
   */
  #turn(right, down) {
    this.yaw += right;
    this.pitch = Math.max(0, Math.min(Math.PI / 2, this.pitch - down));
    this.draw();
  }

  /** @param {number} factor */
  #zoom(factor) {
    this.distance *= factor;
    this.draw();
  }
}

/** @param {WebGLRenderingContext} gl */
function program(gl) {
  const made = gl.createProgram();
  for (const [kind, source] of /** @type {const} */ ([[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  return made;
}

/**
 * @param {WebGLRenderingContext} gl
 * @param {Float32Array} numbers
 */
function buffer(gl, numbers) {
  const made = /** @type {WebGLBuffer} */ (gl.createBuffer());
  gl.bindBuffer(gl.ARRAY_BUFFER, made);
  gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
  return made;
}
