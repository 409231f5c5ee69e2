// The picture with its layers, its zoom, and the places that are picked in it.

// Okabe and Ito's colors, told apart by nearly everybody; each blob has its color's number as well.
export const PALETTE = ['#e69f00', '#56b4e9', '#009e73', '#f0e442', '#0072b2', '#d55e00', '#cc79a7'];
export const LAYERS = ['picture', 'mask', 'blobs', 'tracks', 'trails', 'ellipses', 'regions', 'background'];

const canvas = document.getElementById('picture');
const pen = canvas.getContext('2d');
const masked = document.createElement('canvas');
const SPREAD = Math.sqrt(5.991); // 95 % of a normal distribution in the plane are within it

export const layers = Object.fromEntries(LAYERS.map((name) => [name, name !== 'background']));
let view = null;
let zoom = 1;
let corner = [0, 0];
let drag = null;
let cross = null;
let pick = () => {};
let regions = [];
let labels = [];
let background = null; // what stands still, and what moves in white
let corners = null; // of the region that is drawn
let finish = () => {};

export const current = () => view;

export function onPick(listener) {
  pick = listener;
}

export function showLabels(next) {
  labels = next;
  draw();
}

export function showRegions(next) {
  regions = next;
  draw();
}

// Clicks are corners from now on; done gets them, or nothing if they are dropped.
export function drawRegion(done) {
  corners = [];
  finish = done;
  canvas.focus();
}

export function endRegion(keep) {
  const drawn = corners;
  corners = null;
  finish(keep && drawn?.length > 2 ? drawn : null);
  draw();
}

export const isDrawing = () => corners !== null;

export function showBackground(next) {
  background?.forEach((image) => image.close());
  background = next;
  draw();
}

export function show(next) {
  if (view?.picture !== next.picture) view?.picture.close();
  view?.mask.close();
  view = next;
  paintMask();
  draw();
}

