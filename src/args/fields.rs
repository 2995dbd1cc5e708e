//! Translates errors of the `render` crate into the command's terms: which option is at fault.

use crate::terminal::error::Error;
use render::Field;

impl From<render::Error> for Error {
    fn from(error: render::Error) -> Self {
        let text = error.problem().say(|field| name(field).into_owned());
        match error {
            render::Error::Input { .. } => Self::BadInput(text),
            render::Error::Failed(_) => Self::Failed(text),
        }
    }
}

/// The option that sets `field`; for fields without an option, a name for messages.
pub(super) fn name(field: Field) -> std::borrow::Cow<'static, str> {
    match field {
        Field::Scene => "the scene".into(),
        Field::Setting("photons_per_iteration") => "--photons".into(),
        Field::Setting("max_depth") => "--depth".into(),
        Field::Setting("initial_radius") => "--radius".into(),
        Field::Setting(name) => format!("--{}", name.replace('_', "-")).into(),
        Field::Method => "--method".into(),
        Field::Engine => "--engine".into(),
        Field::Lanes => "--lanes".into(),
        Field::Profile => "--profile".into(),
        Field::Threads => "--threads".into(),
        Field::MemoryLimit => "--memory-limit".into(),
        Field::Image => "--output".into(),
        Field::Exposure => "--exposure".into(),
        Field::Tone => "--tone".into(),
        Field::Snapshots => "--snapshots".into(),
        Field::RadiusImage => "--radius-image".into(),
        Field::CountImage => "--count-image".into(),
        Field::Stats => "--stats".into(),
        Field::Checkpoint => "--checkpoint".into(),
        Field::Range => "--range".into(),
        Field::Part => "--part".into(),
        Field::Parts => "one of the parts".into(),
        Field::Resumed => "the checkpoint".into(),
        Field::Like => "--like".into(),
        Field::Resume => "`sppm resume`".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_told_by_options_and_are_bad_input_or_failures() {
        let told = |field| Error::from(render::Error::named(field, "no"));
        for (field, option) in [
            (Field::Setting("photons_per_iteration"), "--photons"),
            (Field::Setting("max_depth"), "--depth"),
            (Field::Setting("initial_radius"), "--radius"),
            (Field::Setting("light_samples"), "--light-samples"),
            (Field::Setting("glint_samples"), "--glint-samples"),
            (Field::Method, "--method"),
            (Field::Engine, "--engine"),
            (Field::Lanes, "--lanes"),
            (Field::Profile, "--profile"),
            (Field::Threads, "--threads"),
            (Field::MemoryLimit, "--memory-limit"),
            (Field::Image, "--output"),
            (Field::Exposure, "--exposure"),
            (Field::Tone, "--tone"),
            (Field::Snapshots, "--snapshots"),
            (Field::RadiusImage, "--radius-image"),
            (Field::CountImage, "--count-image"),
            (Field::Stats, "--stats"),
            (Field::Checkpoint, "--checkpoint"),
            (Field::Range, "--range"),
            (Field::Part, "--part"),
            (Field::Parts, "one of the parts"),
            (Field::Resumed, "the checkpoint"),
            (Field::Like, "--like"),
            (Field::Scene, "the scene"),
            (Field::Resume, "`sppm resume`"),
        ] {
            let error = told(field);
            assert_eq!((error.to_string(), error.code()), (format!("{option}: no"), 2));
        }
        assert_eq!(Error::from(render::Error::failed("no")).code(), 1);
    }
}
