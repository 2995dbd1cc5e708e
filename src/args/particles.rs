//! Options for files of molecules and particles: how spheres are made of them, and the stage that shows them.

use super::frames::Frames;
use super::values::number;
use crate::terminal::error::Error;
use clap::Args as ClapArgs;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use figure::Frame;
use figure::recipe::{Bonds, Recipe, parse_frame};
use figure::stage::{Background, Light, Stage, View, is_matte};
use figure::units::Length;
use figure::{Refusal, Rule, Selection};
use files::named::{self, Opened};
use files::particles::{Clip, Problem, Scenery};
use render::{MethodName, Renderer};
use scene::Scene;
use std::path::Path;

/// How a file of particles is shown.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Particle files")]
pub(crate) struct ParticleArgs {
    /// The frame to show, from 0, or `last`; `render` also takes ranges, such as 3..10 (10 is left out), 3.., .. and 0..100:5,
    /// and makes an image of each frame [default: 0]
    ///
    /// The images of a range are numbered, as OUT-0003.png, or as `{frame}` in --output says. The camera stays as it suits
    /// the first of them. A frame that fails does not keep the others from being rendered.
    #[arg(long, value_name = "N|last|A..B", allow_hyphen_values = true)]
    frame: Option<String>,

    /// The frame to which camera, lamps and ground are fitted: its number, `last`, or `each` for every frame's own [default:
    /// the first of a range, else the one that is shown]
    #[arg(long, value_name = "N|last|each", allow_hyphen_values = true)]
    camera_frame: Option<String>,

    /// Where colours come from: `jmol`, `cpk` (of elements), `file`, a column such as `type`, `chain`, `molecule` or any
    /// property, a name such as `red`, or `#rrggbb`
    ///
    /// Columns with names take a palette, columns of numbers --map. By default: the file's own colours, or those of
    /// elements, or of types.
    #[arg(long, value_name = "WHAT")]
    color: Option<String>,

    /// The map for a column of numbers: viridis, cividis, inferno, magma, plasma, coolwarm or grey [default: viridis]
    #[arg(long, value_name = "NAME", requires = "color")]
    map: Option<String>,

    /// The values at both ends of the map, such as `-1..2.5` or `5%..95%` (percentiles) [default: 0%..100%]
    #[arg(long, value_name = "LOW..HIGH", requires = "color", allow_hyphen_values = true)]
    color_range: Option<String>,

    /// Radii: `vdw`, `covalent` (of elements), `touch` (half the distance of neighbours), a column, or a length in the
    /// file's unit
    ///
    /// By default: the file's own, or van der Waals radii, or such that neighbours touch.
    #[arg(long, value_name = "WHAT", allow_hyphen_values = true)]
    ball_radius: Option<String>,

    /// Multiply all radii by this
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    ball_scale: Option<String>,

    /// The surface: `matte`, `mirror`, `glass`, `glass 1.33` (its index of refraction), `light` or `light 10` (its radiance)
    /// [default: matte]
    #[arg(long, value_name = "KIND")]
    material: Option<String>,

    /// Show some particles otherwise: `WHERE: KEY=VALUE, ...` with the keys radius, scale, color, map, range, material and
    /// hide; can be repeated, and later rules win
    ///
    /// WHERE compares columns (x, y, z, element, type, name, residue, resid, chain, molecule, id, radius, any property), as
    /// in 'element == "O" and not z > 3' or 'type in (1, 2)'. Example: --style 'type == 2: color=red, material=glass'
    #[arg(long, value_name = "RULE")]
    style: Vec<String>,

    /// Show only the particles that this selects, such as 'x < 3'; can be repeated
    #[arg(long, value_name = "WHERE")]
    cut: Vec<String>,

    /// The unit of lengths in the file, by which radii of elements are scaled [default: as the format states, or else as the
    /// distances of neighbours suggest]
    #[arg(long, value_name = "UNIT", value_parser = names(Length::ALL.map(Length::name)))]
    unit: Option<String>,

