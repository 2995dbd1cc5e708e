//! A still with the tables that the passes read.

use crate::direct_light::LightTable;
use crate::hierarchy::Hierarchy;
use crate::parameters::Parameters;
use crate::search::ball_count;
use crate::tables::Tables;
use scene::still::Carried;
use scene::{Scene, Still};

/// What a sphere takes in the tables made of a scene of few.
pub(crate) const BYTES_PER_SPHERE: u64 = 256;
/// What each of many spheres takes: 22 in the tree, a box for sixteen while it is built, and a row of 32 for its surface.
const BYTES_OF_MANY: u64 = 56;
/// So many spheres are few. Of more, most are balls: a room for each would hold the eye.
const FEW: u64 = 4096;

/// What so many spheres take in the tables and trees made of the scene, while they are built.
pub(crate) fn bytes_of_spheres(spheres: usize) -> u64 {
    let spheres = spheres as u64;
    spheres.min(FEW) * BYTES_PER_SPHERE + spheres.saturating_sub(FEW) * BYTES_OF_MANY
}

/// A still with its tables.
pub(crate) struct Prepared<'a> {
    pub(crate) still: Still<'a>,
    pub(crate) tables: Tables,
    pub(crate) lights: LightTable,
}

impl<'a> Prepared<'a> {
    /// With the hierarchy `old`, if that is of this still.
    pub(crate) fn new(still: Still<'a>, parameters: &Parameters, old: Option<Hierarchy>) -> Self {
        let search = parameters.search(ball_count(&still));
        let hierarchy = Hierarchy::reuse(old, &still, search);
        let tables = Tables::with_hierarchy(&still, hierarchy);
        let lights = LightTable::new(&still);
        Self { still, tables, lights }
    }

    /// The only still of a scene, with the hierarchy `old` if that is of it; `None` if something moves.
    pub(crate) fn only(
        scene: &'a Scene,
        carried: Carried,
        parameters: &Parameters,
        old: Option<Hierarchy>,
    ) -> Option<Self> {
        (!scene.moves()).then(|| Self::new(scene.at_for(0.0, carried), parameters, old))
    }
}
