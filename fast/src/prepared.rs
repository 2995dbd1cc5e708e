//! A still with the tables that the passes read.

use crate::direct_light::LightTable;
use crate::hierarchy::Hierarchy;
use crate::parameters::Parameters;
use crate::photon_pass::Emitters;
use crate::search::ball_count;
use crate::tables::Tables;
use scene::{Scene, Still, Vec3};

/// What a sphere takes in the tables and trees made of the scene, while they are built.
pub(crate) const BYTES_PER_SPHERE: u64 = 256;

/// A still with its tables.
pub(crate) struct Prepared<'a> {
    pub(crate) still: Still<'a>,
    pub(crate) tables: Tables,
    pub(crate) lights: LightTable,
    pub(crate) emitters: Emitters,
}

impl<'a> Prepared<'a> {
    /// With the hierarchy `old`, if that is of this still.
    pub(crate) fn new(still: Still<'a>, parameters: &Parameters, old: Option<Hierarchy>) -> Self {
        let search = parameters.search(ball_count(&still));
        let hierarchy = Hierarchy::reuse(old, &still, search);
        let tables = Tables::with_hierarchy(&still, hierarchy);
        let lights = LightTable::new(&still);
        let emitters = Emitters::new(&still);
        Self { still, tables, lights, emitters }
    }

    /// The only still of a scene, with the hierarchy `old` if that is of it; `None` if something moves.
    pub(crate) fn only(scene: &'a Scene, parameters: &Parameters, old: Option<Hierarchy>) -> Option<Self> {
        let moves = scene.spheres.iter().any(|s| s.velocity != Vec3::ZERO);
        (!moves).then(|| Self::new(scene.at(0.0), parameters, old))
    }
}
