//! Files of particles as parts of scenes: read, checked by their digests, and written as tables `[[particles]]`.

use crate::atomic_file::reason;
use crate::input;
use figure::{Balls, Recipe, Refusal, Rule, Set, Stage, balls, stage};
use importers::{Format, Particles, Trajectory};
use scene::{Import, Scene, Settings, Sphere};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::io::{self, Read as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Memory per particle while its file is read and made spheres; 80 where it has an element alone, and more with names and
/// properties (`figure/tests/memory.rs`).
pub(crate) const BYTES_PER_PARTICLE: u64 = 128;

/// Bytes of a file that are in memory while its digest is made.
const READ_AT_ONCE: u64 = 1 << 20;

/// Why a file of particles cannot be part of a scene.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Problem {
    /// It cannot be read: one line with its name.
    #[error("{0}")]
    Read(String),
    /// It is not the file that was meant: one line with its name.
    #[error("{0}")]
    Changed(String),
    /// The recipe does not suit it.
    #[error("{0}")]
    Recipe(Refusal),
    /// The stage does not suit it: what is wrong, and what would be right.
    #[error("{0}")]
    Stage(String),
}

/// What a file of particles holds, and the SHA-256 of its bytes.
#[derive(Debug)]
pub(crate) struct Source {
    /// The particles.
    pub(crate) particles: Particles,
    /// In hexadecimal.
    pub(crate) digest: String,
}

/// Reads the frame of the file `path` that `recipe` asks for, in at most `most` bytes of memory.
///
/// # Errors
/// If it cannot be read: one line.
fn read(path: &Path, recipe: &Recipe, most: u64) -> Result<Source, String> {
    read_of(path, digest(path)?, recipe, most)
}

/// As [`read`], of a file with this `digest`.
fn read_of(path: &Path, digest: String, recipe: &Recipe, most: u64) -> Result<Source, String> {
    let particles = importers::read(path, &recipe.request(most)).map_err(|error| error.to_string())?;
    Ok(Source { particles, digest })
}

/// The SHA-256 of the bytes of the file `path`.
fn digest(path: &Path) -> Result<String, String> {
    let name = path.display();
    let opened = input::open(path, "a file of particles is a file");
    let (mut file, _) = opened.map_err(|problem| format!("{name}: {problem}"))?;
    let unread = |error: &io::Error| format!("{name}: cannot be read: {}", reason(error));
    let (mut hash, mut bytes) = (Sha256::new(), Vec::new());
    loop {
        bytes.clear();
        match file.by_ref().take(READ_AT_ONCE).read_to_end(&mut bytes) {
            Ok(0) => return Ok(hexadecimal(&hash.finalize())),
            Ok(_) => hash.update(&bytes),
            Err(error) => return Err(unread(&error)),
        }
    }
}

/// Bytes in hexadecimal.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}"); // writing to a String cannot fail
        text
    })
}

/// As [`read`], of a file that must have the SHA-256 `digest`, if that is given.
///
/// # Errors
/// If the file cannot be read, or has another.
pub(crate) fn read_unchanged(
    path: &Path,
    digest: Option<&str>,
    recipe: &Recipe,
    most: u64,
) -> Result<Source, Problem> {
    let found = self::digest(path).map_err(Problem::Read)?;
    // First: what has changed may be read no more, or need more memory.
    if digest.is_some_and(|expected| !expected.eq_ignore_ascii_case(&found)) {
        let name = path.display();
        return Err(Problem::Changed(format!(
            "{name} has changed: its SHA-256 is {found}; bring back the file that was meant, or correct the digest"
        )));
    }
    read_of(path, found, recipe, most).map_err(Problem::Read)
}

/// Appends the spheres that `recipe` makes of what was read of the file `path` to `scene`, which has no sky yet. Returns whether
/// they fill a cell, and what the user should know of them.
///
/// # Errors
/// If the recipe does not suit it.
pub(crate) fn append(
    scene: &mut Scene,
    Source { particles, digest }: Source,
    path: &Path,
    recipe: &Recipe,
) -> Result<(bool, Vec<String>), Problem> {
    let (mut made, has_cell) = made_of(particles, recipe)?;
    let notes = std::mem::take(&mut made.notes);
    attach(scene, made, path, digest, recipe);
    Ok((has_cell, notes))
}

