//! The scene: everything that is rendered, as its file states it.

use crate::{Camera, Material, Rgb, Settings, Sphere};

/// A scene that has been checked: `scene::file` makes no other, and so should whoever builds one by hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What people call it.
    pub name: String,
    /// Where it is seen from.
    pub camera: Camera,
    /// The materials that spheres refer to.
    pub materials: Vec<Material>,
    /// The spheres, in file order; of equally near hits the one with the lower index counts.
    pub spheres: Vec<Sphere>,
    /// Radiance that arrives from every direction in which nothing stands; zero for a black surrounding.
    pub background: Rgb,
    /// Settings that suit the scene; the command line may override each.
    pub settings: Settings,
}
