// The params file: what would change in it, saving, loading, and the changes as commands.

import { element } from '/page/fields.js';
import { on, send } from '/page/wire.js';

const $ = (id) => document.getElementById(id);
let seen = null; // the difference that is shown
let notice = () => {};
let loads = () => {};
let file = '';

export function describeSaving(callbacks) {
  ({ notice, loads } = callbacks);
}

export function showFiles(state) {
  file = state.file;
  $('folder').textContent = state.folder;
  $('files').replaceChildren(...state.files.map((name) => element('option', { value: name })));
}

export function openSaving() {
  $('path').value = file || 'colortrack.yaml';
  $('saving').showModal();
  askDiff();
}

function askDiff() {
  $('save-now').disabled = true;
  send('diff', { path: $('path').value });
}

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
$('load').addEventListener('click', () => {
  send('load', { path: $('path').value });
  loads();
  $('saving').close();
});
$('copy').addEventListener('click', () => send('lines'));