/// Puts the `scene`, which has no sky yet, on a stage: it gets camera, background and spheres of that, the last of its own.
/// Returns the settings of the stage.
pub(crate) fn set_up(scene: &mut Scene, set: Set) -> Settings {
    let Set { camera, spheres, materials, background, transparent_background, settings } = set;
    (scene.camera, scene.background) = (camera, background);
    scene.transparent_background = transparent_background;
    let first = scene.imports.first();
    let place = first.map_or(scene.spheres.len(), |import| import.spheres.start);
    let own = first.map_or(scene.materials.len(), |import| import.materials.start);
    let (more, more_materials) = (spheres.len(), materials.len());
    for sphere in &mut scene.spheres[place..] {
        sphere.material += more_materials as u32;
    }
    let of_stage = |sphere: Sphere| Sphere { material: sphere.material + own as u32, ..sphere };
    scene.spheres.splice(place..place, spheres.into_iter().map(of_stage));
    scene.materials.splice(own..own, materials);
    for import in &mut scene.imports {
        import.spheres = import.spheres.start + more..import.spheres.end + more;
        import.materials = import.materials.start + more_materials..import.materials.end + more_materials;
    }
    settings
}

/// A scene that shows a file of particles by itself.
#[derive(Debug)]
pub struct Staged {
    /// The scene.
    pub scene: Scene,
    /// What the user should know: sentences without a full stop.
    pub notes: Vec<String>,
}

/// The stage that suits one frame of a file, on which others can be shown: its camera, lamps and settings.
#[derive(Clone, Debug)]
pub struct Scenery {
    /// The origin of the scene.
    origin: [f64; 3],
    set: Set,
}

/// The file `path` on a stage of its own: camera, lamps and settings follow from its particles, and the origin of the
/// scene is their centre, whatever that of `recipe` is. The scene has the name of the file.
///
/// # Errors
/// If the file cannot be read, or if recipe or stage do not suit it.
pub fn staged(path: &Path, recipe: &Recipe, wanted: &Stage, most: u64) -> Result<Staged, Problem> {
    let source = read(path, recipe, most).map_err(Problem::Read)?;
    from_source(source, path, recipe, wanted, None).map(|(staged, _)| staged)
}

/// A file of particles of which several frames are shown.
#[derive(Debug)]
pub struct Clip {
    path: PathBuf,
    digest: String,
    /// Where frames start, or why that cannot be found for all; then each is searched by itself.
    trajectory: Result<Trajectory, String>,
}

