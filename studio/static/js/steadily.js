/** Edits while something is moved, one a frame at most, and the edit that counts when it is let go. */

import {ask} from './link.js';
import {change} from './store.js';

/** @typedef {import('./types.js').Edit} Edit */

export function steadily() {
  /** @type {Edit | null} */
  let next = null;
  let frame = 0;
  const drop = () => {
    cancelAnimationFrame(frame);
    frame = 0;
    next = null;
  };
  return {
    /** @param {Edit} edit */
    move(edit) {
      next = edit;
      frame ||= requestAnimationFrame(() => {
        frame = 0;
        if (next) ask({type: 'edit', phase: 'move', edit: next});
        next = null;
      });
    },
    /** @param {Edit} edit */
    release(edit) {
      drop();
      if (ask({type: 'edit', phase: 'release', edit})) change({busy: 'Cutting exactly…', problem: null});
    },
    drop,
  };
}
