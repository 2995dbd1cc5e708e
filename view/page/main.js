// The page: joins the connection, the picture and the controls.

import { depthOf, dollied, frame, heightAt, length, middle, minus, orbited, panned, project, add, scaled } from "./camera.js";
import { bindLook, bindSave, bindSettings, showLegend, showSettings, showStatus } from "./panel.js";
import { Picture } from "./picture.js";
import { Connection } from "./socket.js";
import { Spheres, brief } from "./spheres.js";
import { Viewer } from "./viewer.js";

const $ = (id) => document.getElementById(id);
const stage = $("stage");
// A press that moves less than this, in CSS pixels, is a click.
const CLICK = 4;
// After this time without a key or a turn of the wheel the camera rests.
const REST = 180;

const viewer = new Viewer(stage, $("picture"));
let [scene, setup, camera, status] = [null, null, null, null];
let [isDragging, isFocusing, restTimer, sendsCamera] = [false, false, 0, false];
const pins = [];

const connection = new Connection({
  up() {
    $("notice").hidden = true;
    if (Number($("layer").value)) connection.send({ type: "layer", layer: Number($("layer").value) });
  },
  down() {
    const what = $("empty").hidden ? "The picture stays; trying to reach it again…" : "Trying to reach it again…";
    notice(`The program has ended, or cannot be reached. ${what}`, 0);
  },
  picture(picture) {
    $("empty").hidden = true;
    const isOlder = viewer.a && picture.version < viewer.a.version && picture.number < viewer.a.number;
    if (!isOlder) viewer.show(picture);
    window.dispatchEvent(new CustomEvent("picture", { detail: picture }));
  },
  scene(message) {
    scene = message;
    document.body.classList.toggle("studio", scene.mode === "studio");
    $("statistics").hidden = scene.mode === "files";
    if (scene.mode === "files") $("hint").hidden = true;
    $("title").textContent = scene.name;
    document.title = `${scene.name} – sppm`;
    const layer = $("layer").value;
    $("layer").replaceChildren(...scene.layers.map((name, i) => new Option(name, i)));
    $("layer").value = layer && layer < scene.layers.length ? layer : "0";
    $("layer-row").hidden = scene.layers.length < 2;
    if (scene.spheres) spheres.read(scene);
    listOthers();
  },
  setup(message) {
    setup = message;
    if (!isDragging) camera = structuredClone(setup.camera);
    showSettings(setup);
    showCamera();
    drawRing();
  },
  status(message) {
    status = message;
    showStatus(status, viewer.a, setup);
  },
  problem: ({ problem }) => notice(problem),
  refused: ({ problem }) => notice(problem),
});
const send = (message) => connection.send(message);

const spheres = new Spheres(send, (message) => connection.ask(message), () => drawRing());
const updateLook = bindLook(viewer, () => showLegend(viewer));
bindSettings(send);
const openSave = bindSave(connection, viewer);

let noticeTimer = 0;
function notice(text, time = 5000) {
  clearTimeout(noticeTimer);
  [$("notice").textContent, $("notice").hidden] = [text[0].toUpperCase() + text.slice(1), false];
  if (time) noticeTimer = setTimeout(() => ($("notice").hidden = true), time);
}

// The camera

// Sends the camera, at most once per frame of the screen.
function move(next, moving) {
  camera = next;
  drawRing();
  clearTimeout(restTimer);
  if (moving === "keys") restTimer = setTimeout(() => flush(false), REST);
  if (moving) {
    if (sendsCamera) return;
    sendsCamera = true;
    requestAnimationFrame(() => sendsCamera && flush(true));
  } else {
    flush(false);
  }
}

function flush(moving) {
  sendsCamera = false;
  showCamera();
  connection.ask({ type: "camera", camera, moving }).then(({ version }) =>
    window.dispatchEvent(new CustomEvent("taken", { detail: { version, moving } })));
}

const pivot = () => spheres.sphere && isMovable(spheres.sphere) ? spheres.sphere.center : middle(camera, spheres.all);
const reach = () => Math.max(Math.abs(depthOf(camera, pivot())), 1e-6);