impl Clip {
    /// Opens the file `path` and looks where its frames start.
    ///
    /// # Errors
    /// If it cannot be read: one line.
    pub fn open(path: &Path) -> Result<Self, String> {
        let digest = digest(path)?;
        let trajectory = Trajectory::open(path).map_err(|error| error.to_string());
        Ok(Self { path: path.to_owned(), digest, trajectory })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The number of frames.
    ///
    /// # Errors
    /// If it cannot be told, as the file is damaged: one line.
    pub fn frames(&self) -> Result<usize, String> {
        self.trajectory.as_ref().map(Trajectory::frames).map_err(Clone::clone)
    }

    /// The frame that `recipe` asks for, on the stage of `scenery`, or else on one of its own; and that stage. See [`staged`].
    ///
    /// # Errors
    /// As [`staged`].
    pub fn stage(
        &self,
        recipe: &Recipe,
        wanted: &Stage,
        scenery: Option<&Scenery>,
        most: u64,
    ) -> Result<(Staged, Scenery), Problem> {
        let request = recipe.request(most);
        let read = match &self.trajectory {
            Ok(trajectory) => trajectory.read(&request),
            Err(_) => importers::read(&self.path, &request),
        };
        let particles = read.map_err(|error| Problem::Read(error.to_string()))?;
        let source = Source { particles, digest: self.digest.clone() };
        from_source(source, &self.path, recipe, wanted, scenery)
    }
}

/// What was read of the file `path`, on the stage of `scenery` or else on one of its own.
fn from_source(
    Source { particles, digest }: Source,
    path: &Path,
    recipe: &Recipe,
    wanted: &Stage,
    scenery: Option<&Scenery>,
) -> Result<(Staged, Scenery), Problem> {
    let origin = scenery.map_or_else(|| stage::origin(&particles), |scenery| scenery.origin);
    let recipe = Recipe { origin, ..recipe.clone() };
    let (mut made, has_cell) = made_of(particles, &recipe)?;
    let scenery = match scenery {
        Some(scenery) => scenery.clone(),
        None => Scenery { origin, set: set_of(&made, has_cell, wanted)? },
    };
    let mut staged = empty_stage(scenery.set.clone(), stem(path), &mut made);
    attach(&mut staged.scene, made, path, digest, &recipe);
    let told = |problem| Problem::Read(format!("{}: {problem}", path.display()));
    Ok((finished(staged).map_err(told)?, scenery))
}

/// Particles that are in memory on a stage of their own, as by [`staged`]. The scene has this name, and its spheres are its
/// own.
///
/// # Errors
/// If recipe or stage do not suit them.
pub fn staged_in_memory(
    particles: Particles,
    name: &str,
    recipe: &Recipe,
    wanted: &Stage,
) -> Result<Staged, Problem> {
    let recipe = Recipe { origin: stage::origin(&particles), ..recipe.clone() };
    let (mut made, has_cell) = made_of(particles, &recipe)?;
    let mut staged = empty_stage(set_of(&made, has_cell, wanted)?, name.into(), &mut made);
    join(&mut staged.scene, made);
    finished(staged).map_err(Problem::Stage)
}

/// The balls of `particles`, and whether these fill a cell.
fn made_of(particles: Particles, recipe: &Recipe) -> Result<(Balls, bool), Problem> {
    // Files of macromolecules state the cell of the crystal that they come from, which is not what they show.
    let is_molecule = matches!(particles.format, Format::Pdb | Format::Mmcif);
    let has_cell = particles.cell.is_some() && (recipe.cell || !is_molecule);
    Ok((balls(particles, recipe).map_err(Problem::Recipe)?, has_cell))
}

fn set_of(made: &Balls, has_cell: bool, wanted: &Stage) -> Result<Set, Problem> {
    stage::set(&made.spheres, &made.materials, has_cell, wanted).map_err(Problem::Stage)
}

/// A stage without the balls, of which it takes the notes.
fn empty_stage(set: Set, name: String, made: &mut Balls) -> Staged {
    let Set { camera, spheres, materials, background, transparent_background, settings } = set;
    let (spheres, imports) = (spheres.into(), Vec::new());
    let scene =
        Scene { name, camera, spheres, materials, background, transparent_background, settings, imports };
    Staged { scene, notes: std::mem::take(&mut made.notes) }
}

/// The whole scene, with its sky, checked.
fn finished(Staged { scene, notes }: Staged) -> Result<Staged, String> {
    let scene = scene.with_sky();
    scene.settings.validate().map_err(|error| error.to_string())?;
    scene.check().map_err(|flaw| flaw.to_string())?;
    Ok(Staged { scene, notes })
}

/// The name of the file without folders and extensions: of `a/water.xyz.gz` it is `water`.
pub fn stem(path: &Path) -> String {
    let name = Path::new(path.file_name().unwrap_or_default());
    let is_packed = name.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"));
    let name = if is_packed { Path::new(name.file_stem().unwrap_or_default()) } else { name };
    let stem = name.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().filter(|c| !c.is_control()).collect()
}

/// Appends `balls`, which `recipe` has made of the file `path` with this digest, to `scene`, which has no sky yet.
fn attach(scene: &mut Scene, balls: Balls, path: &Path, digest: String, recipe: &Recipe) {
    let (spheres, materials) = join(scene, balls);
    scene.imports.push(Import { file: path.into(), digest, table: table(recipe), spheres, materials });
}

/// Appends `balls` to `scene`, which has no sky yet, as spheres of its own. Returns the indices of spheres and materials.
pub fn join(scene: &mut Scene, balls: Balls) -> (Range<usize>, Range<usize>) {
    let (spheres, materials) = (scene.spheres.len(), scene.materials.len());
    let mut new = balls.spheres;
    for sphere in &mut new {
        sphere.material += materials as u32;
    }
    // Of two lists, the shorter is copied into the memory of the longer: they may hold millions.
    if spheres < new.len() {
        new.splice(0..0, scene.spheres.drain(..));
        scene.spheres = new.into();
    } else {
        scene.spheres.append(&mut new);
    }
    scene.materials.extend(balls.materials);
    (spheres..scene.spheres.len(), materials..scene.materials.len())
}

/// The table `[[particles]]` of a scene file with this recipe, without its header, file and digest.
fn table(recipe: &Recipe) -> String {
    let mut text = String::new();
    let entries = |text: &mut String, entries: Vec<(&'static str, String)>| {
        for (key, value) in entries {
            let _ = writeln!(text, "{key} = {}", value_of(key, &value)); // writing to a String cannot fail
        }
    };
    entries(&mut text, recipe.entries());
    if recipe.origin != [0.0; 3] {
        let [x, y, z] = recipe.origin;
        let _ = writeln!(text, "origin = [{x:?}, {y:?}, {z:?}]");
    }
    if !recipe.cut.is_empty() {
        let cuts = recipe.cut.iter().map(|cut| toml::Value::from(cut.text())).collect();
        let _ = writeln!(text, "cut = {}", toml::Value::Array(cuts));
    }
    for rule in recipe.style.iter().map(Rule::entries) {
        text.push_str("\n[[particles.style]]\n");
        entries(&mut text, rule);
    }
    text
}

/// A value in TOML: numbers, true and false as such, where a key has them.
fn value_of(key: &str, text: &str) -> String {
    let is_bare = match key {
        "wrap" | "cell" | "hide" => true,
        "frame" | "radius" | "scale" => text.parse::<f64>().is_ok_and(f64::is_finite),
        _ => false,
    };
    if is_bare { text.into() } else { toml::Value::from(text).to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_sha256sum() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc.xyz");
        std::fs::write(&path, "abc").unwrap();
        // The first example of FIPS 180-2.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(digest(&path).as_deref(), Ok(expected));
        assert!(digest(folder.path()).unwrap_err().contains("this is a directory"));
        // All of a file counts, though it is read in pieces.
        let long: Vec<u8> = (0..=READ_AT_ONCE).map(|i| (i % 251) as u8).collect();
        std::fs::write(&path, &long).unwrap();
        assert_eq!(digest(&path), Ok(hexadecimal(&Sha256::digest(&long))));
    }

    /// Whichever are more.
    #[test]
    fn balls_are_joined_behind_the_spheres_that_are_there() {
        let cornell = crate::builtin::scene("cornell").unwrap();
        let of = |count: usize, first: usize, material: u32| -> Vec<Sphere> {
            let spheres = cornell.spheres[first..first + count].iter();
            spheres.map(|sphere| Sphere { material, ..*sphere }).collect()
        };
        for count in 0..5 {
            let (spheres, materials) = (of(count, 0, 1), cornell.materials[..2].to_vec());
            let mut scene = Scene { spheres: spheres.clone().into(), materials, ..cornell.clone() };
            let balls =
                Balls { spheres: of(2, 6, 0), materials: vec![cornell.materials[2]], notes: Vec::new() };
            assert_eq!(join(&mut scene, balls), (count..count + 2, 2..3), "{count}");
            assert_eq!(*scene.spheres, [spheres, of(2, 6, 2)].concat(), "{count}");
            assert_eq!(scene.materials, cornell.materials[..3], "{count}");
        }
    }

    /// Wherever they are, and whatever origin is asked for.
    #[test]
    fn particles_in_memory_are_shown_as_those_of_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xyz");
        std::fs::write(&path, "2\n\nC 100 0 0\nO 103 0 0\n").unwrap();
        let (usual, stage) = (Recipe::default(), Stage::default());
        let recipe = Recipe { origin: [9.0, 8.0, 7.0], ..usual.clone() };
        let of_file = |recipe: &Recipe| staged(&path, recipe, &stage, u64::MAX).unwrap().scene;
        let particles = importers::read(&path, &usual.request(u64::MAX)).unwrap();
        let in_memory = staged_in_memory(particles, "a", &recipe, &stage).unwrap().scene;
        let scene = of_file(&usual);
        assert_eq!(of_file(&recipe), scene);
        assert_eq!(in_memory, Scene { imports: Vec::new(), ..scene });
    }