function rgb(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

// The labels, which come as gray levels, in the colors of the palette.
function paintMask() {
  const [width, height] = view.size;
  if (masked.width !== width || masked.height !== height) [masked.width, masked.height] = [width, height];
  const brush = masked.getContext('2d', { willReadFrequently: true });
  brush.drawImage(view.mask, 0, 0);
  const image = brush.getImageData(0, 0, width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const inks = PALETTE.map((hex) => {
    const [red, green, blue] = rgb(hex);
    return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  });
  for (let i = 0; i < pixels.length; i++) {
    const label = pixels[i] & 255;
    pixels[i] = label ? inks[(label - 1) % inks.length] : 0;
  }
  brush.putImageData(image, 0, 0);
}

export function draw() {
  if (!view) return;
  const [width, height] = view.size;
  const shown = canvas.clientWidth || width;
  const scale = Math.min(Math.max(1, (shown * devicePixelRatio) / width), 4);
  const size = [width, height].map((side) => Math.round(side * scale));
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  canvas.style.aspectRatio = `${width} / ${height}`;
  pen.resetTransform();
  if (!layers.picture) pen.clearRect(0, 0, ...size);
  pen.setTransform(scale * zoom, 0, 0, scale * zoom, -corner[0] * scale * zoom, -corner[1] * scale * zoom);
  pen.imageSmoothingEnabled = zoom < 3;
  const thin = width / shown / zoom;
  if (layers.picture) pen.drawImage(view.picture, 0, 0, width, height);
  if (layers.background && background) drawBackground(width, height);
  pen.imageSmoothingEnabled = false;
  if (layers.mask) {
    pen.globalAlpha = layers.picture ? 0.7 : 1;
    pen.drawImage(masked, 0, 0);
    pen.globalAlpha = 1;
  }
  // The center of the top left pixel is (0, 0).
  pen.translate(0.5, 0.5);
  if (layers.regions) regions.forEach((region) => drawCorners(region.polygon, region.ignore ? '#ff9f80' : '#7ee0b5', thin, true));
  if (layers.blobs) {
    view.before_limits.slice(0, 60).forEach((blob) => drawDropped(blob, thin));
    for (const blob of view.blobs) drawBlob(blob, thin);
  }
  for (const track of view.tracks ?? []) drawTrack(track, thin);
  labels.forEach((label) => drawLabel(label, thin));
  drawMarks(thin);
}

// What stands still, in place of the picture; what moves lightens it.
function drawBackground(width, height) {
  const [still, moves] = background;
  pen.drawImage(still, 0, 0, width, height);
  pen.globalAlpha = 0.6;
  pen.globalCompositeOperation = 'lighter';
  pen.drawImage(moves, 0, 0, width, height);
  pen.globalCompositeOperation = 'source-over';
  pen.globalAlpha = 1;
}

function drawLabel({ id, box: [u, v, width, height], guessed, marked }, thin) {
  pen.beginPath();
  pen.rect(u - width / 2, v - height / 2, width, height);
  line('#fff', (marked ? 3 : 2) * thin, guessed ? [5 * thin, 4 * thin] : []);
  words(`ID ${id}${guessed ? '?' : ''}`, u + width / 2 + 3 * thin, v, '#fff', thin);
}

function line(color, width, dash = []) {
  pen.setLineDash(dash);
  pen.lineWidth = width * 2.2;
  pen.strokeStyle = 'rgb(0 0 0 / .55)';
  pen.stroke();
  pen.lineWidth = width;
  pen.strokeStyle = color;
  pen.stroke();
  pen.setLineDash([]);
}

function words(text, x, y, color, thin) {
  pen.font = `600 ${13 * thin}px system-ui, sans-serif`;
  pen.lineWidth = 3.5 * thin;
  pen.lineJoin = 'round';
  pen.strokeStyle = 'rgb(0 0 0 / .8)';
  pen.strokeText(text, x, y);
  pen.fillStyle = color;
  pen.fillText(text, x, y);
}

function drawBlob(blob, thin) {
  const color = PALETTE[blob.color % PALETTE.length];
  pen.beginPath();
  pen.rect(blob.box_u - 0.5, blob.box_v - 0.5, blob.box_w, blob.box_h);
  line('#fff', thin);
  words(`${blob.color + 1}: ${Math.round(blob.area)} px`, blob.box_u, blob.box_v + blob.box_h + 14 * thin, color, thin);
}

// What the limits of size and shape leave out.
function drawDropped({ box: [u, v, width, height] }, thin) {
  if (view.blobs.some((blob) => blob.box_u === u && blob.box_v === v && blob.box_w === width)) return;
  pen.beginPath();
  pen.rect(u - 0.5, v - 0.5, width, height);
  line('#ccc', 0.8 * thin, [3 * thin, 3 * thin]);
}

function drawCorners(polygon, color, thin, closed) {
  pen.beginPath();
  polygon.forEach(([u, v]) => pen.lineTo(u, v));
  if (closed) pen.closePath();
  line(color, 2 * thin, closed ? [] : [5 * thin, 4 * thin]);
  for (const [u, v] of polygon) {
    pen.fillStyle = color;
    pen.fillRect(u - 3 * thin, v - 3 * thin, 6 * thin, 6 * thin);
  }
}

export function trackColor(id) {
  return `hsl(${((id * 0.61803398875) % 1) * 360} 90% 65%)`;
}

function drawTrack(track, thin) {
  const color = track.state === 0 ? '#bbb' : trackColor(track.track_id);
  const dash = track.state === 2 ? [6 * thin, 5 * thin] : [];
  const trail = view.trails[track.track_id] ?? [];
  if (layers.trails && trail.length > 1) {
    pen.beginPath();
    trail.forEach(([u, v]) => pen.lineTo(u, v));
    line(color, 2 * thin);
  }
  if (layers.ellipses) {
    const [a, b, , , , d] = track.covariance.flat();
    const turn = Math.atan2(2 * b, a - d) / 2;
    const middle = (a + d) / 2;
    const away = Math.hypot((a - d) / 2, b);
    pen.beginPath();
    pen.ellipse(track.u, track.v, SPREAD * Math.sqrt(Math.max(middle + away, 0)),
      SPREAD * Math.sqrt(Math.max(middle - away, 0)), turn, 0, 2 * Math.PI);
    line(color, 1.5 * thin, dash);
  }
  if (layers.tracks) {
    pen.beginPath();
    pen.rect(track.box_u - 0.5, track.box_v - 0.5, track.box_w, track.box_h);
    line(color, 2 * thin, dash);
    if (track.state) words(String(track.track_id), track.box_u - 0.5, track.box_v - 0.5 - 4 * thin, color, thin);
  }
}

function drawMarks(thin) {
  if (corners) drawCorners(corners, '#fff', thin, false);
  if (drag?.box) {
    pen.beginPath();
    pen.rect(...drag.box);
    line('#fff', 1.5 * thin, [4 * thin, 3 * thin]);
  }
  if (cross && document.activeElement === canvas) {
    pen.beginPath();
    pen.moveTo(cross[0] - 12 * thin, cross[1]);
    pen.lineTo(cross[0] + 12 * thin, cross[1]);
    pen.moveTo(cross[0], cross[1] - 12 * thin);
    pen.lineTo(cross[0], cross[1] + 12 * thin);
    line('#fff', 1.5 * thin);
  }
}

// The pixel under the pointer.
function pixel(event) {
  const [width, height] = view.size;
  const box = canvas.getBoundingClientRect();
  const u = ((event.clientX - box.left) / box.width) * width / zoom + corner[0];
  const v = ((event.clientY - box.top) / box.height) * height / zoom + corner[1];
  return [Math.min(Math.max(Math.floor(u), 0), width - 1), Math.min(Math.max(Math.floor(v), 0), height - 1)];
}

export function zoomBy(factor, at) {
  if (!view) return;
  const [width, height] = view.size;
  const [u, v] = at ?? [corner[0] + width / zoom / 2, corner[1] + height / zoom / 2];
  const before = zoom;
  zoom = factor === 0 ? 1 : Math.min(Math.max(zoom * factor, 1), 32);
  corner = [u - ((u - corner[0]) * before) / zoom, v - ((v - corner[1]) * before) / zoom];
  keepInside();
  draw();
}

function keepInside() {
  view.size.forEach((length, axis) => {
    corner[axis] = Math.min(Math.max(corner[axis], 0), length - length / zoom);
  });
}

canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  zoomBy(Math.exp(-event.deltaY / 400), pixel(event));
}, { passive: false });

