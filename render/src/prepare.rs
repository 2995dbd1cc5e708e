//! Validates a job and acquires its resources, so that errors are found before the render starts.

use crate::error::{Error, Field, Problem};
use crate::job::Job;
use crate::keeper::{Keeper, is_in};
use crate::locks::lock;
use crate::memory::Need;
use crate::names::{EngineName, MethodName};
use crate::outputs::check_distinct;
use crate::save::Note;
use files::checkpoint::{Loaded, Store};
use files::lock::Lock;
use files::{atomic_file, scene_file};
use rayon::ThreadPool;
use scene::settings::Piece;
use scene::text::{counted, list};
use scene::{Flaw, RadiusSchedule, Settings};
use std::path::Path;

/// A validated job with its resources.
pub(crate) struct Ready {
    pub(crate) job: Job,
    pub(crate) pool: ThreadPool,
    pub(crate) need: Need,
    /// Digest of the scene, by [`scene_file::digest`].
    pub(crate) digest: String,
    /// The locks of all files that the render may write.
    pub(crate) locks: Vec<Lock>,
    pub(crate) keeper: Option<Keeper>,
    /// The checkpoint to resume.
    pub(crate) from: Option<Loaded>,
}

/// Validates `job` and acquires its threads and the locks of all files that it will write; checks that there is enough
/// memory and disk space. Changes no file.
pub(crate) fn prepare(mut job: Job) -> Result<Ready, Error> {
    check_settings(&job)?;
    // If the iterations are yet to be chosen, nobody knows which there are.
    if !job.automatic.iterations {
        check_range(&job)?;
    }
    check_scene(&job)?;
    job.choose_settings()?;
    check_settings(&job)?;
    check_range(&job)?;
    // Files of particles are read again to resume the render.
    let imported = job.scene.imports.iter().map(|import| (Field::Scene, import.file.clone()));
    job.inputs.extend(imported.collect::<Vec<_>>());
    let digest = scene_file::digest(&job.scene);
    if let Some(from) = &job.from {
        check_resumed(&job, &digest, from)?;
    }
    job.outputs.check(job.engine, &job.inputs)?;
    job.outputs.check_alpha(&job.scene)?;
    check_checkpoint(&job)?;
    check_snapshots(&job)?;
    // Before anything is read that another render may be about to replace.
    let locks = lock(&mut job)?;
    let there = found(&job, &digest)?;
    // Whatever is there, the one that was named is resumed.
    let from = job.from.take().or(there);
    let pool = job.warm.take_pool(job.threads)?;
    let need = job.need(pool.current_num_threads())?;
    job.outputs.check_room(&job.scene)?;
    let keeper = keeper(&job, &digest, from.as_ref())?;
    Ok(Ready { job, pool, need, digest, locks, keeper, from })
}

fn check_settings(job: &Job) -> Result<(), Error> {
    job.scene.settings.validate().map_err(|error| {
        let field = Field::Setting(error.option);
        let problem =
            error.problem.into_iter().fold(Problem::of(field).text(" "), |problem, piece| match piece {
                Piece::Text(text) => problem.text(text),
                Piece::Setting(name) => problem.field(Field::Setting(name)),
            });
        Error::input(field, problem)
    })?;
    let is_global = job.scene.settings.radius_schedule == RadiusSchedule::Global;
    if is_global && job.engine.method() == MethodName::Hybrid {
        let field = Field::Setting("radius_schedule");
        let problem = Problem::of(field)
            .text(" global: method hybrid has radii per pixel alone; leave it out, or take ");
        return Err(Error::input(field, problem.field(Field::Method).text(" sppm")));
    }
    Ok(())
}

/// Checks that the iterations asked for, if not all, are some of the render's, and independent of the others.
fn check_range(job: &Job) -> Result<(), Error> {
    let Some(range) = &job.range else { return Ok(()) };
    job.check_parts(Field::Range)?;
    let all = job.scene.settings.iterations;
    if range.is_empty() || range.end > all {
        let problem = format!(
            " {}..{}: there are no such iterations; they are counted from 0 to before {all}, and the second is left out",
            range.start, range.end
        );
        return Err(Error::input(Field::Range, Problem::of(Field::Range).text(problem)));
    }
    Ok(())
}

/// Checks the scene, which may have been built or changed in code.
fn check_scene(job: &Job) -> Result<(), Error> {
    let unusable = |flaw: Flaw| Error::named(Field::Scene, flaw);
    job.scene.check().map_err(unusable)
}

