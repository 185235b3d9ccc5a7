/** The way to the studio's server: requests with growing numbers, answers to whoever listens, and again after a break. */

import {change} from './store.js';

/** @typedef {{type: string, seq?: number, [name: string]: any}} Message */

/** @type {Map<string, ((message: any) => void)[]>} */
const listeners = new Map();
/** @type {WebSocket | null} */
let socket = null;
let seq = 1000 * Math.floor(1e6 * Math.random()); // tabs of one session do not take answers for one another's
let session = '';
/** @type {() => void} */
let begin;
let wait = 250;
const LONGEST_WAIT = 4000;

/**
 * Call `listener` with every message of a type.
 * @param {string} type
 * @param {(message: any) => void} listener
 */
export function hear(type, listener) {
  listeners.set(type, [...(listeners.get(type) ?? []), listener]);
}

/**
 * Send a request; returns its number, or 0 if there is no server at the moment.
 * @param {{type: string, [name: string]: unknown}} request
 */
export function ask(request) {
  if (socket?.readyState !== WebSocket.OPEN) return 0;
  seq += 1;
  socket.send(JSON.stringify({...request, seq}));
  return seq;
}

/** Resolves once the page knows its piece of work; what is given earlier waits for it. */
export const begun = /** @type {Promise<void>} */ (new Promise(resolve => {begin = resolve;}));

/** @param {string} id */
export function connect(id) {
  session = id;
  begin();
  open();
}

function open() {
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  const current = new WebSocket(`${scheme}://${location.host}/ws/${session}`);
  socket = current;
  current.addEventListener('open', () => {
    wait = 250;
    change({connected: true});
  });
  current.addEventListener('message', event => {
    /** @type {Message} */
    const message = JSON.parse(event.data);
    for (const listener of listeners.get(message.type) ?? []) listener(message);
  });
  current.addEventListener('close', () => {
    if (socket !== current) return;
    change({connected: false, busy: ''});
    setTimeout(open, wait);
    wait = Math.min(LONGEST_WAIT, 2 * wait);
  });
}

/** Where files and actions of this session are. */
export const base = () => `/api/sessions/${session}`;

/**
 * JSON of an address; null where there is none.
 * @param {string} address
 * @param {RequestInit} [options]
 */
export async function json(address, options) {
  const answer = await fetch(address, options);
  return answer.ok ? answer.json() : null;
}