    /// By the name of the file, if there is one.
    #[test]
    fn an_image_that_is_too_large_for_a_stage_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xyz");
        std::fs::write(&path, "1\n\nC 0 0 0\n").unwrap();
        let (recipe, stage) = (Recipe::default(), Stage { size: [1 << 20; 2], ..Stage::default() });
        let particles = importers::read(&path, &recipe.request(u64::MAX)).unwrap();
        let in_memory = staged_in_memory(particles, "a", &recipe, &stage).unwrap_err().to_string();
        assert!(in_memory.starts_with("width 1048576 x height 1048576 is "), "{in_memory}");
        let of_file = staged(&path, &recipe, &stage, u64::MAX).unwrap_err().to_string();
        assert_eq!(of_file, format!("{}: {in_memory}", path.display()));
    }

    fn shown(name: &str, text: &str, cell: bool) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let recipe = Recipe { cell, ..Recipe::default() };
        staged(&path, &recipe, &Stage::default(), u64::MAX).unwrap().scene
    }

    /// A macromolecule is not shown as the crystal that it was found in, unless its cell is asked for; other files are shown as
    /// what fills their cell.
    #[test]
    fn cells_are_looked_at_from_a_corner_where_they_are_shown() {
        let atoms = [[1.0, 2.0, 3.0], [7.0, 3.0, 4.0], [2.0, 8.0, 3.5]];
        let line = |[x, y, z]: [f64; 3]| {
            format!("ATOM      1  CA  ALA A   1    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00\n")
        };
        let pdb = atoms.map(line).concat();
        let crystal = format!("CRYST1   20.000   20.000   20.000  90.00  90.00  90.00 P 1\n{pdb}");
        let alone = shown("a.pdb", &pdb, false).camera.direction;
        assert_eq!(shown("a.pdb", &crystal, false).camera.direction, alone);
        let corner = shown("a.pdb", &crystal, true).camera.direction;
        assert_ne!(corner, alone);
        let columns =
            ["type_symbol", "Cartn_x", "Cartn_y", "Cartn_z"].map(|name| format!("_atom_site.{name}\n"));
        let lengths = ["a", "b", "c"].map(|side| format!("_cell.length_{side} 20\n"));
        let rows = atoms.map(|[x, y, z]| format!("C {x} {y} {z}\n"));
        let cif = format!("data_a\n{}loop_\n{}{}", lengths.concat(), columns.concat(), rows.concat());
        assert_eq!(shown("a.cif", &cif, false).camera.direction, alone);
        assert_eq!(shown("a.cif", &cif, true).camera.direction, corner);
        let xyz = atoms.map(|[x, y, z]| format!("C {x} {y} {z}\n")).concat();
        let filled = format!("3\nLattice=\"20 0 0 0 20 0 0 0 20\"\n{xyz}");
        assert_eq!(shown("a.xyz", &filled, false).camera.direction, corner);
        assert_eq!(shown("a.xyz", &format!("3\n\n{xyz}"), false).camera.direction, alone);
    }

    /// What rests in a trajectory rests in its pictures, whatever else moves.
    #[test]
    fn frames_on_a_shared_stage_have_its_origin() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.xyz");
        let frame = |x: f64| format!("3\n\nC 1 2 3\nC 1 2 6\nC {x} 2 3\n");
        std::fs::write(&path, frame(4.0) + &frame(40.0)).unwrap();
        let clip = Clip::open(&path).unwrap();
        let of = |number: usize, scenery: Option<&Scenery>| {
            let recipe = Recipe { frame: figure::Frame::Number(number), ..Recipe::default() };
            clip.stage(&recipe, &Stage::default(), scenery, u64::MAX).unwrap()
        };
        let (first, scenery) = of(0, None);
        let (second, _) = of(1, Some(&scenery));
        let (alone, _) = of(1, None);
        let rests = |staged: &Staged| {
            let own = &first.scene.imports[0].spheres;
            let center = first.scene.spheres[own.start].center;
            staged.scene.spheres.iter().any(|sphere| sphere.center == center)
        };
        assert!(rests(&second) && !rests(&alone));
        assert_eq!(second.scene.camera, first.scene.camera);
        assert_ne!(alone.scene.camera, first.scene.camera);
    }

    #[test]
    fn a_file_that_has_changed_is_told_even_if_it_cannot_be_read_any_more() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xyz");
        let read = |digest: &str| read_unchanged(&path, Some(digest), &Recipe::default(), u64::MAX);
        std::fs::write(&path, "1\n\nO 1 2 3\n").unwrap();
        let own = digest(&path).unwrap();
        assert_eq!(read(&own.to_uppercase()).unwrap().digest, own);
        std::fs::write(&path, "2\n\nO 1 2 3\n").unwrap();
        assert!(
            matches!(read(&own), Err(Problem::Changed(line)) if line.contains("a.xyz has changed: its SHA-256 is"))
        );
        assert!(
            matches!(read(&digest(&path).unwrap()), Err(Problem::Read(line)) if line.contains("ends after 1 of 2"))
        );
    }

    #[test]
    fn recipes_are_written_as_toml() {
        let mut recipe = Recipe::default();
        assert_eq!(table(&recipe), "");
        for (key, text) in [("frame", "7"), ("unit", "metre"), ("cell", "true")] {
            recipe.set(key, text).unwrap();
        }
        recipe.origin = [1e6, 0.1, -1e-10];
        recipe.cut = vec![figure::Selection::parse("element == \"O\"").unwrap()];
        recipe.style =
            vec![Rule::parse("radius=1e-10, color=red").unwrap(), Rule::parse("z > 3: hide").unwrap()];
        let expected = "frame = 7\nunit = \"metre\"\ncell = true\norigin = [1000000.0, 0.1, -1e-10]\n\
            cut = ['element == \"O\"']\n\n[[particles.style]]\nradius = 1e-10\ncolor = \"#d62728\"\n\n\
            [[particles.style]]\nwhere = \"z > 3\"\nhide = true\n";
        assert_eq!(table(&recipe), expected);
    }

    /// Between spheres of the scene's own and those of the file, whose places and materials move on.
    #[test]
    fn a_stage_stands_between_own_spheres_and_those_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xyz");
        std::fs::write(&path, "2\n\nC 0 0 0\nO 3 0 0\n").unwrap();
        let mut scene = crate::builtin::scene("cornell").unwrap();
        let own = scene.spheres[0];
        scene.materials.truncate(2);
        scene.spheres = std::iter::once(Sphere { material: 1, ..own }).collect();
        let source = read(&path, &Recipe::default(), u64::MAX).unwrap();
        append(&mut scene, source, &path, &Recipe::default()).unwrap();
        let before = scene.clone();
        let material = |albedo: f32| scene::Material::Diffuse { albedo: scene::Rgb::splat(albedo) };
        let set = Set {
            camera: scene.camera,
            spheres: vec![Sphere { material: 0, ..own }, Sphere { material: 2, ..own }],
            materials: vec![material(0.1), material(0.2), material(0.3)],
            background: scene::Rgb::ONE,
            transparent_background: true,
            settings: scene.settings,
        };
        set_up(&mut scene, set);
        let materials: Vec<u32> = scene.spheres.iter().map(|sphere| sphere.material).collect();
        let of_file = |i: usize| before.spheres[i].material + 3;
        assert_eq!(materials, [1, 2, 4, of_file(1), of_file(2)]);
        assert_eq!(scene.materials[2..5], [material(0.1), material(0.2), material(0.3)]);
        assert_eq!(scene.materials[5..], before.materials[2..]);
        assert_eq!((&scene.imports[0].spheres, scene.imports[0].materials.start), (&(3..5), 5));
        assert_eq!(scene.imports[0].materials.end, scene.materials.len());
        assert!(scene.transparent_background && scene.background == scene::Rgb::ONE);
    }

    /// The names of files, without what says how they are written.
    #[test]
    fn stems_are_names_without_extensions() {
        for (path, name) in [
            ("a/water.xyz.gz", "water"),
            ("WATER.XYZ.GZ", "WATER"),
            ("water.xyz.Gz", "water"),
            ("water.xyz", "water"),
            ("a.b.pdb", "a.b"),
            ("a\u{7}b.xyz", "ab"),
            ("", ""),
        ] {
            assert_eq!(stem(Path::new(path)), name, "{path:?}");
        }
    }
}
