// Labels: who is where in some frames by hand, in the others as the tracker proposes.

import { element } from '/page/fields.js';
import { current, showLabels } from '/page/stage.js';
import { on, send } from '/page/wire.js';

let begun = false; // the tracker has been sent over the recording, or a truth is loaded
const $ = (id) => document.getElementById(id);
const id = () => Number($('label-id').value);
let asked = ''; // the path that was refused because there is such a file

export const isLabeling = () => $('labeling').open;

export function label({ u, v, width, height }) {
  send('label', { id: id(), frame: current().number, u, v, width, height });
}

export function chooseId(next) {
  $('label-id').value = next;
  $('label-id').dispatchEvent(new Event('change'));
}

// After each picture, and each change.
export function askLabels() {
  if (isLabeling() && current()) send('labels_at', { frame: current().number });
}

export function showLabeling({ seen, done, labels }, total) {
  begun = seen > 0;
  $('survey').textContent = !isLabeling() ? '' : done ? `${seen} frames seen.` : `The tracker looks at all frames: ${seen} of ${total}.`;
  $('labels').replaceChildren(...labels.map((one) => {
    const strip = element('canvas', { width: 300, height: 12, role: 'img', 'aria-label': `ID ${one.id}: ${one.labeled} frames labeled, ${one.guessed} of them guessed` });
    paint(strip, one, Math.max(total, 1));
    strip.addEventListener('click', (event) => send('seek', { frame: Math.floor((event.offsetX / strip.clientWidth) * total) }));
    const text = `ID ${one.id}: ${one.marks.length} marks, ${one.labeled} frames, ${one.guessed} guessed`;
    return element('div', { class: `label${one.id === id() ? ' active' : ''}` }, element('span', { class: 'name', text }), strip);
  }));
  document.body.dataset.labels = labels.map((one) => `${one.id}:${one.marks.length}`).join(' ');
  document.body.dataset.surveyed = done;
  askLabels();
}

// Measured full, guessed half as high, marks as lines.
function paint(canvas, { stretches, marks }, total) {
  const pen = canvas.getContext('2d');
  const scale = canvas.width / total;
  for (const [begin, end, state] of stretches) {
    pen.fillStyle = state === 1 ? '#009e73' : '#e69f00';
    pen.fillRect(begin * scale, state === 1 ? 0 : 6, Math.max((end - begin) * scale, 1), 12);
  }
  pen.fillStyle = '#d55e00';
  for (const frame of marks) pen.fillRect(frame * scale, 0, 2, 12);
}

$('labeling').addEventListener('toggle', () => {
  if (isLabeling() && !begun) send('survey');
  else showLabels([]);
});
$('label-gone').addEventListener('click', () => send('gone', { id: id(), frame: current().number }));
$('label-undo').addEventListener('click', () => send('unlabel', { id: id(), frame: current().number }));
$('survey-again').addEventListener('click', () => send('survey'));
$('label-load').addEventListener('click', () => send('load_labels', { path: $('label-path').value }));
$('label-save').addEventListener('click', () => {
  const path = $('label-path').value;
  send('save_labels', { path, overwrite: asked === path });
  asked = path;
});
on('labels', ({ frame, labels }) => {
  if (frame === current()?.number && isLabeling()) showLabels(labels);
});