/// Checks that `job`, whose scene has the given digest, is the render of the checkpoint to resume.
fn check_resumed(job: &Job, digest: &str, from: &Loaded) -> Result<(), Error> {
    let (path, account) = (from.path.display(), &from.checkpoint.account);
    let other = |damage| Error::input(Field::Resumed, format!("{path} {damage}"));
    from.checkpoint.check_transport().map_err(other)?;
    let (asked, done) = (job.scene.settings.iterations, account.done().end());
    if asked < done {
        let field = Field::Setting("iterations");
        let problem = format!(" {asked}: {path} holds {done} already; ask for at least as many");
        return Err(Error::input(field, Problem::of(field).text(problem)));
    }
    let (method, field, sums) = (job.engine.method(), job.engine.method_field(), account.sums);
    if method != MethodName::of(sums) {
        let others = if field == Field::Engine {
            list(&EngineName::ALL.map(EngineName::name))
        } else {
            MethodName::of(sums).name().to_owned()
        };
        let problem = format!(" {}: {path} is of {sums}, and goes on by {others} alone", method.name());
        return Err(Error::input(field, Problem::of(field).text(problem)));
    }
    match difference(job, digest, from) {
        Some(what) => {
            let problem = format!("{path} is of {what}; change neither scene nor settings to resume it");
            Err(Error::input(Field::Resumed, problem))
        }
        None => Ok(()),
    }
}

/// What distinguishes the render of a checkpoint from `job`, whose scene has the given digest. The number of iterations
/// may differ.
fn difference(job: &Job, digest: &str, loaded: &Loaded) -> Option<String> {
    let (there, iterations) = (&loaded.checkpoint, job.scene.settings.iterations);
    if digest != there.account.scene {
        return Some(format!("another scene, {}", there.scene.name));
    }
    if there.account.sums != job.engine.method().sums(&job.scene.settings) {
        return Some(there.account.sums.to_string());
    }
    let settings = Settings { iterations, ..there.scene.settings };
    (settings != job.scene.settings).then(|| "other settings".into())
}

/// Checks that the checkpoint is not also another output; and if it is to be kept, that it is no input but the one that is
/// resumed, and that it can be written.
fn check_checkpoint(job: &Job) -> Result<(), Error> {
    let Some(save) = &job.save else { return Ok(()) };
    let inputs = job.inputs.iter().map(|(field, path)| (*field, path.as_path())).filter(|_| save.keep);
    let inputs = inputs.filter(|(field, _)| *field != Field::Resumed);
    let outputs = job.outputs.files().map(|(content, path)| (content.field(), path));
    let taken: Vec<(Field, &Path)> = inputs.chain(outputs).collect();
    check_distinct(&taken, &[(Field::Checkpoint, &save.path)])?;
    let checked = if save.keep { atomic_file::check(&save.path) } else { Ok(()) };
    checked.map_err(|error| Error::named(Field::Checkpoint, error))
}

/// Checks that no snapshot is also an input or another output.
fn check_snapshots(job: &Job) -> Result<(), Error> {
    let snapshots: Vec<_> = job.outputs.all_snapshots(job.scene.settings.iterations).collect();
    let snapshots: Vec<_> = snapshots.iter().map(|path| (Field::Snapshots, path.as_path())).collect();
    let inputs = job.inputs.iter().map(|(field, path)| (*field, path.as_path()));
    let outputs = job.outputs.files().map(|(content, path)| (content.field(), path));
    let checkpoint = job.save.iter().map(|save| (Field::Checkpoint, save.path.as_path()));
    let taken: Vec<(Field, &Path)> = inputs.chain(outputs).chain(checkpoint).collect();
    check_distinct(&taken, &snapshots)
}

/// The existing checkpoint at the job's path, if it is of the same render, and not the one that is resumed. One of another
/// render is an error, as it must not be overwritten.
fn found(job: &Job, digest: &str) -> Result<Option<Loaded>, Error> {
    let Some(save) = &job.save else { return Ok(None) };
    let store = Store::new(&save.path);
    if job.from.as_ref().is_some_and(|from| is_in(&store, from)) {
        return Ok(None);
    }
    let refuse = |problem: Problem| {
        let problem = problem.text("remove it, or name another by ").field(Field::Checkpoint);
        Error::input(Field::Checkpoint, problem)
    };
    let loaded = store.load().map_err(|error| refuse(Problem::from(format!("{error}; "))))?;
    let Some(loaded) = loaded else { return Ok(None) };
    let there = &loaded.checkpoint;
    there.check_transport().map_err(|damage| {
        Error::named(Field::Checkpoint, format_args!("{} {damage}", loaded.path.display()))
    })?;
    let other = |what: String| {
        let (path, done) = (store.path().display(), counted(there.account.iterations, "iteration"));
        let problem = Problem::from(format!("{path} holds {done} of {what}; continue it by "));
        Err(refuse(problem.field(Field::Resume).text(", ")))
    };
    if let Some(what) = difference(job, digest, &loaded) {
        return other(what);
    }
    let range = Note::of(&loaded).part();
    if range != job.range {
        let all = 0..there.scene.settings.iterations;
        return other(format!("this render's {:?}, another part", range.unwrap_or(all)));
    }
    let iterations = job.scene.settings.iterations;
    if there.account.done().end() > iterations {
        return other(format!("this render, more than {iterations}"));
    }
    Ok(Some(loaded))
}

