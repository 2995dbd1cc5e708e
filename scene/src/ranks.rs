//! Values by their rank.

/// The least and the greatest of some values, without the `outside` outermost at either end.
///
/// # Panics
/// If none are left.
pub(crate) fn range_within(mut values: Vec<f32>, outside: usize) -> [f32; 2] {
    let last = values.len() - 1 - outside;
    let [low, high] = [outside, last].map(|rank| *values.select_nth_unstable_by(rank, f32::total_cmp).1);
    assert!(outside <= last, "no value is left");
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_are_left_out_at_either_end() {
        let values: Vec<f32> = (0..101_u16).map(|k| f32::from(k * 37 % 101) - 50.0).collect();
        for outside in [0, 1, 10, 50] {
            let inner = 50.0 - outside as f32;
            assert_eq!(range_within(values.clone(), outside), [-inner, inner]);
        }
        assert_eq!(range_within(vec![3.0, -0.0, 3.0, 0.0, 3.0], 1), [0.0, 3.0]);
        assert_eq!(range_within(vec![2.0], 0), [2.0, 2.0]);
    }
}
