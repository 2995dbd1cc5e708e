//! A still with the tables that the passes read.

use crate::direct_light::LightTable;
use crate::hierarchy::Hierarchy;
use crate::parameters::Parameters;
use crate::photon_pass::Emitters;
use crate::search::ball_count;
use crate::tables::Tables;
use scene::Still;

/// A still with its tables.
pub(super) struct Prepared<'a> {
    pub(super) still: Still<'a>,
    pub(super) tables: Tables,
    pub(super) lights: LightTable,
    pub(super) emitters: Emitters,
}

impl<'a> Prepared<'a> {
    /// With the hierarchy `old`, if that is of this still.
    pub(super) fn new(still: Still<'a>, parameters: &Parameters, old: Option<Hierarchy>) -> Self {
        let search = parameters.search(ball_count(&still));
        let hierarchy = Hierarchy::reuse(old, &still, search);
        let tables = Tables::with_hierarchy(&still, hierarchy);
        let lights = LightTable::new(&still);
        let emitters = Emitters::new(&still);
        Self { still, tables, lights, emitters }
    }
}
