// The colors: which one clicks teach, how far it reaches, and all its parameters.

import { bars, plane } from '/page/charts.js';
import { element, field, set } from '/page/fields.js';
import { PALETTE } from '/page/stage.js';
import { send } from '/page/wire.js';

const $ = (id) => document.getElementById(id);
const AXES = ['L', 'a', 'b'];
const FARTHEST = 100; // where the sliders of the reach end [CIELAB units]
const NAME = /^[A-Za-z0-9_-]{1,40}$/;
let active = '';
let state = null;
let specs = [];
let refresh = () => {};
let notice = () => {};
let reach = []; // a slider for each axis, or one
let fields = [];
let shown = '';
let made = '';
let renamed = '';
let found = null; // the last answer about the a-b plane

export const chosen = () => active;

export function describeColors(described, callbacks) {
  specs = described.detector.each.colors;
  ({ refresh, notice } = callbacks);
}

export function showColors(next) {
  state = next;
  const names = state.colors.map((color) => color.name);
  const given = names.filter((name) => state.given.detector.some((each) => each.startsWith(`${name}.`)));
  if (renamed && names.includes(renamed)) [active, renamed] = [renamed, ''];
  if (!active) active = given[0] ?? 'ball';
  $('active').textContent = active;
  const key = JSON.stringify([state.colors, state.samples, active]);
  if (key !== shown) {
    shown = key;
    const listed = names.includes(active) ? names : [...names, active];
    $('colors').replaceChildren(...listed.map((name) => lineOf(name, names.indexOf(name), given.includes(name))));
  }
  showFields();
}

function lineOf(name, k, given) {
  const radio = element('input', { type: 'radio', name: 'color', id: `color-${name}`, on: { change: () => choose(name) } });
  radio.checked = name === active;
  const swatch = element('span', { class: 'swatch', 'aria-hidden': 'true' });
  if (k >= 0) swatch.style.background = PALETTE[k % PALETTE.length];
  const mine = state.samples.filter((sample) => sample.color === name);
  const tag = k < 0 ? 'not yet picked' : mine.length ? `${mine.length} picked` : given ? '' : 'built in';
  const remove = element('button', { class: 'reset', text: 'remove', type: 'button', 'aria-label': `Remove ${name}`, on: { click: () => send('remove_color', { color: name }) } });
  remove.hidden = state.colors.length < 2 || k < 0;
  return element('div', { class: 'color' }, radio, swatch, element('label', { class: 'name', for: radio.id, text: k < 0 ? name : `${k + 1}: ${name}` }), element('span', { class: 'tag', text: tag }), remove);
}

function choose(name) {
  active = name;
  refresh();
}

export function forgetColor() {
  active = '';
}

function newName() {
  const name = $('name').value.trim();
  if (!NAME.test(name)) {
    notice('A name has letters, digits, _ and -.');
    return '';
  }
  $('name').value = '';
  return name;
}

$('add').addEventListener('click', () => {
  const name = newName();
  if (name) choose(name);
});

$('rename').addEventListener('click', () => {
  renamed = newName();
  if (renamed) send('rename_color', { color: active, to: renamed });
});

// ---- how far the active color reaches: one number, or one for each axis; and all it has

function showFields() {
  const color = state.colors.find((one) => one.name === active);
  const key = color ? `${active} ${color.tolerance_lab === null}` : '';
  if (key !== made) {
    made = key;
    reach = color ? (color.tolerance_lab ? AXES.map(fieldOfAxis) : [field('detector', `${active}.tolerance`, spec('tolerance'), { place: 'reach', label: 'tolerance', brief: true, most: FARTHEST })]) : [];
    $('reach').replaceChildren(...reach);
    fields = color ? specs.map((one) => [`${active}.${one.name}`, field('detector', `${active}.${one.name}`, one, { label: one.name })]) : [];
    $('color-fields').replaceChildren(...fields.map(([, one]) => one));
    $('color-box').hidden = !color;
    $('color-title').textContent = `All of ${active}`;
    showReach();
  }
  reach.forEach((one, axis) => one.update(reach.length > 1 ? color.tolerance_lab[axis] : color.tolerance, false));
  for (const [name, one] of fields) one.update(state.values.detector[name], state.given.detector.includes(name));
}

const spec = (name) => specs.find((one) => one.name === name);

function fieldOfAxis(axis, k) {
  const one = { ...spec('tolerance'), limits: [0.5, spec('tolerance').limits[1]], default: null, description: `How far the color reaches along ${axis}.` };
  const give = (value, sliding) => {
    const axes = state.colors.find((each) => each.name === active).tolerance_lab;
    set('detector', `${active}.tolerance_lab`, axes.map((old, at) => (at === k ? value : old)), sliding);
  };
  return field('detector', `${active}.tolerance_lab.${axis}`, one, { place: 'reach', label: `reach in ${axis}`, brief: true, most: FARTHEST, give });
}

// ---- what that lets in and out, and where it is among the picture's colors

// Pixels differ by powers of ten: their bars, by the logarithm.
function showReach() {
  const mine = found?.colors.find((color) => color.name === active)?.reach ?? [];
  if (mine.length !== reach.length) return;
  mine.forEach(([within, beyond], k) => {
    const sum = (counts) => counts.reduce((a, b) => a + b, 0);
    const text = `Pixels by their distance from ${active}: ${Math.round(sum(within))} within reach, ${Math.round(sum(beyond))} not`;
    bars(reach[k].querySelector('.histogram'), within, beyond, text, Math.log1p);
  });
}

export function showPlane(message) {
  found = message;
  showReach();
  if ($('plane-box').open) plane($('plane'), message, active);
}

$('plane-box').addEventListener('toggle', () => { if (found) showPlane(found); });
