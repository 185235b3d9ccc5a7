/** The form of Make: presets, and a field for every setting with its range, unit and meaning. */

import {json} from './link.js';
import {html} from './dom.js';

/** @typedef {import('./types.js').Setting} Setting */

const FIRST = ['size_mm', 'thickness_mm', 'hinge', 'pin_mm', 'clearance_mm', 'gap_mm'];

/** @typedef {HTMLInputElement | HTMLSelectElement} Field */
/** @typedef {Record<string, number | boolean | string>} Values */

/**
 * Fill the form; `build` gets the values of all settings when it is sent.
 * @param {HTMLFormElement} form
 * @param {(settings: Values, fix: boolean) => void} build
 */
export async function fillSettings(form, build) {
  const answer = await json('/api/settings');
  if (!answer) return;
  /** @type {Setting[]} */
  const settings = answer.settings;
  const presets = html('select', {name: 'preset'}, html('option', {value: ''}, 'as set below'),
    ...answer.presets.map((/** @type {{name: string}} */ {name}, /** @type {number} */ k) => html('option', {value: String(k)}, name)));
  /** @type {Map<string, Field>} */
  const fields = new Map(settings.map(setting => [setting.name, fieldOf(setting)]));
  const row = (/** @type {Setting} */ setting) => rowOf(setting, /** @type {Field} */ (fields.get(setting.name)));
  const others = settings.filter(({name}) => !FIRST.includes(name));
  const fix = html('input', {type: 'checkbox', name: 'fix', checked: true});
  form.append(html('label', {}, 'Preset', presets), ...settings.filter(({name}) => FIRST.includes(name)).map(row),
    html('details', {}, html('summary', {}, 'Clearances and more'), ...others.map(row)),
    html('label', {class: 'tick'}, fix, 'mend what does not hold'), html('button', {class: 'primary'}, 'Build the parts'));
  presets.addEventListener('change', () => {
    if (!presets.value) return;
    for (const {name, value} of settings) put(fields.get(name), value);
    for (const [name, value] of Object.entries(answer.presets[Number(presets.value)].values)) put(fields.get(name), value);
  });
  form.addEventListener('input', event => { if (event.target !== presets) presets.value = ''; });
  form.addEventListener('submit', event => {
    event.preventDefault();
    build(Object.fromEntries([...fields].map(([name, field]) => [name, valueOf(field)])), fix.checked);
  });
  // A field that is hidden in the details cannot say that it is wrong: show it.
  form.addEventListener('invalid', event => {
    const details = event.target instanceof Element ? event.target.closest('details') : null;
    if (details) details.open = true;
  }, true);
}

/**
 * @param {Field | undefined} field
 * @param {unknown} value
 */
function put(field, value) {
  if (field instanceof HTMLInputElement && field.type === 'checkbox') field.checked = Boolean(value);
  else if (field) field.value = String(value);
}

/** @param {Field} field */
function valueOf(field) {
  if (field instanceof HTMLSelectElement) return field.value;
  return field.type === 'checkbox' ? field.checked : field.valueAsNumber;
}

/** @param {Setting} setting @returns {Field} */
function fieldOf({name, value, least, greatest, choices, meaning}) {
  if (choices.length) return html('select', {name, title: meaning}, ...choices.map(choice => html('option', {selected: choice === value}, choice)));
  if (typeof value === 'boolean') return html('input', {type: 'checkbox', name, checked: value, title: meaning});
  return html('input', {type: 'number', name, value: String(value), min: least, max: greatest, step: 'any', required: true, title: meaning});
}

/**
 * @param {Setting} setting
 * @param {Field} field
 */
function rowOf({name, unit}, field) {
  const words = titled(name);
  return html('label', {}, words[0].toUpperCase() + words.slice(1), html('span', {class: 'row'}, field, html('i', {}, unit)));
}

/**
 * A parameter's name as words.
 * @param {string} name
 */
export function titled(name) {
  return name.replace(/_mm$|_deg$/, '').replaceAll('_', ' ');
}
