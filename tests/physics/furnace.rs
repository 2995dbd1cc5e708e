//! Furnace tests: closed scenes with a known radiance in closed form, rendered by photon mapping and by path tracing.
//!
//! On a sphere, the points within a distance R of one of its points form a cap with an area of exactly `pi R^2`. So
//! under uniform light, SPPM's density estimate has no bias from its area. It has a bias from its side test: a photon
//! that arrives at distance r at a grazing angle may come from below the horizon of the visible point. Under a uniform
//! sky this loses `r^2 / (4 b^2)` of the photons, where b is the radius of the sphere. On average over the cap it loses
//! `R^2 / (8 b^2)`.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_mean, coloured, diffuse, empty_scene, glass, mean, mirror, pinhole, relative_error,
    render_path, render_path_fast, render_photons, render_sppm, render_sppm_fast, settings,
};
use scene::{Film, Material, RadiusSchedule, Rgb, Scene, Settings, Vec3};

/// Relative tolerance of furnaces in general. The numbers of photons and samples are chosen to reach it.
const FURNACE: f64 = 1e-3;

/// Relative tolerance of furnaces without noise: about a hundred rounding errors of 2^-24, and flux quantised to 2^-22.
const ROUNDING: f64 = 1e-5;

/// [`FURNACE`] in standard errors, which sets the numbers of photons and samples.
const SIGMAS: f64 = 2.2;

/// Iterations of most furnaces: one with the initial radius and one with a smaller radius.
const ITERATIONS: u32 = 2;

const DEPTHS: [u32; 5] = [1, 2, 3, 5, 64];

/// Radius of the shell of all furnaces.
const SHELL: f32 = 3.0;

/// Initial search radius, at which the side test loses at most 0.05 % of the indirect light.
const RADIUS: f32 = 0.2;

/// The eye of most furnaces: close to the shell, with the opposite half of the shell in view.
const EYE: Vec3 = Vec3::new(0.0, 0.0, 2.9);
const FOV: f32 = 90.0;

/// Share of the shell in view, weighted by the number of pixels that see it.
const IN_VIEW: f64 = 0.4;

/// The sum of the first `terms` powers of `q`.
fn geometric(q: f64, terms: u32) -> f64 {
    (0..terms as i32).map(|k| q.powi(k)).sum()
}

/// The number of random walks for which [`FURNACE`] is [`SIGMAS`] standard errors of the image mean. A walk has at most
/// `depth - 1` steps, each of which survives with probability `q` and ends somewhere on the shell.
fn walks_for(q: f64, depth: u32) -> u32 {
    let survive = |k: i32| q.powi(k);
    let first: f64 = (1..depth as i32).map(survive).sum();
    let second: f64 = (1..depth as i32).map(|k| f64::from(2 * k - 1) * survive(k)).sum();
    let variance = (second - first * first).max(0.0) + first / IN_VIEW;
    let relative_variance = variance / (1.0 + first).powi(2);
    ((SIGMAS / FURNACE).powi(2) * relative_variance).max(20_000.0) as u32
}

/// Settings of SPPM with `walks` photons in total.
fn photons(walks: u32, depth: u32) -> Settings {
    Settings { iterations: ITERATIONS, ..settings(32, 32, walks / ITERATIONS, depth, RADIUS) }
}

/// Settings of the path tracer with about `walks` samples in total. It needs half as many as SPPM needs photons,
/// because paths start in view.
fn samples(walks: u32, depth: u32) -> Settings {
    let side = 64;
    Settings { iterations: walks.div_ceil(side * side), ..settings(side, side, 1, depth, 1.0) }
}

/// What a furnace looks like.
struct Rendered {
    film: Film,
    /// By what, in words.
    by: String,
    by_photons: bool,
    /// What [`FURNACE`] is multiplied by.
    noise: f64,
}

/// Renders a scene by one engine and method.
type Render = fn(&Scene, &Settings) -> Film;

/// An engine's photon mapping and path tracing, and the factor by which its renders may be noisier. The reference takes some twenty
/// times as long as fast, so it has a quarter of the walks.
const ENGINES: [(&str, [Render; 2], u32); 2] =
    [("fast", [render_sppm_fast, render_path_fast], 1), ("the reference", [render_sppm, render_path], 2)];

