//! Materials: a table with a row per material.

use crate::rows;
use crate::surface::tag;
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::Material;

/// The kinds of material.
pub(crate) mod kind {
    pub(crate) const DIFFUSE: u32 = 0;
    pub(crate) const SPECULAR: u32 = 1;
    pub(crate) const DIELECTRIC: u32 = 2;
}

/// A material's row in the table.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct MaterialRow {
    albedo: [f32; 3],
    /// Index of refraction; 1 unless it is glass.
    ior: f32,
    /// See [`kind`].
    kind: u32,
    unused: [f32; 3],
}

/// The row of a material.
pub(crate) fn material_row(material: &Material) -> Row {
    let (ior, kind) = match *material {
        Material::Diffuse { .. } => (1.0, kind::DIFFUSE),
        Material::Specular { .. } => (1.0, kind::SPECULAR),
        Material::Dielectric { ior, .. } => (ior, kind::DIELECTRIC),
    };
    bytemuck::cast(MaterialRow { albedo: material.albedo().into(), ior, kind, unused: [0.0; 3] })
}

/// Materials in lanes.
pub(crate) struct Materials<L: Lanes> {
    pub(crate) albedo: V3<L>,
    /// Index of refraction; 1 unless it is glass.
    pub(crate) ior: L::F,
    /// See [`kind`].
    pub(crate) kind: L::U,
}

impl<L: Lanes> Materials<L> {
    /// The materials of surfaces with these tags.
    #[inline(always)]
    pub(crate) fn gather(materials: &[Row], tag: L::U) -> Self {
        let mut index = [0; MOST_LANES];
        L::store_u(L::shr::<{ tag::MATERIAL_SHIFT }>(tag), &mut index);
        let [r, g, b, ior, kind, ..] = rows::gather::<L>(materials, &index);
        Self { albedo: V3::new(r, g, b), ior, kind: L::bits(kind) }
    }
}
