//! Tells what rays of a `NumPy` file hit: `cargo run --release --example read_rays -- rays.npy`
//!
//! The file holds float32 of shape (N, 6), origin and direction of each ray. Without one, three rays are made up.

use files::npy;
use render::{EngineChoice, trace};
use scene::ray::NO_SPHERE;
use scene::{Ray, Vec3};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rays = match std::env::args().nth(1) {
        Some(file) => npy::read(Path::new(&file))?,
        None => [-0.2, 0.0, 0.2]
            .map(|x| Ray {
                origin: Vec3::new(50.0, 50.0, 200.0),
                direction: Vec3::new(x, 0.0, -1.0).normalize(),
                leaves: NO_SPHERE,
            })
            .to_vec(),
    };
    let scene = files::builtin::scene("cornell").ok_or("no such scene")?;
    let still = scene.at(scene.camera.shutter[0]);
    for (distance, sphere, normal) in trace(EngineChoice::default(), &still, &rays) {
        if distance < f32::INFINITY {
            println!("sphere {sphere} at {distance}, normal {normal}");
        } else {
            println!("nothing");
        }
    }
    Ok(())
}
