//! A still scene as the kernels read it.

use crate::hierarchy::Hierarchy;
use crate::material::material_row;
use crate::parameters::Parameters;
use crate::search::Search;
use crate::shapes::Shape;
use crate::surface::{Surfaces, surface_row};
use lanes::Row;
use scene::Still;
use scene::ray::SphereId;
use scene::still::Role;

/// The tables of one still. Rows are fetched by lanes; shapes are broadcast to lanes.
pub(crate) struct Tables {
    /// A row per sphere ([`surface_row`]); empty if spheres are too many (`Parameters::most_surface_rows`).
    surfaces: Vec<Row>,
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
        let most_rows = Parameters::default().most_surface_rows;
        Self::with_hierarchy(still, Hierarchy::new(still), most_rows)
    }

    /// With the given search.
    pub(crate) fn with_search(still: &Still, search: Search) -> Self {
        let most_rows = Parameters::default().most_surface_rows;
        Self::with_hierarchy(still, Hierarchy::with_search(still, search), most_rows)
    }

    /// With the given hierarchy, which must be of this still, and the most spheres that have a table of surfaces.
    pub(crate) fn with_hierarchy(still: &Still, hierarchy: Hierarchy, most_rows: u32) -> Self {
        let is_shape = |role: &Role| matches!(role, Role::Enclosure(_)) || !hierarchy.holds_balls();
        let ids = (0..still.spheres.len() as SphereId).filter(|id| is_shape(&still.roles[*id as usize]));
        let shapes: Vec<Shape> = ids.map(|id| Shape::of(still, id)).collect();
        let casts_shadow = |s: &&Shape| !matches!(s, Shape::Enclosure(e) if !e.casts_shadow);
        let shadow_casters = shapes.iter().filter(casts_shadow).copied().collect();
        let surfaces = match hierarchy {
            Hierarchy::Tree(_) if still.spheres.len() > most_rows as usize => Vec::new(),
            _ => {
                let ids = 0..still.spheres.len() as SphereId;
                never_empty(ids.map(|id| surface_row(still, id)).collect())
            }
        };
        let materials = never_empty(still.materials.iter().map(material_row).collect());
        Self { surfaces, materials, shapes, shadow_casters, hierarchy }
    }

    /// The surfaces of the spheres of `still`, which these tables must be of. Those of `hits` are asked for, if they have to
    /// come from memory; a hit may be no sphere.
    #[inline(always)]
    pub(crate) fn surfaces<'a>(&'a self, still: &'a Still<'a>, hits: &[SphereId]) -> Surfaces<'a> {
        let surfaces = Surfaces { rows: &self.surfaces, still };
        surfaces.prefetch(hits);
        surfaces
    }

    /// The rows of the surfaces; empty if there are too many.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[Row] {
        &self.surfaces
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
