//! The spheres of a scene, which its clones share.

use crate::sphere::Sphere;
use std::ops::{Deref, DerefMut};
use std::slice;
use std::sync::Arc;

/// Spheres, as a vector. A clone shares them and copies nothing; they are copied when one of the clones is changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spheres(Arc<Vec<Sphere>>);

impl Deref for Spheres {
    type Target = Vec<Sphere>;

    fn deref(&self) -> &Vec<Sphere> {
        &self.0
    }
}

impl DerefMut for Spheres {
    fn deref_mut(&mut self) -> &mut Vec<Sphere> {
        Arc::make_mut(&mut self.0)
    }
}

impl From<Vec<Sphere>> for Spheres {
    fn from(spheres: Vec<Sphere>) -> Self {
        Self(Arc::new(spheres))
    }
}

impl FromIterator<Sphere> for Spheres {
    fn from_iter<T: IntoIterator<Item = Sphere>>(spheres: T) -> Self {
        Vec::from_iter(spheres).into()
    }
}

impl<'a> IntoIterator for &'a Spheres {
    type Item = &'a Sphere;
    type IntoIter = slice::Iter<'a, Sphere>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Spheres {
    type Item = &'a mut Sphere;
    type IntoIter = slice::IterMut<'a, Sphere>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Rgb, Vec3};

    const BALL: Sphere =
        Sphere { center: Vec3::ZERO, velocity: Vec3::ZERO, radius: 1.0, material: 0, emission: Rgb::ZERO };

    #[test]
    fn clones_share_their_spheres_until_one_is_changed() {
        let mut spheres = Spheres::from(vec![BALL; 2]);
        let other = spheres.clone();
        assert_eq!(spheres.as_ptr(), other.as_ptr());
        spheres.pop();
        assert_eq!((spheres.len(), other.len()), (1, 2));
        let place = spheres.as_ptr();
        spheres[0].radius = 3.0;
        assert_eq!(spheres.as_ptr(), place, "nobody else has them");
    }
}
