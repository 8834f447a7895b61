//! From sticks to a set-point: how far they reach in stabilise and in acro, and the throttle's curve.
//!
//! ```text
//!   stick x in -1..1     reach * ((1 - e) x + e x^3)              e: expo; PX4's MC_ACRO_EXPO is the same curve
//!   throttle, t in -1..1 about the stick's middle                 mid, e: Betaflight's thr_mid and thr_expo, the
//!                        mid + side * ((1 - e) t + e t^3)         stick's middle standing where it stands;
//!                                                                 side: 1 - mid above, mid below
//! ```

use super::calibration::Sticks;
use crate::params::pilot::PilotParams;
use crate::signals::Setpoint;

/// How far the sticks reach, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickCurves {
    /// Stabilise: roll and pitch at full stick, rad.
    pub tilt_rad: f32,
    /// Stabilise: rate of the heading at full stick, rad/s.
    pub yaw_rate_rad_s: f32,
    /// Stabilise: share of a cube, 0..1.
    pub expo: f32,
    /// Acro: rates at full stick about the body's axes, rad/s.
    pub acro_rad_s: [f32; 3],
    /// Acro: share of a cube, 0..1.
    pub acro_expo: f32,
    /// Throttle in the middle of its stick, 0..1.
    pub throttle_mid: f32,
    /// Share of a cube in the throttle's curve, 0..1.
    pub throttle_expo: f32,
}

impl StickCurves {
    /// What an owner chose.
    pub fn new(params: &PilotParams) -> Self {
        let radians = |degrees: u16| f32::from(degrees).to_radians();
        let share = |percent: u8| f32::from(percent) / 100.0;
        let acro_tilt_rad_s = radians(params.acro_tilt_deg_s);
        Self {
            tilt_rad: radians(params.tilt_deg.into()),
            yaw_rate_rad_s: radians(params.yaw_deg_s),
            expo: share(params.expo_percent),
            acro_rad_s: [acro_tilt_rad_s, acro_tilt_rad_s, radians(params.acro_yaw_deg_s)],
            acro_expo: share(params.acro_expo_percent),
            throttle_mid: share(params.throttle_mid_percent),
            throttle_expo: share(params.throttle_expo_percent),
        }
    }

    /// Sticks that mean angles.
    pub fn stabilise(&self, sticks: &Sticks) -> Setpoint {
        Setpoint {
            roll_rad: self.tilt_rad * curve(self.expo, sticks.roll),
            pitch_rad: self.tilt_rad * curve(self.expo, sticks.pitch),
            yaw_rate_rad_s: self.yaw_rate_rad_s * curve(self.expo, sticks.yaw),
            throttle: self.throttle(sticks.throttle),
            acro_rad_s: None,
        }
    }

    /// Sticks that mean rates.
    pub fn acro(&self, sticks: &Sticks) -> Setpoint {
        let deflections = [sticks.roll, sticks.pitch, sticks.yaw];
        let rates_rad_s = core::array::from_fn(|axis| self.acro_rad_s[axis] * curve(self.acro_expo, deflections[axis]));
        Setpoint { throttle: self.throttle(sticks.throttle), acro_rad_s: Some(rates_rad_s), ..Setpoint::default() }
    }

    fn throttle(&self, stick: f32) -> f32 {
        let off_middle = 2.0 * stick - 1.0;
        let side = if off_middle > 0.0 { 1.0 - self.throttle_mid } else { self.throttle_mid };
        self.throttle_mid + side * curve(self.throttle_expo, off_middle)
    }
}

/// Straight without expo, flat about the middle with.
fn curve(expo: f32, stick: f32) -> f32 {
    (1.0 - expo) * stick + expo * stick * stick * stick
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::tests::any_pilot;
    use proptest::prelude::*;

    fn near(found: f32, expected: f32) -> bool {
        (found - expected).abs() < 1e-6
    }

    proptest! {
        /// Whatever is chosen: full stick is full reach, no stick is none, more stick is more, and the throttle goes
        /// from nothing to everything.
        #[test]
        fn ends_and_order_are_kept(pilot in any_pilot(), stick in -1f32..=1.0, more in 0f32..=1.0) {
            let curves = StickCurves::new(&pilot);
            let all = |stick: f32| Sticks { roll: stick, pitch: stick, yaw: stick, throttle: 0.5 + 0.5 * stick };
            let further = all(stick + more * (1.0 - stick));
            let (low, high) = (curves.stabilise(&all(stick)), curves.stabilise(&further));
            prop_assert!(low.roll_rad <= high.roll_rad + 1e-6 && low.throttle <= high.throttle + 1e-6);
            let (low, high) = (curves.acro(&all(stick)).acro_rad_s.unwrap(), curves.acro(&further).acro_rad_s.unwrap());
            prop_assert!((0..3).all(|axis| low[axis] <= high[axis] + 1e-6));
            let (full, rest) = (curves.stabilise(&all(1.0)), curves.stabilise(&all(0.0)));
            prop_assert!(near(full.pitch_rad, f32::from(pilot.tilt_deg).to_radians()) && near(full.throttle, 1.0));
            prop_assert_eq!((rest.roll_rad, rest.yaw_rate_rad_s), (0.0, 0.0));
            prop_assert!(near(rest.throttle, f32::from(pilot.throttle_mid_percent) / 100.0));
            prop_assert!(near(curves.stabilise(&all(-1.0)).throttle, 0.0));
            let [.., yaw] = curves.acro(&all(1.0)).acro_rad_s.unwrap();
            prop_assert!(near(yaw, f32::from(pilot.acro_yaw_deg_s).to_radians()));
        }
    }

    /// By hand: with a share of 0.4 half a stick is 0.6 / 2 + 0.4 / 8 = 0.35 of the reach.
    #[test]
    fn expo_is_a_share_of_a_cube() {
        let pilot = PilotParams { acro_tilt_deg_s: 180, acro_expo_percent: 40, ..PilotParams::DEFAULT };
        let sticks = Sticks { roll: 0.5, pitch: -0.5, throttle: 0.75, yaw: 0.0 };
        let acro = StickCurves::new(&pilot).acro(&sticks);
        let [roll, pitch, _] = acro.acro_rad_s.unwrap();
        assert!(near(roll, 0.35 * core::f32::consts::PI) && near(pitch, -roll));
        assert!(near(acro.throttle, 0.75), "straight");
        let pilot = PilotParams { throttle_mid_percent: 60, throttle_expo_percent: 40, ..pilot };
        let throttle = |stick| StickCurves::new(&pilot).stabilise(&Sticks { throttle: stick, ..sticks }).throttle;
        assert!(near(throttle(0.75), 0.6 + 0.4 * 0.35) && near(throttle(0.25), 0.6 - 0.6 * 0.35));
    }
}
