//! Stages: the camera sees every ball and no lamp.

use figure::color::{Screen, WHITE};
use figure::stage::{Background, Light, Set, Stage, View, set};
use proptest::prelude::*;
use scene::{Material, Rgb, Sphere, Vec3};

/// The margin of a frame, and the rounding of the camera to `f32`.
const MARGIN: f64 = 0.05;
const TOLERANCE: f64 = 1e-4;

fn sphere(center: [f32; 3], radius: f32) -> Sphere {
    let center = Vec3::from_array(center);
    Sphere { center, velocity: Vec3::ZERO, radius, material: 0, emission: Rgb::ZERO }
}

/// How far the outline of a ball reaches towards a side of the image: 1 if it touches it. By sampling the circle in which
/// the cone from the eye touches the ball, other than the camera is computed.
fn reach(set: &Set, size: [u32; 2], ball: &Sphere) -> f64 {
    let frame = set.camera.frame(size[0], size[1]);
    let d = (ball.center - frame.eye).as_dvec3();
    let (distance, radius) = (d.length(), f64::from(ball.radius));
    let sine = radius / distance;
    let (axis, cosine) = (d / distance, (1.0 - sine * sine).sqrt());
    let (u, v) = axis.any_orthonormal_pair();
    let outline = (0..720).map(|i| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 720.0).sin_cos();
        let ray = axis * cosine + (u * c + v * s) * sine;
        let ahead = ray.dot(frame.forward.as_dvec3());
        let part = |across: Vec3, half: f32| {
            ray.dot(across.as_dvec3()).abs() / ahead / f64::from(half * frame.pixel)
        };
        if ahead > 0.0 {
            part(frame.right, frame.half[0]).max(part(frame.up, frame.half[1]))
        } else {
            f64::INFINITY
        }
    });
    outline.fold(0.0, f64::max)
}

fn view() -> impl Strategy<Value = View> {
    prop::sample::select(View::ALL.to_vec())
}

proptest! {
    #[test]
    fn every_ball_is_in_the_picture_and_no_lamp(
        balls in prop::collection::vec((prop::array::uniform3(-10.0_f32..10.0), 0.01..5.0_f32), 1..30),
        stretch in prop::array::uniform3(0.01_f32..1.0),
        scale in prop::sample::select(vec![1e-10_f32, 0.1, 1.0, 1e4]),
        (view, has_ground, size) in (view(), any::<bool>(), prop::sample::select(vec![[800, 600], [300, 900], [900, 200]])),
        light in prop::sample::select(Light::ALL.to_vec()),
        zoom in prop::sample::select(vec![0.1, 0.2, 0.4, 1.0, 1.0, 3.0]),
    ) {
        let balls: Vec<Sphere> = balls
            .iter()
            .map(|(p, r)| sphere([0, 1, 2].map(|i| p[i] * stretch[i] * scale), r * scale))
            .collect();
        let ground = has_ground && view != View::Bottom;
        let stage = Stage { view: Some(view), ground, size, light, zoom, ..Stage::default() };
        let set = set(&balls, &[], false, &stage).unwrap();
        let most = balls.iter().map(|ball| reach(&set, size, ball)).fold(0.0, f64::max) / zoom;
        prop_assert!((most - (1.0 - MARGIN)).abs() < TOLERANCE, "{most}");
        for lamp in set.spheres.iter().filter(|sphere| sphere.is_emitter()) {
            let gap = set.camera.eye.distance(lamp.center) - lamp.radius;
            prop_assert!(gap > 0.0);
            // The nearest point of the lamp to the middle of the picture is outside.
            let frame = set.camera.frame(size[0], size[1]);
            let d = lamp.center - frame.eye;
            let ahead = d.dot(frame.forward);
            let out = |across: Vec3, half: f32| {
                let tangent = half * frame.pixel;
                (d.dot(across).abs() - tangent * ahead) / (1.0 + tangent * tangent).sqrt() > lamp.radius * 0.999
            };
            prop_assert!(out(frame.right, frame.half[0]) || out(frame.up, frame.half[1]));
        }
        if ground {
            let below = set.spheres[0];
            // Great numbers in `f32`: the ground is 300 times as large as the balls.
            let touch = balls.iter().map(|ball| {
                let d = (ball.center.as_dvec3() - below.center.as_dvec3()).length();
                (d - f64::from(below.radius) - f64::from(ball.radius)) / f64::from(below.radius)
            });
            let nearest = touch.fold(f64::INFINITY, f64::min);
            prop_assert!(nearest.abs() < 1e-6, "{nearest}");
        }
    }
}

