//! The surfaces that rays hit: a row per sphere, and the point and normal of each hit.
//!
//! Rows are in a table of 32 bytes a sphere. Made when a surface is hit, from the sphere, its role and its material, they would
//! take no memory; but among ten million spheres three lines would come from memory for one, and a segment take a third more
//! time.

use crate::rows;
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, Row, V3, prefetch};
use scene::ray::SphereId;
use scene::still::Role;
use scene::{Still, Vec3};

/// The bits of a surface's tag.
pub(crate) mod tag {
    use lanes::Lanes;

    /// Met from inside.
    pub(crate) const ENCLOSURE: u32 = 1;
    /// Met from both sides.
    pub(crate) const GLASS: u32 = 2;
    /// Glows.
    pub(crate) const EMITTER: u32 = 4;
    /// Met from outside, close to the eye.
    pub(crate) const GROUND: u32 = 8;
    /// The bits above these hold the number of the material.
    pub(crate) const MATERIAL_SHIFT: i32 = 4;

    /// The lanes whose tag has the bit.
    #[inline(always)]
    pub(crate) fn has<L: Lanes>(tag: L::U, bit: u32) -> L::M {
        L::eq(tag & L::u(bit), L::u(bit))
    }
}

/// A sphere's row.
///
/// For a point p on the sphere, the vector from the centre is `(p - anchor) + offset`. For an enclosure the anchor is the
/// point nearest to the eye (`scene::still::Enclosure`) and `scale` is `-1 / radius`; for a ground likewise, but that `scale` is
/// `1 / radius`. For a ball the anchor is the centre, the offset is zero and `scale` is the radius.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SurfaceRow {
    anchor: [f32; 3],
    scale: f32,
    offset: [f32; 3],
    /// See [`tag`].
    tag: u32,
}

/// The row of sphere `id`.
#[inline]
pub(crate) fn surface_row(still: &Still, id: SphereId) -> Row {
    let (sphere, role) = (&still.spheres[id as usize], still.roles[id as usize]);
    let (anchor, scale, offset, side) = match role {
        Role::Solid => (sphere.center, sphere.radius, Vec3::ZERO, 0),
        Role::Glass => (sphere.center, sphere.radius, Vec3::ZERO, tag::GLASS),
        Role::Ground(g) => {
            let g = &still.grounds[g as usize];
            (g.anchor, g.inverse_radius, g.offset, tag::GROUND)
        }
        Role::Enclosure(e) => {
            let e = &still.enclosures[e as usize];
            (e.anchor, e.minus_inverse_radius, e.offset, tag::ENCLOSURE)
        }
    };
    let glow = if sphere.is_emitter() { tag::EMITTER } else { 0 };
    let tag = (sphere.material << tag::MATERIAL_SHIFT) | glow | side;
    bytemuck::cast(SurfaceRow { anchor: anchor.into(), scale, offset: offset.into(), tag })
}

/// Rows of a table that is in the cache: 256 KiB.
const ROWS_IN_CACHE: usize = 1 << 13;

/// Prefetches the rows of the spheres that rays have hit, unless the table is in the cache. A hit may be no sphere.
pub(crate) fn prefetch_rows(rows: &[Row], hits: &[SphereId]) {
    if rows.len() > ROWS_IN_CACHE {
        for hit in hits {
            prefetch(rows, *hit as usize);
        }
    }
}

/// Of the balls with these ids, whose rows are in the table `rows`: centres, radii, and which are of glass.
#[inline(always)]
pub(crate) fn ball_lanes<L: Lanes>(rows: &[Row], ids: &[u32]) -> (V3<L>, L::F, L::M) {
    let [x, y, z, radius, .., tag] = L::gather_rows(rows, ids);
    (V3::new(x, y, z), radius, tag::has::<L>(L::bits(tag), tag::GLASS))
}

