//! Renders a built-in scene and saves the image: `cargo run --release --example render_and_save -- box.png`

use render::Job;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let image = PathBuf::from(std::env::args().nth(1).unwrap_or("box.png".into()));

    // Or scene_file::load(path), for a scene file of your own.
    let mut scene = files::builtin::scene("cornell").ok_or("no such scene")?;
    scene.settings.width = 160;
    scene.settings.height = 120;
    scene.settings.iterations = 16;

    let mut job = Job::new(scene);
    job.outputs.image = Some(image);
    let outcome = job.start(())?.wait()?;

    for unwritten in &outcome.failed {
        println!("{}", unwritten.error);
    }
    for path in &outcome.written {
        println!("wrote {} after {} iterations", path.display(), outcome.report.iterations);
    }
    Ok(())
}
