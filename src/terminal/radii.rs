//! How first radii of the pixels' own are told.

use scene::Settings;
use scene::text::counted;

/// By what pixels begin with narrower radii than the initial one, if by anything: the rest of a phrase that begins with that
/// radius.
pub(crate) fn own_radii(settings: &Settings) -> Option<String> {
    let Settings { radius_pilots, radius_clearance, .. } = settings;
    let pilots =
        (*radius_pilots > 0).then(|| format!("by pilots of {}", counted(*radius_pilots, "iteration")));
    let clearance = (*radius_clearance > 0.0).then(|| format!("by clearance times {radius_clearance}"));
    let ways: Vec<String> = pilots.into_iter().chain(clearance).collect();
    (!ways.is_empty()).then(|| format!("at most, {}", ways.join(" and ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_way_is_told() {
        let of = |radius_pilots, radius_clearance| {
            own_radii(&Settings { radius_pilots, radius_clearance, ..Settings::default() })
        };
        assert_eq!(of(0, 0.0), None);
        assert_eq!(of(1, 0.0).as_deref(), Some("at most, by pilots of 1 iteration"));
        assert_eq!(of(0, 0.7).as_deref(), Some("at most, by clearance times 0.7"));
        let both = "at most, by pilots of 2 iterations and by clearance times 0.5";
        assert_eq!(of(2, 0.5).as_deref(), Some(both));
    }
}
