//! From which side each sphere of a scene is met, at a byte per sphere.

use crate::ray::SphereId;
use std::ops::Index;

/// From which side a sphere is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Opaque, the eye outside of it: met from outside.
    Solid,
    /// The same, and the eye is close to it: a ground. Holds the index into [`crate::Still::grounds`].
    Ground(u32),
    /// Opaque, the eye inside of it: met from inside. Holds the index into [`crate::Still::enclosures`].
    Enclosure(u32),
    /// Transparent: met from both sides.
    Glass,
}

impl Role {
    /// True if the sphere is opaque and met from outside.
    pub fn is_solid(self) -> bool {
        matches!(self, Self::Solid | Self::Ground(_))
    }

    /// True if its intersection is computed from the point of its surface that is nearest to the eye ([`crate::still::Ground`],
    /// [`crate::still::Enclosure`]). Such spheres are few, as the eye is within or close.
    pub fn is_anchored(self) -> bool {
        matches!(self, Self::Ground(_) | Self::Enclosure(_))
    }
}

/// The roles of all spheres, in order of their ids. Those that are anchored are few, and found by bisection.
#[derive(Clone, Debug, Default)]
pub struct Roles {
    kinds: Vec<Kind>,
    /// Grounds and enclosures by their ids.
    anchored: Vec<(SphereId, Role)>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Solid,
    Glass,
    Anchored,
}

impl Roles {
    /// No roles, with room for `count`.
    pub(crate) fn with_capacity(count: usize) -> Self {
        Self { kinds: Vec::with_capacity(count), anchored: Vec::new() }
    }

    /// Adds the role of the next sphere.
    pub(crate) fn push(&mut self, role: Role) {
        self.kinds.push(match role {
            Role::Solid => Kind::Solid,
            Role::Glass => Kind::Glass,
            Role::Ground(_) | Role::Enclosure(_) => {
                self.anchored.push((self.kinds.len() as SphereId, role));
                Kind::Anchored
            }
        });
    }

    /// The role of a sphere that is anchored. Apart, so that asking for a role is short enough to be inlined.
    fn anchored(&self, id: usize) -> &Role {
        let place = self.anchored.partition_point(|(other, _)| (*other as usize) < id);
        &self.anchored[place].1
    }

    /// The number of spheres.
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// True if there are no spheres.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// All roles.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Role> + DoubleEndedIterator {
        (0..self.len()).map(|id| &self[id])
    }
}

impl Index<usize> for Roles {
    type Output = Role;

    #[inline]
    fn index(&self, id: usize) -> &Role {
        match self.kinds[id] {
            Kind::Solid => &Role::Solid,
            Kind::Glass => &Role::Glass,
            Kind::Anchored => self.anchored(id),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_are_those_that_were_added() {
        let role = |i: u32| match i % 7 {
            0 | 3 => Role::Glass,
            4 => Role::Ground(i / 7),
            5 => Role::Enclosure(i / 7),
            _ => Role::Solid,
        };
        let mut roles = Roles::with_capacity(100);
        assert!(roles.is_empty());
        (0..100).for_each(|i| roles.push(role(i)));
        assert_eq!(roles.len(), 100);
        assert!(roles.iter().copied().eq((0..100).map(role)));
        assert!(roles.iter().rev().copied().eq((0..100).rev().map(role)));
        assert!(
            roles.iter().all(|role| !(role.is_solid() && matches!(role, Role::Enclosure(_) | Role::Glass)))
        );
        assert_eq!(
            roles.iter().filter(|role| role.is_anchored() && role.is_solid()).count(),
            14,
            "every seventh"
        );
        assert_eq!(size_of::<Kind>(), 1, "a byte per sphere");
    }
}
