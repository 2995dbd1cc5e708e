//! Renders the same scene by two engines and compares the images: `cargo run --release --example compare_engines`

use compare::Metrics;
use render::{EngineChoice, EngineName, Job, MethodName, Renderer};
use scene::Film;

fn render(renderer: Renderer, iterations: u32) -> Result<Film, Box<dyn std::error::Error>> {
    let mut scene = files::builtin::scene("cornell").ok_or("no such scene")?;
    (scene.settings.width, scene.settings.height) = (48, 36);
    scene.settings.photons_per_iteration = 10_000;
    scene.settings.iterations = iterations;
    let mut job = Job::new(scene);
    job.engine = EngineChoice::new(renderer, None)?;
    let outcome = job.start(())?.wait()?;
    Ok(outcome.last.ok_or("no iteration was done")?.film.clone())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let fast = render(EngineName::Fast.into(), 4)?;
    let reference = render(EngineName::Reference.into(), 4)?;
    assert_eq!(fast, reference, "they agree on every bit");

    // The path tracer is another algorithm: it converges to the same image, and differs by noise until then.
    let path = render(MethodName::Path.into(), 64)?;
    println!("photon mapping against path tracing:\n{}", Metrics::of(&fast, &path)?);
    Ok(())
}