/// The keeper that will write checkpoints, if the job asks for them.
fn keeper(job: &Job, digest: &str, from: Option<&Loaded>) -> Result<Option<Keeper>, Error> {
    let Some(save) = &job.save else { return Ok(None) };
    let mut note = Note {
        renderer: Some(job.engine.renderer()),
        until_error: job.goals.error,
        every: save.every,
        keep: save.keep,
        range: job.range.as_ref().map(|range| [range.start, range.end]),
        ..Note::default()
    };
    job.outputs.note(&save.path, &mut note);
    let asked = job.scene.settings.iterations;
    let keeper = Keeper::new(save.clone(), digest, asked, &note, from);
    if save.keep {
        let sums = job.engine.method().sums(&job.scene.settings);
        let bytes = keeper.room(&job.scene, sums, job.goals.error.is_some());
        let room = atomic_file::check_room(&save.path, bytes);
        room.map_err(|error| Error::named(Field::Checkpoint, error))?;
    }
    Ok(Some(keeper))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::automatic;
    use crate::choice::EngineChoice;
    use scene::{Automatic, Quality, Scene};

    /// A small render, whose error is estimated or not.
    fn job(error: Option<f64>) -> Job {
        let mut scene = files::builtin::scene("cornell").unwrap();
        scene.settings = Settings { width: 16, height: 12, photons_per_iteration: 100, ..scene.settings };
        let mut job = Job::new(scene);
        (job.threads, job.goals.error) = (Some(1), error);
        job
    }

    /// What a job says before it starts is what the render will say, the pilots of its bias included, which take more than the
    /// rest.
    #[test]
    fn a_job_tells_the_memory_of_its_render() {
        let told = |error| job(error).bytes_at_most().unwrap();
        for error in [None, Some(0.1)] {
            assert_eq!(prepare(job(error)).unwrap().need.bytes, told(error));
        }
        let of_pilots = automatic::bytes_at_most(&job(None).scene, 1);
        assert!(told(Some(0.1)) > of_pilots && told(None) < of_pilots, "{of_pilots}, {}", told(None));
        // A limit holds for them too.
        let need = told(Some(0.1));
        let limited =
            |memory_limit| Job { memory_limit: Some(memory_limit), ..job(Some(0.1)) }.bytes_at_most();
        assert_eq!(limited(need).unwrap(), need);
        assert!(matches!(limited(need - 1), Err(Error::Input { field: Field::MemoryLimit, .. })));
    }

    /// A scene without mirrors and glass, half of it under an open sky.
    fn open() -> Scene {
        let text = "background = [0.5, 0.6, 0.8]\ncamera = { eye = [0, 3, 9], target = [0, 1, 0], vertical_fov_degrees = 40 }\n\
                    [settings]\nwidth = 32\nheight = 24\n\
                    [materials.m]\ntype = 'diffuse'\nalbedo = [0.7, 0.7, 0.7]\n\
                    [[sphere]]\ncenter = [0, -10000, 0]\nradius = 10000\nmaterial = 'm'\n\
                    [[sphere]]\ncenter = [0, 1, 0]\nradius = 1\nmaterial = 'm'\n";
        scene_file::parse("open", text).unwrap()
    }

    /// Where nothing else is stated: no other method, nothing that photons alone have, no image of these, no render to repeat.
    #[test]
    fn the_method_is_chosen_where_it_is_left_open() {
        let all = Automatic::all(Quality::Draft);
        let of = |automatic, change: fn(&mut Job)| {
            let mut job = Job { threads: Some(1), ..Job::new(open()) }.choosing(automatic);
            change(&mut job);
            job.choose_settings().unwrap();
            (job.engine.method(), job.chosen.method)
        };
        assert_eq!(of(all, |_| {}), (MethodName::Path, true));
        assert_eq!(of(all, |job| job.automatic.method = false), (MethodName::Sppm, false));
        assert_eq!(of(Automatic { initial_radius: false, ..all }, |_| {}), (MethodName::Sppm, false));
        assert_eq!(of(all, |job| job.outputs.radius_image = Some("r.pfm".into())), (MethodName::Sppm, false));
        assert_eq!(of(all, |job| job.outputs.count_image = Some("n.pfm".into())), (MethodName::Sppm, false));
        let by_hybrid = |job: &mut Job| job.engine = EngineChoice::new(MethodName::Hybrid, None).unwrap();
        assert_eq!(of(all, by_hybrid), (MethodName::Hybrid, false));
        let repeated =
            |job: &mut Job| job.repeats = Some(crate::job::Repeats { path: "a.exr".into(), transport: 1 });
        assert_eq!(of(all, repeated), (MethodName::Sppm, false));
        // The engine stays what it is.
        let mut job = Job { threads: Some(1), ..Job::new(open()) }.choosing(all);
        job.engine = EngineChoice::new(
            crate::Renderer { engine: EngineName::Reference, ..crate::Renderer::default() },
            None,
        )
        .unwrap();
        job.choose_settings().unwrap();
        let renderer = job.engine.renderer();
        assert_eq!((renderer.method, renderer.engine), (MethodName::Path, EngineName::Reference));
        assert_eq!(job.scene.settings.initial_radius, open().settings.initial_radius);
    }

    /// Of path tracing nothing is chosen that photons alone have, nor told as chosen; and then nothing is left to be chosen.
    #[test]
    fn a_method_without_photons_has_its_own_settings_chosen() {
        let all = Automatic::all(Quality::Draft);
        let mut job = job(None).choosing(all);
        job.engine = EngineChoice::new(MethodName::Path, None).unwrap();
        let own = job.scene.settings;
        job.choose_settings().unwrap();
        let expected = Automatic { method: false, ..all.without_photons() };
        assert!(job.chosen == expected && !job.automatic.any(), "{:?}", job.chosen);
        let Settings { iterations, max_depth, .. } = job.scene.settings;
        assert_eq!(job.scene.settings, Settings { iterations, max_depth, ..own });
        job.choose_settings().unwrap();
        assert_eq!(job.scene.settings.iterations, iterations);
        // Where only photons have what is to be chosen, that is nothing at all.
        let only = Automatic { initial_radius: true, photons_per_iteration: true, ..Automatic::default() };
        let mut job = Job { automatic: only, ..job };
        job.chosen = Automatic::default();
        job.choose_settings().unwrap();
        assert!(!job.chosen.any());
    }

    /// Of a part, the iterations are some of those that are chosen, however many the scene has.
    #[test]
    fn a_range_is_of_the_iterations_that_are_chosen() {
        let automatic = Automatic { quality: Quality::Draft, iterations: true, ..Automatic::default() };
        let of = |iterations, range| {
            let mut job = job(None).choosing(automatic);
            let radius_schedule = RadiusSchedule::Global;
            job.scene.settings = Settings { iterations, radius_schedule, ..job.scene.settings };
            job.range = Some(range);
            prepare(job).map(|ready| ready.job.scene.settings.iterations)
        };
        let many = 1 << 20;
        let chosen = of(many, 0..1).unwrap();
        assert!(chosen > 1 && chosen < many, "{chosen}");
        assert_eq!(of(1, chosen - 1..chosen), Ok(chosen));
        let refused = of(many, chosen..chosen + 1).unwrap_err();
        assert!(refused.to_string().contains(&format!("counted from 0 to before {chosen}, ")), "{refused}");
    }

    /// So may reading the scene, which is over when the render begins.
    #[test]
    fn memory_that_was_taken_before_the_render_is_told() {
        let own = job(None).bytes_at_most().unwrap();
        let of = |bytes_before| Job { bytes_before, ..job(None) }.bytes_at_most().unwrap();
        assert_eq!(of(1), own);
        assert!(of(2 * own) > 2 * own);
    }

    /// Settings are chosen by larger renders than a small picture itself: their memory is told too, and a limit holds for them.
    #[test]
    fn choosing_settings_counts_as_memory() {
        let of = |memory_limit| {
            let automatic = Automatic { quality: Quality::Draft, iterations: true, ..Automatic::default() };
            prepare(Job { memory_limit, ..job(None) }.choosing(automatic))
        };
        let own = job(None).bytes_at_most().unwrap();
        let of_choice = automatic::bytes_at_most(&job(None).scene, 1);
        assert!(own < of_choice, "{own} and {of_choice}");
        let told = of(None).unwrap().need.bytes;
        assert!(told > of_choice, "{told} and {of_choice}");
        assert_eq!(of(Some(told)).unwrap().need.bytes, told);
        let refused = of(Some(of_choice)).map(|ready| ready.need.bytes).unwrap_err();
        assert!(matches!(refused, Error::Input { field: Field::MemoryLimit, .. }), "{refused}");
    }
}
