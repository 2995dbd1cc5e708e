//! A stage for balls: camera, lamps, ground, background and settings that follow from the balls alone.

use crate::color::{Screen, WHITE};
use crate::fit::{self, Axes};
use crate::principal;
use crate::vector::single;
use glam::{DMat3, DVec3, Vec3};
use importers::Particles;
use scene::settings::RADIUS_RANGE;
use scene::{Camera, Material, Rgb, Settings, Sphere};

/// What kind of stage is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// The direction of the view; `None` is [`View::Iso`] for what has a cell, and [`View::Principal`] for other things.
    pub view: Option<View>,
    /// Magnifies the image about its centre; at 1 all balls just fit into it.
    pub zoom: f64,
    /// The lamps.
    pub light: Light,
    /// Whether there is a ground.
    pub ground: bool,
    /// The background.
    pub background: Background,
    /// Width and height of the image, in pixels.
    pub size: [u32; 2],
}

/// What is behind the particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// Black in a dark room, and white elsewhere.
    #[default]
    Usual,
    /// A colour.
    Color(Screen),
    /// Lights as the usual one does, and is left out of the image, which has alpha in its place.
    Transparent,
}

/// A direction to look along. The z axis points up but for the views along it and for the principal one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// Along +y; x points to the right.
    Front,
    /// Along -y.
    Back,
    /// Along +x.
    Left,
    /// Along -x.
    Right,
    /// Along -z; y points up.
    Top,
    /// Along +z; y points up.
    Bottom,
    /// From the front, the right and above.
    Iso,
    /// Along the axis of the least spread; that of the greatest points to the right.
    Principal,
}

/// Lamps, all of them glowing balls out of the picture, beside the light of the background.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Light {
    /// A key lamp from the upper left, a wide fill lamp from the right, a rim lamp from behind.
    #[default]
    Studio,
    /// The background alone.
    Overcast,
    /// A dim key lamp in the dark, for particles that glow.
    Dark,
}

/// The centre of the box around all particles: the origin of their scene.
pub fn origin(particles: &Particles) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let all = particles.positions.iter().map(|position| position[axis]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        // Halves first: the sum of two large numbers of one sign may be too large.
        if low <= high { 0.5 * low + 0.5 * high } else { 0.0 }
    })
}

/// What a stage adds to balls.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// The camera, a pinhole.
    pub camera: Camera,
    /// The lamps and the ground. Their materials are indices of `materials`.
    pub spheres: Vec<Sphere>,
    /// The materials of `spheres`.
    pub materials: Vec<Material>,
    /// The background of the scene.
    pub background: Rgb,
    /// Whether it is left out of the image.
    pub transparent_background: bool,
    /// Settings for a quick picture.
    pub settings: Settings,
}

/// Tangent of half the vertical angle of view, 20 degrees: little perspective.
const TANGENT: f64 = 0.176_326_980_708_464_97;
/// Share of the frame that stays free around the balls, on each side.
const MARGIN: f64 = 0.05;
/// How much higher than level the principal view is with a ground, as a tangent, so that the ground is seen.
const TILT: f64 = 0.25;
/// Paths per pixel of a quick picture, and shadow rays of each from the first surface: most noise is of direct light, from
/// three lamps and the background (docs/particles.md).
const PATHS: u32 = 40;
const LIGHT_SAMPLES: u32 = 2;
/// Iterations of photon mapping, which take longer.
const ITERATIONS: u32 = 48;
/// Radius of the ground, in sizes of what stands on it: flat to the eye, and yet exact in `f32`.
const GROUND: f64 = 300.0;
/// Radiance of a white particle that faces the key lamp; the image shows 1 as white.
const BRIGHTEST: f64 = 0.9;
/// Reflected share of the ground.
const GROUND_ALBEDO: f32 = 0.6;

impl Default for Stage {
    fn default() -> Self {
        Self {
            view: None,
            zoom: 1.0,
            light: Light::Studio,
            ground: false,
            background: Background::Usual,
            size: [800, 600],
        }
    }
}

impl Stage {
    /// The colour of the background's light.
    fn sky(&self) -> Screen {
        match (self.background, self.light) {
            (Background::Color(color), _) => color,
            (_, Light::Dark) => Screen([0; 3]),
            (_, Light::Studio | Light::Overcast) => Screen([255; 3]),
        }
    }
}

impl Background {
    /// The name of [`Self::Transparent`].
    const TRANSPARENT: &str = "transparent";

    /// Reads `transparent`, or a colour.
    ///
    /// # Errors
    /// If it is neither: what would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text == Self::TRANSPARENT {
            return Ok(Self::Transparent);
        }
        Screen::parse(text).map(Self::Color).ok_or_else(|| {
            let names = Screen::names().collect::<Vec<_>>().join(", ");
            format!("`{text}` must be {}, #rrggbb or one of {names}", Self::TRANSPARENT)
        })
    }
}