/// Renders by photon mapping and by path tracing, with both engines.
fn renders(scene: &Scene, sppm: Settings, path: Settings) -> Vec<Rendered> {
    let mut all = Vec::new();
    for (engine, [render_sppm, render_path], noise) in ENGINES {
        let fewer = noise * noise;
        let sppm = Settings { photons_per_iteration: sppm.photons_per_iteration / fewer, ..sppm };
        let path = Settings { iterations: path.iterations.div_ceil(fewer), ..path };
        let mut push = |film, by_photons| {
            let method = if by_photons { "photon mapping" } else { "path tracing" };
            let by = format!("{method} by {engine}");
            all.push(Rendered { film, by, by_photons, noise: noise.into() });
        };
        push(render_sppm(scene, &sppm), true);
        push(render_path(scene, &path), false);
    }
    all
}

/// Renders with enough walks for [`FURNACE`] if steps survive with probability `q`, and compares the image means.
fn assert_both(scene: &Scene, depth: u32, q: f64, expected: [f64; 3], what: &str) {
    let walks = walks_for(q, depth);
    for Rendered { film, by, noise, .. } in renders(scene, photons(walks, depth), samples(walks / 2, depth)) {
        assert_mean(&film, expected, noise * FURNACE, &format!("{by}, {what}, depth {depth}"));
    }
}

/// A black lamp of radius 1 at the centre of a diffuse shell.
fn concentric(albedo: [f32; 3], emission: Rgb) -> Scene {
    empty_scene(pinhole(EYE, Vec3::ZERO, FOV)).ball(Vec3::ZERO, SHELL, coloured(albedo)).lamp(
        Vec3::ZERO,
        1.0,
        BLACK,
        emission,
    )
}

/// Radiance of the shell of [`concentric`]: `rho / pi E0 (1 + rho F + (rho F)^2 + ...)` with `E0 = pi Le (a/b)^2`,
/// where `F = 1 - (a/b)^2` is the share of the light leaving the shell that arrives at it again.
fn concentric_radiance(albedo: [f32; 3], emission: [f32; 3], depth: u32) -> [f64; 3] {
    let ratio = 1.0 / f64::from(SHELL * SHELL);
    let radiance = |(rho, emission)| rho * emission * ratio * geometric(rho * (1.0 - ratio), depth);
    [0, 1, 2].map(|c| radiance((f64::from(albedo[c]), f64::from(emission[c]))))
}

/// The pixels of a square image of [`concentric`] that show only the lamp, and those that show only the shell, each as
/// an image of one row.
fn lamp_and_shell(film: &Film) -> [Film; 2] {
    let row = |pixels: Vec<Rgb>| Film { width: pixels.len() as u32, height: 1, pixels };
    let edge = f64::from(1.0 / EYE.z).asin().tan();
    let half = f64::from(film.width) / 2.0;
    let (mut lamp, mut shell) = (Vec::new(), Vec::new());
    for (index, pixel) in film.pixels.iter().enumerate() {
        // The image plane at distance 1 has a size of 2 x 2.
        let place = |i: usize| i as f64 / half - 1.0;
        let (x, y) = (index % film.width as usize, index / film.width as usize);
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| place(x).hypot(place(y)));
        // Between two corners, the curved edge of the lamp bulges by less than a tenth of a pixel.
        if corners.iter().all(|&r| r < edge - 0.1 / half) {
            lamp.push(*pixel);
        } else if corners.iter().all(|&r| r > edge + 0.1 / half) {
            shell.push(*pixel);
        }
    }
    [row(lamp), row(shell)]
}

