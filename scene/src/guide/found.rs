//! What walks of a survey find.

use glam::Vec3;

/// Light that arrives where it matters: what a walk from the eye over a diffuse surface found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Where.
    pub point: Vec3,
    /// Where it comes from: a point of a lamp.
    pub source: Vec3,
    /// How much, in the brightest channel; in any unit.
    pub flux: f32,
}

/// A line along which photons come to where they matter: from a diffuse surface to what a walk came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The walk that found it.
    pub walk: u32,
    /// Where photons leave the surface.
    pub point: Vec3,
    /// Its unit normal there.
    pub normal: Vec3,
    /// Their unit direction.
    pub direction: Vec3,
}

/// Light that comes straight from a lamp to a place that a walk met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    /// The walk.
    pub walk: u32,
    /// Is it where the walk met the first diffuse surface, which the eye sees itself?
    pub is_seen: bool,
    /// The light.
    pub arrival: Arrival,
}

/// What some walks have found, in order of the walks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Lines between surfaces.
    pub edges: Vec<Edge>,
    /// Light from lamps.
    pub lit: Vec<Lit>,
}

impl Found {
    /// Light that arrives where the eye sees what is scattered only: there photons are of use.
    pub fn arrivals(&self) -> impl Iterator<Item = &Lit> {
        self.lit.iter().filter(|lit| !lit.is_seen)
    }
}