#[test]
fn the_views_are_those_of_their_names() {
    let balls = [sphere([0.0, 0.0, 0.0], 1.0), sphere([3.0, 2.0, 1.0], 1.0)];
    let direction = |view| {
        let stage = Stage { view: Some(view), ..Stage::default() };
        set(&balls, &[], false, &stage).unwrap().camera.direction
    };
    let expected = [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::NEG_X, Vec3::NEG_Z, Vec3::Z];
    let views = [View::Front, View::Back, View::Left, View::Right, View::Top, View::Bottom];
    assert_eq!(views.map(direction), expected);
    assert!(direction(View::Iso).cmplt(Vec3::new(0.0, 1.0, 0.0)).all());
    // Across the line that joins both balls.
    assert!(direction(View::Principal).dot(Vec3::new(3.0, 2.0, 1.0)).abs() < 1e-6);
}

/// What fills a cell is seen from a corner, and other things across their extent: with a ground from a little above, so that it
/// is seen.
#[test]
fn the_usual_view_suits_cells_and_grounds() {
    // In the plane of x and y, wider along x.
    let balls = [[0.0, 0.0], [8.0, 0.0], [0.0, 4.0], [8.0, 4.0]].map(|[x, y]| sphere([x, y, 0.0], 1.0));
    let of = |has_cell, stage: Stage| set(&balls, &[], has_cell, &stage).unwrap();
    let usual = |has_cell| of(has_cell, Stage::default()).camera;
    let iso = of(false, Stage { view: Some(View::Iso), ..Stage::default() }).camera;
    assert_eq!((usual(true), usual(false).direction), (iso, Vec3::NEG_Z));
    let grounded = of(false, Stage { ground: true, ..Stage::default() });
    let down = grounded.camera.direction;
    // A quarter down.
    assert!((down.y / down.z - 0.25).abs() < 1e-6 && down.z < 0.0 && down.x.abs() < 1e-6, "{down}");
    // Up is the axis of the second greatest extent.
    let below = grounded.spheres[0].center;
    assert!(below.y < -100.0 && (below.x - 4.0).abs() < 1e-3 && below.z.abs() < 1e-3, "{below}");
}

/// The first radius is that of a ball, but neither less than a few pixels nor a great part of what is seen, however close.
#[test]
fn the_first_radius_is_within_shares_of_what_is_seen() {
    let share = |balls: &[Sphere], zoom: f64| {
        let set = set(balls, &[], false, &Stage { zoom, ..Stage::default() }).unwrap();
        let half = 0.5 * f64::from(set.camera.vertical_fov_degrees).to_radians();
        f64::from(set.settings.initial_radius) / (half.tan() * f64::from(set.camera.focus_distance))
    };
    let specks = [sphere([-50.0, 0.0, 0.0], 1e-3), sphere([50.0, 0.0, 0.0], 1e-3)];
    for zoom in [1.0, 4.0] {
        for (balls, expected) in [(&specks[..], 0.02), (&[sphere([0.0; 3], 1.0)], 0.08)] {
            let found = share(balls, zoom);
            assert!((found / expected - 1.0).abs() < 1e-5, "zoom {zoom}: {found} for {expected}");
        }
    }
}

/// The reader of scene files makes zeros positive, so a scene with negative ones would not be read back.
#[test]
fn there_are_no_negative_zeros() {
    let balls = [sphere([0.0; 3], 1.0), sphere([8.0, 0.0, 0.0], 1.0), sphere([8.0, 6.0, 0.0], 1.0)];
    for view in View::ALL {
        let set = set(&balls, &[], false, &Stage { view: Some(view), ..Stage::default() }).unwrap();
        let camera = [set.camera.eye, set.camera.direction, set.camera.up];
        let all = camera.into_iter().chain(set.spheres.iter().map(|sphere| sphere.center));
        assert!(all.flat_map(|v| v.to_array()).all(|x| x != 0.0 || x.is_sign_positive()), "{view:?}");
    }
}

#[test]
fn zoom_magnifies() {
    let balls = [sphere([0.0; 3], 1.0)];
    let fov = |zoom| {
        let stage = Stage { zoom, ..Stage::default() };
        let degrees = set(&balls, &[], false, &stage).unwrap().camera.vertical_fov_degrees;
        f64::from(degrees / 2.0).to_radians().tan()
    };
    assert!((fov(1.0) / fov(2.0) - 2.0).abs() < 1e-6);
}

