// The page: what the server tells, shown; what people do, sent.

import { histogram, plane } from '/page/charts.js';
import { element, field, set } from '/page/fields.js';
import { askLabels, chooseId, isLabeling, label, showLabeling } from '/page/labels.js';
import { crossKey, current, draw, drawRegion, endRegion, isDrawing, LAYERS, layers, onPick, PALETTE, show, showRegions, zoomBy } from '/page/stage.js';
import { connect, on, send } from '/page/wire.js';

const $ = (id) => document.getElementById(id);
const SHAPE = ['min_area', 'max_area', 'min_aspect', 'min_extent', 'min_circularity', 'min_solidity'];
const AXES = ['L', 'a', 'b'];
let described = {};
let state = null;
let active = '';
let asked = 0;
let fields = [];
let shownColors = '';

function notice(text, seconds = 6) {
  $('notice').textContent = text;
  $('notice').classList.add('shown');
  clearTimeout(notice.timer);
  notice.timer = setTimeout(() => $('notice').classList.remove('shown'), seconds * 1000);
}

const spec = (node, name) => described[node].parameters.find((one) => one.name === name)
  ?? described[node].each.colors?.find((one) => one.name === name.split('.').pop());

// ---- the picture and the time

function showView(view) {
  show(view);
  showHistograms();
  askLabels();
  if ($('plane-box').open && !state?.playing) send('plane');
  $('timeline').max = Math.max((state?.total ?? 1) - 1, view.number);
  if (document.activeElement !== $('timeline') || !scrubbing) $('timeline').value = view.number;
  $('frame').textContent = `${view.number} / ${$('timeline').max}`;
  $('trouble').hidden = !view.trouble;
  $('trouble').textContent = view.trouble;
  const tracks = view.tracks?.filter((track) => track.state).length;
  const known = tracks === undefined ? 'tracks follow' : `${tracks} tracks`;
  $('found').textContent = `${view.blobs.length} blobs, ${known}, ${view.time.toFixed(2)} s, worked ${view.milliseconds.toFixed(1)} ms`;
  if (asked) {
    const wait = performance.now() - asked;
    asked = 0;
    document.body.dataset.wait = wait.toFixed(0);
    $('found').textContent += `, shown after ${wait.toFixed(0)} ms`;
  }
  document.body.dataset.frame = view.number;
  document.body.dataset.tracks = tracks ?? '';
}

let scrubbing = false;
$('timeline').addEventListener('input', () => {
  scrubbing = true;
  asked ||= performance.now();
  send('seek', { frame: Number($('timeline').value) });
});
$('timeline').addEventListener('change', () => { scrubbing = false; });
$('play').addEventListener('click', () => send(state?.playing ? 'pause' : 'play'));
$('back').addEventListener('click', () => send('step', { by: -1 }));
$('on').addEventListener('click', () => send('step', { by: 1 }));

LAYERS.forEach((name, k) => {
  const box = element('input', { type: 'checkbox', id: `layer-${name}`, on: { change: () => { layers[name] = box.checked; draw(); } } });
  box.checked = layers[name];
  $('layers').append(element('label', { title: `${name} (${k + 1})` }, box, name));
});

onPick((place) => {
  if (isLabeling()) {
    label(place);
    return;
  }
  asked = performance.now();
  send('sample', { color: active, ...place });
  $('step-pick').classList.add('done');
});

// ---- colors

function showColors() {
  const names = state.colors.map((color) => color.name);
  const chosen = names.filter((name) => state.given.detector.some((given) => given.startsWith(`${name}.`)));
  if (!active) active = chosen[0] ?? 'ball';
  const listed = names.includes(active) ? names : [...names, active];
  const key = JSON.stringify([state.colors, state.samples, active]);
  $('active').textContent = active;
  if (key === shownColors) return;
  shownColors = key;
  $('colors').replaceChildren(...listed.map((name) => {
    const k = names.indexOf(name);
    const radio = element('input', { type: 'radio', name: 'color', id: `color-${name}`, on: { change: () => { active = name; showState(); } } });
    radio.checked = name === active;
    const swatch = element('span', { class: 'swatch', 'aria-hidden': 'true' });
    if (k >= 0) swatch.style.background = PALETTE[k % PALETTE.length];
    const mine = state.samples.filter((sample) => sample.color === name);
    const tag = k < 0 ? 'not yet picked' : mine.length ? `${mine.length} picked` : chosen.includes(name) ? '' : 'built in';
    const remove = element('button', { class: 'reset', text: 'remove', type: 'button', 'aria-label': `Remove ${name}`, on: { click: () => send('remove_color', { color: name }) } });
    remove.hidden = names.length < 2 || k < 0;
    return element('div', { class: 'color' }, radio, swatch, element('label', { class: 'name', for: radio.id, text: k < 0 ? name : `${k + 1}: ${name}` }), element('span', { class: 'tag', text: tag }), remove);
  }));
  showReach();
}

