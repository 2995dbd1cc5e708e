//! A still scene as the kernels read it.
//!
//! Two tables of rows of eight words, from which lanes fetch what they hit by loads and a transpose (on the
//! machines at hand four times faster than eight gathers), a list of shapes to broadcast, and the balls in a hierarchy
//! if they are many.

use crate::hierarchy::{Hierarchy, Search};
use crate::lanes::{Lanes, Row};
use crate::vec3::V3;
use scene::ray::SphereId;
use scene::still::{Enclosure, Role};
use scene::{Material, Sphere, Still};

/// Low bits of a surface's tag.
pub(crate) mod tag {
    /// Met from inside.
    pub(crate) const ENCLOSURE: u32 = 1;
    /// Met from both sides.
    pub(crate) const GLASS: u32 = 2;
    /// Glows.
    pub(crate) const EMITTER: u32 = 4;
    /// What the material's number is shifted by.
    pub(crate) const MATERIAL_SHIFT: i32 = 3;
}

/// Kinds of material, as a material's row tells them.
pub(crate) mod kind {
    pub(crate) const DIFFUSE: u32 = 0;
    pub(crate) const SPECULAR: u32 = 1;
    pub(crate) const DIELECTRIC: u32 = 2;
}

/// What the intersection broadcasts of a sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    Solid(Ball),
    Glass(Ball),
    Enclosure(Enclosure),
}

/// A sphere met from outside, or from both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) sphere: SphereId,
    pub(crate) center: scene::Vec3,
    pub(crate) radius_squared: f32,
}

/// The tables of one still.
pub(crate) struct Tables {
    /// Per sphere: point and scale and shift of its normal, and a tag. With p on the sphere, the vector from the
    /// centre is `(p - a) + b`; words: a.x a.y a.z scale b.x b.y b.z tag. For an enclosure a is the anchor, b its
    /// offset and the scale `-1 / radius`; for others a is the centre, b zero and the scale the radius.
    pub(crate) surfaces: Vec<Row>,
    /// Per material: red, green, blue, index of refraction, kind.
    pub(crate) materials: Vec<Row>,
    /// What rays may hit outside of the hierarchy, in order of the spheres.
    pub(crate) shapes: Vec<Shape>,
    /// What may stand before a light outside of the hierarchy, in order of the spheres.
    pub(crate) shadow_casters: Vec<Shape>,
    pub(crate) hierarchy: Hierarchy,
}

impl Tables {
    pub(crate) fn new(still: &Still) -> Self {
        Self::with_hierarchy(still, Hierarchy::new(still))
    }

    pub(crate) fn with_search(still: &Still, search: Search) -> Self {
        Self::with_hierarchy(still, Hierarchy::with_search(still, search))
    }

    fn with_hierarchy(still: &Still, hierarchy: Hierarchy) -> Self {
        let is_apart = |role: &Role| matches!(role, Role::Enclosure(_)) || !hierarchy.holds_balls();
        let ids = (0..still.spheres.len() as SphereId).filter(|id| is_apart(&still.roles[*id as usize]));
        let shapes: Vec<Shape> = ids.map(|id| shape(still, id)).collect();
        let casts_shadow = |s: &&Shape| !matches!(s, Shape::Enclosure(e) if !e.casts_shadow);
        let shadow_casters = shapes.iter().filter(casts_shadow).copied().collect();
        let spheres = still.spheres.iter().zip(&still.roles);
        let surfaces = never_empty(spheres.map(|(s, role)| surface_row(still, s, *role)).collect());
        let materials = never_empty(still.materials.iter().map(material_row).collect());
        Self { surfaces, materials, shapes, shadow_casters, hierarchy }
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        let rows = size_of_val(&self.surfaces[..]) + size_of_val(&self.materials[..]);
        let shapes = size_of_val(&self.shapes[..]) + size_of_val(&self.shadow_casters[..]);
        rows + shapes + self.hierarchy.bytes()
    }
}

/// Lanes that have hit nothing fetch row 0, so there is one even where there is nothing to hit.
fn never_empty(mut rows: Vec<Row>) -> Vec<Row> {
    if rows.is_empty() {
        rows.push(Row::default());
    }
    rows
}

