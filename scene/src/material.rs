//! Materials: how surfaces reflect and transmit light.

use crate::color::Rgb;
use serde::{Deserialize, Serialize};

/// A material; each of its channels is a reflectance in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Material {
    /// A Lambertian reflector: BRDF `albedo / pi`, opaque.
    Diffuse {
        /// Reflected share of the incoming light.
        albedo: Rgb,
    },
    /// A perfect mirror, opaque.
    Specular {
        /// Reflected share of the incoming light, at every angle.
        albedo: Rgb,
    },
    /// A smooth boundary between vacuum (outside) and glass (inside), with exact unpolarised Fresnel reflectance.
    Dielectric {
        /// Tint: multiplies both reflected and transmitted light, once per interface.
        albedo: Rgb,
        /// Index of refraction of the inside over that of the outside, at least 1.
        ior: f32,
    },
}

impl Material {
    /// The reflectance (for glass: the tint).
    pub fn albedo(&self) -> Rgb {
        match *self {
            Self::Diffuse { albedo } | Self::Specular { albedo } | Self::Dielectric { albedo, .. } => albedo,
        }
    }

    /// True if light is scattered to all sides.
    pub fn is_diffuse(&self) -> bool {
        matches!(self, Self::Diffuse { .. })
    }

    /// True where no light crosses the surface.
    pub fn is_opaque(&self) -> bool {
        !matches!(self, Self::Dielectric { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_glass_lets_light_through() {
        let albedo = Rgb::new(0.1, 0.2, 0.3);
        for (material, is_opaque) in [
            (Material::Diffuse { albedo }, true),
            (Material::Specular { albedo }, true),
            (Material::Dielectric { albedo, ior: 1.5 }, false),
        ] {
            assert_eq!((material.albedo(), material.is_opaque()), (albedo, is_opaque));
            assert_eq!(material.is_diffuse(), matches!(material, Material::Diffuse { .. }));
        }
    }
}
