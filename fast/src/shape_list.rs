//! The spheres that rays can be tested against one by one, and the choice of those that a batch is tested against.

use crate::paths::{Floats, Words};
use crate::rays::Rays;
use crate::shaft::{Culled, Culling};
use crate::shapes::Shape;
use lanes::Lanes;

/// The spheres that rays can be tested against one by one.
pub(crate) struct ShapeList {
    /// In order of their ids.
    shapes: Vec<Shape>,
    /// The places of those that are not in the hierarchy; and of those of them that may block light.
    apart: [Vec<u32>; 2],
    culling: Culling,
}

/// The shapes that the rays of a batch are tested against.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<'a> {
    pub(crate) shapes: &'a [Shape],
    /// The places of those that are chosen, in ascending order.
    pub(crate) places: &'a [u32],
    /// False if the balls of the hierarchy are to be searched as well.
    pub(crate) are_all: bool,
}

impl ShapeList {
    /// Of these shapes, in order of their ids, of which the balls are in the hierarchy or `has_balls_apart`.
    pub(crate) fn new(shapes: Vec<Shape>, has_balls_apart: bool) -> Self {
        let apart = [false, true].map(|blocks| {
            let is_apart = |shape: &Shape| {
                (has_balls_apart || shape.ball().is_none()) && (!blocks || shape.casts_shadow())
            };
            (0..).zip(&shapes).filter(|(_, shape)| is_apart(shape)).map(|(place, _)| place).collect()
        });
        Self { culling: Culling::new(&shapes), shapes, apart }
    }

    /// Those that are not in the hierarchy; or, if rays run close together and can meet few, these. Either without walls that
    /// rays that run close together do not meet first. Shadow rays have a `limit`: where they end, negative if they need not be
    /// traced.
    #[inline(always)]
    pub(crate) fn choose<'a, L: Lanes>(
        &'a self,
        rays: &Rays,
        limit: Option<&Floats>,
        list: &'a mut Words,
    ) -> Chosen<'a> {
        let culled = if rays.are_close { self.culling.list::<L>(rays, limit, list) } else { Culled::NOTHING };
        let Culled { listed, behind } = culled;
        let Some(mut count) = listed else {
            let places = &self.apart[usize::from(limit.is_some())][..];
            // Without a hierarchy they may be more than a list holds.
            if behind == 0 || places.len() > list.len() {
                return Chosen { shapes: &self.shapes, places, are_all: false };
            }
            list[..places.len()].copy_from_slice(places);
            let count = self.culling.take_out(behind, list, places.len());
            return Chosen { shapes: &self.shapes, places: &list[..count], are_all: false };
        };
        count = self.culling.take_out(behind, list, count);
        if let Some(lamp) = rays.ignored_by_all() {
            let found = list[..count].iter().position(|place| self.shapes[*place as usize].sphere() == lamp);
            if let Some(found) = found {
                list.copy_within(found + 1..count, found);
                count -= 1;
            }
        }
        Chosen { shapes: &self.shapes, places: &list[..count], are_all: true }
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        let [all, casting] = &self.apart;
        size_of_val(&self.shapes[..])
            + size_of_val(&all[..])
            + size_of_val(&casting[..])
            + self.culling.bytes()
    }
}
