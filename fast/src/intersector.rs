//! Ray queries without a render: for `sppm trace`, tests and benches.

use crate::hierarchy::SearchBuffers;
use crate::material::Materials;
use crate::paths::{BATCH, Paths, ROOM, Words};
use crate::rays::{BLOCKED, Rays};
use crate::search::{Search, Work};
use crate::surface::Hit;
use crate::tables::Tables;
use crate::trace::{hits, intersect_batch};
use lanes::{Kernel, LaneKind, Lanes, MOST_LANES, dispatch};
use scene::ray::SphereId;
use scene::{Ray, Rgb, Still, Vec3};

/// Finds what rays hit in a still, by the code of the passes: in batches, on any lanes.
pub struct Intersector {
    tables: Tables,
    lanes: LaneKind,
    are_close: bool,
}

impl Intersector {
    /// With the search that the renderer would use.
    pub fn new(still: &Still, lanes: LaneKind) -> Self {
        Self { tables: Tables::new(still), lanes, are_close: false }
    }

    /// With the given search, however many balls there are.
    pub fn with_search(still: &Still, lanes: LaneKind, search: Search) -> Self {
        Self { tables: Tables::with_search(still, search), lanes, are_close: false }
    }

    /// For rays of which those that follow each other are likely to run close together, as camera rays do. What they hit is
    /// the same.
    #[must_use]
    pub fn of_close_rays(self) -> Self {
        Self { are_close: true, ..self }
    }

    /// Bytes of memory held.
    pub fn bytes(&self) -> usize {
        self.tables.bytes()
    }

    /// Distance and sphere of each ray's nearest hit; an infinite distance where there is none.
    pub fn nearest(&self, rays: &[Ray]) -> Vec<(f32, SphereId)> {
        dispatch(self.lanes, Nearest { of: self, rays }).0
    }

    /// What each ray hits, with the surface there; `None` where it hits nothing.
    pub fn surfaces(&self, rays: &[Ray]) -> Vec<Option<Met>> {
        dispatch(self.lanes, AllMet { of: self, rays })
    }

    /// Which rays hit a surface other than `light` nearer than `t`; there is one `t` and one `light` per ray.
    pub fn occluded(&self, rays: &[Ray], t: &[f32], lights: &[SphereId]) -> Vec<bool> {
        dispatch(self.lanes, Occluded { of: self, rays, t, lights }).0
    }

    /// The work of [`Intersector::nearest`] and of [`Intersector::occluded`] on these rays.
    pub fn work(&self, rays: &[Ray], t: &[f32], lights: &[SphereId]) -> [Work; 2] {
        let nearest = dispatch(self.lanes, Nearest { of: self, rays }).1;
        [nearest, dispatch(self.lanes, Occluded { of: self, rays, t, lights }).1]
    }
}

/// What a ray hits: `reference::intersect::Hit`, and the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The sphere.
    pub sphere: SphereId,
    /// Distance along the ray.
    pub t: f32,
    /// The point, moved onto the sphere.
    pub point: Vec3,
    /// Unit normal on the side that the ray comes from.
    pub normal: Vec3,
    /// True if the ray comes from the inside.
    pub inside: bool,
    /// Reflectance or tint.
    pub albedo: Rgb,
    /// Index of refraction; 1 for what is opaque.
    pub ior: f32,
    /// 0 if diffuse, 1 if a mirror, 2 if glass.
    pub kind: u32,
}

struct AllMet<'a> {
    of: &'a Intersector,
    rays: &'a [Ray],
}

impl Kernel for AllMet<'_> {
    type Output = Vec<Option<Met>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (mut paths, mut buffers) = (Paths::new(), SearchBuffers::new());
        let mut found = Vec::with_capacity(self.rays.len());
        for rays in self.rays.chunks(BATCH) {
            fill(&mut paths, rays);
            intersect_batch::<L>(&self.of.tables, &mut paths, &mut buffers, rays.len(), self.of.are_close);
            let surfaces = self.of.tables.surfaces(&paths.hit[..rays.len()]);
            for at in (0..rays.len()).step_by(L::N) {
                let rest = rays.len() - at;
                let (t, hit, arrived) = hits::<L>(&paths, at, L::first(rest));
                let mut ids = [0; MOST_LANES];
                L::store_u(hit, &mut ids);
                let (origin, direction) = (paths.origin.load::<L>(at), paths.direction.load::<L>(at));
                let surface = Hit::<L>::at(surfaces, origin, direction, t, &ids);
                let material = Materials::<L>::gather(&self.of.tables.materials, surface.tag);
                let met = met::<L>(t, &surface, &material, L::mask_bits(arrived), &ids);
                found.extend_from_slice(&met[..L::N.min(rest)]);
            }
        }
        found
    }
}