$('add').addEventListener('click', () => {
  const name = $('name').value.trim();
  if (!/^[A-Za-z0-9_-]{1,40}$/.test(name)) {
    notice('A name has letters, digits, _ and -.');
    return;
  }
  active = name;
  $('name').value = '';
  showState();
});

// How far the active color reaches: one number, or one for each axis.
let reachKey = '';
let reach = [];
function showReach() {
  const color = state.colors.find((one) => one.name === active);
  const key = color ? `${active} ${color.tolerance_lab === null}` : '';
  if (key !== reachKey) {
    reachKey = key;
    reach = [];
    const tolerance = color && spec('detector', 'x.tolerance');
    if (color?.tolerance_lab) {
      reach = AXES.map((axis, k) => {
        const one = field('detector', `${active}.tolerance_lab.${axis}`, { ...tolerance, minimum: 0.5, default: null, description: `How far the color reaches along ${axis}.` }, {
          place: 'reach', label: `reach in ${axis}`, brief: true, most: 100,
          give: (value, sliding) => {
            const axes = state.colors.find((each) => each.name === active).tolerance_lab;
            set('detector', `${active}.tolerance_lab`, axes.map((old, at) => (at === k ? value : old)), sliding);
          },
        });
        one.axis = k;
        return one;
      });
    } else if (color) {
      reach = [field('detector', `${active}.tolerance`, tolerance, { place: 'reach', label: 'tolerance', brief: true, most: 100 })];
    }
    $('reach').replaceChildren(...reach);
  }
  reach.forEach((one) => one.update(one.axis === undefined ? color.tolerance : color.tolerance_lab[one.axis], false));
}

// ---- all parameters

function makeFields() {
  fields = [];
  const add = (node, one, name, place, options) => {
    const made = field(node, name, one, options);
    fields.push({ node, name, made });
    place.append(made);
  };
  $('shape').replaceChildren();
  for (const name of SHAPE) {
    const size = current()?.size ?? [640, 480];
    add('detector', spec('detector', name), name, $('shape'), { place: 'shape', brief: true, most: name.endsWith('area') ? size[0] * size[1] : undefined });
  }
  $('parameters').replaceChildren();
  for (const [node, { parameters }] of Object.entries(described)) {
    for (const [audience, title] of [['user', node], ['expert', `${node}, for experts`], ['document', `${node}, only to reproduce a document`]]) {
      const group = element('details', {}, element('summary', { text: title }));
      for (const one of parameters.filter((each) => each.audience === audience)) add(node, one, one.name, group, {});
      $('parameters').append(group);
    }
  }
}

// ---- what the limits let in and out

const LIMITS = { max_area: 'area', min_area: 'area' };
const passes = (blob) => SHAPE.every((name) => {
  const measure = blob[LIMITS[name] ?? name];
  const limit = state.values.detector[name];
  return name.startsWith('max') ? measure <= limit : measure >= limit;
});

function showHistograms() {
  const blobs = current()?.before_limits;
  if (!blobs || !state) return;
  const kept = blobs.map(passes);
  for (const { name, made } of fields) {
    const chart = made.querySelector('.histogram');
    if (!chart) continue;
    const values = blobs.map((blob) => blob[LIMITS[name] ?? name]);
    const inside = kept.filter(Boolean).length;
    histogram(chart, values.map(made.slider.place), kept, `${LIMITS[name] ?? name.slice(4)} of ${values.length} blobs, of which the limits let ${inside} in`);
  }
}