    /// Move particles into the periodic cell
    #[arg(long)]
    wrap: bool,

    /// Draw bonds, as chains of small balls: those that the file states, or those that distances suggest
    #[arg(long, value_name = "SOURCE", value_parser = names(Bonds::ALL.map(Bonds::name)))]
    bonds: Option<String>,

    /// Draw the edges of the cell, as chains of small balls
    #[arg(long)]
    cell: bool,

    /// The direction of the view [default: iso with a cell, else principal, across the widest extent]; without a value,
    /// `render` serves a page that shows the image as it converges, and prints its address
    #[arg(long, value_name = "VIEW", num_args = 0..=1, value_parser = names(View::ALL.map(View::name)))]
    #[allow(clippy::option_option)] // not given, given alone, or with a value
    view: Option<Option<String>>,

    /// Magnify the image about its centre; at 1 everything just fits
    #[arg(long, value_name = "Z", value_parser = number(0.1, 1000.0), allow_hyphen_values = true)]
    zoom: Option<f32>,

    /// The lamps: `studio` (key, fill and rim), `overcast` (the background alone) or `dark` (for particles that glow)
    /// [default: studio]
    #[arg(long, value_name = "LIGHT", value_parser = names(Light::ALL.map(Light::name)))]
    light: Option<String>,

    /// Put a ground below, which touches the lowest particle
    #[arg(long)]
    ground: bool,

    /// The background, which also lights: a name such as white, grey or black, `#rrggbb`, or `transparent`, for .png, .exr
    /// and .tif files with alpha, lit as by default [default: white; black with --light dark]
    #[arg(long, value_name = "COLOR")]
    background: Option<String>,
}

/// The method and engine for a scene if no option names them: path tracing for one on a stage without caustics, as photons of
/// the few iterations of a quick picture show as spots; else photon mapping.
pub(crate) fn usual_renderer(is_staged: bool, scene: &Scene) -> Renderer {
    if is_staged && is_matte(&scene.materials) { MethodName::Path.into() } else { Renderer::default() }
}

/// The frame that is shown if none is asked for.
const FIRST: Frame = Frame::Number(0);

/// What `--camera-frame` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CameraFrame {
    /// Nothing.
    Usual,
    /// Every frame has a camera of its own.
    Each,
    /// This frame.
    Of(Frame),
}

/// The frame that the value of an `option` names.
fn frame_of(option: &str, text: &str) -> Result<Frame, Error> {
    parse_frame(text).map_err(|problem| Error::BadInput(format!("{option}: {problem}")))
}