function showCamera() {
  if (!camera) return;
  const set = (id, value) => document.activeElement !== $(id) && ($(id).value = value);
  set("fov", camera.vertical_fov_degrees);
  $("fov-out").textContent = `${brief(camera.vertical_fov_degrees)}°`;
  set("lens", lensPlace(camera.aperture_radius));
  $("lens-out").textContent = camera.aperture_radius === 0 ? "0, all sharp" : brief(camera.aperture_radius);
  set("focus", brief(camera.focus_distance));
}

// The lens slider spans up to a tenth of the distance to what is seen, by squares.
const lensMost = () => 0.1 * reach();
const lensPlace = (radius) => Math.sqrt(Math.min(radius / lensMost(), 1));
const bindCamera = (id, parts) => {
  $(id).oninput = () => move({ ...camera, ...parts(Number($(id).value)) }, true);
  $(id).onchange = () => move({ ...camera, ...parts(Number($(id).value)) }, false);
};
bindCamera("fov", (vertical_fov_degrees) => ({ vertical_fov_degrees }));
bindCamera("lens", (place) => ({ aperture_radius: place * place * lensMost() }));
$("focus").onchange = () => Number($("focus").value) > 0 && move({ ...camera, focus_distance: Number($("focus").value) }, false);
$("focus-pick").onclick = () => setFocusing(!isFocusing);

function setFocusing(on) {
  isFocusing = on;
  stage.classList.toggle("focusing", on);
  $("focus-pick").setAttribute("aria-pressed", String(on));
}

// Balls

// Whether a ball can be dragged: those around the camera, such as walls, cannot.
const isMovable = ({ center, radius }) => length(minus(center, camera.eye)) > radius && radius < 0.5 * length(minus(center, camera.eye));

function isOverChosen(place) {
  const sphere = spheres.sphere;
  if (!sphere || !camera || !isMovable(sphere)) return false;
  const seen = project(camera, viewer.aspect, sphere.center, sphere.radius);
  return Boolean(seen) && Math.hypot((place[0] - seen.x) * viewer.aspect, place[1] - seen.y) <= seen.radius;
}

function drawRing() {
  const sphere = spheres?.sphere;
  const seen = sphere && camera && isMovable(sphere) ? project(camera, viewer.aspect, sphere.center, sphere.radius) : null;
  $("ring").toggleAttribute("hidden", !seen);
  $("ball-tip").hidden = !seen;
  if (!seen) return;
  const box = viewer.box();
  const [x, y, radius] = [box.x + seen.x * box.width, box.y + seen.y * box.height, seen.radius * box.height];
  for (const [name, value] of [["cx", x], ["cy", y], ["r", radius]]) $("ring").setAttribute(name, value / viewer.ratio);
}

async function choose(place) {
  const [x, y] = place;
  const { sphere, depth } = await connection.ask({ type: "pick", x, y });
  if (isFocusing) {
    setFocusing(false);
    if (depth) move({ ...camera, focus_distance: depth }, false);
    if (depth && camera.aperture_radius === 0) notice("The lens is a pinhole, so everything is sharp; make its radius larger to see the focus.");
  } else {
    spheres.choose(sphere ?? null);
    $("ball-box").open = true;
  }
}

// The pointer

const pointers = new Map();
let drag = null;

