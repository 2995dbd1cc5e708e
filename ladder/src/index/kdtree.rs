//! k-d trees in place of the hash grid, as the paper proposes for future work: one from an established crate, and one
//! of our own. A photon finds the points within the largest radius.

use super::bins::next_of_slice;
use super::grid::largest_radius;
use super::lookup::{Index, WIDENED};
use super::tuning::Tuning;
use crate::pixels::Pixels;
use crate::vector::Vector;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use lanes::{Lanes, MOST_LANES};
use scene::Vec3;

/// The positions of visible points, and their pixels.
struct Points {
    places: Vec<[f32; 3]>,
    ids: Vec<u32>,
}

impl Points {
    #[inline(always)]
    fn of<V: Vector, P: Pixels>(pixels: &P, count: usize) -> Self {
        let mut points = Self { places: Vec::new(), ids: Vec::new() };
        for at in (0..count).step_by(V::L::N) {
            let site = pixels.site::<V>(at);
            let ([x, y, z], mut words) = (site.point.xyz(), [[0.0; MOST_LANES]; 3]);
            V::L::store(x, &mut words[0]);
            V::L::store(y, &mut words[1]);
            V::L::store(z, &mut words[2]);
            let mut rest = V::L::mask_bits(site.is_set & V::L::first(count - at));
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                points.places.push([words[0][lane], words[1][lane], words[2][lane]]);
                points.ids.push((at + lane) as u32);
            }
        }
        points
    }
}

/// The tree of the crate `kiddo`.
pub(crate) struct Kiddo {
    /// None without points.
    tree: Option<ImmutableKdTree<f32, 3>>,
    ids: Vec<u32>,
    /// The square of the search radius, widened, because the tree's computations round.
    reach_squared: f32,
}

impl Index for Kiddo {
    /// All points found, and how many of them have been returned.
    type Cursor<'a> = (Vec<u32>, usize);

    fn new(_: usize, _: &Tuning) -> Self {
        Self { tree: None, ids: Vec::new(), reach_squared: 0.0 }
    }

    #[inline(always)]
    fn build<V: Vector, P: Pixels>(&mut self, pixels: &P, count: usize) {
        let reach = largest_radius::<V, P>(pixels, count) * WIDENED;
        let points = Points::of::<V, P>(pixels, count);
        self.build_tree(points, reach * reach);
    }

    #[inline(always)]
    fn open(&self, point: Vec3) -> (Vec<u32>, usize) {
        (self.find(point), 0)
    }

    #[inline(always)]
    fn next<L: Lanes>((found, given): &mut (Vec<u32>, usize)) -> Option<(L::U, L::M)> {
        let mut rest = &found[*given..];
        *given += L::N.min(rest.len());
        next_of_slice::<L>(&mut rest)
    }

    fn bytes(&self) -> usize {
        self.ids.len() * (size_of::<u32>() + size_of::<[f32; 3]>() + size_of::<u64>())
    }
}

impl Kiddo {
    #[inline(never)]
    fn build_tree(&mut self, points: Points, reach_squared: f32) {
        self.tree = (!points.ids.is_empty()).then(|| ImmutableKdTree::new_from_slice(&points.places));
        self.ids = points.ids;
        self.reach_squared = reach_squared;
    }

    #[inline(never)]
    fn find(&self, point: Vec3) -> Vec<u32> {
        let Some(tree) = &self.tree else { return Vec::new() };
        let found = tree.within_unsorted::<SquaredEuclidean>(&point.to_array(), self.reach_squared);
        found.iter().map(|neighbour| self.ids[neighbour.item as usize]).collect()
    }
}

/// Our own tree: points are split at the median along the widest side of their bounding box until few are left. The
/// points of a leaf are stored side by side, so that lanes test them together.
pub(crate) struct Tree {
    ids: Vec<u32>,
    nodes: Vec<Node>,
    reach: f32,
}

/// A split, or a leaf.
#[derive(Clone, Copy)]
enum Node {
    /// Points with a smaller coordinate are in the next node, those with a larger one in node `above`.
    Split { axis: u8, at: f32, above: u32 },
    /// The points of a range.
    Leaf { first: u32, end: u32 },
}

