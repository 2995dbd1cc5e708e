// Draws pictures on a plain canvas, where there is no WebGL.

import { encode, luminance, shown, viridis } from "./tone.js";

// More pixels than this are thinned out.
const MOST_PIXELS = 1 << 20;
// Codes of light in so many steps; the step between two of them is hidden by rounding.
const STEPS = 4096;
const CODES = Uint8ClampedArray.from({ length: STEPS + 1 }, (_, i) => Math.round(255 * encode((i / STEPS) ** 2)));
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
    const colour = painter(a.isPlane, look);
    const mode = b ? look.mode : 0;
    let to = 0;
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++, to += 4) {
        const [u, v] = [(x * thin + 0.5) / a.width, (y * thin + 0.5) / a.height];
        const isB = mode === 3 || (mode === 1 && u > look.split);
        const ofB = mode === 0 ? null : b.sample(Math.min(u, 0.999999), Math.min(v, 0.999999)).rgb;
        const ofA = a.at(Math.min(y * thin, a.height - 1) * a.width + Math.min(x * thin, a.width - 1));
        const rgb = mode === 2 ? difference(ofA, ofB, look) : colour(isB ? ofB : ofA);
        [image.data[to], image.data[to + 1], image.data[to + 2], image.data[to + 3]] = [rgb[0], rgb[1], rgb[2], 255];
      }
    }
    context.putImageData(image, 0, 0);
  }
}

const code = (v) => CODES[Math.round(Math.sqrt(v) * STEPS)];
const coloured = (t) => COLOURS[Math.round(255 * Math.min(Math.max(t, 0), 1)) || 0];

function difference(a, b, look) {
  const most = Math.max(...a.map((v, i) => Math.abs(v - b[i])));
  return coloured(most / Math.max(look.range[1], 1e-30));
}

// The function from radiance to codes.
function painter(isPlane, look) {
  const [low, high] = look.range;
  if (isPlane) return ([v]) => coloured((v - low) / Math.max(high - low, 1e-30));
  if (look.tone === "false") {
    const [from, to] = [low, high].map((v) => Math.log2(Math.max(v, 1e-30)));
    return (rgb) => coloured((Math.log2(Math.max(luminance(...rgb), 1e-30)) - from) / Math.max(to - from, 1e-6));
  }
  const gain = 2 ** look.exposure;
  return (rgb) => shown(look.tone, rgb.map((v) => v * gain), look.white).map(code);
}
