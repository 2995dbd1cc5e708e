//! Which light a number chooses, in proportion to power.

use lanes::Lanes;

/// Up to so many lights, the number is compared with all.
const FEW: usize = 16;

/// The cumulative probabilities of lights, made ready to be searched in lanes.
///
/// A search by halves would mispredict every other step, lane by lane. Instead the number's top bits say where to
/// begin, so that nearly always at most one step is left.
pub(crate) struct LightChoice {
    /// They themselves, of few lights; else empty.
    few: Vec<f32>,
    /// The bits of the cumulative probabilities, and then infinities up to a power of two; empty for few lights.
    padded: Vec<u32>,
    /// For k of as many equal parts of [0, 1) how many cumulative probabilities do not exceed k's lower end.
    guide: Vec<u32>,
}

impl LightChoice {
    pub(crate) fn new(cumulative: &[f32]) -> Self {
        if cumulative.len() <= FEW {
            return Self { few: cumulative.to_vec(), padded: Vec::new(), guide: Vec::new() };
        }
        let mut padded: Vec<u32> = cumulative.iter().map(|c| c.to_bits()).collect();
        padded.resize((cumulative.len() + 1).next_power_of_two(), f32::INFINITY.to_bits());
        // Numbers are multiples of 2^-24, so no more parts than that are of use; and then all products are exact.
        let parts = (2 * cumulative.len()).next_power_of_two().min(1 << 24);
        let below = |part: usize| cumulative.partition_point(|c| *c <= part as f32 / parts as f32) as u32;
        let guide = (0..parts).map(below).collect();
        Self { few: Vec::new(), padded, guide }
    }

    /// The numbers of the lights that `u`, in [0, 1), chooses: how many of the cumulative probabilities do not exceed it.
    #[inline(always)]
    pub(crate) fn choose<L: Lanes>(&self, u: L::F) -> L::U {
        let one = L::u(1);
        if self.guide.is_empty() {
            let mut number = L::u(0);
            for c in &self.few {
                number = L::add_where(L::le(L::f(*c), u), number, one);
            }
            return number;
        }
        let mut number = L::gather_u(&self.guide, L::truncate(u * L::f(self.guide.len() as f32)));
        loop {
            let exceeds = L::le(L::from_bits(L::gather_u(&self.padded, number)), u);
            if !L::any(exceeds) {
                return number;
            }
            number = L::add_where(exceeds, number, one);
        }
    }
}