on('plane', (message) => plane($('plane'), message, active));
$('plane-box').addEventListener('toggle', () => { if ($('plane-box').open) send('plane'); });

// ---- regions

function showRegionList() {
  showRegions(state.regions);
  $('regions').replaceChildren(...state.regions.map(({ name, ignore }) => element('div', { class: 'region' },
    element('span', { class: 'name', text: name }), element('span', { class: 'tag', text: ignore ? 'ignored' : 'looked in' }),
    element('button', { class: 'reset', text: 'remove', type: 'button', 'aria-label': `Remove region ${name}`, on: { click: () => removeRegion(name) } }))));
}

function removeRegion(gone) {
  const rest = state.regions.map(({ name }) => name).filter((name) => name !== gone);
  const values = { regions: rest.length ? rest : null, [`${gone}.polygon`]: null, [`${gone}.ignore`]: null };
  send('set', { node: 'detector', values, follows: false });
}

function addRegion(ignore) {
  $('drawing').textContent = 'Click the corners; Enter closes the region, Esc drops it.';
  layers.regions = true;
  $('layer-regions').checked = true;
  drawRegion((polygon) => {
    $('drawing').textContent = '';
    if (!polygon) return;
    const names = state.regions.map(({ name }) => name);
    let k = 1;
    while (names.includes(`region${k}`)) k++;
    const values = { regions: [...names, `region${k}`], [`region${k}.polygon`]: polygon.flat() };
    if (ignore) values[`region${k}.ignore`] = true;
    send('set', { node: 'detector', values, follows: false });
  });
}

$('look-in').addEventListener('click', () => addRegion(false));
$('ignore').addEventListener('click', () => addRegion(true));

$('search').addEventListener('input', () => {
  const words = $('search').value.toLowerCase().split(/\s+/).filter(Boolean);
  for (const group of $('parameters').querySelectorAll('details')) {
    let found = 0;
    for (const one of group.querySelectorAll('.field')) {
      one.hidden = !words.every((word) => one.dataset.name.includes(word));
      found += !one.hidden;
    }
    group.hidden = !found;
    group.open = words.length > 0 && found > 0;
  }
});

function showState() {
  if (!state) return;
  $('source').textContent = state.source;
  $('play').textContent = state.playing ? 'Stop' : 'Play';
  $('undo').disabled = !state.changes;
  $('folder').textContent = state.folder;
  $('files').replaceChildren(...state.files.map((name) => element('option', { value: name })));
  $('step-look').classList.toggle('done', state.samples.some((sample) => !sample.is_it) || state.changes > 1);
  document.title = `${state.unsaved ? '• ' : ''}tuner: ${state.file || state.source}`;
  showColors();
  for (const { node, name, made } of fields) made.update(state.values[node][name], state.given[node].includes(name));
  showRegionList();
  showNodes();
  showLabeling(state.labeling, state.total);
  if (state.waiting) {
    $('trouble').hidden = false;
    $('trouble').textContent = `No picture has come from ${state.source} yet.`;
  }
  showHistograms();
  document.body.dataset.changes = state.changes;
  const refused = Object.values(state.refused);
  if (refused.length) notice(`Refused from ${state.file}: ${refused.join('; ')}`, 15);
}

// ---- running nodes

let found = null;
function showNodes() {
  if (!found && !Object.keys(state.attached).length) return;
  const kinds = Object.keys(described);
  $('nodes').replaceChildren(...kinds.map((kind) => {
    const names = [...new Set([...(found?.[kind] ?? []), ...(state.attached[kind] ? [state.attached[kind]] : [])])];
    const choice = element('select', { id: `node-${kind}`, on: { change: () => send('attach', { node: kind, to: choice.value }) } },
      element('option', { value: '', text: names.length ? 'none' : 'none found' }), ...names.map((name) => element('option', { value: name, text: name })));
    choice.value = state.attached[kind] ?? '';
    return element('div', { class: 'row' }, element('label', { for: choice.id, text: kind }), choice);
  }));
}

on('nodes', ({ nodes }) => { found = nodes; showNodes(); });
$('find').addEventListener('click', () => send('nodes'));

// ---- saving

function askDiff() {
  $('save-now').disabled = true;
  send('diff', { path: $('path').value });
}

