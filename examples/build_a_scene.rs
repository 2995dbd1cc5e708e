//! Builds a scene in code, renders it, and prints its scene file: `cargo run --release --example build_a_scene -- row.png`

use files::scene_file;
use render::Job;
use scene::{Camera, Material, Rgb, Scene, Settings, Sphere, Vec3};
use std::path::PathBuf;

fn ball(center: Vec3, radius: f32, material: u32) -> Sphere {
    Sphere { center, radius, material, velocity: Vec3::ZERO, emission: Rgb::ZERO }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let image = PathBuf::from(std::env::args().nth(1).unwrap_or("row.png".into()));
    let materials = vec![
        Material::Diffuse { albedo: Rgb::new(0.7, 0.65, 0.6) },
        Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 },
        Material::Specular { albedo: Rgb::splat(0.9) },
    ];
    // A room is a large ball with the eye inside, and a lamp is a ball that glows.
    let mut spheres = vec![ball(Vec3::new(0.0, 30.0, 0.0), 30.0, 0)];
    spheres.extend((0..5).map(|i| ball(Vec3::new(2.2 * i as f32 - 4.4, 1.0, 0.0), 1.0, i % 3)));
    let lamp = ball(Vec3::new(-4.0, 7.0, 4.0), 0.7, 0);
    spheres.push(Sphere { emission: Rgb::new(90.0, 85.0, 75.0), ..lamp });

    let eye = Vec3::new(0.0, 4.0, 14.0);
    let scene = Scene {
        name: "row".into(),
        camera: Camera { eye, direction: Vec3::Y - eye, ..Camera::default() },
        materials,
        spheres: spheres.into(),
        background: Rgb::ZERO,
        transparent_background: false,
        imports: Vec::new(),
        settings: Settings {
            width: 160,
            height: 120,
            iterations: 16,
            max_depth: 16,
            initial_radius: 0.3,
            ..Settings::default()
        },
    };
    // A file of it has every number, and is read back as the same scene.
    let text = scene_file::to_text(&scene, &scene.settings);
    let again = scene_file::parse("row.toml", &text)?;
    assert_eq!(scene_file::digest(&again), scene_file::digest(&scene));
    println!("{text}");

    let mut job = Job::new(again);
    job.outputs.image = Some(image);
    let outcome = job.start(())?.wait()?;
    println!("wrote {:?}", outcome.written);
    Ok(())
}