fn assert_concentric(albedo: [f32; 3], depth: u32, light_samples: u32) {
    let emission = [4.0, 2.0, 1.0];
    let scene = concentric(albedo, Rgb::from_array(emission));
    let brightest = albedo.into_iter().fold(0.0_f32, f32::max);
    let walks = walks_for(f64::from(brightest) * (1.0 - 1.0 / f64::from(SHELL * SHELL)), depth);
    let expected = concentric_radiance(albedo, emission, depth);
    let [sppm, path] =
        [photons(walks, depth), samples(walks / 2, depth)].map(|s| Settings { light_samples, ..s });
    for Rendered { film, by, noise, .. } in renders(&scene, sppm, path) {
        let [lamp, shell] = lamp_and_shell(&film);
        assert!(lamp.pixels.len() > 50 && shell.pixels.len() > 500);
        assert!(lamp.pixels.iter().all(|&pixel| pixel == Rgb::from_array(emission)));
        assert_mean(&shell, expected, noise * FURNACE, &format!("{by}, albedo {albedo:?}, depth {depth}"));
    }
}

#[test]
fn lamp_at_the_centre_of_a_bright_shell() {
    for depth in DEPTHS {
        assert_concentric([0.75, 0.5, 0.2], depth, 1);
    }
    assert_concentric([0.75, 0.5, 0.2], 5, 3);
    tell("physics", 4 * (DEPTHS.len() + 1), "furnaces: a lamp in a bright shell");
}

#[test]
fn lamp_at_the_centre_of_a_dark_shell() {
    for depth in [1, 2, 64] {
        assert_concentric([0.1, 0.3, 0.0], depth, 1);
    }
    tell("physics", 12, "furnaces: a lamp in a dark shell");
}

/// Each iteration is then an estimate by itself, with a disc of its own.
#[test]
fn lamp_at_the_centre_by_global_radii() {
    let (albedo, emission, depth) = ([0.5, 0.3, 0.1], [4.0, 2.0, 1.0], 3);
    let scene = concentric(albedo, Rgb::from_array(emission));
    let walks = walks_for(0.5, depth);
    let settings = Settings {
        iterations: 6,
        photons_per_iteration: walks / 6,
        radius_schedule: RadiusSchedule::Global,
        ..photons(walks, depth)
    };
    let [lamp, shell] = lamp_and_shell(&render_sppm(&scene, &settings));
    assert!(lamp.pixels.iter().all(|&pixel| pixel == Rgb::from_array(emission)));
    assert_mean(&shell, concentric_radiance(albedo, emission, depth), FURNACE, "global radii");
    tell("physics", 1, "furnaces by global radii");
}

#[test]
fn lamp_at_the_centre_behind_the_eye() {
    let mut scene = concentric([0.5; 3], Rgb::ONE);
    scene.camera = pinhole(Vec3::Z * 2.0, Vec3::Z * SHELL, 120.0);
    let depth = 3;
    let expected = concentric_radiance([0.5; 3], [1.0; 3], depth);
    for Rendered { film, by, noise, .. } in
        renders(&scene, photons(6_000_000, depth), samples(1_000_000, depth))
    {
        assert_mean(&film, expected, noise * FURNACE, &by);
    }
    tell("physics", 4, "furnaces: a lamp behind the eye");
}

fn glowing_shell(material: Material, emission: Rgb) -> Scene {
    empty_scene(pinhole(EYE, Vec3::ZERO, FOV)).lamp(Vec3::ZERO, SHELL, material, emission)
}

#[test]
fn closed_emitting_shell_for_walks_that_never_end() {
    let (albedo, emission) = ([1.0, 0.5, 0.2], [0.5, 1.0, 3.0]);
    let scene = glowing_shell(coloured(albedo), Rgb::from_array(emission));
    for depth in DEPTHS {
        let expected = [0, 1, 2].map(|c| f64::from(emission[c]) * geometric(f64::from(albedo[c]), depth + 1));
        let path = render_path(&scene, &samples(5000, depth));
        assert_mean(&path, expected, ROUNDING, &format!("depth {depth}"));
    }
    tell("physics", DEPTHS.len(), "furnaces without roulette");
}

#[test]
fn closed_emitting_shell_with_roulette() {
    for (albedo, depths) in [(0.0, &DEPTHS[..]), (0.5, &DEPTHS), (0.8, &[64])] {
        let scene = glowing_shell(diffuse(albedo), Rgb::new(1.0, 2.0, 4.0));
        for &depth in depths {
            let radiance = geometric(f64::from(albedo), depth + 1);
            let expected = [1.0, 2.0, 4.0].map(|emission| emission * radiance);
            assert_both(&scene, depth, f64::from(albedo), expected, &format!("albedo {albedo}"));
        }
    }
    tell("physics", 44, "furnaces with roulette");
}

