//! A still scene as the kernels read it.

use crate::hierarchy::{Hierarchy, SearchBuffers};
use crate::intersect::occlude;
use crate::material::material_row;
use crate::pages::Pages;
use crate::paths::Floats;
use crate::rays::Rays;
use crate::search::Search;
use crate::shape_list::ShapeList;
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
    /// The spheres that can be tested one by one.
    pub(crate) shapes: ShapeList,
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
        let is_shape = |role: &Role| role.is_anchored() || !matches!(hierarchy, Hierarchy::Tree(_));
        let ids = (0..still.spheres.len() as SphereId).filter(|id| is_shape(&still.roles[*id as usize]));
        let shapes: Vec<Shape> = ids.map(|id| Shape::of(still, id)).collect();
        let shapes = ShapeList::new(shapes, !hierarchy.holds_balls());
        // Lanes that have hit nothing fetch row 0.
        let count = still.spheres.len();
        let row = |id| if id < count { surface_row(still, id as SphereId) } else { Row::default() };
        let surfaces = Pages::made(count.max(1), row);
        let materials = never_empty(still.materials.iter().map(material_row).collect());
        Self { surfaces, materials, shapes, hierarchy }
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
        let chosen = self.shapes.choose::<L>(rays, Some(t), &mut buffers.places);
        let are_all = chosen.are_all;
        occlude::<L::Pair>(chosen, rays, t);
        if !are_all {
            self.hierarchy.occlude::<L>(self.rows(), rays, buffers, t);
        }
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        let rows = size_of_val(&self.surfaces[..]) + size_of_val(&self.materials[..]);
        rows + self.shapes.bytes() + self.hierarchy.bytes()
    }
}

/// Lanes that have hit nothing fetch row 0, so every table needs one row.
fn never_empty(mut rows: Vec<Row>) -> Vec<Row> {
    if rows.is_empty() {
        rows.push(Row::default());
    }
    rows
}