impl View {
    /// All views.
    pub const ALL: [Self; 8] = [
        Self::Front,
        Self::Back,
        Self::Left,
        Self::Right,
        Self::Top,
        Self::Bottom,
        Self::Iso,
        Self::Principal,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
            Self::Iso => "iso",
            Self::Principal => "principal",
        }
    }

    /// The directions of the camera, and that which is up for the ground.
    fn axes(self, balls: &[Sphere], is_tilted: bool) -> (Axes, DVec3) {
        let look = |forward: DVec3, up: DVec3| {
            let forward = forward.normalize();
            let right = forward.cross(up).normalize();
            Axes { right, up: right.cross(forward), forward }
        };
        let level = |forward| (look(forward, DVec3::Z), DVec3::Z);
        match self {
            Self::Front => level(DVec3::Y),
            Self::Back => level(DVec3::NEG_Y),
            Self::Left => level(DVec3::X),
            Self::Right => level(DVec3::NEG_X),
            Self::Iso => level(DVec3::new(-0.6, 1.0, -0.55)),
            Self::Top => (look(DVec3::NEG_Z, DVec3::Y), DVec3::Z),
            Self::Bottom => (look(DVec3::Z, DVec3::Y), DVec3::Z),
            Self::Principal => {
                let [_, up, toward] = principal::axes(balls.iter().map(|ball| ball.center.as_dvec3()));
                let down = if is_tilted { TILT * up } else { DVec3::ZERO };
                (look(-toward - down, up), up)
            }
        }
    }
}

impl Light {
    /// All kinds of light.
    pub const ALL: [Self; 3] = [Self::Studio, Self::Overcast, Self::Dark];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Overcast => "overcast",
            Self::Dark => "dark",
        }
    }
}

/// A lamp: its direction to the right, to the top and away from the camera, its distance and its radius in sizes of what
/// is seen, and the radiance of a white surface that faces it, as a share of that of the key lamp.
struct Lamp {
    direction: [f64; 3],
    distance: f64,
    radius: f64,
    share: f64,
}

const KEY: Lamp = Lamp { direction: [-0.55, 0.75, -0.6], distance: 4.5, radius: 1.0, share: 1.0 };
const FILL: Lamp = Lamp { direction: [0.9, 0.45, -0.7], distance: 5.0, radius: 1.8, share: 0.2 };
const RIM: Lamp = Lamp { direction: [0.4, 0.7, 0.7], distance: 4.5, radius: 0.6, share: 0.6 };

/// Whether there are neither mirrors nor glass: then there are no caustics, and path tracing gives the better picture.
pub fn is_matte(materials: &[Material]) -> bool {
    materials.iter().all(|material| matches!(material, Material::Diffuse { .. }))
}

/// The stage for `balls`, of which there is one at least; `has_cell` says whether they come from a cell, and `materials` are
/// theirs.
///
/// # Errors
/// If the options contradict each other.
pub fn set(balls: &[Sphere], materials: &[Material], has_cell: bool, stage: &Stage) -> Result<Set, String> {
    let sky = stage.sky().linear();
    if stage.light == Light::Overcast && sky == Rgb::ZERO {
        return Err("overcast light is that of the background, and a black one gives none".into());
    }
    let view = stage.view.unwrap_or(if has_cell { View::Iso } else { View::Principal });
    let (axes, up) = view.axes(balls, stage.ground);
    if stage.ground && axes.forward.dot(up) > 0.0 {
        return Err(format!("the view {} is from below the ground", view.name()));
    }
    let shot = Shot::new(axes, balls, stage);
    let mut set = Set {
        camera: shot.camera(),
        spheres: Vec::new(),
        materials: Vec::new(),
        background: sky,
        transparent_background: stage.background == Background::Transparent,
        settings: shot.settings(balls, is_matte(materials), stage),
    };
    let ground = stage.ground.then(|| shot.ground(up, balls));
    if let Some((center, radius)) = ground {
        set.add(center, radius, Material::Diffuse { albedo: Rgb::splat(GROUND_ALBEDO) }, Rgb::ZERO);
    }
    let lamps: &[Lamp] = match stage.light {
        Light::Studio => &[KEY, FILL, RIM],
        Light::Overcast => &[],
        Light::Dark => &[KEY],
    };
    let key = key_of(stage.light, sky);
    for lamp in lamps {
        let (center, radius) = shot.place(lamp);
        let sinks = ground.is_some_and(|(below, depth)| center.distance(below) < depth + radius);
        if !sinks && !shot.sees(center, radius) {
            // The disc of the lamp takes (radius / distance)^2 of the cosine-weighted hemisphere of what faces it.
            let radiance = key * lamp.share * (lamp.distance / lamp.radius).powi(2);
            set.add(center, radius, Material::Diffuse { albedo: Rgb::ZERO }, Rgb::splat(radiance as f32));
        }
    }
    Ok(set)
}

