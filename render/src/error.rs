//! Errors of a render. Messages refer to fields, which each front end can print under its own names.

use std::fmt;

/// Why a render could not start, or failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// A request is invalid. No image was written.
    Input {
        /// The field at fault.
        field: Field,
        /// One sentence: what is wrong, and how to fix it.
        problem: Problem,
    },
    /// The render failed while it ran, or the system denied a resource. One sentence.
    Failed(Problem),
}

/// An input of a render: a field of [`crate::Job`], or something that the job was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Field {
    /// The scene, or its file.
    Scene,
    /// A setting, by its name in scene files.
    Setting(&'static str),
    /// The method.
    Method,
    /// `engine`.
    Engine,
    /// The vectors of the fast engine.
    Lanes,
    /// The file of free parameters.
    Profile,
    /// `threads`.
    Threads,
    /// `memory_limit`.
    MemoryLimit,
    /// `outputs.image`.
    Image,
    /// `outputs.exposure`.
    Exposure,
    /// `outputs.tone`.
    Tone,
    /// `outputs.snapshots`.
    Snapshots,
    /// `outputs.radius_image`.
    RadiusImage,
    /// `outputs.count_image`.
    CountImage,
    /// `outputs.stats`.
    Stats,
    /// `save`.
    Checkpoint,
    /// `range`.
    Range,
    /// Not a field: which part of how many is asked for.
    Part,
    /// Not a field: the files that are merged.
    Parts,
    /// The checkpoint that is resumed.
    Resumed,
    /// The file whose render is repeated.
    Like,
    /// Not a field: the operation that resumes a render from its checkpoint.
    Resume,
}

impl Field {
    /// The name of the field in this library.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Setting(name) => name,
            Self::Method => "method",
            Self::Engine => "engine",
            Self::Lanes => "lanes",
            Self::Profile => "profile",
            Self::Threads => "threads",
            Self::MemoryLimit => "memory_limit",
            Self::Image => "image",
            Self::Exposure => "exposure",
            Self::Tone => "tone",
            Self::Snapshots => "snapshots",
            Self::RadiusImage => "radius_image",
            Self::CountImage => "count_image",
            Self::Stats => "stats",
            Self::Checkpoint => "checkpoint",
            Self::Range => "range",
            Self::Part => "part",
            Self::Parts => "parts",
            Self::Resumed => "the checkpoint",
            Self::Like => "like",
            Self::Resume => "Job::resume",
        }
    }
}

/// A sentence that may contain names of fields, which a front end replaces by its own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problem(Vec<Piece>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    Field(Field),
}

impl Problem {
    /// A sentence that begins with the name of `field`.
    pub fn of(field: Field) -> Self {
        Self(vec![Piece::Field(field)])
    }

    /// Appends `text`.
    #[must_use]
    pub fn text(mut self, text: impl fmt::Display) -> Self {
        self.0.push(Piece::Text(text.to_string()));
        self
    }

    /// Appends the name of `field`.
    #[must_use]
    pub fn field(mut self, field: Field) -> Self {
        self.0.push(Piece::Field(field));
        self
    }

    /// Appends another problem.
    #[must_use]
    pub fn join(mut self, rest: &Self) -> Self {
        self.0.extend_from_slice(&rest.0);
        self
    }

    /// The sentence, with the names of fields given by `name`.
    pub fn say(&self, name: impl Fn(Field) -> String) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Field(field) => name(*field),
        };
        self.0.iter().map(piece).collect()
    }
}

impl From<String> for Problem {
    fn from(text: String) -> Self {
        Self(vec![Piece::Text(text)])
    }
}

impl From<&str> for Problem {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.say(|field| field.name().into()))
    }
}

impl Error {
    /// An input error of `field`; `problem` is the whole sentence.
    pub fn input(field: Field, problem: impl Into<Problem>) -> Self {
        Self::Input { field, problem: problem.into() }
    }

    /// An input error of `field` with the message `name: problem`.
    pub fn named(field: Field, problem: impl fmt::Display) -> Self {
        Self::input(field, Problem::of(field).text(": ").text(problem))
    }

    /// A failure.
    pub fn failed(problem: impl Into<Problem>) -> Self {
        Self::Failed(problem.into())
    }

    /// The message.
    pub fn problem(&self) -> &Problem {
        let (Self::Input { problem, .. } | Self::Failed(problem)) = self;
        problem
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problem().fmt(f)
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_end_names_fields_in_its_own_words() {
        let problem = Problem::of(Field::Lanes).text(": ").field(Field::Engine).text(" path has no lanes");
        assert_eq!(problem.to_string(), "lanes: engine path has no lanes");
        let dashed = problem.say(|field| format!("--{}", field.name()));
        assert_eq!(dashed, "--lanes: --engine path has no lanes");
        let error = Error::named(Field::Setting("width"), "is 0");
        assert_eq!(error.to_string(), "width: is 0");
    }

    /// What a front end prints is the field's name in this library, unless it has another.
    #[test]
    fn fields_have_names_of_their_own() {
        use Field as F;
        let all = [
            F::Scene,
            F::Setting("width"),
            F::Method,
            F::Engine,
            F::Lanes,
            F::Profile,
            F::Threads,
            F::MemoryLimit,
            F::Image,
            F::Exposure,
            F::Tone,
            F::Snapshots,
            F::RadiusImage,
            F::CountImage,
            F::Stats,
            F::Checkpoint,
            F::Range,
            F::Part,
            F::Parts,
            F::Resumed,
            F::Like,
            F::Resume,
        ];
        let names: std::collections::HashSet<&str> = all.iter().map(|field| field.name()).collect();
        assert_eq!(names.len(), all.len());
        assert!(
            ["width", "memory_limit", "radius_image", "Job::resume"].iter().all(|name| names.contains(name))
        );
        let joined = Problem::of(Field::Stats).text(" a").join(&Problem::from("b").field(Field::Like));
        assert_eq!(joined.to_string(), "stats ablike");
        assert_eq!(Error::failed("it").problem().to_string(), "it");
    }
}
