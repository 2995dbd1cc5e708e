// Draws pictures on a plain canvas, where there is no WebGL.

import { coder, luminance, viridis } from "./tone.js";
import { SCALES } from "./picture.js";

// More pixels than this are thinned out.
const MOST_PIXELS = 1 << 20;
const COLOURS = Array.from({ length: 256 }, (_, i) => viridis(i / 255).map((v) => Math.round(255 * v)));

export class CanvasPainter {
  static on(canvas) {
    const context = canvas.getContext("2d");
    return context ? new CanvasPainter(context) : null;
  }

  constructor(context) {
    this.canvas = context.canvas;
    this.context = context;
    this.sheet = document.createElement("canvas");
    this.key = null;
  }

  draw(a, b, box, look) {
    const { canvas } = this;
    this.context.clearRect(0, 0, canvas.width, canvas.height);
    if (!a) return;
    const key = [a, b, JSON.stringify(look)];
    if (!this.key || key.some((part, i) => part !== this.key[i])) {
      this.key = key;
      this.develop(a, b, look);
    }
    this.context.imageSmoothingEnabled = a.reduced || box.width < 3 * a.width;
    this.context.drawImage(this.sheet, box.x, box.y, box.width, box.height);
  }

  // Makes the codes of all pixels.
  develop(a, b, look) {
    const thin = Math.max(1, Math.ceil(Math.sqrt((a.width * a.height) / MOST_PIXELS)));
    const [width, height] = [Math.ceil(a.width / thin), Math.ceil(a.height / thin)];
    [this.sheet.width, this.sheet.height] = [width, height];
    const context = this.sheet.getContext("2d");
    const image = context.createImageData(width, height);
    const mode = b ? look.mode : 0;
    const write = mode === 2 ? null : writer(a.isPlane, look);
    const bytes = image.data;
    let to = 0;
    for (let y = 0; y < height; y++) {
      const rowOfA = Math.min(y * thin, a.height - 1) * a.width;
      const rowOfB = b ? place((y * thin + 0.5) / a.height, b.height) * b.width : 0;
      for (let x = 0; x < width; x++, to += 4) {
        const u = (x * thin + 0.5) / a.width;
        const [atA, atB] = [rowOfA + Math.min(x * thin, a.width - 1), b ? rowOfB + place(u, b.width) : 0];
        if (mode === 2) {
          difference(a.at(atA), b.at(atB), look, bytes, to);
        } else {
          const isB = mode === 3 || (mode === 1 && u > look.split);
          const { words, scale } = isB ? b : a;
          const word = words[isB ? atB : atA];
          const unit = SCALES[word >>> 27] * scale;
          write((word & 511) * unit, ((word >>> 9) & 511) * unit, ((word >>> 18) & 511) * unit, bytes, to);
        }
        bytes[to + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
  }
}

// The row or column of so many at a place from 0 to 1.
const place = (at, count) => Math.min(Math.floor(at * count), count - 1);

// Writes a colour for `t`, from 0 to 1.
function paint(t, bytes, to) {
  const colour = COLOURS[Math.round(255 * Math.min(Math.max(t, 0), 1)) || 0];
  for (let c = 0; c < 3; c++) bytes[to + c] = colour[c];
}

function difference(a, b, look, bytes, to) {
  const most = Math.max(...a.map((v, i) => Math.abs(v - b[i])));
  paint(most / Math.max(look.range[1], 1e-30), bytes, to);
}

// The function that writes the codes of a pixel's values to `bytes`, from `to` on.
function writer(isPlane, look) {
  const [low, high] = look.range;
  if (isPlane) return (v, _g, _b, bytes, to) => paint((v - low) / Math.max(high - low, 1e-30), bytes, to);
  if (look.tone === "false") {
    const [from, until] = [low, high].map((v) => Math.log2(Math.max(v, 1e-30)));
    const at = (y) => (Math.log2(Math.max(y, 1e-30)) - from) / Math.max(until - from, 1e-6);
    return (r, g, b, bytes, to) => paint(at(luminance(r, g, b)), bytes, to);
  }
  return coder(look.tone, 2 ** look.exposure, look.white);
}