/// Adds lossless mirrors and glass: separate, nested and overlapping.
fn lossless_objects(scene: Scene) -> Scene {
    scene
        .ball(Vec3::new(-1.0, 0.0, -0.5), 0.7, glass(1.0, 1.5))
        .ball(Vec3::new(1.0, 0.2, -0.6), 0.6, mirror(1.0))
        .ball(Vec3::new(0.2, 1.1, -1.0), 0.3, mirror(1.0))
        .ball(Vec3::new(0.0, -1.2, -0.2), 0.6, glass(1.0, 1.3))
        .ball(Vec3::new(0.0, -1.2, -0.2), 0.4, glass(1.0, 2.4))
        .ball(Vec3::new(0.9, -1.0, 0.2), 0.5, glass(1.0, 1.7))
}

#[test]
fn glass_and_mirrors_are_invisible_in_a_black_furnace() {
    let emission = Rgb::new(1.0, 2.0, 4.0);
    let scene = lossless_objects(glowing_shell(BLACK, emission));
    // Light can circulate in glass at grazing angles for a long time; at this depth none of the paths is cut off.
    let depth = 1024;
    let sppm = render_sppm(&scene, &Settings { iterations: 2, ..settings(96, 96, 1, depth, 1.0) });
    let path = render_path(&scene, &Settings { iterations: 2, ..settings(96, 96, 1, depth, 1.0) });
    for film in [sppm, path] {
        let is_odd = |pixel: &Rgb| (*pixel / emission - Rgb::ONE).abs().max_element() > ROUNDING as f32;
        let odd = film.pixels.iter().filter(|pixel| is_odd(pixel)).count();
        assert_eq!(odd, 0, "pixels that show the glass or the mirrors");
    }
    tell("physics", 2 * 96 * 96, "pixels of black furnaces with glass and mirrors");
}

#[test]
fn glass_and_mirrors_are_invisible_in_a_reflecting_furnace() {
    let albedo = 0.5;
    let scene = lossless_objects(glowing_shell(diffuse(albedo), Rgb::ONE));
    // Segments through glass count towards the depth. Even with four segments per bounce, only 0.5^64 of the light is
    // cut off.
    let depth = 256;
    let walks = walks_for(f64::from(albedo), depth);
    // The objects block a tenth of the shadow rays, which makes direct light noisy: use more pixels and iterations.
    let sppm = Settings { iterations: 16, ..settings(64, 64, walks / 16, depth, RADIUS) };
    for Rendered { film, by, noise, .. } in renders(&scene, sppm, samples(walks / 2, depth)) {
        assert_mean(&film, [2.0; 3], noise * FURNACE, &by);
    }
    tell("physics", 4, "reflecting furnaces with glass and mirrors");
}

/// Radiance is scaled by the squared index of refraction when light enters glass, and by its inverse when it leaves. So
/// a surface inside glass is brighter by that factor, but looks the same from outside.
#[test]
fn white_balls_within_glass_are_invisible_in_a_furnace() {
    let emission = Rgb::new(1.0, 2.0, 4.0);
    let mut scene = glowing_shell(BLACK, emission)
        .ball(Vec3::ZERO, 1.0, glass(1.0, 1.5))
        .ball(Vec3::new(0.1, 0.0, 0.0), 0.6, diffuse(1.0))
        .ball(Vec3::new(0.0, 0.9, 0.0), 0.3, diffuse(1.0));
    scene.camera.vertical_fov_degrees = 38.0;
    let expected = emission.to_array().map(f64::from);
    // The balls are lossless and visible in almost every pixel. Photons bounce until the shell absorbs them.
    let sppm = Settings { iterations: 8, ..settings(64, 64, 250_000, 256, 0.1) };
    assert_mean(&render_photons(&scene, &sppm), expected, SUNKEN, "SPPM");
    // A few paths circulate in the glass for so long that they are cut off.
    assert_mean(&render_path(&scene, &samples(40_000, 256)), expected, FURNACE, "path tracer");
}

