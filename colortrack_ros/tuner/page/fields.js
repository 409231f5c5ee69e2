// A field for each parameter: its name, value, unit, text and range.

import { begin } from '/page/waits.js';
import { send } from '/page/wire.js';

let dragged = '';
let flying = false; // a change has been sent and not answered yet
let waiting = null;

// Sends a value; while a slider is dragged, all its places are one change, and those that the
// server has no time for are left out.
export function set(node, name, value, sliding = false) {
  const change = { node, values: { [name]: value }, follows: sliding && dragged === name };
  dragged = sliding ? name : '';
  begin();
  if (flying && change.follows) {
    waiting = change;
    return;
  }
  if (waiting) give(waiting);
  give(change);
}

function give(change) {
  waiting = null;
  flying = send('set', change);
}

// The last change is in force, or refused.
export function answered() {
  flying = false;
  if (waiting) give(waiting);
}

export function element(tag, options = {}, ...children) {
  const made = document.createElement(tag);
  const { text, on = {}, ...attributes } = options;
  if (text !== undefined) made.textContent = text;
  for (const [kind, listener] of Object.entries(on)) made.addEventListener(kind, listener);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== false) made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children);
  return made;
}

const shown = (value) => (value === null || value === undefined ? 'none' : Array.isArray(value) ? `[${value.join(', ')}]` : String(value));

// What somebody typed, as the parameter's type has it; undefined if it is none.
function typed(spec, text) {
  const one = (word) => {
    if (spec.type.includes('str')) return word.trim();
    if (spec.type.includes('bool')) return word.trim() === 'true';
    const number = Number(word);
    return word.trim() !== '' && Number.isFinite(number) ? number : undefined;
  };
  if (!spec.many) return one(text);
  const words = text.replace(/^\s*\[|\]\s*$/g, '').split(',').filter((word) => word.trim() !== '');
  const values = words.map(one);
  return values.includes(undefined) ? undefined : values;
}

// A field with update(value, given); sliders where there is a range.
export function field(node, name, spec, options = {}) {
  const id = `${options.place ?? 'all'}-${node}-${name}`;
  const give = (value, sliding) => {
    box.shown = ''; // if it is refused, what is in force has to come back
    if (options.give) options.give(value, sliding);
    else set(node, name, value, sliding);
  };
  const reset = element('button', { class: 'reset', text: 'default', title: `back to ${shown(spec.default)}`, type: 'button', on: { click: () => give(null) } });
  const label = element('label', { for: id }, element('span', { text: options.label ?? name }), element('span', { class: 'unit', text: spec.unit }));
  const input = control(id, spec, give, options);
  const about = `${spec.description} Default: ${shown(spec.default)}${rangeOf(spec)}.`;
  const box = element('div', { class: 'field', 'data-name': `${node} ${name} ${spec.description}`.toLowerCase() },
    label, element('div', { class: 'line' }, ...input.parts, ...(options.give ? [] : [reset])));
  if (options.brief) box.title = about;
  else box.append(element('p', { class: 'text', text: about }));
  box.update = (value, given) => {
    box.classList.toggle('given', given);
    reset.classList.toggle('idle', !given);
    const key = JSON.stringify([value ?? spec.default, options.place]);
    if (key !== box.shown || box.contains(document.activeElement)) input.update(value ?? spec.default);
    box.shown = key;
  };
  box.slider = input.slider;
  return box;
}

function rangeOf({ limits, choices }) {
  if (choices.length) return `; one of ${choices.map((choice) => choice || "''").join(', ')}`;
  return limits ? `; ${limits[0]} to ${limits[1]}` : '';
}

function control(id, spec, give, options) {
  if (spec.type === 'bool') {
    const box = element('input', { id, type: 'checkbox', on: { change: () => give(box.checked) } });
    return { parts: [box], update: (value) => { box.checked = value; } };
  }
  if (spec.choices.length) {
    const choice = element('select', { id, on: { change: () => give(choice.value) } },
      ...spec.choices.map((name) => element('option', { value: name, text: name || "''" })));
    return { parts: [choice], update: (value) => { choice.value = value; } };
  }
  const number = !spec.many && spec.type !== 'str';
  const box = element('input', { id, type: number ? 'number' : 'text', step: spec.type === 'int' ? 1 : 'any',
    min: spec.limits?.[0], max: spec.limits?.[1], on: {
      change: () => {
        const value = typed(spec, box.value);
        if (value !== undefined) give(value);
      },
    } });
  const parts = [box];
  let slider = null;
  if (number && spec.limits) {
    slider = sliderOf(spec, options, (value) => { box.value = value; give(value, true); });
    slider.setAttribute('aria-label', `${options.label ?? spec.name}, slider`);
    slider.addEventListener('change', () => { dragged = ''; });
    const chart = options.place && element('canvas', { class: 'histogram', role: 'img' });
    parts.unshift(element('div', { class: 'slide' }, ...(chart ? [chart] : []), slider));
  }
  const update = (value) => {
    if (document.activeElement !== box) box.value = Array.isArray(value) ? value.join(', ') : value ?? '';
    if (slider && document.activeElement !== slider) slider.put(value);
  };
  return { parts, update, slider };
}

// Wide ranges go by powers, so that 20 px can be set as well as 100000.
function sliderOf(spec, options, give) {
  const low = spec.limits[0];
  const high = options.most ?? spec.limits[1];
  const wide = low >= 0 && high - low > 1000;
  const bend = wide ? 4 : 1;
  const slider = element('input', { type: 'range', min: 0, max: 1, step: 0.001, on: {
    input: () => {
      const value = low + (high - low) * Number(slider.value) ** bend;
      give(spec.type === 'int' ? Math.round(value) : Number(value.toPrecision(4)));
    },
  } });
  slider.place = (value) => Math.min(Math.max((value - low) / (high - low), 0), 1) ** (1 / bend);
  slider.put = (value) => { slider.value = Math.max((value - low) / (high - low), 0) ** (1 / bend); };
  return slider;
}
