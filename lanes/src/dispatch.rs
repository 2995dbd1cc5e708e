//! Running a kernel on a back end: the one place that asks the processor for features and enables them.

#[cfg(target_arch = "x86_64")]
use crate::avx2::Avx2;
#[cfg(target_arch = "x86_64")]
use crate::avx512::Avx512;
use crate::emulated::Emulated;
use crate::operations::Kernel;
#[cfg(test)]
use crate::operations::Lanes;

/// Which vectors kernels run on. All give the same bits. A kind that the processor lacks is emulated, so that tests reach
/// the kernels at every width on any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneKind {
    /// Eight lanes of plain Rust; runs anywhere.
    Emulated,
    /// Eight lanes of AVX2 (and FMA, BMI, LZCNT and POPCNT, which came with it).
    Avx2,
    /// Sixteen lanes of AVX-512 (F, BW, DQ, VL).
    Avx512,
}

impl LaneKind {
    /// All kinds, the plainest first.
    pub const ALL: [Self; 3] = [Self::Emulated, Self::Avx2, Self::Avx512];

    /// True if this processor has the kind.
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Emulated => true,
            Self::Avx2 => [
                is_x86_feature_detected!("avx2"),
                is_x86_feature_detected!("fma"),
                is_x86_feature_detected!("bmi1"),
                is_x86_feature_detected!("bmi2"),
                is_x86_feature_detected!("lzcnt"),
                is_x86_feature_detected!("popcnt"),
            ]
            .into_iter()
            .all(|has_it| has_it),
            Self::Avx512 => [
                is_x86_feature_detected!("avx512f"),
                is_x86_feature_detected!("avx512bw"),
                is_x86_feature_detected!("avx512dq"),
                is_x86_feature_detected!("avx512vl"),
                Self::Avx2.is_available(),
            ]
            .into_iter()
            .all(|has_it| has_it),
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            self == Self::Emulated
        }
    }

    /// The fastest kind that this processor has.
    pub fn best() -> Self {
        Self::ALL.into_iter().rev().find(|kind| kind.is_available()).unwrap_or(Self::Emulated)
    }
}

/// Runs a kernel on lanes of the given kind, or on emulated lanes where the processor lacks it: on as many in builds with
/// debug assertions, as tests have them; else on eight, as the instances for sixteen took about a third of the time to build
/// `fast`.
pub fn dispatch<K: Kernel>(kind: LaneKind, kernel: K) -> K::Output {
    match kind {
        // SAFETY: `is_available` has asked the processor for the features that the function enables.
        #[cfg(target_arch = "x86_64")]
        LaneKind::Avx2 if kind.is_available() => unsafe { run_on_avx2(kernel) },
        // SAFETY: `is_available` has asked the processor for the features that the function enables.
        #[cfg(target_arch = "x86_64")]
        LaneKind::Avx512 if kind.is_available() => unsafe { run_on_avx512(kernel) },
        #[cfg(debug_assertions)]
        LaneKind::Avx512 => kernel.run::<Emulated<16>>(),
        _ => kernel.run::<Emulated<8>>(),
    }
}