/// The radiance that the key lamp alone gives a surface which faces it and reflects all light: with the background it makes
/// white particles [`BRIGHTEST`].
fn key_of(light: Light, sky: Rgb) -> f64 {
    let all = BRIGHTEST / f64::from(WHITE);
    match light {
        Light::Dark => 0.25 * all,
        Light::Studio | Light::Overcast => all - f64::from(scene::max_component(sky)),
    }
}

/// A camera before balls.
struct Shot {
    axes: Axes,
    eye: DVec3,
    /// The centre of the balls' bounding box.
    center: DVec3,
    /// Half the height and width of the frame at the centre, or the radius of the balls if that is greater.
    size: f64,
    /// Half the width and height of the frame at distance 1.
    half: [f64; 2],
}

impl Shot {
    fn new(axes: Axes, balls: &[Sphere], stage: &Stage) -> Self {
        let [width, height] = stage.size.map(f64::from);
        let whole = [TANGENT * width / height, TANGENT];
        let all = || balls.iter().map(|ball| (ball.center.as_dvec3(), f64::from(ball.radius)));
        let eye = fit::eye(&axes, whole.map(|tangent| tangent * (1.0 - MARGIN)), all());
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (center, radius) in all() {
            low = low.min(center - radius);
            high = high.max(center + radius);
        }
        let center = 0.5 * (low + high);
        let radius = all().map(|(c, r)| c.distance(center) + r).fold(0.0, f64::max);
        let half = whole.map(|tangent| tangent / stage.zoom);
        let distance = (center - eye).dot(axes.forward);
        let size = half.into_iter().map(|tangent| tangent * distance).fold(radius, f64::max);
        Self { axes, eye, center, size, half }
    }

    fn camera(&self) -> Camera {
        let fov = 2.0 * libm::atan(self.half[1]).to_degrees();
        Camera {
            eye: single(self.eye),
            direction: single(self.axes.forward),
            up: single(self.axes.up),
            vertical_fov_degrees: fov as f32,
            focus_distance: (self.center - self.eye).dot(self.axes.forward) as f32,
            ..Camera::default()
        }
    }

    /// Centre and radius of a lamp.
    fn place(&self, lamp: &Lamp) -> (DVec3, f64) {
        let frame = DMat3::from_cols(self.axes.right, self.axes.up, self.axes.forward);
        let direction = frame * DVec3::from_array(lamp.direction).normalize();
        (self.center + direction * (lamp.distance * self.size), lamp.radius * self.size)
    }

    /// Whether a ball may be seen, or holds the eye.
    fn sees(&self, center: DVec3, radius: f64) -> bool {
        let d = center - self.eye;
        let ahead = d.dot(self.axes.forward);
        let is_within = |(tangent, across): (f64, DVec3)| {
            let length = (1.0 + tangent * tangent).sqrt();
            d.dot(across).abs() - radius * length <= tangent * ahead
        };
        d.length() <= radius || self.half.into_iter().zip([self.axes.right, self.axes.up]).all(is_within)
    }

    /// Centre and radius of the ground: a great sphere that touches the lowest ball and lies below all others.
    fn ground(&self, up: DVec3, balls: &[Sphere]) -> (DVec3, f64) {
        let radius = GROUND * self.size;
        let height = |ball: &Sphere| {
            let d = ball.center.as_dvec3() - self.center;
            let aside = d - up * d.dot(up);
            let reach = radius + f64::from(ball.radius);
            d.dot(up) - (reach * reach - aside.length_squared()).sqrt()
        };
        let lowest = balls.iter().map(height).fold(f64::INFINITY, f64::min);
        (self.center + up * lowest, radius)
    }

    /// Settings for a quick picture. Photons bring indirect light alone, which is smooth: the first radius is that of a
    /// ball, or a few pixels where balls are small. A smaller one shows single photons as spots.
    fn settings(&self, balls: &[Sphere], is_matte: bool, stage: &Stage) -> Settings {
        let mut radii: Vec<f32> = balls.iter().map(|ball| ball.radius).collect();
        let middle = radii.len() / 2;
        let median = f64::from(*radii.select_nth_unstable_by(middle, f32::total_cmp).1);
        let seen = self.half[1] * (self.center - self.eye).dot(self.axes.forward);
        let initial_radius = median.clamp(0.02 * seen, 0.08 * seen) as f32;
        let [width, height] = stage.size;
        let [least, most] = RADIUS_RANGE;
        Settings {
            width,
            height,
            iterations: if is_matte { PATHS } else { ITERATIONS },
            photons_per_iteration: 200_000,
            max_depth: 16,
            light_samples: if is_matte { LIGHT_SAMPLES } else { 1 },
            initial_radius: initial_radius.clamp(least, most),
            ..Settings::default()
        }
    }
}

impl Set {
    fn add(&mut self, center: DVec3, radius: f64, material: Material, emission: Rgb) {
        let index = self.materials.iter().position(|there| *there == material).unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        self.spheres.push(Sphere {
            center: single(center),
            velocity: Vec3::ZERO,
            radius: radius as f32,
            material: index as u32,
            emission,
        });
    }
}
