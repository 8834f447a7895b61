//! How often chance alone reaches a ratio of variances, or a difference in units of an estimated deviation.

/// Terms of the continued fraction; for the arguments here it has settled to rounding within fifty.
const TERMS_MAX: u32 = 300;
/// Halvings of an interval: to rounding.
const HALVINGS: u32 = 80;

/// The chance with which a variable of Fisher's F distribution exceeds a value; 1 below 0.
pub(crate) fn f_exceeded(value: f64, numerator: f64, denominator: f64) -> f64 {
    if value <= 0.0 {
        return 1.0;
    }
    beta_share(0.5 * denominator, 0.5 * numerator, denominator / (denominator + numerator * value))
}

/// What a variable of Student's t distribution stays within, to either side, in 95 of 100 cases.
pub(crate) fn student_95(degrees_of_freedom: f64) -> f64 {
    let (mut low, mut high) = (1.0, 1e6);
    for _ in 0..HALVINGS {
        let middle = f64::sqrt(low * high);
        if f_exceeded(middle * middle, 1.0, degrees_of_freedom) > 0.05 { low = middle } else { high = middle }
    }
    f64::sqrt(low * high)
}

/// The regularised incomplete beta function I_x(a, b), by its continued fraction (Abramowitz and Stegun, 26.5.8).
fn beta_share(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_share_below(b, a, 1.0 - x);
    }
    beta_share_below(a, b, x)
}

/// The same where the fraction settles quickly: x not above the mean.
fn beta_share_below(a: f64, b: f64, x: f64) -> f64 {
    let logarithm = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log1p(-x);
    libm::exp(logarithm) / (a * fraction(a, b, x))
}

/// `1 + d1/(1 + d2/(1 + ...))`, from its last term on.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    let term = |n: u32| {
        let m = f64::from(n / 2);
        if n.is_multiple_of(2) {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        }
    };
    (1..=TERMS_MAX).rev().fold(1.0, |rest, n| 1.0 + term(n) / rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_are_met() {
        // t with one degree of freedom is Cauchy's: beyond 1 to either side lies half
        assert!((f_exceeded(1.0, 1.0, 1.0) - 0.5).abs() < 1e-12);
        // F(2, n) exceeds x with the chance (1 + 2 x / n)^(-n / 2)
        for (x, n) in [(0.3, 3.0), (4.0, 7.0), (60.0, 5.0), (2.0, 200.0)] {
            let exact = libm::pow(1.0 + 2.0 * x / n, -0.5 * n);
            assert!((f_exceeded(x, 2.0, n) / exact - 1.0).abs() < 1e-10, "{x} {n}");
        }
        // t with two degrees of freedom: |t| beyond x with 1 - x / sqrt(2 + x^2)
        assert!((f_exceeded(9.0, 1.0, 2.0) - (1.0 - 3.0 / f64::sqrt(11.0))).abs() < 1e-12);
    }

    #[test]
    fn students_bounds_are_the_tables() {
        // two-sided 5 %: 1, 4, 10 and very many degrees of freedom
        for (freedom, bound) in [(1.0, 12.706), (4.0, 2.776), (10.0, 2.228), (1e6, 1.960)] {
            assert!((student_95(freedom) - bound).abs() < 1e-3, "{freedom}");
        }
    }
}