/// Which of the spheres with these ids, rows of the table, are no balls.
#[inline(always)]
pub(crate) fn are_anchored<L: Lanes>(rows: &[Row], ids: &[u32]) -> L::M {
    let [.., tag] = L::gather_rows(rows, ids);
    !L::eq(L::bits(tag) & L::u(tag::ENCLOSURE | tag::GROUND), L::u(0))
}

/// [`SurfaceRow`]s in lanes.
struct SurfaceLanes<L: Lanes> {
    anchor: V3<L>,
    scale: L::F,
    offset: V3<L>,
    tag: L::U,
}

impl<L: Lanes> SurfaceLanes<L> {
    /// The rows of the spheres with these ids.
    #[inline(always)]
    fn gather(surfaces: &[Row], ids: &[u32]) -> Self {
        let [ax, ay, az, scale, bx, by, bz, tag] = rows::gather::<L>(surfaces, ids);
        Self { anchor: V3::new(ax, ay, az), scale, offset: V3::new(bx, by, bz), tag: L::bits(tag) }
    }
}

/// Where rays hit surfaces.
pub(crate) struct Hit<L: Lanes> {
    /// The point, moved onto the sphere.
    pub(crate) point: V3<L>,
    /// Unit normal, on the side that the ray comes from.
    pub(crate) normal: V3<L>,
    /// True where the ray comes from inside.
    pub(crate) inside: L::M,
    /// `-1 / radius` of an enclosure, `1 / radius` of a ground, the radius of a ball.
    pub(crate) scale: L::F,
    /// See [`tag`].
    pub(crate) tag: L::U,
}

impl<L: Lanes> Hit<L> {
    /// The points at distance `t` along the rays, on the spheres with these ids.
    #[inline(always)]
    pub(crate) fn at(surfaces: &[Row], origin: V3<L>, direction: V3<L>, t: L::F, ids: &[u32]) -> Self {
        let SurfaceLanes { anchor, scale, offset, tag } = SurfaceLanes::<L>::gather(surfaces, ids);
        let point = origin + direction.scale(t);
        let from_anchor = point - anchor;
        let in_shell = tag::has::<L>(tag, tag::ENCLOSURE);
        let shell_normal = (from_anchor + offset).scale(scale);
        // One step of Newton's method to unit length, as in the reference.
        let shell_normal = shell_normal.scale(L::f(1.5) - L::f(0.5) * shell_normal.dot(shell_normal));
        if !L::any(!in_shell) {
            return Self { point, normal: shell_normal, inside: in_shell, scale, tag };
        }
        let outward = from_anchor.scale(L::f(1.0) / L::sqrt(from_anchor.dot(from_anchor)));
        let (mut ball_point, mut outward) = (anchor + outward.scale(scale), outward);
        let on_ground = tag::has::<L>(tag, tag::GROUND);
        if L::any(on_ground) {
            let (point, normal) = on_to_ground(from_anchor, offset, scale);
            ball_point = V3::select(on_ground, anchor + point, ball_point);
            outward = V3::select(on_ground, normal, outward);
        }
        let inside_glass = tag::has::<L>(tag, tag::GLASS) & L::lt(L::f(0.0), outward.dot(direction));
        let ball_normal = V3::select(inside_glass, -outward, outward);
        Self {
            point: V3::select(in_shell, point, ball_point),
            normal: V3::select(in_shell, shell_normal, ball_normal),
            inside: in_shell | inside_glass,
            scale,
            tag,
        }
    }
}

/// The point on a ground below a point, both from its anchor, and the normal there: as `reference::intersect::surface_at`.
#[inline(always)]
fn on_to_ground<L: Lanes>(from_anchor: V3<L>, offset: V3<L>, inverse_radius: L::F) -> (V3<L>, V3<L>) {
    let outward = (from_anchor + offset).scale(inverse_radius);
    let twice_offset = offset + offset;
    let height = from_anchor.dot(from_anchor + twice_offset) * (L::f(0.5) * inverse_radius);
    let point = from_anchor - outward.scale(height);
    let normal = (point + offset).scale(inverse_radius);
    (point, normal.scale(L::f(1.5) - L::f(0.5) * normal.dot(normal)))
}
