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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::Search;
    use scene::{Rgb, Sphere, Vec3};

    #[test]
    fn balls_are_searched_as_the_parameters_say() {
        let scene = files::builtin::scene("random").unwrap();
        let search = |in_turn, in_clusters| {
            let parameters = Parameters::default().with("most_balls_in_turn", in_turn).unwrap();
            let parameters = parameters.with("most_balls_in_clusters", in_clusters).unwrap();
            match Prepared::new(scene.at(0.0), &parameters, None).tables.hierarchy {
                Hierarchy::InTurn => Search::InTurn,
                Hierarchy::Clusters(_) => Search::Clusters,
                Hierarchy::Tree(_) => Search::Tree,
            }
        };
        let searches = [search(4096.0, 0.0), search(0.0, 4096.0), search(0.0, 0.0)];
        assert_eq!(searches, [Search::InTurn, Search::Clusters, Search::Tree]);
    }

    /// What the tables of a room take that holds so many balls, and what is told of so many spheres.
    fn taken_and_told(balls: u32) -> [f64; 2] {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.spheres.extend((0..balls).map(|i| Sphere {
            center: Vec3::from([i % 40, i / 40 % 40, i / 1600].map(|c| 2.0 * c as f32)),
            velocity: Vec3::ZERO,
            radius: 0.5,
            material: 0,
            emission: Rgb::ZERO,
        }));
        let taken = Tables::new(&scene.at(0.0)).bytes();
        [taken as f64, bytes_of_spheres(scene.spheres.len()) as f64]
    }

    /// In turn, in clusters and in a tree.
    #[test]
    fn tables_take_no_more_than_is_told() {
        let many = [0, 1, 100, 1000, 4000, 10_000, 30_000].map(taken_and_told);
        for [taken, told] in many {
            assert!(taken <= told, "{taken} bytes, {told} are told");
        }
        // Of many spheres each takes little, and hardly less than is told.
        let [taken, told] = [0, 1].map(|k| (many[6][k] - many[5][k]) / 20_000.0);
        assert!(taken <= told && told < 1.1 * taken, "{taken} bytes each, {told} are told");
    }
}
