//! The names of engines and lanes, in files and on the command line.

use fast::LaneKind;
use scene::Sums;
use scene::text::list;
use serde::{Deserialize, Serialize};

/// The name of an engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum EngineName {
    /// Stochastic progressive photon mapping on vectors and all threads: the reference's image, bit for bit
    Fast,
    /// Stochastic progressive photon mapping in plain scalar code: the definition of the image
    Reference,
    /// A path tracer: ground truth without bias, noisy where there are caustics; iterations are samples per pixel
    Path,
}

/// The name of the lanes that the fast engine runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum LanesName {
    /// The widest that this processor has
    Auto,
    /// 8 lanes of AVX2
    Avx2,
    /// 16 lanes of AVX-512 (F, BW, DQ and VL)
    Avx512,
    /// 8 lanes of plain code, for any processor
    Emulated,
}

impl EngineName {
    /// All engines.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Reference, Self::Path];

    /// Whether the engine traces photons, so that there are radii and photon counts.
    pub fn has_photons(self) -> bool {
        match self {
            Self::Fast | Self::Reference => true,
            Self::Path => false,
        }
    }

    /// The default engine to resume `sums`.
    pub fn of(sums: Sums) -> Self {
        match sums {
            Sums::Photons => Self::Fast,
            Sums::Paths => Self::Path,
        }
    }

    /// The names of all engines that can resume `sums`, as a list for messages.
    pub fn all_of(sums: Sums) -> String {
        let names = Self::ALL.iter().filter(|engine| engine.sums() == sums).map(|engine| engine.name());
        list(&names.collect::<Vec<_>>())
    }

    /// The kind of sums that the engine keeps for each pixel.
    pub fn sums(self) -> Sums {
        if self.has_photons() { Sums::Photons } else { Sums::Paths }
    }

    /// The name, in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Reference => "reference",
            Self::Path => "path",
        }
    }
}

impl LanesName {
    /// All names.
    pub const ALL: [Self; 4] = [Self::Auto, Self::Avx2, Self::Avx512, Self::Emulated];

    /// The name, in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Emulated => "emulated",
        }
    }

    /// The lanes with that name; the widest available ones for `Auto`.
    pub fn kind(self) -> LaneKind {
        match self {
            Self::Auto => LaneKind::best(),
            Self::Avx2 => LaneKind::Avx2,
            Self::Avx512 => LaneKind::Avx512,
            Self::Emulated => LaneKind::Emulated,
        }
    }
}

impl From<LaneKind> for LanesName {
    fn from(kind: LaneKind) -> Self {
        match kind {
            LaneKind::Emulated => Self::Emulated,
            LaneKind::Avx2 => Self::Avx2,
            LaneKind::Avx512 => Self::Avx512,
        }
    }
}

/// The kinds of lanes that this processor supports, starting with the emulated ones.
pub fn available_lanes() -> impl Iterator<Item = LaneKind> {
    LaneKind::ALL.into_iter().filter(|kind| kind.is_available())
}
