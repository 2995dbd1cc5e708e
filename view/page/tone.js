// Tone curves, the same as those of PNG files (files/src/image_file/tone.rs), and false colours; in JavaScript, and in GLSL.

export const CURVES = ["clamp", "reinhard", "aces", "agx", "false"];

const TO_ACES = [0.59719, 0.35458, 0.04823, 0.076, 0.90834, 0.01566, 0.0284, 0.13383, 0.83777];
const FROM_ACES = [1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602];
const INSET = [
  0.842479062253094, 0.0784335999999992, 0.0792237451477643, 0.0423282422610123, 0.878468636469772,
  0.0791661274605434, 0.0423756549057051, 0.0784336, 0.879142973793104,
];
const OUTSET = [
  1.19687900512017, -0.0980208811401368, -0.0990297440797205, -0.0528968517574562, 1.15190312990417,
  -0.0989611768448433, -0.0529716355144438, -0.0980434501171241, 1.15107367264116,
];
const STOPS = [-12.47393, 4.026069];
const AGX_FIT = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
// Viridis by Smith and van der Walt, as fitted by a polynomial (Matt Zucker, CC0).
const VIRIDIS = [
  [0.2777273272234177, 0.005407344544966578, 0.3340998053353061],
  [0.1050930431085774, 1.404613529898575, 1.384590162594685],
  [-0.3308618287255563, 0.214847559468213, 0.09509516302823659],
  [-4.634230498983486, -5.799100973351585, -19.33244095627987],
  [6.228269936347081, 14.17993336680509, 56.69055260068105],
  [4.776384997670288, -13.74514537774601, -65.35303263337234],
  [-5.435455855934631, 4.645852612178535, 26.3124352495832],
];

const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
// Row `i` of a matrix, times a vector.
const row = (m, i, x, y, z) => m[3 * i] * x + m[3 * i + 1] * y + m[3 * i + 2] * z;

export const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

const acesFit = (v) => (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);

function agxFit(v) {
  const x = (clamp(Math.log2(v), STOPS[0], STOPS[1]) - STOPS[0]) / (STOPS[1] - STOPS[0]);
  let sum = 0;
  for (let i = 0; i < AGX_FIT.length; i++) sum = sum * x + AGX_FIT[i];
  return sum;
}

const ACES = { to: TO_ACES, from: FROM_ACES, fit: acesFit };
const AGX = { to: INSET, from: OUTSET, fit: agxFit };

// What a screen shows of linear radiance: linear light in [0, 1], in `out`; for AgX its root of order 2.2. This runs for each
// pixel, so it makes no arrays.
function signal(curve, r, g, b, white, out) {
  r = Math.max(r, 0);
  g = Math.max(g, 0);
  b = Math.max(b, 0);
  if (curve === "reinhard") {
    const y = luminance(r, g, b);
    const scale = (1 + y / (white * white)) / (1 + y);
    r *= scale;
    g *= scale;
    b *= scale;
  } else if (curve === "aces" || curve === "agx") {
    const { to, from, fit } = curve === "aces" ? ACES : AGX;
    const x = fit(row(to, 0, r, g, b)), y = fit(row(to, 1, r, g, b)), z = fit(row(to, 2, r, g, b));
    r = row(from, 0, x, y, z);
    g = row(from, 1, x, y, z);
    b = row(from, 2, x, y, z);
  }
  out[0] = clamp(r, 0, 1);
  out[1] = clamp(g, 0, 1);
  out[2] = clamp(b, 0, 1);
}

// The code of sRGB, from 0 to 1, of linear light.
export const encode = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
export const decode = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);

// The codes of signals, for `light` as the function from signal to light. A step hides less than half a code.
const STEPS = 4096;
const codesOf = (light) => Uint8Array.from({ length: STEPS + 1 }, (_, i) => Math.round(255 * encode(light((i / STEPS) ** 2))));
const CODES = codesOf((v) => v), AGX_CODES = codesOf((v) => v ** 2.2);

// The function that writes the codes of a pixel's radiance to `bytes`, from `to` on.
export function coder(curve, gain, white) {
  const codes = curve === "agx" ? AGX_CODES : CODES;
  const out = new Float64Array(3);
  return (r, g, b, bytes, to) => {
    signal(curve, r * gain, g * gain, b * gain, white, out);
    for (let c = 0; c < 3; c++) bytes[to + c] = codes[Math.round(Math.sqrt(out[c]) * STEPS)];
  };
}

// The colour, in codes of sRGB, for a place t in [0, 1].
export function viridis(t) {
  t = clamp(t, 0, 1);
  return [0, 1, 2].map((c) => clamp(VIRIDIS.reduceRight((sum, a) => sum * t + a[c], 0), 0, 1));
}

const glsl = (v) => v.toPrecision(9).includes(".") || v.toPrecision(9).includes("e") ? v.toPrecision(9) : v.toPrecision(9) + ".0";
const vec = (v) => `vec3(${v.map(glsl).join(", ")})`;
// Matrices of GLSL are given column by column.
const mat = (m) => `mat3(${[0, 3, 6, 1, 4, 7, 2, 5, 8].map((i) => glsl(m[i])).join(", ")})`;

export const GLSL = `
float luminance(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }

vec3 tone(int curve, vec3 light, float white) {
  light = max(light, 0.0);
  vec3 signal = light;
  if (curve == 1) {
    float y = luminance(light);
    signal = light * ((1.0 + y / (white * white)) / (1.0 + y));
  } else if (curve == 2) {
    vec3 v = ${mat(TO_ACES)} * light;
    signal = ${mat(FROM_ACES)} * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
  } else if (curve == 3) {
    vec3 v = ${mat(INSET)} * light;
    vec3 x = (clamp(log2(max(v, 1e-20)), ${glsl(STOPS[0])}, ${glsl(STOPS[1])}) - ${glsl(STOPS[0])}) / ${glsl(STOPS[1] - STOPS[0])};
    signal = ${mat(OUTSET)} * (${AGX_FIT.slice(1).reduce((sum, a) => `(${sum} * x + ${glsl(a)})`, `vec3(${glsl(AGX_FIT[0])})`)});
  }
  signal = clamp(signal, 0.0, 1.0);
  return curve == 3 ? pow(signal, vec3(2.2)) : signal;
}

vec3 encode(vec3 v) { return mix(1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, 12.92 * v, vec3(lessThanEqual(v, vec3(0.0031308)))); }

vec3 viridis(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(${VIRIDIS.slice(0, -1).reduceRight((sum, a) => `(${sum} * t + ${vec(a)})`, vec(VIRIDIS.at(-1)))}, 0.0, 1.0);
}
`;
