// Regions: drawn corner by corner, listed, removed.

import { element } from '/page/fields.js';
import { draw, drawRegion, layers, showRegions } from '/page/stage.js';
import { send } from '/page/wire.js';

const $ = (id) => document.getElementById(id);
let regions = [];
let shown = '';

export function showRegionList(next) {
  const key = JSON.stringify(next);
  if (key === shown) return;
  [shown, regions] = [key, next];
  showRegions(regions);
  $('regions').replaceChildren(...regions.map(({ name, ignore }) => element('div', { class: 'region' },
    element('span', { class: 'name', text: name }), element('span', { class: 'tag', text: ignore ? 'ignored' : 'looked in' }),
    element('button', { class: 'reset', text: 'remove', type: 'button', 'aria-label': `Remove region ${name}`, on: { click: () => remove(name) } }))));
}

function change(values) {
  send('set', { node: 'detector', values, follows: false });
}

function remove(gone) {
  const rest = regions.map(({ name }) => name).filter((name) => name !== gone);
  change({ regions: rest.length ? rest : null, [`${gone}.polygon`]: null, [`${gone}.ignore`]: null });
}

function add(ignore) {
  $('drawing').textContent = 'Click the corners; Enter closes the region, Esc drops it.';
  layers.regions = true;
  $('layer-regions').checked = true;
  draw();
  drawRegion((polygon) => {
    $('drawing').textContent = '';
    if (!polygon) return;
    const names = regions.map(({ name }) => name);
    let k = 1;
    while (names.includes(`region${k}`)) k++;
    change({ regions: [...names, `region${k}`], [`region${k}.polygon`]: polygon.flat(), ...(ignore ? { [`region${k}.ignore`]: true } : {}) });
  });
}

$('look-in').addEventListener('click', () => add(false));
$('ignore').addEventListener('click', () => add(true));
