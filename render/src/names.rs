//! The names of methods, engines and lanes, in files and on the command line.

use fast::LaneKind;
use scene::{RadiusSchedule, Settings, Sums};
use serde::{Deserialize, Serialize};

/// The name of a method: an algorithm, which defines the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum MethodName {
    /// Stochastic progressive photon mapping: converges everywhere, caustics included
    #[default]
    Sppm,
    /// Path tracing: ground truth without bias, noisy where there are caustics; iterations are samples per pixel
    Path,
    /// Path tracing, and photons for caustics: for open scenes, under a sky, with small lamps
    Hybrid,
}

/// The name of an engine: an implementation. Both give the same image, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum EngineName {
    /// On vectors
    #[default]
    Fast,
    /// In plain scalar code: the definition of the image
    Reference,
}

/// A method, and the engine that renders by it.
///
/// Files of earlier versions have no method: their engine `path` is read as the method of that name, by the fast engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Recorded")]
pub struct Renderer {
    /// The method.
    pub method: MethodName,
    /// The engine.
    pub engine: EngineName,
}

/// A [`Renderer`] as files have it.
#[derive(Deserialize)]
struct Recorded {
    #[serde(default)]
    method: MethodName,
    engine: RecordedEngine,
}

/// The name of an engine as files have it.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum RecordedEngine {
    Fast,
    Reference,
    /// As files of earlier versions have it.
    Path,
}

impl From<Recorded> for Renderer {
    fn from(recorded: Recorded) -> Self {
        match recorded.engine {
            RecordedEngine::Fast => Self { method: recorded.method, engine: EngineName::Fast },
            RecordedEngine::Reference => Self { method: recorded.method, engine: EngineName::Reference },
            RecordedEngine::Path => MethodName::Path.into(),
        }
    }
}

/// Photon mapping by this engine.
impl From<EngineName> for Renderer {
    fn from(engine: EngineName) -> Self {
        Self { engine, ..Self::default() }
    }
}

/// This method by the fast engine.
impl From<MethodName> for Renderer {
    fn from(method: MethodName) -> Self {
        Self { method, ..Self::default() }
    }
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

impl MethodName {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::Sppm, Self::Path, Self::Hybrid];

    /// Whether photons are traced, so that there are radii and photon counts.
    pub fn has_photons(self) -> bool {
        self != Self::Path
    }

    /// The method that keeps `sums`.
    pub fn of(sums: Sums) -> Self {
        match sums {
            Sums::Photons | Sums::Exact => Self::Sppm,
            Sums::Paths => Self::Path,
            Sums::Hybrid => Self::Hybrid,
        }
    }

    /// The kind of sums that the method keeps for each pixel, with these settings.
    pub fn sums(self, settings: &Settings) -> Sums {
        match (self, settings.radius_schedule) {
            (Self::Sppm, RadiusSchedule::PerPixel) => Sums::Photons,
            (Self::Sppm, RadiusSchedule::Global) => Sums::Exact,
            (Self::Path, _) => Sums::Paths,
            (Self::Hybrid, _) => Sums::Hybrid,
        }
    }

    /// The name, in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sppm => "sppm",
            Self::Path => "path",
            Self::Hybrid => "hybrid",
        }
    }
}

impl EngineName {
    /// All engines.
    pub const ALL: [Self; 2] = [Self::Fast, Self::Reference];

    /// The name, in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Reference => "reference",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renderers_are_read_as_this_and_earlier_versions_write_them() {
        let read = |text: &str| serde_json::from_str::<Renderer>(text).ok();
        for method in MethodName::ALL {
            for engine in EngineName::ALL {
                let renderer = Renderer { method, engine };
                assert_eq!(read(&serde_json::to_string(&renderer).unwrap()), Some(renderer));
            }
        }
        assert_eq!(read(r#"{"engine": "fast"}"#), Some(EngineName::Fast.into()));
        assert_eq!(read(r#"{"engine": "reference"}"#), Some(EngineName::Reference.into()));
        assert_eq!(read(r#"{"engine": "path"}"#), Some(MethodName::Path.into()));
        assert_eq!(read(r#"{"engine": "gpu"}"#), None);
        assert_eq!(read(r#"{"method": "path"}"#), None);
    }

    #[test]
    fn each_kind_of_sums_has_its_method() {
        for method in MethodName::ALL {
            assert_eq!(MethodName::of(method.sums(&Settings::default())), method);
        }
    }

    /// Names are those that files and options have.
    #[test]
    fn each_name_is_that_of_files() {
        fn written(name: impl Serialize) -> String {
            serde_json::to_string(&name).unwrap().trim_matches('"').to_owned()
        }
        for method in MethodName::ALL {
            assert_eq!(written(method), method.name());
        }
        for engine in EngineName::ALL {
            assert_eq!(written(engine), engine.name());
        }
        for lanes in LanesName::ALL {
            assert_eq!(written(lanes), lanes.name());
        }
    }

    #[test]
    fn lanes_are_named_and_found_again() {
        for kind in LaneKind::ALL {
            assert_eq!(LanesName::from(kind).kind(), kind);
        }
        assert_eq!(LanesName::Auto.kind(), LaneKind::best());
        let available: Vec<LaneKind> = available_lanes().collect();
        assert!(available[0] == LaneKind::Emulated && available.contains(&LaneKind::best()));
        assert!(available.iter().all(|kind| kind.is_available()));
    }

    #[test]
    fn only_photon_mapping_has_photons_and_sums_follow_the_schedule() {
        let global = Settings { radius_schedule: RadiusSchedule::Global, ..Settings::default() };
        assert!(MethodName::Sppm.has_photons() && !MethodName::Path.has_photons());
        assert!(MethodName::Hybrid.has_photons());
        assert_eq!(MethodName::Sppm.sums(&Settings::default()), Sums::Photons);
        assert_eq!(MethodName::Sppm.sums(&global), Sums::Exact);
        assert_eq!(MethodName::Path.sums(&global), Sums::Paths);
        assert_eq!(MethodName::of(Sums::Exact), MethodName::Sppm);
    }
}
