// The list of balls, and the form of the one that is chosen.
//
// Of many balls the first are listed; others are chosen by their number, or in the picture, and described when they are.
// Balls that share a material are of one style, which can be changed as a whole.

import { decode, encode } from "./tone.js";

const $ = (id) => document.getElementById(id);
// The slider of glow is logarithmic: 0, then from LEAST to MOST.
const LEAST = 0.01;
const MOST = 10000;
const glowOf = (place) => (place <= 0 ? 0 : LEAST * (MOST / LEAST) ** place);
const placeOf = (glow) => (glow <= 0 ? 0 : Math.min(Math.max(Math.log(glow / LEAST) / Math.log(MOST / LEAST), 0.005), 1));

export const brief = (v) => (Number.isFinite(v) ? String(Number(v.toPrecision(4))) : "–");

const hex = (rgb) => `#${rgb.map((v) => Math.round(255 * encode(Math.min(Math.max(v, 0), 1))).toString(16).padStart(2, "0")).join("")}`;
const light = (text) => [1, 3, 5].map((at) => decode(parseInt(text.slice(at, at + 2), 16) / 255));

const KINDS = { diffuse: "diffuse", specular: "mirror", dielectric: "glass" };

function title(sphere, index) {
  const kind = Math.max(...sphere.emission) > 0 ? "lamp" : KINDS[sphere.material.type];
  return sphere.name ? `${index + 1} · ${sphere.name}` : `${index + 1} · ${kind}, radius ${brief(sphere.radius)}`;
}

export class Spheres {
  // `send` sends a request, `ask` one that is answered; `chosen` is told of every choice.
  constructor(send, ask, chosen) {
    [this.send, this.ask, this.chosen] = [send, ask, chosen];
    [this.all, this.total, this.index, this.far, this.styles] = [[], 0, null, null, []];
    $("ball-number").onchange = () => {
      const number = Math.round(Number($("ball-number").value));
      if (number >= 1 && number <= this.total) this.choose(number - 1);
    };
    $("style").onchange = () => {
      const style = this.styles[$("style").value];
      $("styled").checked = Boolean(style);
      this.choose(style ? style.first : null);
    };
    $("ball").onchange = () => this.choose($("ball").value === "" ? null : Number($("ball").value));
    const material = (moving) => this.change({ material: this.material() }, moving);
    for (const id of ["material", "ior"]) $(id).onchange = () => material(false);
    this.live("albedo", material);
    const emission = (moving) => this.change({ emission: this.emission() }, moving);
    this.live("glow", emission);
    this.live("glow-colour", emission);
    const place = () => this.change({ center: ["x", "y", "z"].map((axis) => Number($(`ball-${axis}`).value)) });
    for (const axis of ["x", "y", "z"]) $(`ball-${axis}`).onchange = place;
    $("ball-r").onchange = () => this.change({ radius: Number($("ball-r").value) });
  }

  // Follows a control while it is dragged.
  live(id, change) {
    $(id).oninput = () => change(true);
    $(id).onchange = () => change(false);
  }

  get sphere() {
    return this.index === null ? null : (this.all[this.index] ?? this.far);
  }

  // The style of the chosen ball, if others share it.
  get style() {
    return this.styles.find(({ style }) => style === this.sphere?.style) ?? null;
  }

  read({ spheres, total, styles }) {
    [this.all, this.total, this.styles] = [spheres, total, styles];
    $("style-row").hidden = !styles.length;
    const titles = styles.map(({ count, material }) => `${count} balls · ${KINDS[material.type]} · ${hex(material.albedo)}`);
    $("style").replaceChildren(new Option("none", ""), ...titles.map((text, i) => new Option(text, i)));
    $("number-row").hidden = total <= spheres.length;
    $("ball-number").max = total;
    const options = spheres.map((sphere, i) => new Option(title(sphere, i), i));
    const rest = total > spheres.length ? [new Option(`… and ${total - spheres.length} more`, "", false, false)] : [];
    $("ball").replaceChildren(new Option("none", ""), ...options, ...rest);
    this.choose(this.sphere ? this.index : null, false);
  }

  choose(index, tells = true) {
    if (index !== this.index) this.far = null;
    this.index = index;
    if (index !== null && index >= this.all.length) this.describe(index);
    this.show();
    if (tells) this.chosen();
  }

  // Asks for a ball that is not in the list.
  async describe(index) {
    const { sphere } = await this.ask({ type: "describe", index });
    if (index !== this.index) return;
    this.far = sphere;
    this.show();
    this.chosen();
  }

  show() {
    const { sphere, style } = this;
    $("ball").value = sphere && this.index < this.all.length ? String(this.index) : "";
    if (document.activeElement !== $("ball-number")) $("ball-number").value = sphere ? this.index + 1 : "";
    $("ball-form").hidden = !sphere;
    $("no-ball").hidden = Boolean(sphere);
    $("style").value = style ? String(this.styles.indexOf(style)) : "";
    $("styled-row").hidden = !style;
    if (!style) $("styled").checked = false;
    else $("styled-text").textContent = `Change all ${style.count} balls of this style`;
    if (sphere) this.fill(sphere);
  }

  fill({ center, radius, material, emission }) {
    const set = (id, value) => {
      if (document.activeElement !== $(id) || $(id).type === "range") $(id).value = value;
    };
    set("material", material.type);
    if (document.activeElement !== $("albedo")) $("albedo").value = hex(material.albedo);
    $("ior-row").hidden = material.type !== "dielectric";
    set("ior", brief(material.ior ?? 1.5));
    const glow = Math.max(...emission);
    if (document.activeElement !== $("glow")) $("glow").value = placeOf(glow);
    $("glow-out").textContent = brief(glow);
    $("glow-row").hidden = glow === 0;
    if (document.activeElement !== $("glow-colour")) $("glow-colour").value = hex(glow > 0 ? emission.map((v) => v / glow) : [1, 1, 1]);
    ["x", "y", "z"].forEach((axis, i) => set(`ball-${axis}`, brief(center[i])));
    set("ball-r", brief(radius));
  }

  // The material that the form states. A colour that was not changed keeps its digits.
  material() {
    const type = $("material").value;
    const before = this.sphere.material;
    const albedo = $("albedo").value === hex(before.albedo) ? before.albedo : light($("albedo").value);
    return type === "dielectric" ? { type, albedo, ior: Number($("ior").value) || 1.5 } : { type, albedo };
  }

  emission() {
    const glow = glowOf(Number($("glow").value));
    $("glow-out").textContent = brief(glow);
    const before = this.sphere.emission;
    const most = Math.max(...before);
    // A colour that was not changed keeps its digits.
    const own = most > 0 ? before.map((v) => v / most) : [1, 1, 1];
    const colour = $("glow-colour").value === hex(own) ? own : light($("glow-colour").value);
    return colour.map((v) => v * glow);
  }

  change(parts, moving = false) {
    const styled = $("styled").checked && !parts.center;
    if (this.sphere) this.send({ type: "sphere", index: this.index, ...parts, styled, moving });
  }
}
