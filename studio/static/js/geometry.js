/** Flat point lists: as SVG paths, their bounds, places along an outline, and smooth lines. */

/** @typedef {import('./types.js').Flat} Flat */

/**
 * SVG path data of a flat list, rounded to a thousandth of the shape's size or less.
 * @param {Flat} flat
 * @param {boolean} closed
 */
export function pathOf(flat, closed) {
  let data = '';
  for (let k = 0; k < flat.length; k += 2) data += `${k ? 'L' : 'M'}${round(flat[k])} ${round(flat[k + 1])}`;
  return closed && data ? `${data}Z` : data;
}

/** @param {number} value */
const round = value => Math.round(value * 1e4) / 1e4;

/**
 * Least and greatest x and y of flat lists.
 * @param {...Flat} lists
 */
export function boundsOf(...lists) {
  let [left, low, right, high] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const flat of lists) {
    for (let k = 0; k < flat.length; k += 2) {
      left = Math.min(left, flat[k]);
      right = Math.max(right, flat[k]);
      low = Math.min(low, flat[k + 1]);
      high = Math.max(high, flat[k + 1]);
    }
  }
  return {left, low, right, high};
}

/**
 * The point of a closed outline nearest to a point, and how far along it is.
 * @param {Flat} outline
 * @param {number} x
 * @param {number} y
 */
export function nearestOn(outline, x, y) {
  let best = {x, y, distance: Infinity, position: 0}, position = 0;
  const count = outline.length;
  for (let k = 0; k < count; k += 2) {
    const ax = outline[k], ay = outline[k + 1];
    const dx = outline[(k + 2) % count] - ax, dy = outline[(k + 3) % count] - ay;
    const square = dx * dx + dy * dy;
    const share = square ? Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / square)) : 0;
    const px = ax + share * dx, py = ay + share * dy, distance = Math.hypot(px - x, py - y), length = Math.sqrt(square);
    if (distance < best.distance) best = {x: px, y: py, distance, position: position + share * length};
    position += length;
  }
  return best;
}

/**
 * Length of a closed outline.
 * @param {Flat} outline
 */
export function lengthOf(outline) {
  let length = 0;
  for (let k = 0, count = outline.length; k < count; k += 2) {
    length += Math.hypot(outline[(k + 2) % count] - outline[k], outline[(k + 3) % count] - outline[k + 1]);
  }
  return length;
}

/**
 * The point of a closed outline at a position along it.
 * @param {Flat} outline
 * @param {number} position
 */
export function pointAt(outline, position) {
  const total = lengthOf(outline), count = outline.length;
  let left = ((position % total) + total) % total;
  for (let k = 0; k < count; k += 2) {
    const dx = outline[(k + 2) % count] - outline[k], dy = outline[(k + 3) % count] - outline[k + 1];
    const length = Math.hypot(dx, dy);
    if (left <= length) return {x: outline[k] + (length && left / length) * dx, y: outline[k + 1] + (length && left / length) * dy};
    left -= length;
  }
  return {x: outline[0], y: outline[1]};
}

/**
 * A line at even steps, its wobble averaged away; the ends stay.
 * @param {Flat} line
 * @param {number} step
 */
export function smooth(line, step = 0.02) {
  let even = resample(line, step);
  for (let turn = 0; turn < 3; turn++) {
    const next = even.slice();
    for (let k = 2; k < even.length - 2; k++) next[k] = (even[k - 2] + 2 * even[k] + even[k + 2]) / 4;
    even = next;
  }
  return even;
}

/**
 * @param {Flat} line
 * @param {number} step
 */
function resample(line, step) {
  const even = [line[0], line[1]];
  let rest = step;
  for (let k = 2; k < line.length; k += 2) {
    const dx = line[k] - line[k - 2], dy = line[k + 1] - line[k - 1], length = Math.hypot(dx, dy);
    for (; rest <= length; rest += step) even.push(line[k - 2] + (dx * rest) / length, line[k - 1] + (dy * rest) / length);
    rest -= length;
  }
  const [x, y] = line.slice(-2);
  if (Math.hypot(x - even[even.length - 2], y - even[even.length - 1]) < step / 2 && even.length > 2) even.length -= 2;
  even.push(x, y);
  return even;
}
