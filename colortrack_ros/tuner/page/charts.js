// What the sliders are set by: histograms of the blobs, and the a-b plane.

import { PALETTE } from '/page/stage.js';

const BINS = 40; // as REACH_BINS of the server
const SPAN = 128; // a and b go from -128 to 128

function sharp(canvas) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(Math.round(side * devicePixelRatio), 1));
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  return canvas.getContext('2d');
}

// Things by their places along a slider; those that the limits leave out are pale.
export function histogram(canvas, places, kept, text) {
  const counts = [0, 1].map(() => new Array(BINS).fill(0));
  places.forEach((place, k) => {
    counts[Number(kept[k])][Math.min(Math.max(Math.floor(place * BINS), 0), BINS - 1)]++;
  });
  bars(canvas, counts[1], counts[0], text, (count) => count);
}

// Bars along a slider: what is let in, and above it what is not.
export function bars(canvas, within, beyond, text, height) {
  const pen = sharp(canvas);
  const style = getComputedStyle(canvas);
  const most = Math.max(1, ...within.map((count, k) => height(count + beyond[k])));
  const wide = canvas.width / BINS;
  const tall = (count) => (count ? (0.15 + (0.85 * height(count)) / most) * canvas.height : 0);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  for (let k = 0; k < BINS; k++) {
    const both = tall(within[k] + beyond[k]);
    const inside = both * (within[k] / Math.max(within[k] + beyond[k], 1));
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
