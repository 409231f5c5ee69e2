// What the sliders are set by: histograms of the blobs, and the a-b plane.

import { PALETTE } from '/page/stage.js';

const SPAN = 128; // a and b go from -128 to 128

function sharp(canvas) {
  const box = canvas.getBoundingClientRect();
  canvas.width = Math.max(Math.round(box.width * devicePixelRatio), 1);
  canvas.height = Math.max(Math.round(box.height * devicePixelRatio), 1);
  return canvas.getContext('2d');
}

// Bars along a slider; those that the limits leave out are pale.
export function histogram(canvas, places, kept, text) {
  const pen = sharp(canvas);
  const style = getComputedStyle(canvas);
  const bins = 40;
  const counts = [new Array(bins).fill(0), new Array(bins).fill(0)];
  places.forEach((place, k) => {
    counts[Number(kept[k])][Math.min(Math.max(Math.floor(place * bins), 0), bins - 1)]++;
  });
  const most = Math.max(1, ...counts[0].map((out, k) => out + counts[1][k]));
  const wide = canvas.width / bins;
  const tall = (count) => (count ? (0.15 + (0.85 * count) / most) * canvas.height : 0);
  for (let k = 0; k < bins; k++) {
    const both = tall(counts[0][k] + counts[1][k]);
    const inside = both * (counts[1][k] / Math.max(counts[0][k] + counts[1][k], 1));
    pen.fillStyle = style.outlineColor;
    pen.fillRect(k * wide + 1, canvas.height - both, wide - 2, both - inside);
    pen.fillStyle = style.color;
    pen.fillRect(k * wide + 1, canvas.height - inside, wide - 2, inside);
  }
  canvas.setAttribute('aria-label', text);
}

// The colors of the picture, and the reference colors with what was shown of them.
export function plane(canvas, { cells, colors }, active) {
  const pen = sharp(canvas);
  const scale = canvas.width / (2 * SPAN);
  const at = (a, b) => [(a + SPAN) * scale, (SPAN - b) * scale];
  pen.fillStyle = '#101216';
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.strokeStyle = '#444a55';
  pen.beginPath();
  pen.moveTo(...at(-SPAN, 0));
  pen.lineTo(...at(SPAN, 0));
  pen.moveTo(...at(0, -SPAN));
  pen.lineTo(...at(0, SPAN));
  pen.stroke();
  const side = 3 * scale;
  const most = Math.log(1 + Math.max(...cells.map((cell) => cell[2]), 1));
  for (const [a, b, pixels, red, green, blue] of cells) {
    const [x, y] = at(a, b);
    pen.globalAlpha = 0.3 + (0.7 * Math.log(1 + pixels)) / most;
    pen.fillStyle = `rgb(${red} ${green} ${blue})`;
    pen.fillRect(x - side / 2, y - side / 2, side, side);
  }
  pen.globalAlpha = 1;
  pen.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  pen.fillStyle = '#c8ccd4';
  pen.fillText('a', canvas.width - 14 * devicePixelRatio, at(0, 0)[1] - 4);
  pen.fillText('b', at(0, 0)[0] + 5, 14 * devicePixelRatio);
  colors.forEach(({ name, samples, others, axes }, k) => {
    pen.lineWidth = (name === active ? 2.5 : 1) * devicePixelRatio;
    pen.strokeStyle = PALETTE[k % PALETTE.length];
    for (const [, a, b] of samples) {
      const [x, y] = at(a, b);
      if (axes) {
        pen.beginPath();
        pen.ellipse(x, y, axes[1] * scale, axes[2] * scale, 0, 0, 2 * Math.PI);
        pen.stroke();
      }
      pen.beginPath();
      pen.arc(x, y, 3 * devicePixelRatio, 0, 2 * Math.PI);
      pen.fillStyle = '#fff';
      pen.fill();
    }
    for (const [, a, b] of others) {
      const [x, y] = at(a, b);
      const r = 4 * devicePixelRatio;
      pen.strokeStyle = '#fff';
      pen.beginPath();
      pen.moveTo(x - r, y - r);
      pen.lineTo(x + r, y + r);
      pen.moveTo(x - r, y + r);
      pen.lineTo(x + r, y - r);
      pen.stroke();
    }
  });
}
