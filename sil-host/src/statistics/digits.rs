//! How many digits a number is printed with.

/// Decimals with which a number has so many significant digits, or all that stand before the point; at most
/// `decimals_max`. None of zero and of what is not a number.
pub(crate) fn decimals(value: f64, significant: u32, decimals_max: u32) -> usize {
    if value == 0.0 || !value.is_finite() {
        return 0;
    }
    let behind_the_point = f64::from(significant) - 1.0 - libm::floor(libm::log10(value.abs()));
    behind_the_point.clamp(0.0, f64::from(decimals_max)) as usize
}

#[cfg(test)]
mod tests {
    use super::decimals;

    #[test]
    fn a_number_has_its_significant_digits() {
        for (value, printed) in
            [(1234.5, "1234"), (12.345, "12.3"), (-0.012345, "-0.0123"), (1.0, "1.00"), (0.0, "0"), (1e-9, "0.000000")]
        {
            assert_eq!(format!("{value:.*}", decimals(value, 3, 6)), printed);
        }
    }
}
