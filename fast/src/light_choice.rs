//! Choosing a light for a photon, with probabilities proportional to power.

use lanes::Lanes;

/// Up to so many lights, the random number is compared with all cumulative probabilities.
const FEW: usize = 16;

/// The cumulative probabilities of lights, for a search in lanes.
///
/// A binary search, lane by lane, would mispredict every other step. Instead the top bits of the random number look up
/// where to begin in a guide table, after which there is nearly always at most one step.
pub(crate) struct LightChoice {
    /// The cumulative probabilities, if there are few lights; otherwise empty.
    few: Vec<f32>,
    /// The bits of the cumulative probabilities, then infinities up to a power of two; empty if there are few lights.
    padded: Vec<u32>,
    /// The guide table: for each of a number of equal parts of [0, 1), how many cumulative probabilities do not exceed its
    /// lower end.
    guide: Vec<u32>,
}

impl LightChoice {
    pub(crate) fn new(cumulative: &[f32]) -> Self {
        if cumulative.len() <= FEW {
            return Self { few: cumulative.to_vec(), padded: Vec::new(), guide: Vec::new() };
        }
        let mut padded: Vec<u32> = cumulative.iter().map(|c| c.to_bits()).collect();
        padded.resize((cumulative.len() + 1).next_power_of_two(), f32::INFINITY.to_bits());
        // Random numbers are multiples of 2^-24, so more parts are of no use; and with these all products are exact.
        let parts = (2 * cumulative.len()).next_power_of_two().min(1 << 24);
        let below = |part: usize| cumulative.partition_point(|c| *c <= part as f32 / parts as f32) as u32;
        let guide = (0..parts).map(below).collect();
        Self { few: Vec::new(), padded, guide }
    }

    /// The light that `u`, in [0, 1), chooses: its number is how many cumulative probabilities do not exceed `u`.
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
