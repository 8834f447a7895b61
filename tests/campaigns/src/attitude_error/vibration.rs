//! What rotors that are not balanced do to the accelerometer: lines at each rotor's speed and its harmonics.
//!
//! An imbalance turns in the rotor's plane, so that its force on x and y goes with the square of the speed and turns
//! with the rotor; two blades push along z at twice the speed. The chip's own low-pass (260 Hz, MPU-6000 register map
//! 4.3, as the firmware sets it) takes its share of each line; what is left is sampled 1000 times a second, aliases and
//! all.

use std::f64::consts::TAU;

/// The accelerometer's low-pass with CONFIG 0, Hz; of second order.
const CHIP_CUTOFF_HZ: f64 = 260.0;
/// Amplitude of the second and third harmonic in the rotor's plane, of the first: rotors are no pure imbalance.
const HARMONICS: [f64; 3] = [1.0, 0.3, 0.1];

/// Four rotors with their phases.
pub struct Vibration {
    peak_m_s2: f64,
    hover_rad_s: f64,
    phases_rad: [f64; 4],
}

impl Vibration {
    /// So strong at this speed, when the first harmonics of all four meet.
    pub fn new(peak_m_s2: f64, hover_rad_s: f64) -> Self {
        // apart from one another, as they are when somebody looks
        Self { peak_m_s2, hover_rad_s, phases_rad: [0.0, 1.3, 2.9, 4.4] }
    }

    /// What the chip adds to a sample, body axes, m/s^2, after so long with the rotors at these speeds.
    pub fn sample_m_s2(&mut self, speeds_rad_s: [f64; 4], duration_s: f64) -> [f64; 3] {
        let mut sum_m_s2 = [0.0; 3];
        for (phase_rad, speed_rad_s) in self.phases_rad.iter_mut().zip(speeds_rad_s) {
            *phase_rad = (*phase_rad + speed_rad_s * duration_s) % TAU;
            let strength_m_s2 = 0.25 * self.peak_m_s2 * (speed_rad_s / self.hover_rad_s).powi(2);
            for (times, share) in (1..).zip(HARMONICS) {
                let order = f64::from(times);
                let (sin, cos) = libm::sincos(order * *phase_rad);
                let line_m_s2 = strength_m_s2 * share * passed(order * speed_rad_s / TAU);
                sum_m_s2[0] += line_m_s2 * cos;
                sum_m_s2[1] += line_m_s2 * sin;
            }
            sum_m_s2[2] += strength_m_s2 * passed(2.0 * speed_rad_s / TAU) * libm::cos(2.0 * *phase_rad);
        }
        sum_m_s2
    }
}

/// Share of a line that the chip's low-pass leaves.
fn passed(frequency_hz: f64) -> f64 {
    1.0 / (1.0 + (frequency_hz / CHIP_CUTOFF_HZ).powi(4)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean square of each axis over ten seconds.
    fn mean_square(vibration: &mut Vibration, speeds_rad_s: [f64; 4]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for _ in 0..10_000 {
            let sample = vibration.sample_m_s2(speeds_rad_s, 1e-3);
            sums.iter_mut().zip(sample).for_each(|(sum, value)| *sum += value * value / 10_000.0);
        }
        sums
    }

    /// Four sines of a quarter each that never stay together: half the square of each, times what the filter and the
    /// harmonics make of it.
    #[test]
    fn its_power_is_that_of_its_lines() {
        let speeds = [500.0, 510.0, 523.0, 541.0];
        let found = mean_square(&mut Vibration::new(40.0, 500.0), speeds);
        let line = |speed: f64, order: f64, share: f64| {
            0.5 * (10.0 * share * (speed / 500.0).powi(2) * passed(order * speed / TAU)).powi(2)
        };
        let plane = |speed: f64| line(speed, 1.0, 1.0) + line(speed, 2.0, 0.3) + line(speed, 3.0, 0.1);
        let expected: f64 = speeds.map(plane).into_iter().sum();
        let blades: f64 = speeds.map(|speed| line(speed, 2.0, 1.0)).into_iter().sum();
        assert!((found[0] / expected - 1.0).abs() < 0.02 && (found[1] / expected - 1.0).abs() < 0.02, "{found:?}");
        assert!((found[2] / blades - 1.0).abs() < 0.02, "{found:?} {blades}");
    }

    /// Twice the speed, four times the force, less what the chip takes of it.
    #[test]
    fn it_grows_with_the_speed_squared() {
        let at = |speed: f64| mean_square(&mut Vibration::new(40.0, 300.0), [speed; 4])[2];
        let filtered = (passed(600.0 / TAU) / passed(300.0 / TAU)).powi(2);
        assert!((at(300.0) / at(150.0) / (16.0 * filtered) - 1.0).abs() < 0.05, "{}", at(300.0) / at(150.0));
        assert_eq!(Vibration::new(0.0, 300.0).sample_m_s2([300.0; 4], 1e-3), [0.0; 3]);
    }
}