/// The largest number of points in a leaf.
const LEAF: usize = 32;
/// The largest number of waiting nodes; the depth of a tree of 2^28 points is less.
const DEPTH: usize = 32;

/// A walk through the tree.
pub(crate) struct Walk<'a> {
    tree: &'a Tree,
    point: [f32; 3],
    waiting: [u32; DEPTH],
    count: usize,
    rest: &'a [u32],
}

impl Index for Tree {
    type Cursor<'a> = Walk<'a>;

    fn new(_: usize, _: &Tuning) -> Self {
        Self { ids: Vec::new(), nodes: Vec::new(), reach: 0.0 }
    }

    #[inline(always)]
    fn build<V: Vector, P: Pixels>(&mut self, pixels: &P, count: usize) {
        let reach = largest_radius::<V, P>(pixels, count) * WIDENED;
        let points = Points::of::<V, P>(pixels, count);
        self.build_tree(&points, reach);
    }

    #[inline(always)]
    fn open(&self, point: Vec3) -> Walk<'_> {
        // Node 0 is the root.
        let count = usize::from(!self.nodes.is_empty());
        Walk { tree: self, point: point.to_array(), waiting: [0; DEPTH], count, rest: &[] }
    }

    #[inline(always)]
    fn next<L: Lanes>(walk: &mut Walk<'_>) -> Option<(L::U, L::M)> {
        while walk.rest.is_empty() {
            walk.rest = walk.next_leaf()?;
        }
        next_of_slice::<L>(&mut walk.rest)
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.ids[..]) + size_of_val(&self.nodes[..])
    }
}

impl<'a> Walk<'a> {
    /// The points of the next leaf that the search sphere touches.
    #[inline(always)]
    fn next_leaf(&mut self) -> Option<&'a [u32]> {
        self.count = self.count.checked_sub(1)?;
        let mut number = self.waiting[self.count];
        loop {
            match self.tree.nodes[number as usize] {
                Node::Leaf { first, end } => return Some(&self.tree.ids[first as usize..end as usize]),
                Node::Split { axis, at, above } => {
                    let x = self.point[axis as usize];
                    // Rounding is monotone: a point whose computed distance is below the radius lies on a side that
                    // this test visits.
                    let (goes_below, goes_above) = (x - self.tree.reach <= at, x + self.tree.reach >= at);
                    if goes_below && goes_above {
                        self.waiting[self.count] = above;
                        self.count += 1;
                    }
                    number = if goes_below { number + 1 } else { above };
                }
            }
        }
    }
}

impl Tree {
    #[inline(never)]
    fn build_tree(&mut self, points: &Points, reach: f32) {
        let mut order: Vec<u32> = (0..points.ids.len() as u32).collect();
        self.nodes.clear();
        if !order.is_empty() {
            split(&points.places, &mut order, 0, &mut self.nodes);
        }
        self.ids = order.iter().map(|&number| points.ids[number as usize]).collect();
        self.reach = reach;
    }
}

/// Builds the subtree of the points `order`, which begin at index `first` of all points in order.
fn split(places: &[[f32; 3]], order: &mut [u32], first: u32, nodes: &mut Vec<Node>) {
    if order.len() <= LEAF {
        nodes.push(Node::Leaf { first, end: first + order.len() as u32 });
        return;
    }
    let coordinate = |number: u32, axis: usize| places[number as usize][axis];
    let width = |axis: usize| {
        let values = order.iter().map(|&number| coordinate(number, axis));
        let (low, high) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    let axis = (0..3).max_by(|&a, &b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| coordinate(a, axis).total_cmp(&coordinate(b, axis)));
    let at = coordinate(order[middle], axis);
    let number = nodes.len();
    nodes.push(Node::Split { axis: axis as u8, at, above: 0 });
    let (below, above) = order.split_at_mut(middle);
    split(places, below, first, nodes);
    nodes[number] = Node::Split { axis: axis as u8, at, above: nodes.len() as u32 };
    split(places, above, first + middle as u32, nodes);
}
