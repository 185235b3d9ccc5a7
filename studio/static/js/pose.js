/** Where the pieces lie at a time of the swing: 0 makes P, 1 makes Q. */

/** @typedef {import('./types.js').Scene} Scene */
/** @typedef {{x: number[], y: number[], turn: number[]}} Pose */

/**
 * Headings and the middle change evenly between the known times; the chain is laid from its open hinge.
 * @param {Pick<Scene, 'pieces' | 'motion'>} scene
 * @param {number} time
 * @returns {Pose}
 */
export function poseAt({pieces, motion}, time) {
  const {times, headings, middles, open} = motion;
  const n = pieces.length, {low, share} = place(times, time), high = Math.min(low + 1, times.length - 1);
  const between = (/** @type {number[][]} */ rows, /** @type {number} */ k) => rows[low][k] + share * (rows[high][k] - rows[low][k]);
  const turn = pieces.map((_, k) => between(headings, k));
  const x = new Array(n).fill(0), y = new Array(n).fill(0);
  let middleX = 0, middleY = 0, atX = 0, atY = 0;
  for (let step = 0; step < n; step++) {
    const k = (open + step) % n, dx = pieces[k].length * Math.cos(turn[k]), dy = pieces[k].length * Math.sin(turn[k]);
    x[k] = atX;
    y[k] = atY;
    middleX += (atX + dx / 2) / n;
    middleY += (atY + dy / 2) / n;
    atX += dx;
    atY += dy;
  }
  const shiftX = between(middles, 0) - middleX, shiftY = between(middles, 1) - middleY;
  return {x: x.map(value => value + shiftX), y: y.map(value => value + shiftY), turn};
}

/**
 * How high the pieces are lifted.
 * @param {Scene} scene
 * @param {number} time
 */
export function levelsAt({motion}, time) {
  const {low, share} = place(motion.times, time), high = Math.min(low + 1, motion.times.length - 1);
  return motion.levels[low].map((level, k) => level + share * (motion.levels[high][k] - level));
}

/**
 * @param {number[]} times
 * @param {number} time
 */
function place(times, time) {
  let low = 0;
  while (low < times.length - 2 && times[low + 1] <= time) low++;
  const span = times[low + 1] - times[low];
  return {low, share: span > 0 ? Math.max(0, Math.min(1, (time - times[low]) / span)) : 0};
}

/**
 * A point of piece `k` where the pose puts it.
 * @param {Pose} pose
 * @param {number} k
 * @param {number} x
 * @param {number} y
 */
export function placed(pose, k, x, y) {
  const cos = Math.cos(pose.turn[k]), sin = Math.sin(pose.turn[k]);
  return {x: pose.x[k] + x * cos - y * sin, y: pose.y[k] + x * sin + y * cos};
}

/**
 * A point of the plane in the frame of piece `k`.
 * @param {Pose} pose
 * @param {number} k
 * @param {number} x
 * @param {number} y
 */
export function unplaced(pose, k, x, y) {
  const cos = Math.cos(pose.turn[k]), sin = Math.sin(pose.turn[k]), dx = x - pose.x[k], dy = y - pose.y[k];
  return {x: dx * cos + dy * sin, y: dy * cos - dx * sin};
}

/**
 * The outline that the pieces make: P's of their lower arcs, Q's of their upper ones.
 * @param {Scene} scene
 * @param {import('./types.js').Side} side
 */
export function assembled(scene, side) {
  const pose = poseAt(scene, side === 'p' ? 0 : 1), outline = [];
  const order = scene.pieces.map((_, k) => k);
  if (side === 'q') order.reverse();
  for (const k of order) {
    const {outline: points, lower} = scene.pieces[k];
    const arc = side === 'p' ? points.slice(0, 2 * lower - 2) : points.slice(2 * lower - 2);
    for (let i = 0; i < arc.length; i += 2) {
      const {x, y} = placed(pose, k, arc[i], arc[i + 1]);
      outline.push(x, y);
    }
  }
  return outline;
}

/**
 * Bounds of all pieces at some times.
 * @param {Scene} scene
 * @param {number[]} times
 * @returns {number[][]} flat lists of points, one a time
 */
export function swept(scene, times) {
  return times.map(time => {
    const pose = poseAt(scene, time);
    return scene.pieces.flatMap(({outline}, k) => {
      const points = [];
      for (let i = 0; i < outline.length; i += 8) {
        const {x, y} = placed(pose, k, outline[i], outline[i + 1]);
        points.push(x, y);
      }
      return points;
    });
  });
}
