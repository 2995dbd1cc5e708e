// The picture on the screen: where it lies, how large, what it is compared with.

import { CanvasPainter } from "./canvas.js";
import { GlPainter } from "./gl.js";
import { luminance } from "./tone.js";

export const MODES = { split: 1, difference: 2, b: 3 };
const LARGEST_PIXEL = 64;

export class Viewer {
  constructor(stage, canvas) {
    [this.stage, this.canvas] = [stage, canvas];
    this.painter = painterOn(canvas);
    this.canvas = this.painter.canvas;
    [this.a, this.b] = [null, null];
    this.look = { exposure: 0, tone: "agx", white: 4, split: 0.5, mode: 0, range: [0, 1] };
    // Pixels of the screen per pixel of the image, and the image's point in the middle of the stage; fitted if null.
    this.zoom = null;
    this.onchange = () => {};
    new ResizeObserver(() => this.draw()).observe(stage);
  }

  get usesGl() {
    return this.painter instanceof GlPainter;
  }

  show(picture) {
    this.a = picture;
    this.measure();
    this.draw();
  }

  compare(picture, mode) {
    this.b = picture;
    this.look.mode = picture ? MODES[mode] : 0;
    this.measure();
    this.draw();
  }

  // Finds the range of values that false colours span.
  measure() {
    if (!this.a) return;
    if (this.b && this.look.mode === 2) {
      const at = (i) => this.b.sample(((i % this.a.width) + 0.5) / this.a.width, (Math.floor(i / this.a.width) + 0.5) / this.a.height).rgb;
      const [, high] = this.a.range((rgb, i) => Math.max(...at(i).map((v, c) => Math.abs(v - rgb[c]))));
      this.look.range = [0, high || 1e-6];
    } else if (this.a.isPlane) {
      this.look.range = this.a.range(([v]) => v);
    } else if (this.look.tone === "false") {
      const [low, high] = this.a.range((rgb) => luminance(...rgb));
      this.look.range = [Math.max(low, high * 1e-4, 1e-30), Math.max(high, 1e-29)];
    }
  }

  // Whether colours stand for numbers.
  get isFalse() {
    return Boolean(this.a && (this.a.isPlane || this.look.tone === "false" || (this.b && this.look.mode === 2)));
  }

  get size() {
    return this.a ? [this.a.wholeWidth, this.a.wholeHeight] : [1, 1];
  }

  get aspect() {
    return this.size[0] / this.size[1];
  }

  // Where the image lies, in pixels of the screen.
  box() {
    const [across, down] = [this.canvas.width, this.canvas.height];
    const [width, height] = this.size;
    const fitted = Math.min(across / width, down / height);
    const { scale, x, y } = this.zoom ?? { scale: fitted, x: 0.5, y: 0.5 };
    const box = { width: width * scale, height: height * scale, scale };
    return { ...box, x: Math.round(across / 2 - x * box.width), y: Math.round(down / 2 - y * box.height) };
  }

  // The place in the image of a pointer: 0 to 1 inside of it.
  at(event) {
    const rect = this.canvas.getBoundingClientRect();
    const ratio = this.canvas.width / rect.width;
    const box = this.box();
    return [((event.clientX - rect.left) * ratio - box.x) / box.width, ((event.clientY - rect.top) * ratio - box.y) / box.height];
  }

  // The height of the image on the screen, in CSS pixels.
  get shownHeight() {
    return this.box().height / this.ratio;
  }

  get ratio() {
    return this.canvas.width / Math.max(this.canvas.clientWidth, 1);
  }

  // Zooms so that `place` of the image stays where it is.
  zoomBy(factor, place = [0.5, 0.5]) {
    const box = this.box();
    const scale = Math.min(Math.max(box.scale * factor, 0.02), LARGEST_PIXEL);
    const centre = this.zoom ?? { x: 0.5, y: 0.5 };
    const keep = (at, middle) => at + (middle - at) * (box.scale / scale);
    this.zoom = { scale, x: keep(place[0], centre.x), y: keep(place[1], centre.y) };
    this.draw();
  }

  zoomTo(scale) {
    this.zoom = scale === null ? null : { scale, x: 0.5, y: 0.5 };
    this.draw();
  }

  // Moves the image by CSS pixels.
  slide(x, y) {
    const box = this.box();
    const { scale } = box;
    const centre = this.zoom ?? { x: 0.5, y: 0.5 };
    this.zoom = { scale, x: centre.x - (x * this.ratio) / box.width, y: centre.y - (y * this.ratio) / box.height };
    this.draw();
  }

  draw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      const { clientWidth, clientHeight } = this.stage;
      const [width, height] = [clientWidth, clientHeight].map((v) => Math.max(1, Math.round(v * devicePixelRatio)));
      if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
      this.painter.draw(this.a, this.b, this.box(), this.look);
      this.onchange();
    });
  }
}

// WebGL where there is a graphics card; `?canvas` in the address does without, and `?webgl` does without the card.
function painterOn(canvas) {
  const asked = new URLSearchParams(location.search);
  const wantsCanvas = asked.has("canvas");
  try {
    const painter = wantsCanvas ? null : GlPainter.on(canvas, asked.has("webgl"));
    if (painter) return painter;
  } catch (error) {
    console.warn(`WebGL is not used: ${error.message}`);
    // A canvas that had another context gives no plain one.
    const other = canvas.cloneNode();
    canvas.replaceWith(other);
    return CanvasPainter.on(other);
  }
  return CanvasPainter.on(canvas);
}