/// The hits of a packet, lane by lane.
#[inline(always)]
fn met<L: Lanes>(
    t: L::F,
    surface: &Hit<L>,
    material: &Materials<L>,
    arrived: u32,
    ids: &[u32; MOST_LANES],
) -> [Option<Met>; MOST_LANES] {
    let inside = L::select(surface.inside, L::f(1.0), L::f(0.0));
    let (p, n, c) = (surface.point, surface.normal, material.albedo);
    let columns = [t, p.x, p.y, p.z, n.x, n.y, n.z, inside, c.x, c.y, c.z, material.ior];
    let mut rows = [[0.0; MOST_LANES]; 12];
    for k in 0..columns.len() {
        L::store(columns[k], &mut rows[k]);
    }
    let mut kinds = [0; MOST_LANES];
    L::store_u(material.kind, &mut kinds);
    let mut all = [None; MOST_LANES];
    for lane in 0..L::N {
        let [t, px, py, pz, nx, ny, nz, inside, r, g, b, ior] = std::array::from_fn(|k| rows[k][lane]);
        let met = Met {
            sphere: ids[lane],
            t,
            point: Vec3::new(px, py, pz),
            normal: Vec3::new(nx, ny, nz),
            inside: inside > 0.0,
            albedo: Rgb::new(r, g, b),
            ior,
            kind: kinds[lane],
        };
        all[lane] = (arrived >> lane & 1 == 1).then_some(met);
    }
    all
}

struct Nearest<'a> {
    of: &'a Intersector,
    rays: &'a [Ray],
}

impl Kernel for Nearest<'_> {
    type Output = (Vec<(f32, SphereId)>, Work);
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (mut paths, mut buffers) = (Paths::new(), SearchBuffers::new());
        let mut found = Vec::with_capacity(self.rays.len());
        for rays in self.rays.chunks(BATCH) {
            fill(&mut paths, rays);
            intersect_batch::<L>(&self.of.tables, &mut paths, &mut buffers, rays.len(), self.of.are_close);
            found.extend(paths.t.iter().copied().zip(paths.hit).take(rays.len()));
        }
        (found, buffers.work())
    }
}

struct Occluded<'a> {
    of: &'a Intersector,
    rays: &'a [Ray],
    t: &'a [f32],
    lights: &'a [SphereId],
}

impl Kernel for Occluded<'_> {
    type Output = (Vec<bool>, Work);
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (mut paths, mut buffers) = (Paths::new(), SearchBuffers::new());
        let mut lights: Words = [0; ROOM];
        let mut found = Vec::with_capacity(self.rays.len());
        let chunks = self.rays.chunks(BATCH).zip(self.t.chunks(BATCH)).zip(self.lights.chunks(BATCH));
        for ((rays, t), some_lights) in chunks {
            fill(&mut paths, rays);
            paths.t[..t.len()].copy_from_slice(t);
            lights[..t.len()].copy_from_slice(some_lights);
            occlude_batch::<L>(self.of, &mut paths, &lights, &mut buffers, t.len());
            found.extend(paths.t[..t.len()].iter().map(|t| *t == BLOCKED));
        }
        (found, buffers.work())
    }
}

#[inline(always)]
fn occlude_batch<L: Lanes>(
    of: &Intersector,
    paths: &mut Paths,
    lights: &Words,
    buffers: &mut SearchBuffers,
    count: usize,
) {
    let Paths { origin, direction, leaves, t, .. } = paths;
    let rays = Rays { origin, direction, leaves, ignores: lights, count, are_close: of.are_close };
    of.tables.occlude::<L>(&rays, buffers, t);
}

fn fill(paths: &mut Paths, rays: &[Ray]) {
    for (k, ray) in rays.iter().enumerate() {
        (paths.origin.x[k], paths.origin.y[k], paths.origin.z[k]) = ray.origin.into();
        (paths.direction.x[k], paths.direction.y[k], paths.direction.z[k]) = ray.direction.into();
        paths.leaves[k] = ray.leaves;
    }
}
