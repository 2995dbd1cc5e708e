//! Direct light from a lamp by one shadow ray: `reference::direct_light` on any lanes.

use crate::intersect::{Rays, from_either_side, from_inside, occluded};
use crate::sampling::{cosine_hemisphere, uniform_cone};
use crate::tables::{Shape, Tables, fetch_pairs};
use crate::vector::{F, M, U, Vector, callable};
use lanes::{Lanes, MOST_LANES};
use std::f32::consts::PI;

/// The indices of the lights that `u` selects: the number of cumulative probabilities that do not exceed `u`.
#[inline(always)]
pub(crate) fn choose_light<L: Lanes>(cumulative: &[f32], u: L::F) -> [u32; MOST_LANES] {
    let (mut values, mut numbers) = ([0.0; MOST_LANES], [0; MOST_LANES]);
    L::store(u, &mut values);
    for lane in 0..L::N {
        let value = values[lane];
        numbers[lane] = cumulative.partition_point(|c| *c <= value) as u32;
    }
    numbers
}

/// Points that receive light.
#[derive(Clone, Copy)]
pub(crate) struct Receivers<V: Vector> {
    /// Which lanes hold a point.
    pub(crate) live: M<V>,
    pub(crate) point: V,
    pub(crate) normal: V,
    pub(crate) sphere: U<V>,
}

callable! {
    /// Direct irradiance from the lights, with three uniform numbers per lane; zero in lanes that are not live. There
    /// must be at least one light.
    pub(crate) fn irradiance<V: Vector>(
        tables: &Tables,
        to: &Receivers<V>,
        choice: F<V>,
        u: F<V>,
        v: F<V>,
    ) -> V {
        let Receivers { live, point, normal, sphere } = *to;
        let number = choose_light::<V::L>(&tables.still.lights.cumulative, choice);
        let [[cx, cy, cz, r2, er, eg, eb, lamp], [_, _, _, _, _, probability, _, _]] =
            fetch_pairs::<V::L>(&tables.lights, &number);
        let lamp = V::L::bits(lamp);
        let (mut direction, mut t, mut weight) =
            from_outside::<V>(V::new(cx, cy, cz), r2, point, normal, u, v);
        let mut valid = V::L::lt(V::L::f(0.0), weight) & !V::L::eq(sphere, lamp);
        let number = V::L::load_u(&number);
        for (shell_number, shape) in &tables.shells {
            let chosen = V::L::eq(number, V::L::u(*shell_number));
            let within = cosine_hemisphere::<V>(normal, u, v);
            let (t_within, is_within) =
                distance_within::<V>(shape, &Rays { origin: point, direction: within, leaves: sphere });
            direction = V::select(chosen, within, direction);
            t = V::L::select(chosen, t_within, t);
            weight = V::L::select(chosen, V::L::f(PI), weight);
            valid = (chosen & is_within) | (!chosen & valid);
        }
        let rays = Rays { origin: point, direction, leaves: sphere };
        let lit = live & valid;
        let lit = lit & !occluded::<V>(&tables.shadow_casters, &rays, t, lamp, lit);
        V::select(lit, V::new(er, eg, eb).scale(weight / probability), V::zero())
    }

    /// Directions in the cones of the lamps, distances, and weights. Where the lamp gives no light, the weight is 0.
    fn from_outside<V: Vector>(
        center: V,
        r2: F<V>,
        point: V,
        normal: V,
        u: F<V>,
        v: F<V>,
    ) -> (V, F<V>, F<V>) {
        let (zero, one, two) = (V::L::f(0.0), V::L::f(1.0), V::L::f(2.0));
        let to_center = center - point;
        let d2 = to_center.dot(to_center);
        let d = V::L::sqrt(d2);
        let sin2_max = r2 / d2;
        let height = sin2_max / (one + V::L::sqrt(one - sin2_max));
        let (direction, h) = uniform_cone::<V>(to_center.scale(one / d), height, u, v);
        let cos = normal.dot(direction);
        let half_chord2 = r2 - d2 * (h * (two - h));
        let half_chord = V::L::select(V::L::lt(zero, half_chord2), V::L::sqrt(half_chord2), zero);
        let t = d * (one - h) - half_chord;
        let counts = V::L::lt(zero, cos) & V::L::lt(r2, d2);
        (direction, t, V::L::select(counts, cos * (V::L::f(2.0 * PI) * height), zero))
    }
}

/// Distances to an emitting shell from inside, and which lanes hold a ray that starts inside.
#[inline(always)]
fn distance_within<V: Vector>(shape: &Shape, rays: &Rays<V>) -> (F<V>, M<V>) {
    let infinity = V::L::f(f32::INFINITY);
    match shape {
        Shape::Enclosure(e) => {
            let t = from_inside::<V>(e, rays);
            (t, V::L::lt(t, infinity))
        }
        // It does not glow.
        Shape::Ground(_) => (infinity, V::L::first(0)),
        Shape::Solid(ball) | Shape::Glass(ball) => {
            let (t, valid) = from_either_side::<V>(ball, rays);
            let f = rays.origin - V::splat(ball.center);
            let within = V::L::lt(f.dot(f), V::L::f(ball.radius_squared));
            (t, valid & V::L::lt(t, infinity) & within)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one::One;

    /// As in the reference: of three lights, of which the last has no cumulative probability.
    #[test]
    fn a_number_equal_to_a_cumulative_probability_chooses_the_light_after_it() {
        let cumulative = [0.25, 0.5_f32];
        for (u, light) in [(0.0, 0), (0.25_f32.next_down(), 0), (0.25, 1), (0.5, 2), (0.99, 2)] {
            assert_eq!(choose_light::<One>(&cumulative, u)[0], light, "{u}");
        }
        assert_eq!(choose_light::<One>(&[], 0.99)[0], 0);
    }
}
