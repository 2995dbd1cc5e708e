// The controls that need no picture: look, settings, comparison, statistics, saving.

import { brief } from "./spheres.js";
import { viridis } from "./tone.js";

const $ = (id) => document.getElementById(id);
const SETTINGS = ["photons_per_iteration", "initial_radius", "max_depth", "width", "height"];

// Exposure, tone curve and legend.
export function bindLook(viewer, changed) {
  const update = () => {
    const { look } = viewer;
    look.exposure = Number($("exposure").value);
    [look.tone, look.white] = [$("tone").value, Math.max(Number($("white").value), 0.01) || 4];
    $("exposure-out").textContent = `${look.exposure > 0 ? "+" : ""}${look.exposure} stops`;
    $("white-row").hidden = look.tone !== "reinhard";
    viewer.measure();
    viewer.draw();
    changed();
  };
  for (const id of ["exposure", "white"]) $(id).oninput = update;
  $("tone").onchange = update;
  update();
  const scale = $("scale").getContext("2d");
  for (let x = 0; x < 128; x++) {
    scale.fillStyle = `rgb(${viridis(x / 127).map((v) => Math.round(255 * v)).join(" ")})`;
    scale.fillRect(x, 0, 1, 8);
  }
  return update;
}

export function showLegend(viewer) {
  $("legend").hidden = !viewer.isFalse;
  [$("low").textContent, $("high").textContent] = viewer.look.range.map(brief);
}

// The settings, method and engine.
export function bindSettings(send) {
  for (const id of SETTINGS) {
    $(id).onchange = () => $(id).value !== "" && send({ type: "settings", [id]: Number($(id).value) });
  }
  $("seed").onchange = () => send({ type: "settings", seed: $("seed").value.trim() });
  const engine = () => send({ type: "engine", method: $("method").value, engine: $("engine").value });
  [$("method").onchange, $("engine").onchange] = [engine, engine];
}

export function showSettings({ settings, method, engine, can_undo, can_redo, changed, paused }) {
  for (const id of SETTINGS) $(id).value = id === "initial_radius" ? brief(settings[id]) : settings[id];
  [$("seed").value, $("method").value, $("engine").value] = [settings.seed, method, engine];
  [$("undo").disabled, $("redo").disabled, $("reset").disabled] = [!can_undo, !can_redo, !changed];
  $("pause").setAttribute("aria-pressed", String(paused));
  $("pause").textContent = paused ? "Go on" : "Pause";
}

const grouped = (n) => Math.round(n).toLocaleString("en").replaceAll(",", "\u202f");
const percent = (v) => (v == null ? "–" : `${(100 * v).toPrecision(2)} %`);

function timed(seconds) {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const minutes = Math.floor(seconds / 60);
  return minutes < 60 ? `${minutes} min ${Math.floor(seconds % 60)} s` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

// Progress in the header and in the panel.
export function showStatus(status, picture, setup) {
  if (status.preview) return;
  const { iterations, limit, seconds, photons, camera_segments, mean_radius, error, waiting, curve, workers } = status;
  const rate = seconds > 0 ? (photons || camera_segments) / seconds : 0;
  const of = limit ? ` of ${grouped(limit)}` : "";
  const state = waiting ? (setup && !(limit && iterations >= limit) ? " · paused" : " · done") : "";
  const noise = error == null ? "" : ` · error about ${percent(error)}`;
  $("progress").textContent = `${grouped(iterations)}${of} iterations · ${timed(seconds)}${noise}${state}`;
  const rows = [
    ["Iterations", `${grouped(iterations)}${of}`],
    ...(workers == null ? [] : [["Workers", grouped(workers)]]),
    ["Time", timed(seconds)],
    [photons ? "Photons" : "Path segments", grouped(photons || camera_segments)],
    [photons ? "Photons per second" : "Segments per second", grouped(rate)],
    ["Mean radius", mean_radius == null ? "–" : brief(mean_radius)],
    ["Estimated error", percent(error)],
    ["Size", picture ? `${picture.wholeWidth} × ${picture.wholeHeight}` : "–"],
  ];
  $("numbers").replaceChildren(...rows.flatMap(([name, value]) => [element("dt", name), element("dd", value)]));
  $("curve-box").hidden = curve.length < 2;
  if (curve.length >= 2) drawCurve($("curve"), curve);
}

function element(kind, text) {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
}

function drawCurve(canvas, points) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((v) => Math.round(v * devicePixelRatio));
  if (!width) return;
  [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  const all = points.filter(([, error]) => error > 0).map(([n, error]) => [Math.log10(n), Math.log10(error)]);
  const [xs, ys] = [0, 1].map((i) => all.map((point) => point[i]));
  const [x0, x1] = [Math.min(...xs), Math.max(...xs, Math.min(...xs) + 0.3)];
  const [y0, y1] = [Math.floor(Math.min(...ys)), Math.ceil(Math.max(...ys) + 1e-9)];
  const size = 10 * devicePixelRatio;
  const left = 3.6 * size;
  const place = ([x, y]) => [left + ((x - x0) / (x1 - x0)) * (width - left - 2), (1 - (y - y0) / Math.max(y1 - y0, 1)) * (height - 1.4 * size) + 0.7 * size];
  [context.font, context.textAlign, context.textBaseline] = [`${size}px ${style.fontFamily}`, "right", "middle"];
  for (let y = y0; y <= y1; y++) {
    const [, at] = place([x0, y]);
    [context.strokeStyle, context.fillStyle] = [style.getPropertyValue("--line"), style.getPropertyValue("--quiet")];
    context.beginPath();
    context.moveTo(left, at);
    context.lineTo(width, at);
    context.stroke();
    context.fillText(`${Number((100 * 10 ** y).toPrecision(1))} %`, left - 0.4 * size, at);
  }
  [context.strokeStyle, context.lineWidth] = [style.getPropertyValue("--accent"), 2 * devicePixelRatio];
  context.beginPath();
  for (const point of all) context.lineTo(...place(point));
  context.stroke();
}

// The dialogue that saves: it keeps the image as it is when it opens.
export function bindSave(connection, viewer) {
  const box = $("save-box");
  const open = async () => {
    $("save-what").textContent = "Finishing an iteration…";
    $("save-links").hidden = true;
    box.showModal();
    const kept = await connection.ask({ type: "keep" });
    if (kept.type !== "kept") return;
    const { exposure, tone, white } = viewer.look;
    const look = new URLSearchParams({ exposure, tone: tone === "false" ? "agx" : tone, white });
    $("save-what").textContent = `The image after ${grouped(kept.iterations)} iterations.`;
    for (const link of $("save-links").querySelectorAll("a")) {
      const { file } = link.dataset;
      link.href = `save/${kept.number}/${file}${file === "image.png" ? `?${look}` : ""}`;
      link.download = `${kept.stem}.${file.split(".")[1]}`;
    }
    $("save-links").hidden = false;
  };
  $("save").onclick = open;
  return open;
}