/// Relative tolerance: the side test loses photons at grazing angles, `R^2 / (8 b^2)` on a ball of radius `b`. That is
/// 0.4 % on the smaller ball, which covers a quarter of the image. The rest is noise.
const SUNKEN: f64 = 2e-3;

/// A sphere in a shell, both glowing and reflecting: a radiosity problem with two unknowns.
struct TwoSurfaces {
    albedo: [[f32; 3]; 2],
    emission: [[f32; 3]; 2],
}

const TWO_SURFACES: TwoSurfaces =
    TwoSurfaces { albedo: [[0.2, 0.6, 0.4], [0.5, 0.3, 0.6]], emission: [[4.0, 1.0, 2.0], [0.25, 1.0, 1.0]] };

impl TwoSurfaces {
    fn scene(&self) -> Scene {
        let [inner, outer] = self.albedo.map(coloured);
        let [inner_emission, outer_emission] = self.emission.map(Rgb::from_array);
        empty_scene(pinhole(EYE, Vec3::ZERO, FOV)).lamp(Vec3::ZERO, 1.0, inner, inner_emission).lamp(
            Vec3::ZERO,
            SHELL,
            outer,
            outer_emission,
        )
    }

    /// Radiance of both after `depth` exchanges, for one channel. The sphere sees only the shell; a share `(a/b)^2` of
    /// what the shell sees is the sphere.
    fn radiance(&self, channel: usize, depth: u32) -> [f64; 2] {
        let value = |table: [[f32; 3]; 2]| table.map(|surface| f64::from(surface[channel]));
        let (rho, emission) = (value(self.albedo), value(self.emission));
        let share = 1.0 / f64::from(SHELL * SHELL);
        (0..depth).fold(emission, |[inner, outer], _| {
            [emission[0] + rho[0] * outer, emission[1] + rho[1] * (share * inner + (1.0 - share) * outer)]
        })
    }
}

/// Relative tolerance of SPPM on the inner sphere: it gets a ninth of the photons, so the noise is three times as
/// large.
const SMALL_SPHERE: f64 = 3e-3;

#[test]
fn two_glowing_and_reflecting_surfaces() {
    let scene = TWO_SURFACES.scene();
    for depth in [1, 3, 16] {
        let expected = [0, 1, 2].map(|channel| TWO_SURFACES.radiance(channel, depth));
        // Each shadow ray goes to one of two lights. Use enough pixels and iterations that both are chosen often.
        let sppm = Settings { iterations: 10, ..settings(64, 64, 400_000, depth, RADIUS / 2.0) };
        for Rendered { film, by, by_photons, noise } in renders(&scene, sppm, samples(6_000_000, depth)) {
            let inner = if by_photons { SMALL_SPHERE } else { FURNACE };
            for (surface, pixels) in lamp_and_shell(&film).iter().enumerate() {
                let expected = expected.map(|radiance| radiance[surface]);
                let what = format!("{by}, surface {surface}, depth {depth}");
                assert_mean(pixels, expected, noise * [inner, FURNACE][surface], &what);
            }
        }
    }
    tell("physics", 24, "radiosities of two surfaces");
}

#[test]
fn furnaces_scale_with_the_unit_of_length_and_of_light() {
    let (size, power) = (1.0 / 128.0, 1024.0);
    let scene = concentric([0.5; 3], Rgb::ONE);
    let mut scaled = scene.clone();
    scaled.camera.eye *= size;
    for sphere in &mut scaled.spheres {
        (sphere.center, sphere.radius) = (sphere.center * size, sphere.radius * size);
        sphere.emission *= power;
    }
    let settings = photons(20_000, 3);
    let scaled_settings = Settings { initial_radius: settings.initial_radius * size, ..settings };
    let (one, other) = (render_sppm(&scene, &settings), render_sppm(&scaled, &scaled_settings));
    let [expected, actual] = [mean(&one).map(|v| v * f64::from(power)), mean(&other)];
    assert!(relative_error(actual, expected) < ROUNDING, "{actual:?} instead of {expected:?}");
}
