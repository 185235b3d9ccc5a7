/** The form of Make: presets, and a field for every setting with its range, unit and meaning. */

import {json} from './link.js';
import {html} from './dom.js';

/** @typedef {import('./types.js').Setting} Setting */

const FIRST = 8;

/**
 * Fill the form; `build` gets the settings that differ from the defaults.
 * @param {HTMLFormElement} form
 * @param {(settings: Record<string, number>, fix: boolean) => void} build
 */
export async function fillSettings(form, build) {
  const answer = await json('/api/settings');
  if (!answer) return;
  /** @type {Setting[]} */
  const settings = answer.settings;
  const presets = html('select', {name: 'preset'}, html('option', {value: ''}, 'as set below'),
    ...answer.presets.map((/** @type {{name: string}} */ {name}, /** @type {number} */ k) => html('option', {value: String(k)}, name)));
  /** @type {Map<string, HTMLInputElement>} */
  const fields = new Map();
  const rows = settings.map(setting => row(setting, fields));
  const more = html('details', {}, html('summary', {}, 'Clearances and more'), ...rows.slice(FIRST));
  const fix = html('input', {type: 'checkbox', name: 'fix', checked: true});
  form.append(html('label', {}, 'Preset', presets), ...rows.slice(0, FIRST), ...(rows.length > FIRST ? [more] : []),
    html('label', {class: 'tick'}, fix, 'mend what does not hold'), html('button', {class: 'primary'}, 'Build the parts'));
  presets.addEventListener('change', () => {
    if (!presets.value) return;
    for (const {name, value} of settings) set(fields, name, value);
    for (const [name, value] of Object.entries(answer.presets[Number(presets.value)].values)) set(fields, name, Number(value));
  });
  form.addEventListener('input', event => { if (event.target !== presets) presets.value = ''; });
  form.addEventListener('submit', event => {
    event.preventDefault();
    build(Object.fromEntries(settings.map(({name}) => [name, fields.get(name)?.valueAsNumber ?? NaN])), fix.checked);
  });
}

/**
 * @param {Map<string, HTMLInputElement>} fields
 * @param {string} name
 * @param {number} value
 */
function set(fields, name, value) {
  const field = fields.get(name);
  if (field) field.value = String(value);
}

/**
 * @param {Setting} setting
 * @param {Map<string, HTMLInputElement>} fields
 */
function row({name, value, least, greatest, unit, meaning}, fields) {
  const field = html('input', {type: 'number', name, value, min: least, max: greatest, step: 'any', required: true, title: meaning});
  fields.set(name, field);
  return html('label', {}, titled(name), html('span', {class: 'row'}, field, html('i', {}, unit)));
}

/**
 * A parameter's name as words.
 * @param {string} name
 */
function titled(name) {
  const words = name.replace(/_mm$|_deg$/, '').replaceAll('_', ' ');
  return words[0].toUpperCase() + words.slice(1);
}
