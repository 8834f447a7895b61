//! What acts on a vehicle from outside while it flies the test sequence.

use serde::Serialize;
use sil_host::effects::RotorVibration;
use sil_host::model::VehicleModel;
use sil_host::sensors::random::RandomStream;

/// A torque that sets in and goes, N m: as much as the ring's centre of gravity can be wrong.
const TORQUE_NM: f64 = 0.1;
/// How long it stays and stays away, s: no part of the sequence's period, so that it comes at any time of a step.
const STAYS_S: f64 = 2.3;

/// Standard deviation of a gust's torque: 0.2 N m is its three-fold, two thirds of what one axis has beside the other.
const GUST_NM: f64 = 0.2 / 3.0;
/// Scale of turbulence over airspeed, s: at 1.5 m, where the vertical scale is the height (MIL-F-8785C), and 5 m/s.
const GUST_S: f64 = 0.3;

/// Largest acceleration that the rotors shake the IMU with, m/s^2; the rate, and the speed of the rotors, are those of
/// the flights of docs/gyro-notches.md on the gimbal.
const VIBRATION_M_S2: f64 = 30.0;
const VIBRATION_RAD_S: f64 = 0.24;
const ROTORS_RAD_S: f64 = 942.0;

/// What acts from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Weather {
    /// Nothing.
    Still,
    /// A torque about roll and about pitch, in turn.
    TorqueSteps,
    /// Turbulence of Dryden's first-order spectrum, as a torque about roll and pitch.
    Gusts,
    /// Rotors that are not balanced.
    Vibration,
}

/// All, the still air first.
pub const WEATHERS: [Weather; 4] = [Weather::Still, Weather::TorqueSteps, Weather::Gusts, Weather::Vibration];

impl Weather {
    /// What tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Weather::Still => "still air",
            Weather::TorqueSteps => "torque steps",
            Weather::Gusts => "gusts",
            Weather::Vibration => "vibration",
        }
    }

    /// The vehicle in it.
    pub fn shake(self, model: &mut VehicleModel) {
        if self == Weather::Vibration {
            let (peak_m_s2, peak_rad_s, at_rad_s) = (VIBRATION_M_S2, VIBRATION_RAD_S, ROTORS_RAD_S);
            model.effects.push(RotorVibration { peak_m_s2, peak_rad_s, at_rad_s }.into());
        }
    }

    /// Torque about the body's axes over time, asked for once per `step_s`, N m.
    pub fn torque_nm(self, seed: u64, step_s: f64) -> impl FnMut(f64) -> [f64; 3] {
        let mut stream = RandomStream::new(seed, "gusts");
        let kept = libm::exp(-step_s / GUST_S);
        let fresh_nm = GUST_NM * (1.0 - kept * kept).sqrt();
        let mut gust_nm = [GUST_NM * stream.normal(), GUST_NM * stream.normal()];
        move |time_s| match self {
            Weather::Still | Weather::Vibration => [0.0; 3],
            Weather::TorqueSteps => {
                let present =
                    |since_s: f64| if since_s > 0.0 && since_s / STAYS_S % 2.0 < 1.0 { TORQUE_NM } else { 0.0 };
                [present(time_s - 1.0), present(time_s - 1.0 - 0.5 * STAYS_S), 0.0]
            }
            Weather::Gusts => {
                gust_nm = gust_nm.map(|gust_nm| kept * gust_nm + fresh_nm * stream.normal());
                [gust_nm[0], gust_nm[1], 0.0]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation and correlation time are those of the constants, whatever the step.
    #[test]
    fn gusts_have_drydens_spectrum_of_first_order() {
        for step_s in [0.001, 0.01] {
            let mut torque_nm = Weather::Gusts.torque_nm(1, step_s);
            let series: Vec<f64> = (0..200_000).map(|_| torque_nm(0.0)[0]).collect();
            let lag = (GUST_S / step_s).round() as usize;
            let mean_of = |products: Vec<f64>| products.iter().sum::<f64>() / products.len() as f64;
            let square = mean_of(series.iter().map(|x| x * x).collect());
            let lagged = mean_of(series.iter().zip(&series[lag..]).map(|(x, y)| x * y).collect());
            // 200 s are 330 independent values at least: 8 % of the variance, twice
            assert!((square.sqrt() / GUST_NM - 1.0).abs() < 0.08, "{square}");
            assert!((lagged / square - libm::exp(-1.0)).abs() < 0.1, "{lagged} {square}");
        }
    }

    #[test]
    fn a_torque_comes_stays_and_goes() {
        let torque_nm = Weather::TorqueSteps.torque_nm(1, 0.001);
        let found = [0.9, 1.1, 2.2, 3.2, 3.4, 5.7].map(torque_nm);
        let (off, on) = (0.0, TORQUE_NM);
        assert_eq!(found.map(|nm| nm[0]), [off, on, on, on, off, on]);
        assert_eq!(found.map(|nm| nm[1]), [off, off, on, on, on, off]);
    }
}
