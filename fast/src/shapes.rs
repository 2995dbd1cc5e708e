//! Spheres as rays are tested against them one by one.

use scene::ray::SphereId;
use scene::still::{Enclosure, Ground, Role};
use scene::{Still, Vec3};

/// A sphere as the intersection broadcasts it to all lanes, by the side that rays meet it from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    /// From outside.
    Solid(BallShape),
    /// From both sides.
    Glass(BallShape),
    /// From outside, close to the eye.
    Ground(Ground),
    /// From inside.
    Enclosure(Enclosure),
}

/// A sphere that rays meet from outside, or from both sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallShape {
    pub(crate) sphere: SphereId,
    pub(crate) center: Vec3,
    pub(crate) radius_squared: f32,
}

impl Shape {
    /// Sphere `id` of a still.
    pub(crate) fn of(still: &Still, id: SphereId) -> Self {
        let s = &still.spheres[id as usize];
        let ball = BallShape { sphere: id, center: s.center, radius_squared: s.radius * s.radius };
        match still.roles[id as usize] {
            Role::Solid => Self::Solid(ball),
            Role::Glass => Self::Glass(ball),
            Role::Ground(g) => Self::Ground(still.grounds[g as usize]),
            Role::Enclosure(e) => Self::Enclosure(still.enclosures[e as usize]),
        }
    }

    /// Its id.
    #[inline(always)]
    pub(crate) fn sphere(&self) -> SphereId {
        match self {
            Self::Solid(ball) | Self::Glass(ball) => ball.sphere,
            Self::Ground(ground) => ground.sphere,
            Self::Enclosure(enclosure) => enclosure.sphere,
        }
    }

    /// True if it may block light.
    pub(crate) fn casts_shadow(&self) -> bool {
        !matches!(self, Self::Enclosure(enclosure) if !enclosure.casts_shadow)
    }

    /// The ball, if it is one.
    pub(crate) fn ball(&self) -> Option<&BallShape> {
        match self {
            Self::Solid(ball) | Self::Glass(ball) => Some(ball),
            Self::Ground(_) | Self::Enclosure(_) => None,
        }
    }
}
