//! Iterations whose photons are traced and joined in several rounds.

use crate::pair::{Way, all_lanes, assert_equal, tell};
use scene::Settings;

#[test]
fn rounds_of_photons() {
    let mut cases = 0;
    for name in ["cornell", "motion"] {
        let scene = files::builtin::scene(name).unwrap();
        // A round has at least the 1024 photons of one work item; the last round may have a single photon.
        let settings = Settings {
            width: 40,
            height: 27,
            iterations: 3,
            photons_per_iteration: 4 * 4096 + 1,
            initial_radius: 5.0,
            ..scene.settings
        };
        let in_rounds = |most| move |way| Way { deposits_at_once: Some(most), ..way };
        let ways: Vec<Way> = [1, 6000, 20_000]
            .into_iter()
            .flat_map(|most| all_lanes(2).into_iter().map(in_rounds(most)))
            .collect();
        cases += assert_equal(&scene, &settings, &ways);
    }
    tell(cases, "photons in 2 to 17 rounds");
}