/// Runs a kernel on AVX2. Unlike [`dispatch`], which compiles a kernel for three back ends, this compiles it for one.
///
/// # Errors
/// Returns the kernel if the processor lacks AVX2.
pub fn on_avx2<K: Kernel>(kernel: K) -> Result<K::Output, K> {
    #[cfg(target_arch = "x86_64")]
    if LaneKind::Avx2.is_available() {
        // SAFETY: `is_available` has asked the processor for the features that the function enables.
        return Ok(unsafe { run_on_avx2(kernel) });
    }
    Err(kernel)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_on_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
fn run_on_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx512>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::any::type_name;

    struct Name;
    impl Kernel for Name {
        type Output = &'static str;
        #[inline(always)]
        fn run<L: Lanes>(self) -> Self::Output {
            type_name::<L>()
        }
    }

    #[test]
    fn kernels_run_on_the_lanes_that_they_are_sent_to() {
        assert_eq!(dispatch(LaneKind::Emulated, Name), type_name::<Emulated<8>>());
        #[cfg(target_arch = "x86_64")]
        {
            let [has_avx2, has_avx512] = [LaneKind::Avx2, LaneKind::Avx512].map(LaneKind::is_available);
            let avx2 = if has_avx2 { type_name::<Avx2>() } else { type_name::<Emulated<8>>() };
            assert_eq!(dispatch(LaneKind::Avx2, Name), avx2);
            assert_eq!(on_avx2(Name).ok(), has_avx2.then_some(avx2));
            let avx512 = if has_avx512 { type_name::<Avx512>() } else { type_name::<Emulated<16>>() };
            assert_eq!(dispatch(LaneKind::Avx512, Name), avx512);
        }
    }

    /// The lanes of a kernel and of a part of it that is called; and the same of its back end of eight.
    struct Called;
    impl Kernel for Called {
        type Output = [[&'static str; 2]; 2];
        #[inline(always)]
        fn run<L: Lanes>(self) -> Self::Output {
            [[type_name::<L>(), L::call(Name)], [type_name::<L::Eight>(), L::Eight::call(Name)]]
        }
    }

    #[test]
    fn parts_that_are_called_run_on_the_lanes_of_their_kernel() {
        for kind in LaneKind::ALL {
            for [whole, part] in dispatch(kind, Called) {
                assert_eq!(part, whole, "{kind:?}");
            }
        }
    }

    /// What the back end of eight makes of two packets and a mask.
    struct OfEight {
        a: [f32; 8],
        b: [f32; 8],
        bits: u32,
    }

    impl OfEight {
        #[inline(always)]
        fn words<E: Lanes>(&self) -> Vec<u32> {
            let (a, b, m) = (E::load(&self.a), E::load(&self.b), E::mask_from_bits(self.bits));
            let (c, d) = (E::bits(a), E::bits(b));
            let masks =
                [E::lt(a, b), E::le(a, b), E::eq(c, d), m & E::le(a, b), m | E::lt(a, b), !m, E::first(5)];
            let mut words: Vec<u32> = masks.iter().map(|m| E::mask_bits(*m)).collect();
            let count = self.bits.count_ones() as usize;
            for v in [E::bits(E::select(m, a, b)), E::select_u(m, c, d), E::add_where(m, c, d)] {
                let mut lanes = [0; 8];
                E::store_u(v, &mut lanes);
                words.extend(lanes);
            }
            let (mut floats, mut others) = ([0.0; 8], [0; 8]);
            E::compress(m, a, &mut floats);
            E::compress_u(m, d, &mut others);
            words.extend(floats[..count].iter().map(|x| x.to_bits()));
            words.extend(&others[..count]);
            words.push(u32::from(E::any(m)));
            words
        }
    }

    impl Kernel for &OfEight {
        type Output = Vec<u32>;
        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u32> {
            assert_eq!(L::Eight::N, 8);
            self.words::<L::Eight>()
        }
    }

    #[test]
    fn the_back_ends_of_eight_agree_for_every_mask() {
        let a = [1.0, -0.0, f32::NAN, 3.5, f32::INFINITY, -7.0, 1e-45, 2.0];
        let mut b = [1.0, 0.0, 1.0, 2.5, f32::MAX, f32::NAN, 1e-44, 2.0];
        for bits in 0..256 {
            b.rotate_left(1);
            let given = OfEight { a, b, bits };
            let expected = given.words::<Emulated<8>>();
            for kind in LaneKind::ALL {
                assert_eq!(dispatch(kind, &given), expected, "{kind:?}, mask {bits:#b}");
            }
        }
    }

    /// Compares with what the operating system reports of the processor.
    #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
    #[test]
    fn lanes_are_available_where_the_processor_has_all_they_need() {
        let Ok(told) = std::fs::read_to_string("/proc/cpuinfo") else { return };
        let Some(flags) = told.lines().find(|line| line.starts_with("flags")) else { return };
        let has =
            |names: &str| names.split(' ').all(|name| flags.split_whitespace().any(|flag| flag == name));
        // "abm" is LZCNT and POPCNT as AMD brought them.
        let avx2 = has("avx2 fma bmi1 bmi2 abm popcnt");
        let avx512 = avx2 && has("avx512f avx512bw avx512dq avx512vl");
        assert_eq!(LaneKind::ALL.map(LaneKind::is_available), [true, avx2, avx512]);
        let best =
            [LaneKind::Emulated, LaneKind::Avx2, LaneKind::Avx512][usize::from(avx2) + usize::from(avx512)];
        assert_eq!(LaneKind::best(), best);
    }
}
