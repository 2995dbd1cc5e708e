// Moves of the camera. Vectors are arrays of three numbers; a camera is as the server sends it.

export const add = (a, b) => a.map((v, i) => v + b[i]);
export const minus = (a, b) => a.map((v, i) => v - b[i]);
export const scaled = (a, s) => a.map((v) => v * s);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a) => Math.sqrt(dot(a, a));
export const unit = (a) => scaled(a, 1 / length(a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// `v` turned by `angle` around the unit vector `axis` (Rodrigues).
function turned(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scaled(v, c), scaled(cross(axis, v), s)), scaled(axis, dot(axis, v) * (1 - c)));
}

export function frame(camera) {
  const forward = unit(camera.direction);
  const right = unit(cross(forward, unit(camera.up)));
  return { forward, right, up: cross(right, forward) };
}

// Turns the camera around `pivot`, by angles to the right and up.
export function orbited(camera, pivot, yaw, pitch) {
  const axis = unit(camera.up);
  const { forward, right } = frame(camera);
  // Straight up and down are out of reach, as the picture would flip there.
  const slope = Math.asin(Math.min(Math.max(dot(forward, axis), -1), 1));
  const limit = 1.5;
  const bounded = Math.min(Math.max(slope - pitch, -limit), limit);
  const tilt = Math.abs(slope) > limit ? 0 : bounded - slope;
  const turn = (v) => turned(turned(v, right, tilt), axis, -yaw);
  return { ...camera, eye: add(pivot, turn(minus(camera.eye, pivot))), direction: turn(unit(camera.direction)) };
}

// Moves the camera sideways, in scene units.
export function panned(camera, across, along) {
  const { right, up } = frame(camera);
  return { ...camera, eye: add(camera.eye, add(scaled(right, across), scaled(up, along))) };
}

// Moves the camera forward, in scene units.
export function dollied(camera, way) {
  return { ...camera, eye: add(camera.eye, scaled(frame(camera).forward, way)) };
}

const slope = (camera) => Math.tan((camera.vertical_fov_degrees * Math.PI) / 360);

// The height of what is seen at this distance along the viewing direction.
export const heightAt = (camera, depth) => 2 * depth * slope(camera);

export const depthOf = (camera, point) => dot(minus(point, camera.eye), frame(camera).forward);

// Where a sphere is seen: its centre from 0 to 1, and its radius over the image's height; null behind the camera.
export function project(camera, aspect, center, radius) {
  const { forward, right, up } = frame(camera);
  const way = minus(center, camera.eye);
  const [depth, distance] = [dot(way, forward), length(way)];
  if (depth <= 0 || distance <= radius) return null;
  const [half, sine] = [slope(camera), radius / distance];
  return {
    x: 0.5 + dot(way, right) / (2 * depth * half * aspect),
    y: 0.5 - dot(way, up) / (2 * depth * half),
    radius: (sine / Math.sqrt(1 - sine * sine)) * (distance / depth) / (2 * half),
  };
}

// A point to turn around: the middle of the balls before the camera, or a point ahead where there are none.
export function middle(camera, spheres) {
  const { forward } = frame(camera);
  const isBall = ({ center, radius }) => {
    const way = minus(center, camera.eye);
    return dot(way, forward) > 0 && length(way) > radius && radius < 0.5 * length(way);
  };
  const balls = spheres.filter(isBall).map(({ center }) => center);
  if (balls.length === 0) return add(camera.eye, scaled(forward, camera.focus_distance));
  return scaled(balls.reduce(add), 1 / balls.length);
}
