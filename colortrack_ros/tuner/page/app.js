// The page: what the server tells, shown; what people do, sent.

import { histogram } from '/page/charts.js';
import { chosen, describeColors, forgetColor, showColors, showPlane } from '/page/colors.js';
import { answered, element, field } from '/page/fields.js';
import { askLabels, chooseId, isLabeling, label, showLabeling } from '/page/labels.js';
import { showRegionList } from '/page/regions.js';
import { describeSaving, openSaving, showFiles } from '/page/saving.js';
import { crossKey, current, draw, endRegion, isDrawing, LAYERS, layers, onPick, show, showBackground, zoomBy } from '/page/stage.js';
import { begin, end, expect, forget } from '/page/waits.js';
import { connect, on, send } from '/page/wire.js';

const $ = (id) => document.getElementById(id);
const SHAPE = ['min_area', 'max_area', 'min_aspect', 'min_extent', 'min_circularity', 'min_solidity'];
const IDLE = 120; // without a new picture, before what is not urgent is drawn [ms]
let described = {};
let state = null;
let fields = [];

function notice(text, seconds = 6) {
  $('notice').textContent = text;
  $('notice').classList.add('shown');
  clearTimeout(notice.timer);
  notice.timer = setTimeout(() => $('notice').classList.remove('shown'), seconds * 1000);
}

const spec = (node, name) => described[node].parameters.find((one) => one.name === name);

// ---- the picture and the time

function showView(view) {
  show(view);
  clearTimeout(showView.timer);
  showView.timer = setTimeout(() => { if (!state?.playing) send('plane'); }, IDLE);
  requestAnimationFrame(showHistograms);
  askLabels();
  if (layers.background) send('background');
  showLength();
  if (document.activeElement !== $('timeline') || !scrubbing) $('timeline').value = view.number;
  showTrouble();
  const tracks = view.tracks?.filter((track) => track.state).length;
  const known = tracks === undefined ? 'tracks follow' : `${tracks} tracks`;
  $('found').textContent = `${view.blobs.length} blobs, ${known}, ${view.time.toFixed(2)} s, worked ${view.milliseconds.toFixed(1)} ms`;
  const wait = end(view.revision);
  if (wait) {
    document.body.dataset.wait = wait.toFixed(0);
    $('found').textContent += `, shown after ${wait.toFixed(0)} ms`;
  }
  document.body.dataset.frame = view.number;
  document.body.dataset.tracks = tracks ?? '';
}

function showTrouble() {
  const waiting = state?.waiting && `No picture has come from ${state.source} yet.`;
  $('trouble').textContent = [waiting, current()?.trouble, state?.trouble].filter(Boolean).join('. ');
  $('trouble').hidden = !$('trouble').textContent;
}

function showLength() {
  const number = current()?.number ?? 0;
  $('timeline').max = Math.max((state?.total ?? 1) - 1, number);
  $('frame').textContent = `${number} / ${$('timeline').max}`;
}

let scrubbing = false;
$('timeline').addEventListener('input', () => {
  scrubbing = true;
  send('seek', { frame: Number($('timeline').value) });
});
$('timeline').addEventListener('change', () => { scrubbing = false; });
$('play').addEventListener('click', () => send(state?.playing ? 'pause' : 'play'));
$('back').addEventListener('click', () => send('step', { by: -1 }));
$('on').addEventListener('click', () => send('step', { by: 1 }));

LAYERS.forEach((name, k) => {
  const box = element('input', { type: 'checkbox', id: `layer-${name}`, on: { change: () => showLayer(name, box.checked) } });
  box.checked = layers[name];
  $('layers').append(element('label', { title: `${name} (${k + 1})` }, box, name));
});

function showLayer(name, shown) {
  layers[name] = shown;
  draw();
  if (name === 'background' && shown) send('background');
}

on('background', async ({ picture, moves }) => {
  if (!picture) {
    if (current()?.tracks) {
      showBackground(null);
      notice('No background is learned: moving_only, or the method background, does.');
    }
    return; // or it comes with the tracks
  }
  const images = [['jpeg', picture], ['png', moves]].map(([kind, text]) => imageOf(`data:image/${kind};base64,${text}`));
  showBackground(await Promise.all(images));
});

async function imageOf(address) {
  const image = new Image();
  image.src = address;
  await image.decode();
  return createImageBitmap(image);
}

onPick((place) => {
  if (isLabeling()) {
    label(place);
    return;
  }
  begin();
  send('sample', { color: chosen(), ...place });
  $('step-pick').classList.add('done');
});

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
  showFiles(state);
  showLength();
  $('step-look').classList.toggle('done', state.samples.some((sample) => !sample.is_it) || state.changes > 1);
  document.title = `${state.unsaved ? '• ' : ''}tuner: ${state.file || state.source}`;
  showColors(state);
  for (const { node, name, made } of fields) made.update(state.values[node][name], state.given[node].includes(name));
  showRegionList(state.regions);
  showNodes();
  showLabeling(state.labeling, state.total);
  showTrouble();
  requestAnimationFrame(showHistograms);
  document.body.dataset.changes = state.changes;
  const refused = Object.values(state.refused);
  if (refused.length) notice(`Refused from ${state.file}: ${refused.join('; ')}`, 15);
}

// ---- running nodes

let found = null;
function showNodes() {
  if (!found && !Object.keys(state.attached).length) return;
  const kinds = Object.keys(described);
  const key = JSON.stringify([found, state.attached]);
  if (key === showNodes.shown) return;
  showNodes.shown = key;
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

on('saved_labels', ({ path }) => {
  document.body.dataset.savedLabels = path;
  notice(`Saved ${path}`);
});
$('label-id').addEventListener('change', showState);
on('hello', (message) => {
  described = message.parameters;
  describeColors(described, { refresh: showState, notice });
  makeFields();
});
describeSaving({ notice, loads: forgetColor });
on('set', ({ revision }) => { expect(revision); answered(); });
on('plane', showPlane);
on('state', (message) => { state = message; showState(); });
on('view', showView);
on('refused', ({ why }) => {
  notice(why);
  forget();
  answered();
  showState();
});
on('link', (up) => {
  $('link').textContent = up ? 'connected' : 'connection lost, trying again';
  $('link').classList.toggle('lost', !up);
  document.body.dataset.link = up ? 'up' : 'down';
});
connect();