canvas.addEventListener('pointerdown', (event) => {
  if (!view) return;
  canvas.setPointerCapture(event.pointerId);
  drag = { from: pixel(event), start: [event.clientX, event.clientY], corner: [...corner], moves: event.button === 1 };
  if (event.button === 1) event.preventDefault();
});

canvas.addEventListener('pointermove', (event) => {
  if (!drag) return;
  const way = [event.clientX - drag.start[0], event.clientY - drag.start[1]];
  const box = canvas.getBoundingClientRect();
  if (drag.moves) {
    corner = drag.corner.map((from, axis) => from - (way[axis] * view.size[0]) / box.width / zoom);
    keepInside();
  } else if (Math.hypot(...way) > 5 && !corners) {
    const to = pixel(event);
    const low = [0, 1].map((axis) => Math.min(drag.from[axis], to[axis]));
    drag.box = [...low, ...[0, 1].map((axis) => Math.abs(drag.from[axis] - to[axis]) + 1)];
  }
  draw();
});

canvas.addEventListener('pointerup', (event) => {
  if (!drag) return;
  const [u, v, width, height] = drag.box ?? [...drag.from, 1, 1];
  const moves = drag.moves;
  drag = null;
  if (corners && !moves) corners.push([u, v]);
  else if (!moves) pick({ u, v, width, height, is_it: !event.shiftKey });
  draw();
});

canvas.addEventListener('pointercancel', () => { drag = null; draw(); });
canvas.addEventListener('focus', draw);
canvas.addEventListener('blur', draw);

// Moves the cross by keys, and picks there; says whether the key was one of these.
export function crossKey(event) {
  if (!view || document.activeElement !== canvas) return false;
  const step = (event.shiftKey ? 10 : 1) * Math.max(1, Math.round(view.size[0] / 320 / zoom));
  const ways = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
  cross ??= view.size.map((length) => Math.floor(length / 2));
  if (ways[event.key]) {
    cross = cross.map((at, axis) => Math.min(Math.max(at + ways[event.key][axis], 0), view.size[axis] - 1));
  } else if (event.key === 'Enter' && corners) {
    if (corners.length > 2) endRegion(true);
    else corners.push([...cross]);
  } else if (event.key === ' ' && corners) {
    corners.push([...cross]);
  } else if (event.key === 'Escape' && corners) {
    endRegion(false);
  } else if (event.key === 'Enter') {
    pick({ u: cross[0], v: cross[1], width: 1, height: 1, is_it: !event.shiftKey });
  } else {
    return false;
  }
  draw();
  return true;
}

new ResizeObserver(draw).observe(canvas);