/// What the intersection broadcasts of sphere `id`.
pub(crate) fn shape(still: &Still, id: SphereId) -> Shape {
    let s = &still.spheres[id as usize];
    let ball = Ball { sphere: id, center: s.center, radius_squared: s.radius * s.radius };
    match still.roles[id as usize] {
        Role::Solid => Shape::Solid(ball),
        Role::Glass => Shape::Glass(ball),
        Role::Enclosure(e) => Shape::Enclosure(still.enclosures[e as usize]),
    }
}

fn surface_row(still: &Still, sphere: &Sphere, role: Role) -> Row {
    let (a, scale, b, side) = match role {
        Role::Solid => (sphere.center, sphere.radius, scene::Vec3::ZERO, 0),
        Role::Glass => (sphere.center, sphere.radius, scene::Vec3::ZERO, tag::GLASS),
        Role::Enclosure(e) => {
            let e = &still.enclosures[e as usize];
            (e.anchor, e.minus_inverse_radius, e.offset, tag::ENCLOSURE)
        }
    };
    let glow = if sphere.is_emitter() { tag::EMITTER } else { 0 };
    let tag = f32::from_bits((sphere.material << tag::MATERIAL_SHIFT) | glow | side);
    Row([a.x, a.y, a.z, scale, b.x, b.y, b.z, tag])
}

fn material_row(material: &Material) -> Row {
    let c = material.albedo();
    let (ior, kind) = match *material {
        Material::Diffuse { .. } => (1.0, kind::DIFFUSE),
        Material::Specular { .. } => (1.0, kind::SPECULAR),
        Material::Dielectric { ior, .. } => (ior, kind::DIELECTRIC),
    };
    Row([c.x, c.y, c.z, ior, f32::from_bits(kind), 0.0, 0.0, 0.0])
}

/// What lanes have hit.
pub(crate) struct Surface<L: Lanes> {
    pub(crate) point: V3<L>,
    pub(crate) normal: V3<L>,
    pub(crate) inside: L::M,
    /// `-1 / radius` for an enclosure, else the radius.
    pub(crate) scale: L::F,
    pub(crate) tag: L::U,
}

impl<L: Lanes> Surface<L> {
    /// The points at distance `t` along the rays, on the spheres `hit` (each a valid id).
    #[inline(always)]
    pub(crate) fn at(tables: &Tables, origin: V3<L>, direction: V3<L>, t: L::F, hit: &[u32]) -> Self {
        let [ax, ay, az, scale, bx, by, bz, tag] = L::gather_rows(&tables.surfaces, hit);
        let (a, tag) = (V3::<L>::new(ax, ay, az), L::bits(tag));
        let point = origin + direction.scale(t);
        let from_a = point - a;
        let in_shell = L::eq(tag & L::u(tag::ENCLOSURE), L::u(tag::ENCLOSURE));
        let shell_normal = (from_a + V3::new(bx, by, bz)).scale(scale);
        // To unit length, by the reference's step.
        let shell_normal = shell_normal.scale(L::f(1.5) - L::f(0.5) * shell_normal.dot(shell_normal));
        if !L::any(!in_shell) {
            return Self { point, normal: shell_normal, inside: in_shell, scale, tag };
        }
        let outward = from_a.scale(L::f(1.0) / L::sqrt(from_a.dot(from_a)));
        let is_glass = L::eq(tag & L::u(tag::GLASS), L::u(tag::GLASS));
        let inside_glass = is_glass & L::lt(L::f(0.0), outward.dot(direction));
        let ball_normal = V3::select(inside_glass, -outward, outward);
        Self {
            point: V3::select(in_shell, point, a + outward.scale(scale)),
            normal: V3::select(in_shell, shell_normal, ball_normal),
            inside: in_shell | inside_glass,
            scale,
            tag,
        }
    }
}

/// The materials of lanes: albedo, index of refraction, kind.
pub(crate) struct Materials<L: Lanes> {
    pub(crate) albedo: V3<L>,
    pub(crate) ior: L::F,
    pub(crate) kind: L::U,
}

impl<L: Lanes> Materials<L> {
    #[inline(always)]
    pub(crate) fn of(tables: &Tables, tag: L::U) -> Self {
        let mut index = [0; crate::lanes::MOST_LANES];
        L::store_u(L::shr::<{ tag::MATERIAL_SHIFT }>(tag), &mut index);
        let [r, g, b, ior, kind, ..] = L::gather_rows(&tables.materials, &index);
        Self { albedo: V3::new(r, g, b), ior, kind: L::bits(kind) }
    }
}