/// Accepts one of `names`.
fn names<const N: usize>(names: [&'static str; N]) -> impl TypedValueParser<Value = String> {
    PossibleValuesParser::new(names)
}

impl ParticleArgs {
    /// Refuses the options for `name`, which is no file of particles.
    pub(crate) fn refuse(&self, name: &str) -> Result<(), Error> {
        match self.first() {
            None => Ok(()),
            Some(option) => Err(Error::BadInput(format!(
                "{option}: this is for files of particles, such as .xyz or .pdb, and {name} is none; scene files say it in \
                 [[particles]]"
            ))),
        }
    }

    /// The direction of the view, if it is given.
    fn direction(&self) -> Option<&str> {
        self.view.as_ref()?.as_deref()
    }

    /// Whether `--view` is given without a direction, for a page.
    pub(crate) fn asks_for_a_page(&self) -> bool {
        matches!(self.view, Some(None))
    }

    /// The first of the options that is given.
    fn first(&self) -> Option<&'static str> {
        let base = self.base();
        let given = [
            ("--frame", self.frame.is_some()),
            ("--camera-frame", self.camera_frame.is_some()),
            (base.first().map_or("", |(option, ..)| option), !base.is_empty()),
            ("--style", !self.style.is_empty()),
            ("--cut", !self.cut.is_empty()),
            ("--unit", self.unit.is_some()),
            ("--wrap", self.wrap),
            ("--bonds", self.bonds.is_some()),
            ("--cell", self.cell),
            ("--view", self.direction().is_some()),
            ("--zoom", self.zoom.is_some()),
            ("--light", self.light.is_some()),
            ("--ground", self.ground),
            ("--background", self.background.is_some()),
        ];
        given.into_iter().find(|(_, is_given)| *is_given).map(|(option, _)| option)
    }

    /// The options for all particles, with the keys of the rule that they make, and their values.
    fn base(&self) -> Vec<(&'static str, &'static str, &str)> {
        let options = [
            ("--color", "color", &self.color),
            ("--map", "map", &self.map),
            ("--color-range", "range", &self.color_range),
            ("--ball-radius", "radius", &self.ball_radius),
            ("--ball-scale", "scale", &self.ball_scale),
            ("--material", "material", &self.material),
        ];
        options
            .into_iter()
            .filter_map(|(option, key, value)| Some((option, key, value.as_deref()?)))
            .collect()
    }

    /// Reads the file of particles `path`, in at most about `most` bytes of memory, and puts it on a stage for an image of
    /// this `size`, if it is asked for.
    pub(crate) fn open(&self, path: &Path, size: [Option<u32>; 2], most: u64) -> Result<Opened, Error> {
        if self.frames()?.is_some() {
            let problem = "--frame: only `render` takes a range of frames; name one";
            return Err(Error::BadInput(problem.into()));
        }
        let frame = self.frame.as_deref().map(|text| frame_of("--frame", text)).transpose()?;
        let (recipe, stage) = (self.recipe(frame.unwrap_or(FIRST))?, self.stage(size)?);
        let opened = match self.camera_frame()? {
            CameraFrame::Of(frame) => {
                let clip = Clip::open(path).map_err(Error::BadInput)?;
                let scenery = self.scenery(&clip, frame, &stage, most)?;
                let staged = clip.stage(&recipe, &stage, Some(&scenery), most);
                staged.map(|(staged, _)| named::of_particles(path, staged))
            }
            CameraFrame::Usual | CameraFrame::Each => named::open_particles(path, &recipe, &stage, most),
        };
        opened.map_err(|problem| Error::BadInput(self.say(path, &problem)))
    }

    /// The range of frames, if one is asked for.
    pub(crate) fn frames(&self) -> Result<Option<Frames>, Error> {
        let range = self.frame.as_deref().filter(|text| text.contains(".."));
        let parsed = range.map(Frames::parse).transpose();
        parsed.map_err(|problem| Error::BadInput(format!("--frame: {problem}")))
    }

    /// The frame that the camera is fitted to.
    pub(crate) fn camera_frame(&self) -> Result<CameraFrame, Error> {
        match self.camera_frame.as_deref() {
            None => Ok(CameraFrame::Usual),
            Some("each") => Ok(CameraFrame::Each),
            Some(text) => match parse_frame(text) {
                Ok(frame) => Ok(CameraFrame::Of(frame)),
                Err(problem) => Err(Error::BadInput(format!("--camera-frame: {problem}, or each"))),
            },
        }
    }

    /// The stage that suits `frame`.
    pub(crate) fn scenery(
        &self,
        clip: &Clip,
        frame: Frame,
        stage: &Stage,
        most: u64,
    ) -> Result<Scenery, Error> {
        let staged = clip.stage(&self.recipe(frame)?, stage, None, most);
        staged.map(|(_, scenery)| scenery).map_err(|problem| Error::BadInput(self.say(clip.path(), &problem)))
    }

    /// How `frame` is made balls.
    pub(crate) fn recipe(&self, frame: Frame) -> Result<Recipe, Error> {
        let bad = |option: &str, problem: String| Error::BadInput(format!("{option}: {problem}"));
        let mut recipe = Recipe { frame, wrap: self.wrap, cell: self.cell, ..Recipe::default() };
        let keys = [("unit", &self.unit), ("bonds", &self.bonds)];
        for (key, value) in keys {
            if let Some(value) = value {
                recipe.set(key, value).map_err(|problem| bad(&format!("--{key}"), problem))?;
            }
        }
        for cut in &self.cut {
            let parsed =
                Selection::parse(cut).map_err(|error| bad("--cut", format!("{error} of '{cut}'")))?;
            recipe.cut.push(parsed);
        }
        let mut base = Rule::default();
        for (option, key, value) in self.base() {
            base.set(key, value).map_err(|problem| bad(option, problem))?;
        }
        if base != Rule::default() {
            recipe.style.push(base);
        }
        for rule in &self.style {
            recipe.style.push(Rule::parse(rule).map_err(|problem| bad("--style", problem))?);
        }
        Ok(recipe)
    }

    /// The stage for an image of this size, if one is asked for.
    pub(crate) fn stage(&self, [width, height]: [Option<u32>; 2]) -> Result<Stage, Error> {
        let usual = Stage::default();
        let background = self.background.as_deref().map(Background::parse).transpose();
        let bad = |problem| Error::BadInput(format!("--background: {problem}"));
        let light = self.light.as_deref();
        Ok(Stage {
            view: self.direction().and_then(|name| View::ALL.into_iter().find(|view| view.name() == name)),
            zoom: self.zoom.map_or(usual.zoom, f64::from),
            light: Light::ALL.into_iter().find(|kind| Some(kind.name()) == light).unwrap_or_default(),
            ground: self.ground,
            background: background.map_err(bad)?.unwrap_or_default(),
            size: [width.unwrap_or(usual.size[0]), height.unwrap_or(usual.size[1])],
        })
    }

    /// The problem in terms of options.
    pub(crate) fn say(&self, path: &Path, problem: &Problem) -> String {
        let Problem::Recipe(Refusal { rule, key, problem }) = problem else { return problem.to_string() };
        let base = self.base();
        match rule.map(|rule| rule.checked_sub(usize::from(!base.is_empty()))) {
            Some(Some(rule)) => {
                let text = self.style.get(rule).map_or("", String::as_str);
                format!("--style: {key}: {problem} (in '{text}')")
            }
            Some(None) => {
                let option =
                    base.iter().find(|(_, of, _)| of == key).map_or("--color", |(option, ..)| option);
                format!("{option}: {problem}")
            }
            None if *key == "file" => format!("{}: {problem}", path.display()),
            None => format!("--{key}: {problem}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    fn of(words: &[&str]) -> ParticleArgs {
        of_render(&[&["a.xyz"], words].concat()).source.particles
    }

    const ALL: [&[&str]; 18] = [
        &["--frame", "3"],
        &["--camera-frame", "last"],
        &["--color", "red"],
        &["--ball-radius", "2"],
        &["--ball-scale", "0.5"],
        &["--material", "glass"],
        &["--style", "x < 3: hide"],
        &["--cut", "x < 3"],
        &["--unit", "nanometre"],
        &["--wrap"],
        &["--bonds", "file"],
        &["--cell"],
        &["--view", "iso"],
        &["--zoom", "2"],
        &["--light", "dark"],
        &["--ground"],
        &["--background", "grey"],
        &["--color", "x"],
    ];

    /// Whatever is given of them, the first is named where there are no particles.
    #[test]
    fn every_option_is_refused_for_other_scenes() {
        assert!(of(&[]).refuse("cornell").is_ok() && of(&["--view"]).refuse("cornell").is_ok());
        for words in ALL {
            let problem = of(words).refuse("cornell").unwrap_err().to_string();
            assert!(
                problem.starts_with(&format!("{}: this is for files of particles", words[0])),
                "{problem}"
            );
        }
        let both = of(&["--ground", "--frame", "1"]).refuse("cornell").unwrap_err().to_string();
        assert!(both.starts_with("--frame: "), "{both}");
    }

    #[test]
    fn a_view_without_a_direction_is_a_page() {
        assert!(of(&["--view"]).asks_for_a_page() && of(&["--view"]).direction().is_none());
        assert!(!of(&["--view", "iso"]).asks_for_a_page() && !of(&[]).asks_for_a_page());
        assert_eq!(of(&["--view", "iso"]).direction(), Some("iso"));
    }

    #[test]
    fn frames_are_one_or_a_range_and_the_camera_has_its_own() {
        assert_eq!(of(&[]).frames().unwrap(), None);
        assert_eq!(of(&["--frame", "7"]).frames().unwrap(), None);
        assert!(of(&["--frame", "1..4"]).frames().unwrap().is_some());
        let problem = of(&["--frame", "4..1"]).frames().unwrap_err().to_string();
        assert!(problem.starts_with("--frame: `4..1` is not a range of frames"), "{problem}");
        let camera = |words: &[&str]| of(words).camera_frame().unwrap();
        assert_eq!(camera(&[]), CameraFrame::Usual);
        assert_eq!(camera(&["--camera-frame", "each"]), CameraFrame::Each);
        assert_eq!(camera(&["--camera-frame", "5"]), CameraFrame::Of(Frame::Number(5)));
        assert_eq!(camera(&["--camera-frame", "last"]), CameraFrame::Of(Frame::Last));
        let problem = of(&["--camera-frame", "x"]).camera_frame().unwrap_err().to_string();
        assert!(problem.starts_with("--camera-frame: "), "{problem}");
        let opened = of(&["--frame", "1..4"]).open(Path::new("a.xyz"), [None; 2], 0).unwrap_err().to_string();
        assert_eq!(opened, "--frame: only `render` takes a range of frames; name one");
    }

    /// Each option is in the recipe, and nothing else changes by it.
    #[test]
    fn a_recipe_has_what_is_asked_for() {
        let recipe = |words: &[&str]| of(words).recipe(Frame::Number(2)).unwrap();
        let usual = Recipe { frame: Frame::Number(2), ..Recipe::default() };
        assert_eq!(recipe(&[]), usual);
        assert_eq!(recipe(&["--wrap"]), Recipe { wrap: true, ..usual.clone() });
        assert_eq!(recipe(&["--cell"]), Recipe { cell: true, ..usual.clone() });
        let set = |key: &str, value: &str| {
            let mut recipe = usual.clone();
            recipe.set(key, value).unwrap();
            recipe
        };
        assert_eq!(recipe(&["--unit", "nanometre"]), set("unit", "nanometre"));
        assert_eq!(recipe(&["--bonds", "file"]), set("bonds", "file"));
        let cuts = recipe(&["--cut", "x < 3", "--cut", "y < 1"]).cut;
        assert_eq!(cuts, ["x < 3", "y < 1"].map(|cut| Selection::parse(cut).unwrap()));
        // What is for all balls comes before what is for some, which wins.
        let style = recipe(&["--style", "x < 3: hide", "--color", "red", "--ball-scale", "2"]).style;
        let mut base = Rule::default();
        base.set("color", "red").unwrap();
        base.set("scale", "2").unwrap();
        assert_eq!(style, [base, Rule::parse("x < 3: hide").unwrap()]);
        for (words, start) in [
            (["--cut", "x <"], "--cut: "),
            (["--style", "x"], "--style: "),
            (["--ball-scale", "x"], "--ball-scale: "),
            (["--material", "x"], "--material: "),
        ] {
            let problem = of(&words).recipe(FIRST).unwrap_err().to_string();
            assert!(problem.starts_with(start), "{problem}");
        }
    }

    /// With several of them, it would not be known which.
    #[test]
    fn the_selection_at_fault_is_told() {
        let cuts = ["--cut", "x < 3", "--cut", "y <", "--cut", "z < 1"];
        let problem = of(&cuts).recipe(FIRST).unwrap_err().to_string();
        assert!(problem.starts_with("--cut: ") && problem.ends_with(" of 'y <'"), "{problem}");
    }

    /// Of the frame that is shown, and of that to which the camera is fitted. The second frame takes more than the limit.
    #[test]
    fn a_memory_limit_holds_for_every_frame_that_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xyz");
        let frame = |atoms: usize| {
            let row = |i: usize| format!("O {} 0 0\n", 3 * i);
            let rows: String = (0..atoms).map(row).collect();
            format!("{atoms}\n\n{rows}")
        };
        std::fs::write(&path, frame(2) + &frame(100)).unwrap();
        let open = |words: &[&str]| of(words).open(&path, [None; 2], 1024).map_err(|error| error.to_string());
        for words in [
            &["--frame", "1"][..],
            &["--frame", "1", "--camera-frame", "0"],
            &["--frame", "0", "--camera-frame", "1"],
        ] {
            let problem = open(words).err().unwrap();
            assert!(problem.contains("100 particles need "), "{words:?}: {problem}");
        }
        // Nothing has been tried yet.
        let gone = of(&["--camera-frame", "0"]).open(&folder.path().join("b.xyz"), [None; 2], 1024);
        assert_eq!(gone.unwrap_err().code(), 2);
        for words in [&["--frame", "0"][..], &["--frame", "0", "--camera-frame", "0"]] {
            assert!(open(words).is_ok(), "{words:?}");
        }
    }

    #[test]
    fn a_stage_is_as_asked_for() {
        let stage = |words: &[&str], size| of(words).stage(size).unwrap();
        let usual = Stage::default();
        assert_eq!(stage(&[], [None; 2]), usual);
        assert_eq!(stage(&[], [Some(7), None]), Stage { size: [7, usual.size[1]], ..usual });
        assert_eq!(stage(&[], [None, Some(7)]), Stage { size: [usual.size[0], 7], ..usual });
        assert_eq!(stage(&["--zoom", "2.5"], [None; 2]), Stage { zoom: 2.5, ..usual });
        assert_eq!(stage(&["--ground"], [None; 2]), Stage { ground: true, ..usual });
        for view in View::ALL {
            assert_eq!(stage(&["--view", view.name()], [None; 2]), Stage { view: Some(view), ..usual });
        }
        for light in Light::ALL {
            assert_eq!(stage(&["--light", light.name()], [None; 2]), Stage { light, ..usual });
        }
        let grey = Background::parse("grey").unwrap();
        assert_eq!(stage(&["--background", "grey"], [None; 2]), Stage { background: grey, ..usual });
        let problem = of(&["--background", "x"]).stage([None; 2]).unwrap_err().to_string();
        assert!(problem.starts_with("--background: "), "{problem}");
    }

    /// A rule that does not suit the file is told by the option that made it.
    #[test]
    fn refusals_name_the_option_at_fault() {
        let said = |words: &[&str], rule, key: &'static str| {
            let refusal = Refusal { rule, key, problem: "no".into() };
            of(words).say(Path::new("a.xyz"), &Problem::Recipe(refusal))
        };
        let style = ["--style", "x < 3: hide", "--style", "y < 1: hide"];
        assert_eq!(said(&style, Some(1), "color"), "--style: color: no (in 'y < 1: hide')");
        let both = [&style[..], &["--ball-radius", "x", "--color", "y"]].concat();
        assert_eq!(said(&both, Some(1), "color"), "--style: color: no (in 'x < 3: hide')");
        assert_eq!(said(&both, Some(0), "radius"), "--ball-radius: no");
        assert_eq!(said(&both, Some(0), "color"), "--color: no");
        assert_eq!(said(&both, Some(0), "hide"), "--color: no");
        assert_eq!(said(&[], None, "file"), "a.xyz: no");
        assert_eq!(said(&[], None, "bonds"), "--bonds: no");
        let read = Problem::Read("a.xyz:3: no".into());
        assert_eq!(of(&[]).say(Path::new("a.xyz"), &read), read.to_string());
    }
}
