// Draws pictures by WebGL2, which reads RGB9E5 as it is.

import { CURVES, GLSL } from "./tone.js";

const VERTEX = `#version 300 es
uniform vec4 place; // left, bottom, right, top, in the units of the canvas from -1 to 1
out vec2 at;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  at = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(mix(place.xy, place.zw, corner), 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D a, b;
uniform vec2 scales;   // of a and b
uniform float gain, white, split;
uniform int curve, mode; // mode: 0 a alone, 1 slider, 2 difference, 3 b alone
uniform vec2 range;
uniform bool isPlane;
in vec2 at;
out vec4 colour;
${GLSL}
void main() {
  vec3 ofA = texture(a, at).rgb * scales.x, ofB = texture(b, at).rgb * scales.y;
  if (mode == 2) {
    vec3 d = abs(ofA - ofB);
    float most = max(d.r, max(d.g, d.b));
    colour = vec4(viridis(most / max(range.y, 1e-30)), 1.0);
    return;
  }
  vec3 light = mode == 3 || (mode == 1 && at.x > split) ? ofB : ofA;
  if (isPlane) {
    colour = vec4(viridis((light.r - range.x) / max(range.y - range.x, 1e-30)), 1.0);
  } else if (curve == 4) {
    float y = log2(max(luminance(light), 1e-30)), low = log2(max(range.x, 1e-30)), high = log2(max(range.y, 1e-30));
    colour = vec4(viridis((y - low) / max(high - low, 1e-6)), 1.0);
  } else {
    colour = vec4(encode(tone(curve, light * gain, white)), 1.0);
  }
}`;

export class GlPainter {
  // A painter on `canvas`; null without WebGL2. Without a graphics card it is slower than a plain canvas, and takes processor
  // time that the render needs: then it is used only if it `isWanted`.
  static on(canvas, isWanted) {
    const gl = canvas.getContext("webgl2", { antialias: false, failIfMajorPerformanceCaveat: !isWanted });
    return gl ? new GlPainter(gl) : null;
  }

  constructor(gl) {
    this.canvas = gl.canvas;
    this.gl = gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "no shaders");
    gl.useProgram(program);
    gl.bindVertexArray(gl.createVertexArray());
    this.place = (name) => gl.getUniformLocation(program, name);
    this.textures = [gl.createTexture(), gl.createTexture()];
    this.loaded = [null, null];
    gl.uniform1i(this.place("a"), 0);
    gl.uniform1i(this.place("b"), 1);
  }

  load(unit, picture) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[unit]);
    if (this.loaded[unit] === picture || !picture) return;
    this.loaded[unit] = picture;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB9_E5, picture.width, picture.height, 0, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, picture.words);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  }

  // Draws `a`, and `b` if there is one, into the rectangle `box` of the canvas, in its pixels.
  draw(a, b, box, look) {
    const gl = this.gl;
    const { width, height } = gl.canvas;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (!a) return;
    [a, b ?? a].forEach((picture, unit) => {
      this.load(unit, picture);
      const isBlown = box.width >= 3 * picture.width && !picture.reduced;
      const filter = isBlown ? gl.NEAREST : gl.LINEAR;
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    });
    const [left, right] = [box.x, box.x + box.width].map((x) => (2 * x) / width - 1);
    const [top, bottom] = [box.y, box.y + box.height].map((y) => 1 - (2 * y) / height);
    gl.uniform4f(this.place("place"), left, bottom, right, top);
    gl.uniform2f(this.place("scales"), a.scale, (b ?? a).scale);
    gl.uniform1f(this.place("gain"), 2 ** look.exposure);
    gl.uniform1f(this.place("white"), look.white);
    gl.uniform1f(this.place("split"), look.split);
    gl.uniform1i(this.place("curve"), CURVES.indexOf(look.tone));
    gl.uniform1i(this.place("mode"), b ? look.mode : 0);
    gl.uniform2f(this.place("range"), ...look.range);
    gl.uniform1i(this.place("isPlane"), a.isPlane ? 1 : 0);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
}