function openSaving() {
  $('path').value = state?.file || 'colortrack.yaml';
  $('saving').showModal();
  askDiff();
}

let seen = null;
on('diff', (message) => {
  if (message.path !== $('path').value) return; // another one has been asked for since
  seen = message;
  $('save-now').disabled = !message.diff;
  const lines = (message.diff || 'Nothing would change.').split('\n');
  $('diff').replaceChildren(...lines.map((line) => element('span', {
    class: line.startsWith('+') ? 'plus' : line.startsWith('-') ? 'minus' : '', text: `${line}\n`,
  })));
});
on('saved', ({ path }) => {
  $('saving').close();
  $('step-save').classList.add('done');
  document.body.dataset.saved = path;
  notice(`Saved ${path}`);
});
on('lines', async ({ text }) => {
  try {
    await navigator.clipboard.writeText(text);
    notice('Copied.');
  } catch {
    $('diff').textContent = text || 'Nothing has changed.';
  }
});
$('save').addEventListener('click', openSaving);
$('path').addEventListener('change', askDiff);
$('save-now').addEventListener('click', () => send('save', { path: seen.path, digest: seen.digest }));
$('load').addEventListener('click', () => { send('load', { path: $('path').value }); active = ''; $('saving').close(); });
$('copy').addEventListener('click', () => send('lines'));
$('undo').addEventListener('click', () => send('undo'));
$('help').addEventListener('click', () => $('helping').showModal());

// ---- the rest

function theme(name) {
  if (name) document.documentElement.dataset.theme = name;
}
$('theme').addEventListener('click', () => {
  const dark = getComputedStyle(document.documentElement).colorScheme === 'dark'
    || (!document.documentElement.dataset.theme && matchMedia('(prefers-color-scheme: dark)').matches);
  theme(dark ? 'light' : 'dark');
  localStorage.setItem('theme', document.documentElement.dataset.theme);
  showHistograms();
});
theme(localStorage.getItem('theme'));
$('steps').hidden = localStorage.getItem('steps') === 'hidden';
$('steps-close').addEventListener('click', () => { $('steps').hidden = true; localStorage.setItem('steps', 'hidden'); });

document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector('dialog[open]')) return;
  if (isDrawing() && ['Enter', 'Escape'].includes(event.key) && document.activeElement.id !== 'picture') {
    event.preventDefault();
    endRegion(event.key === 'Enter');
    return;
  }
  if (crossKey(event)) {
    event.preventDefault();
    return;
  }
  if (event.target.matches('input, select, textarea') && event.target.type !== 'checkbox') return;
  const actions = {
    ' ': () => $('play').click(),
    ArrowLeft: () => $('back').click(),
    ArrowRight: () => $('on').click(),
    Home: () => send('seek', { frame: 0 }),
    End: () => send('seek', { frame: Number($('timeline').max) }),
    '+': () => zoomBy(1.5),
    '-': () => zoomBy(1 / 1.5),
    0: () => zoomBy(0),
    u: () => $('undo').click(),
    s: openSaving,
    '/': () => $('search').focus(),
    '?': () => $('helping').showModal(),
  };
  LAYERS.forEach((name, k) => { actions[k + 1] = () => $(`layer-${name}`).click(); });
  if (isLabeling() && /^[1-9]$/.test(event.key)) {
    chooseId(Number(event.key));
    return;
  }
  const action = actions[event.key];
  if (!action || (event.key === ' ' && event.target.matches('button, summary'))) return;
  event.preventDefault();
  action();
});

document.addEventListener('asked', () => { asked ||= performance.now(); });
on('saved_labels', ({ path }) => {
  document.body.dataset.savedLabels = path;
  notice(`Saved ${path}`);
});
$('label-id').addEventListener('change', showState);
on('hello', (message) => { described = message.parameters; makeFields(); });
on('state', (message) => { state = message; showState(); });
on('view', showView);
on('refused', ({ why }) => { notice(why); showState(); });
on('link', (up) => {
  $('link').textContent = up ? 'connected' : 'connection lost, trying again';
  $('link').classList.toggle('lost', !up);
  document.body.dataset.link = up ? 'up' : 'down';
});
connect();
