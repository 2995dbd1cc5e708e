//! A still scene as the kernels read it.

use crate::hierarchy::{Hierarchy, SearchBuffers};
use crate::intersect::occlude;
use crate::material::material_row;
use crate::pages::Pages;
use crate::paths::Floats;
use crate::rays::Rays;
use crate::search::Search;
use crate::shapes::Shape;
use crate::surface::{prefetch_rows, surface_row};
use lanes::{Lanes, Row};
use scene::Still;
use scene::ray::SphereId;
use scene::still::Role;

/// The tables of one still. Rows are fetched by lanes; shapes are broadcast to lanes.
pub(crate) struct Tables {
    /// A row per sphere ([`surface_row`]).
    surfaces: Pages<Row>,
    /// A row per material ([`material_row`]).
    pub(crate) materials: Vec<Row>,
    /// The spheres that are not in the hierarchy, in order of their ids.
    pub(crate) shapes: Vec<Shape>,
    /// Those of them that may block light, in order of their ids.
    pub(crate) shadow_casters: Vec<Shape>,
    /// The balls, if they are many.
    pub(crate) hierarchy: Hierarchy,
}

impl Tables {
    /// With the search that is usually fastest.
    pub(crate) fn new(still: &Still) -> Self {
        Self::with_hierarchy(still, Hierarchy::new(still))
    }

    /// With the given search.
    pub(crate) fn with_search(still: &Still, search: Search) -> Self {
        Self::with_hierarchy(still, Hierarchy::with_search(still, search))
    }

    /// With the given hierarchy, which must be of this still.
    pub(crate) fn with_hierarchy(still: &Still, hierarchy: Hierarchy) -> Self {
        let is_shape = |role: &Role| role.is_anchored() || !hierarchy.holds_balls();
        let ids = (0..still.spheres.len() as SphereId).filter(|id| is_shape(&still.roles[*id as usize]));
        let shapes: Vec<Shape> = ids.map(|id| Shape::of(still, id)).collect();
        let casts_shadow = |s: &&Shape| !matches!(s, Shape::Enclosure(e) if !e.casts_shadow);
        let shadow_casters = shapes.iter().filter(casts_shadow).copied().collect();
        // Lanes that have hit nothing fetch row 0.
        let count = still.spheres.len();
        let row = |id| if id < count { surface_row(still, id as SphereId) } else { Row::default() };
        let surfaces = Pages::made(count.max(1), row);
        let materials = never_empty(still.materials.iter().map(material_row).collect());
        Self { surfaces, materials, shapes, shadow_casters, hierarchy }
    }

    /// The rows of the surfaces, of which those of `hits` are asked for, if they have to come from memory.
    #[inline(always)]
    pub(crate) fn surfaces(&self, hits: &[SphereId]) -> &[Row] {
        prefetch_rows(&self.surfaces, hits);
        &self.surfaces
    }

    /// The rows of the surfaces.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[Row] {
        &self.surfaces
    }

    /// Sets `t` to [`BLOCKED`](crate::rays::BLOCKED) where a shadow ray hits anything nearer than `t`.
    #[inline(always)]
    pub(crate) fn occlude<L: Lanes>(&self, rays: &Rays, buffers: &mut SearchBuffers, t: &mut Floats) {
        occlude::<L::Pair>(&self.shadow_casters, rays, t);
        self.hierarchy.occlude::<L>(self.rows(), rays, buffers, t);
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        let rows = size_of_val(&self.surfaces[..]) + size_of_val(&self.materials[..]);
        let shapes = size_of_val(&self.shapes[..]) + size_of_val(&self.shadow_casters[..]);
        rows + shapes + self.hierarchy.bytes()
    }
}

/// Lanes that have hit nothing fetch row 0, so every table needs one row.
fn never_empty(mut rows: Vec<Row>) -> Vec<Row> {
    if rows.is_empty() {
        rows.push(Row::default());
    }
    rows
}