/// The eye is so placed that the frame is tight, which the centre of the balls is not in the middle of.
#[test]
fn what_is_in_focus_is_the_plane_through_the_middle_of_the_balls() {
    let balls = [sphere([-4.0, 0.0, 0.0], 3.0), sphere([5.0, 9.0, 2.0], 0.5), sphere([6.0, 1.0, 1.0], 0.2)];
    // Of the box around them.
    let center = Vec3::new(-0.4, 3.25, 0.0);
    for view in View::ALL {
        let camera = set(&balls, &[], false, &Stage { view: Some(view), ..Stage::default() }).unwrap().camera;
        let depth = (center - camera.eye).dot(camera.direction);
        assert!((camera.focus_distance / depth - 1.0).abs() < 1e-5, "{view:?}: {depth}");
    }
}

/// A white particle that faces a lamp, from which the lamp takes its share of the half space, has the radiance of the lamp's
/// share of the brightest, beside the background's light: in sizes of what is seen, however large that is.
#[test]
fn a_white_particle_that_faces_the_key_lamp_is_just_below_white() {
    /// The radiance of a white surface that faces the key lamp.
    const BRIGHTEST: f32 = 0.9;
    let grey = Background::Color(Screen([128; 3]));
    // Its brightest channel leaves the least for the lamps.
    let orange = Background::Color(Screen([200, 120, 0]));
    for radius in [1e-3, 1.0, 400.0] {
        for (light, background, shares) in [
            (Light::Studio, Background::Usual, &[1.0, 0.2, 0.6][..]),
            (Light::Studio, grey, &[1.0, 0.2, 0.6]),
            (Light::Studio, orange, &[1.0, 0.2, 0.6]),
            (Light::Dark, Background::Usual, &[0.25]),
            (Light::Overcast, Background::Usual, &[]),
        ] {
            let stage = Stage { light, background, ..Stage::default() };
            let set = set(&[sphere([0.0; 3], radius)], &[], false, &stage).unwrap();
            let lamps: Vec<f32> = set
                .spheres
                .iter()
                .map(|lamp| WHITE * lamp.emission.x * (lamp.radius / lamp.center.length()).powi(2))
                .collect();
            assert_eq!(lamps.len(), shares.len(), "{light:?}");
            let key = BRIGHTEST - WHITE * set.background.x;
            for (lamp, share) in lamps.iter().zip(shares) {
                assert!((lamp - share * key).abs() < 1e-5, "{light:?}: {lamp} for {share} of {key}");
            }
        }
    }
}

/// Matte balls are path traced, and others need photons: iterations take longer, and the radius of most balls is the first
/// radius, within some pixels.
#[test]
fn settings_follow_materials_and_most_radii() {
    let matte = Material::Diffuse { albedo: Rgb::splat(0.5) };
    let mirror = Material::Specular { albedo: Rgb::ONE };
    let balls: Vec<Sphere> = [0.05, 0.1, 0.08, 1.0, 0.07]
        .iter()
        .zip(0_u8..)
        .map(|(r, x)| sphere([f32::from(x), 0.0, 0.0], *r))
        .collect();
    let of = |materials: &[Material]| set(&balls, materials, false, &Stage::default()).unwrap().settings;
    assert_eq!((of(&[matte; 2]).iterations, of(&[matte; 2]).light_samples), (40, 2));
    assert_eq!((of(&[matte, mirror]).iterations, of(&[mirror]).iterations), (48, 48));
    assert_eq!(of(&[matte]).initial_radius, 0.08);
    assert_eq!([of(&[matte]).width, of(&[matte]).height], Stage::default().size);
}

#[test]
fn backgrounds_are_linear_light() {
    let balls = [sphere([0.0; 3], 1.0)];
    let background = |stage: Stage| set(&balls, &[], false, &stage).map(|set| set.background);
    assert_eq!(background(Stage::default()), Ok(Rgb::ONE));
    assert_eq!(background(Stage { light: Light::Dark, ..Stage::default() }), Ok(Rgb::ZERO));
    // What is left out of the image lights the particles all the same.
    for (light, color) in [(Light::Studio, Rgb::ONE), (Light::Overcast, Rgb::ONE), (Light::Dark, Rgb::ZERO)] {
        let stage = Stage { light, background: Background::Transparent, ..Stage::default() };
        assert_eq!(background(stage), Ok(color), "{light:?}");
    }
    let grey = Screen([188; 3]);
    assert_eq!(
        background(Stage { background: Background::Color(grey), ..Stage::default() }),
        Ok(grey.linear())
    );
    let black =
        Stage { light: Light::Overcast, background: Background::Color(Screen([0; 3])), ..Stage::default() };
    assert!(background(black).unwrap_err().contains("a black one gives none"));
}

#[test]
fn a_ground_is_not_seen_from_below() {
    let balls = [sphere([0.0; 3], 1.0)];
    let stage = Stage { view: Some(View::Bottom), ground: true, ..Stage::default() };
    assert!(set(&balls, &[], false, &stage).unwrap_err().contains("from below"));
}
