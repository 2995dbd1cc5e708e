//! The unit of lengths of a file: as its format states it, or as distances between neighbours suggest.

use crate::neighbours::nearest;
use importers::elements::element;
use importers::{Format, Particles};

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// 10^-10 m.
    Angstrom,
    /// 10^-9 m.
    Nanometre,
    /// One metre.
    Metre,
}

impl Length {
    /// All units.
    pub const ALL: [Self; 3] = [Self::Angstrom, Self::Nanometre, Self::Metre];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Angstrom => "angstrom",
            Self::Nanometre => "nanometre",
            Self::Metre => "metre",
        }
    }

    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let text =
            if text == "nanometer" || text == "meter" { text.replace("er", "re") } else { text.into() };
        let found = Self::ALL.into_iter().find(|unit| unit.name() == text);
        found.ok_or_else(|| format!("`{text}` must be {}", Self::ALL.map(Self::name).join(", ")))
    }

    /// One angstrom in this unit.
    pub fn per_angstrom(self) -> f64 {
        match self {
            Self::Angstrom => 1.0,
            Self::Nanometre => 0.1,
            Self::Metre => 1e-10,
        }
    }
}

/// One angstrom in the unit of `particles`: as `asked`, as the format prescribes, or else such that the distances between
/// neighbours are those of atoms.
pub(crate) fn per_angstrom(particles: &Particles, asked: Option<Length>) -> f64 {
    if let Some(unit) = asked {
        return unit.per_angstrom();
    }
    // In XYZ files angstrom is a custom, which many do not follow.
    let stated = particles.unit.in_angstrom().filter(|_| particles.format != Format::Xyz);
    stated.map_or_else(|| guess(particles), |length| 1.0 / length)
}

fn guess(particles: &Particles) -> f64 {
    let usual = Length::Angstrom;
    let (Some(distance), Some(atoms)) = (nearest(&particles.positions), &particles.elements) else {
        return usual.per_angstrom();
    };
    let radii = atoms.iter().filter_map(|&atom| element(atom)?.covalent).map(f64::from);
    let (sum, count) = radii.fold((0.0, 0.0), |(sum, count), radius| (sum + radius, count + 1.0));
    if count == 0.0 {
        return usual.per_angstrom();
    }
    let bond = 2.0 * sum / count;
    // The unit in which a bond is nearest to the distance of neighbours, as a ratio.
    let apart = |unit: &Length| libm::fabs(libm::log(distance / (bond * unit.per_angstrom())));
    let best = Length::ALL.into_iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    best.unwrap_or(usual).per_angstrom()
}
