//! Labels for the numbers along axes.

/// A number with at most six decimals and no trailing zeros.
#[allow(clippy::trivially_copy_pass_by_ref)] // the signature that plotters requires
pub fn label(value: &f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::label;

    #[test]
    fn labels_have_no_more_digits_than_they_need() {
        assert_eq!(
            [2.0, 0.1 + 0.2, 1e-6, 1500.0].map(|value| label(&value)),
            ["2", "0.3", "0.000001", "1500"]
        );
    }
}
