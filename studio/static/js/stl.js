/** Binary STL: triangles with a normal each. */

const HEADER = 84;
const TRIANGLE = 50;

/**
 * Corner positions and normals, three numbers each, for a triangle list.
 * @param {ArrayBuffer} bytes
 */
export function readStl(bytes) {
  const view = new DataView(bytes), count = view.getUint32(80, true);
  const positions = new Float32Array(9 * count), normals = new Float32Array(9 * count);
  for (let k = 0; k < count; k++) {
    const corner = (/** @type {number} */ i) => view.getFloat32(HEADER + TRIANGLE * k + 12 + 4 * i, true);
    for (let i = 0; i < 9; i++) positions[9 * k + i] = corner(i);
    const normal = cross(minus(positions, 9 * k + 3, 9 * k), minus(positions, 9 * k + 6, 9 * k));
    for (let i = 0; i < 9; i++) normals[9 * k + i] = normal[i % 3];
  }
  return {positions, normals};
}

/**
 * A part that is printed upside down, as it lies in the puzzle: turned around the x-axis, from z = 0 up.
 * @param {{positions: Float32Array, normals: Float32Array}} part
 * @param {number} height in mm
 */
export function turnedOver({positions, normals}, height) {
  const turned = (/** @type {Float32Array} */ list, /** @type {number} */ up) => list.map((value, k) => [value, -value, up - value][k % 3]);
  return {positions: turned(positions, height), normals: turned(normals, 0)};
}

/**
 * @param {Float32Array} list
 * @param {number} a
 * @param {number} b
 */
const minus = (list, a, b) => [list[a] - list[b], list[a + 1] - list[b + 1], list[a + 2] - list[b + 2]];

/**
 * @param {number[]} a
 * @param {number[]} b
 */
function cross(a, b) {
  const normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const length = Math.hypot(...normal) || 1;
  return normal.map(value => value / length);
}
