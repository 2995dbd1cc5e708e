//! Options for when a render ends, and for writing checkpoints.

use super::frames::numbered;
use super::values::{every, positive, time};
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args as ClapArgs, ValueHint};
use render::{Every, Goals, Save};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// When a render ends, beside its iterations.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Goals (the render ends with the first that is reached)")]
pub(crate) struct GoalArgs {
    /// End after so much time, such as 90s, 10m or 2h (90 is 90s); iterations are then as many as it takes, unless -n says
    /// more
    ///
    /// The first iteration is always finished; the one in progress when time is up is abandoned.
    #[arg(long, value_name = "T", value_parser = time, allow_hyphen_values = true)]
    pub time: Option<Duration>,

    /// End once the estimated relative error is at most E, such as 0.05
    ///
    /// The estimate is the root of the relative mean-square error that `sppm compare` would give against the converged image:
    /// noise, from how much the image changed since an earlier iteration, and the bias of photon mapping, from two radii.
    #[arg(long, value_name = "E", value_parser = positive, allow_hyphen_values = true)]
    pub until_error: Option<f64>,
}

impl GoalArgs {
    /// The goals given on the command line; an error goal that is not given is taken from `usual`.
    pub(crate) fn or(&self, usual: Goals) -> Goals {
        Goals { time: self.time, error: self.until_error.or(usual.error) }
    }
}

/// What is kept of a render on its way.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Checkpoints")]
pub(crate) struct CheckpointArgs {
    /// Save the render to FILE as it goes, and keep the last state [default: OUT.sppm, removed when all is done]
    ///
    /// `sppm resume FILE` goes on from there, and so does the same `sppm render`. The generation before is in FILE.1.
    #[arg(long, value_name = "FILE", conflicts_with = "no_checkpoint", value_parser = PathBufValueParser::new().try_map(file), value_hint = ValueHint::FilePath)]
    pub checkpoint: Option<PathBuf>,

    /// How often to save, and to refresh the image: a time, such as 30s or 5m, or a number of iterations [default: 60s]
    #[arg(long, value_name = "T|N", value_parser = every, conflicts_with = "no_checkpoint", allow_hyphen_values = true)]
    pub every: Option<Every>,

    /// Save nothing
    #[arg(long)]
    pub no_checkpoint: bool,
}

/// A path that is not `-`, which stands for standard output elsewhere; a checkpoint cannot be streamed.
fn file(path: PathBuf) -> Result<PathBuf, &'static str> {
    if path == Path::new("-") {
        return Err("is standard output, which cannot hold a checkpoint; name a file");
    }
    Ok(path)
}

impl CheckpointArgs {
    /// Those of one frame of a trajectory.
    pub(crate) fn of_frame(&self, number: usize) -> Self {
        let checkpoint = self.checkpoint.as_deref().map(|path| numbered(path, number));
        Self { checkpoint, ..self.clone() }
    }

    /// How to save the render that writes `image`; `None` with `--no-checkpoint`, or if neither a checkpoint nor an image
    /// is named.
    pub(crate) fn save(&self, image: Option<&Path>) -> Option<Save> {
        if self.no_checkpoint {
            return None;
        }
        let every = self.every.unwrap_or_default();
        match &self.checkpoint {
            Some(path) => Some(Save { path: path.clone(), keep: true, every }),
            None => image.map(|image| Save { every, ..Save::beside(image) }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    #[test]
    fn goals_are_those_given_and_an_error_stays() {
        let of = |words: &[&str]| of_render(&[&["cornell"], words].concat()).goals;
        let usual = Goals { time: Some(Duration::from_secs(9)), error: Some(0.5) };
        assert_eq!(of(&[]).or(usual), Goals { time: None, error: Some(0.5) });
        let given = of(&["--time", "3s", "--until-error", "0.1"]).or(usual);
        assert_eq!(given, Goals { time: Some(Duration::from_secs(3)), error: Some(0.1) });
    }

    #[test]
    fn checkpoints_are_beside_the_image_or_where_they_are_named() {
        let of = |words: &[&str]| of_render(&[&["cornell"], words].concat()).checkpoints;
        let image = Some(Path::new("a.png"));
        let save = |path: &str, every, keep| Some(Save { path: path.into(), every, keep });
        let usual = Every::default();
        assert_eq!(of(&[]).save(image), save("a.png.sppm", usual, false));
        assert_eq!(of(&[]).save(None), None);
        assert_eq!(of(&["--every", "7"]).save(image), save("a.png.sppm", Every::Iterations(7), false));
        assert_eq!(of(&["--no-checkpoint"]).save(image), None);
        let named = of(&["--checkpoint", "b.sppm", "--every", "7"]);
        assert_eq!(
            [named.save(image), named.save(None)],
            [(); 2].map(|()| save("b.sppm", Every::Iterations(7), true))
        );
        assert_eq!(named.of_frame(3).save(None), save("b-0003.sppm", Every::Iterations(7), true));
        assert_eq!(of(&[]).of_frame(3).checkpoint, None);
        // What holds for a render holds for each frame.
        assert_eq!(of(&["--no-checkpoint"]).of_frame(3).save(image), None);
        let often = of(&["--every", "7"]).of_frame(3);
        assert_eq!(often.save(image), save("a.png.sppm", Every::Iterations(7), false));
        assert!(file("-".into()).is_err() && file("a".into()).is_ok());
    }
}