stage.addEventListener("contextmenu", (event) => event.preventDefault());
stage.addEventListener("pointerdown", (event) => {
  if (event.target.closest("button, #divider")) return;
  stage.focus({ preventScroll: true });
  pointers.set(event.pointerId, event);
  stage.setPointerCapture(event.pointerId);
  if (pointers.size > 1) return;
  const place = viewer.at(event);
  const isImage = event.button === 1 || event.altKey || scene?.mode !== "studio";
  const kind = isImage ? "image" : event.button === 2 || event.shiftKey ? "pan" : isOverChosen(place) ? "ball" : "orbit";
  drag = { kind, place, camera, pivot: camera && pivot(), x: event.clientX, y: event.clientY, moved: false, sphere: spheres.sphere };
});
stage.addEventListener("pointermove", (event) => {
  showValue(event);
  const before = pointers.get(event.pointerId);
  if (!before) return stage.classList.toggle("over-ball", isOverChosen(viewer.at(event)));
  pointers.set(event.pointerId, event);
  if (pointers.size === 2) return pinch(event, before);
  if (!drag) return;
  const [x, y] = [event.clientX - drag.x, event.clientY - drag.y];
  if (!drag.moved && Math.hypot(x, y) < CLICK) return;
  drag.moved = true;
  stage.classList.add("turning");
  $("hint").classList.add("gone");
  isDragging = drag.kind !== "image";
  const height = viewer.shownHeight;
  if (drag.kind === "image") viewer.slide(event.clientX - before.clientX, event.clientY - before.clientY);
  else if (drag.kind === "orbit") move(orbited(drag.camera, drag.pivot, (x / height) * 3, (y / height) * 3), true);
  else if (drag.kind === "pan") {
    const unit = heightAt(drag.camera, reach()) / height;
    move(panned(drag.camera, -x * unit, y * unit), true);
  } else moveBall(x, y, true);
});
for (const end of ["pointerup", "pointercancel"]) {
  stage.addEventListener(end, (event) => {
    if (!pointers.delete(event.pointerId)) return;
    stage.classList.remove("turning");
    if (!drag || pointers.size > 0) return;
    const { kind, moved, place } = drag;
    isDragging = false;
    if (!moved && event.button === 0 && scene?.mode === "studio") choose(place);
    else if (moved && (kind === "orbit" || kind === "pan")) move(camera, false);
    else if (moved && kind === "ball") moveBall(event.clientX - drag.x, event.clientY - drag.y, false);
    drag = null;
  });
}
stage.addEventListener("pointerleave", () => ($("value").textContent = ""));

// Moves the chosen ball in the plane of the picture.
function moveBall(x, y, moving) {
  const { sphere } = drag;
  const unit = heightAt(camera, depthOf(camera, sphere.center)) / viewer.shownHeight;
  const { right, up } = frame(camera);
  const center = add(sphere.center, add(scaled(right, x * unit), scaled(up, -y * unit)));
  if (spheres.sphere) spheres.sphere.center = center;
  drawRing();
  spheres.change({ center }, moving);
}

// Two fingers: closer and farther.
function pinch(event, before) {
  const other = [...pointers.values()].find(({ pointerId }) => pointerId !== event.pointerId);
  const apart = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
  const factor = apart(event) / Math.max(apart(before), 1);
  drag = null;
  if (scene?.mode === "studio") approach(1 - 1 / factor);
  else viewer.zoomBy(factor, viewer.at(event));
}

const approach = (share) => camera && move(dollied(camera, share * reach()), "keys");

stage.addEventListener("wheel", (event) => {
  event.preventDefault();
  const turns = -event.deltaY / (event.deltaMode === 1 ? 3 : 120);
  if (event.ctrlKey || scene?.mode !== "studio") viewer.zoomBy(1.2 ** turns, viewer.at(event));
  else approach(1 - 0.9 ** turns);
}, { passive: false });

function showValue(event) {
  const [x, y] = viewer.at(event);
  const found = viewer.a?.sample(x, y);
  if (!found) return ($("value").textContent = "");
  const [wide, high] = viewer.size;
  const values = viewer.a.isPlane ? brief(found.rgb[0]) : found.rgb.map((v) => v.toPrecision(3)).join("  ");
  const other = viewer.b?.sample(x, y);
  const beside = other ? `  |  ${other.rgb.map((v) => v.toPrecision(3)).join("  ")}` : "";
  $("value").textContent = `${Math.floor(x * wide)}, ${Math.floor(y * high)}:  ${values}${beside}`;
}

// Keys

const TURN = 0.06;
const STEP = 0.04;
const keys = {
  ArrowLeft: () => turn(-TURN, 0), ArrowRight: () => turn(TURN, 0), ArrowUp: () => turn(0, -TURN), ArrowDown: () => turn(0, TURN),
  PageUp: () => approach(0.06), PageDown: () => approach(-0.06),
};
const turn = (yaw, pitch) => move(orbited(camera, pivot(), yaw, pitch), "keys");
const shift = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const anywhere = {
  "+": () => viewer.zoomBy(1.25), "=": () => viewer.zoomBy(1.25), "-": () => viewer.zoomBy(0.8),
  0: () => viewer.zoomTo(null), 1: () => viewer.zoomTo(1), "[": () => expose(-0.5), "]": () => expose(0.5), "?": () => $("help-box").showModal(),
  c: () => pin(), p: () => $("pause").click(), s: () => openSave(), f: () => setFocusing(!isFocusing), Escape: () => setFocusing(false),
};

addEventListener("keydown", (event) => {
  if (event.target.matches("input, select") || document.querySelector("dialog[open]")) return;
  const isStudio = scene?.mode === "studio" && camera;
  if (event.ctrlKey || event.metaKey) {
    if (!isStudio || event.key.toLowerCase() !== "z") return;
    event.preventDefault();
    return send({ type: event.shiftKey ? "redo" : "undo" });
  }
  const isMove = document.activeElement === stage && isStudio;
  const along = event.shiftKey && shift[event.key];
  if (isMove && along) {
    const unit = STEP * heightAt(camera, reach());
    move(panned(camera, along[0] * unit, along[1] * unit), "keys");
  } else if (isMove && keys[event.key]) keys[event.key]();
  else if (anywhere[event.key] && (isStudio || !"psf".includes(event.key))) anywhere[event.key]();
  else return;
  event.preventDefault();
});

function expose(stops) {
  $("exposure").value = Number($("exposure").value) + stops;
  updateLook();
}

// Comparing

function listOthers() {
  const now = $("other").value;
  const others = scene.others.map((name, i) => new Option(name, `other/${i}`));
  const pinned = pins.map(({ name }, i) => new Option(name, `pin/${i}`));
  $("other").replaceChildren(new Option("nothing", ""), ...others, ...pinned);
  $("other").value = now;
  if (scene.mode === "files" && scene.others.length && !listOthers.isDone) {
    listOthers.isDone = true;
    [$("other").value, $("compare-box").open] = ["other/0", true];
    compare();
  }
}

const loaded = new Map();
async function load(name) {
  const [kind, number] = name.split("/");
  if (kind === "pin") return pins[number].picture;
  if (!loaded.has(name)) loaded.set(name, Picture.read(await (await fetch(name)).arrayBuffer()));
  return loaded.get(name);
}

async function compare() {
  const name = $("other").value;
  const picture = name ? await load(name) : null;
  const mode = $("mode").value;
  $("mode-row").hidden = !picture;
  viewer.compare(picture, mode);
  const isSplit = Boolean(picture) && mode === "split";
  for (const id of ["divider", "name-a", "name-b"]) $(id).hidden = !isSplit;
  [$("name-a").textContent, $("name-b").textContent] = [scene.name, $("other").selectedOptions[0]?.textContent ?? ""];
  placeDivider();
  showLegend(viewer);
}
[$("other").onchange, $("mode").onchange] = [compare, compare];

// The slider spans the stage; the picture is divided where it stands.
function placeDivider() {
  const box = viewer.box();
  const thumb = 26 * viewer.ratio;
  const at = thumb / 2 + Number($("divider").value) * (viewer.canvas.width - thumb);
  viewer.look.split = (at - box.x) / box.width;
}
$("divider").oninput = () => {
  placeDivider();
  viewer.draw();
};

function pin() {
  if (!viewer.a) return;
  const what = setup ? `${{ path: "path tracing", hybrid: "paths and caustics" }[setup.method] ?? setup.engine}, ` : "";
  pins.push({ name: `pinned: ${what}${viewer.a.iterations} iterations`, picture: viewer.a });
  if (pins.length > 8) pins.shift();
  listOthers();
  [$("other").value, $("compare-box").open] = [`pin/${pins.length - 1}`, true];
  compare();
}
$("pin").onclick = pin;

// Buttons

$("layer").onchange = () => send({ type: "layer", layer: Number($("layer").value) });
$("undo").onclick = () => send({ type: "undo" });
$("redo").onclick = () => send({ type: "redo" });
$("reset").onclick = () => send({ type: "reset" });
$("pause").onclick = () => send({ type: "pause", paused: !setup?.paused });
$("help").onclick = () => $("help-box").showModal();
$("zoom-in").onclick = () => viewer.zoomBy(1.5);
$("zoom-out").onclick = () => viewer.zoomBy(1 / 1.5);
$("zoom-fit").onclick = () => viewer.zoomTo(null);
$("zoom-one").onclick = () => viewer.zoomTo(1);

viewer.onchange = () => {
  if (!$("divider").hidden) placeDivider();
  showLegend(viewer);
  drawRing();
};
document.body.dataset.painter = viewer.usesGl ? "webgl" : "canvas";
if (matchMedia("(max-width: 720px)").matches) for (const box of document.querySelectorAll("#panel details")) box.open = false;
