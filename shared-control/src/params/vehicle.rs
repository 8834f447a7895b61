//! The vehicle's own numbers, as an owner weighs and measures them or `sil identify` finds them.
//!
//! A rotor's speed follows the command in a straight line, so that its lift is (s0 + (s1 - s0) command)^2 with s0^2 and
//! s1^2 the lifts at both ends: the generic vehicle of the model files, which identification writes.

use core::fmt;

use super::Rig;
use super::allowed::Allowed;
use crate::elementary::{magnitude, sqrt};
use crate::gravity_moment::GravityMoment;
use crate::lift_curve::{LIFT_INTERVALS, LiftCurve};
use crate::vehicle::{Actuation, VehicleParameters};

/// One number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VehiclePart {
    /// [`VehicleNumbers::flown`].
    Flown,
    /// [`VehicleNumbers::mass_g`].
    Mass,
    /// [`VehicleNumbers::arm_mm`].
    Arm,
    /// [`VehicleNumbers::inertia_e5_kg_m2`], roll.
    Roll,
    /// The same, pitch.
    Pitch,
    /// The same, yaw.
    Yaw,
    /// [`VehicleNumbers::ring_e5_kg_m2`].
    Ring,
    /// [`VehicleNumbers::torque_per_lift_um`].
    TorquePerLift,
    /// [`VehicleNumbers::lift_min_mn`].
    LiftMin,
    /// [`VehicleNumbers::lift_max_mn`].
    LiftMax,
    /// [`VehicleNumbers::lag_e4_s`].
    Lag,
    /// [`VehicleNumbers::delay_e4_s`].
    Delay,
}

/// Whose numbers are flown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlownVehicle {
    /// Nobody has said: on the gimbal, which holds whatever hangs in it, the F450; in free flight nothing arms, since
    /// another vehicle would leave the ground with gains that are not its own.
    #[default]
    Unnamed,
    /// [`VehicleNumbers`].
    Own,
    /// The F450 on what [`Rig`] says.
    F450,
}

impl FlownVehicle {
    fn number(self) -> u16 {
        match self {
            Self::Unnamed => 0,
            Self::Own => 1,
            Self::F450 => 2,
        }
    }

    fn from_number(number: u16) -> Self {
        match number {
            1 => Self::Own,
            2 => Self::F450,
            _ => Self::Unnamed,
        }
    }
}

/// The numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VehicleNumbers {
    /// Are these numbers flown, or the F450's?
    pub flown: FlownVehicle,
    /// Mass, g.
    pub mass_g: u16,
    /// Motor to centre, mm.
    pub arm_mm: u16,
    /// Inertia of the body about its axes, 1e-5 kg m^2.
    pub inertia_e5_kg_m2: [u16; 3],
    /// Inertia of the rig's ring, which pitch turns along, 1e-5 kg m^2.
    pub ring_e5_kg_m2: u16,
    /// Reaction torque per lift of a motor, 1e-6 m.
    pub torque_per_lift_um: u16,
    /// Lift of a motor at command 0, mN.
    pub lift_min_mn: u16,
    /// Lift of a motor at command 1, mN.
    pub lift_max_mn: u16,
    /// Time constant from command to lift, 1e-4 s.
    pub lag_e4_s: u16,
    /// Pure delay from command to lift, 1e-4 s.
    pub delay_e4_s: u16,
}

/// What makes no sense about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VehicleFault {
    /// In free flight none are named, neither the owner's nor the F450's.
    Missing,
    /// No body has such inertias: one exceeds the sum of the others.
    Inertia,
    /// The lift at command 0 is more than a quarter of that at 1.
    LiftRange,
    /// Four motors lift less than 1.3 times the weight.
    TooWeak,
    /// At `HOVER_PERMILLE` the lift is not the weight, by more than 30 %.
    Hover,
    /// The motors turn it too fast or too slowly for these controllers.
    Authority,
}

impl fmt::Display for VehicleFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            VehicleFault::Missing => "no vehicle's numbers: sil identify --params",
            VehicleFault::Inertia => "vehicle: VEH_I..: one exceeds the others' sum",
            VehicleFault::LiftRange => "vehicle: VEH_LIFT_MIN_MN over a quarter of MAX",
            VehicleFault::TooWeak => "vehicle: VEH_LIFT_MAX_MN does not lift mass",
            VehicleFault::Hover => "vehicle: HOVER_PERMILLE does not lift VEH_MASS_G",
            VehicleFault::Authority => "vehicle: lift, arm and inertia do not fit",
        })
    }
}

const GRAVITY_M_S2: f32 = 9.81;
/// Least lift of all motors over the weight.
const LIFT_OVER_WEIGHT_MIN: f32 = 1.3;
/// Deviation of the lift at the hovering throttle from the weight.
const HOVER_WITHIN: f32 = 0.3;
/// Angular acceleration that a vehicle can have in roll and pitch, rad/s^2: the gimbal's 8.5 in pitch and less, to a
/// racer's and more.
const AUTHORITY_RAD_S2: core::ops::RangeInclusive<f32> = 4.0..=1000.0;
/// The same in yaw.
const AUTHORITY_YAW_RAD_S2: core::ops::RangeInclusive<f32> = 0.4..=300.0;

impl VehicleNumbers {
    /// Those of `models/generic-free.toml`, the F450 in free flight; not flown unless an owner says so.
    pub const DEFAULT: VehicleNumbers = VehicleNumbers {
        flown: FlownVehicle::Unnamed,
        mass_g: 1200,
        arm_mm: 226,
        inertia_e5_kg_m2: [1151, 1151, 2000],
        ring_e5_kg_m2: 0,
        torque_per_lift_um: 16_100,
        lift_min_mn: 23,
        lift_max_mn: 9_374,
        lag_e4_s: 527,
        delay_e4_s: 0,
    };

    /// The F450 that this project knows, on whatever the rig is.
    pub const F450: VehicleNumbers = VehicleNumbers { flown: FlownVehicle::F450, ..VehicleNumbers::DEFAULT };

    /// The vehicle of these numbers on a rig.
    ///
    /// # Errors
    /// The first thing that makes no sense; then nothing may fly by them.
    pub fn vehicle(&self, rig: Rig, hover_throttle: f32) -> Result<VehicleParameters, VehicleFault> {
        let [roll, pitch, yaw] = self.inertia_e5_kg_m2.map(|inertia| f32::from(inertia) * 1e-5);
        let ring_kg_m2 = if rig == Rig::Gimbal { f32::from(self.ring_e5_kg_m2) * 1e-5 } else { 0.0 };
        let (lift_min_n, lift_max_n) = (f32::from(self.lift_min_mn) / 1000.0, f32::from(self.lift_max_mn) / 1000.0);
        // a body's plane may have all its mass: equal but for rounding
        let sum = 1.001 * (roll + pitch + yaw);
        if [roll, pitch, yaw].iter().any(|inertia| 2.0 * inertia > sum) {
            return Err(VehicleFault::Inertia);
        }
        if 4.0 * lift_min_n > lift_max_n {
            return Err(VehicleFault::LiftRange);
        }
        let vehicle = VehicleParameters {
            gravity_m_s2: GRAVITY_M_S2,
            arm_m: f32::from(self.arm_mm) / 1000.0,
            inertia_kg_m2: [roll, pitch + ring_kg_m2, yaw],
            ring_inertia_kg_m2: ring_kg_m2,
            torque_per_lift_m: f32::from(self.torque_per_lift_um) * 1e-6,
            lift_curve: straight_speed(lift_min_n, lift_max_n),
            actuation: Actuation { delay_s: f32::from(self.delay_e4_s) * 1e-4, lag_s: f32::from(self.lag_e4_s) * 1e-4 },
            gravity_moment: GravityMoment::NONE,
            yaw_locked: rig == Rig::Gimbal,
        };
        self.check(rig, &vehicle, hover_throttle).map_or(Ok(vehicle), Err)
    }

    /// What makes no sense about the whole.
    fn check(&self, rig: Rig, vehicle: &VehicleParameters, hover_throttle: f32) -> Option<VehicleFault> {
        let weight_n = f32::from(self.mass_g) / 1000.0 * vehicle.gravity_m_s2;
        let hovering_n = 4.0 * vehicle.lift_curve.lift(hover_throttle);
        let [roll, pitch, yaw] = vehicle.acceleration_authority_rad_s2();
        let flies = rig == Rig::Free;
        if flies && 4.0 * vehicle.lift_curve.lift_max_n < LIFT_OVER_WEIGHT_MIN * weight_n {
            Some(VehicleFault::TooWeak)
        } else if flies && magnitude(hovering_n - weight_n) > HOVER_WITHIN * weight_n {
            Some(VehicleFault::Hover)
        } else if !(AUTHORITY_RAD_S2.contains(&roll)
            && AUTHORITY_RAD_S2.contains(&pitch)
            && AUTHORITY_YAW_RAD_S2.contains(&yaw))
        {
            Some(VehicleFault::Authority)
        } else {
            None
        }
    }

    /// A number.
    pub(super) fn get(&self, part: VehiclePart) -> u16 {
        let [roll, pitch, yaw] = self.inertia_e5_kg_m2;
        match part {
            VehiclePart::Flown => self.flown.number(),
            VehiclePart::Mass => self.mass_g,
            VehiclePart::Arm => self.arm_mm,
            VehiclePart::Roll => roll,
            VehiclePart::Pitch => pitch,
            VehiclePart::Yaw => yaw,
            VehiclePart::Ring => self.ring_e5_kg_m2,
            VehiclePart::TorquePerLift => self.torque_per_lift_um,
            VehiclePart::LiftMin => self.lift_min_mn,
            VehiclePart::LiftMax => self.lift_max_mn,
            VehiclePart::Lag => self.lag_e4_s,
            VehiclePart::Delay => self.delay_e4_s,
        }
    }

    /// Changes a number, to what the table allows.
    pub(super) fn set(&mut self, part: VehiclePart, value: u16) {
        let [roll, pitch, yaw] = &mut self.inertia_e5_kg_m2;
        let number = match part {
            VehiclePart::Flown => return self.flown = FlownVehicle::from_number(value),
            VehiclePart::Mass => &mut self.mass_g,
            VehiclePart::Arm => &mut self.arm_mm,
            VehiclePart::Roll => roll,
            VehiclePart::Pitch => pitch,
            VehiclePart::Yaw => yaw,
            VehiclePart::Ring => &mut self.ring_e5_kg_m2,
            VehiclePart::TorquePerLift => &mut self.torque_per_lift_um,
            VehiclePart::LiftMin => &mut self.lift_min_mn,
            VehiclePart::LiftMax => &mut self.lift_max_mn,
            VehiclePart::Lag => &mut self.lag_e4_s,
            VehiclePart::Delay => &mut self.delay_e4_s,
        };
        *number = value;
    }
}

/// The lift of a rotor whose speed follows the command in a straight line.
fn straight_speed(lift_min_n: f32, lift_max_n: f32) -> LiftCurve {
    let (slowest, fastest) = (sqrt(lift_min_n), sqrt(lift_max_n));
    let command_at = core::array::from_fn(|k| match k {
        0 => 0.0,
        LIFT_INTERVALS => 1.0,
        _ => {
            let lift_n = lift_min_n + (lift_max_n - lift_min_n) * k as f32 / LIFT_INTERVALS as f32;
            (sqrt(lift_n) - slowest) / (fastest - slowest)
        }
    });
    LiftCurve { lift_min_n, lift_max_n, command_at }
}

/// Name, range, unit and meaning.
pub(super) const fn row(part: VehiclePart) -> (&'static str, Allowed, &'static str, &'static str) {
    const INERTIA: Allowed = Allowed::Range(10, u16::MAX);
    match part {
        VehiclePart::Flown => (
            "VEHICLE",
            Allowed::Range(0, 2),
            "",
            "vehicle: 1 that of VEH_..., 2 the F450 on its RIG, 0 not said: on the gimbal the F450, free none arms",
        ),
        VehiclePart::Mass => ("VEH_MASS_G", Allowed::Range(100, 10_000), "g", "mass"),
        VehiclePart::Arm => ("VEH_ARM_MM", Allowed::Range(50, 1000), "mm", "motor to centre"),
        VehiclePart::Roll => ("VEH_IXX_E5", INERTIA, "1e-5 kg m^2", "inertia of the body about roll"),
        VehiclePart::Pitch => ("VEH_IYY_E5", INERTIA, "1e-5 kg m^2", "inertia of the body about pitch"),
        VehiclePart::Yaw => ("VEH_IZZ_E5", INERTIA, "1e-5 kg m^2", "inertia of the body about yaw"),
        VehiclePart::Ring => (
            "VEH_RING_E5",
            Allowed::Range(0, u16::MAX),
            "1e-5 kg m^2",
            "inertia of the gimbal's ring; not in free flight",
        ),
        VehiclePart::TorquePerLift => {
            ("VEH_TQ_LIFT_UM", Allowed::Range(1000, u16::MAX), "1e-6 m", "reaction torque over lift of a motor")
        }
        VehiclePart::LiftMin => ("VEH_LIFT_MIN_MN", Allowed::Range(0, 20_000), "mN", "lift of a motor at command 0"),
        VehiclePart::LiftMax => {
            ("VEH_LIFT_MAX_MN", Allowed::Range(200, u16::MAX), "mN", "lift of a motor at command 1")
        }
        VehiclePart::Lag => ("VEH_LAG_E4", Allowed::Range(0, 2000), "1e-4 s", "time constant from command to lift"),
        VehiclePart::Delay => ("VEH_DELAY_E4", Allowed::Range(0, 300), "1e-4 s", "pure delay from command to lift"),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    const HOVER: f32 = 0.54;

    /// Against `F450_FREE`, the same vehicle with its motors' insides, which is compared with its model elsewhere: the
    /// bodies are one to the last digit that is stored, the lift agrees about hover, where the generic one is tangent.
    #[test]
    fn the_defaults_are_the_f450_in_free_flight() {
        let (found, known) = (VehicleNumbers::DEFAULT.vehicle(Rig::Free, HOVER).unwrap(), VehicleParameters::F450_FREE);
        let near = |found: f32, known: f32, within: f32| (found - known).abs() <= within * known;
        assert!(near(found.arm_m, known.arm_m, 1e-6) && near(found.torque_per_lift_m, known.torque_per_lift_m, 1e-3));
        assert!((0..3).all(|axis| near(found.inertia_kg_m2[axis], known.inertia_kg_m2[axis], 1e-3)));
        assert!(near(found.actuation.lag_s, known.actuation.lag_s, 5e-3));
        for command in [0.45, 0.54, 0.65] {
            assert!(near(found.lift_curve.lift(command), known.lift_curve.lift(command), 0.02), "{command}");
        }
        assert!(!found.yaw_locked && found.lift_curve.is_increasing());
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let refused = |change: fn(&mut VehicleNumbers)| {
            let mut numbers = VehicleNumbers::DEFAULT;
            change(&mut numbers);
            numbers.vehicle(Rig::Free, HOVER).unwrap_err()
        };
        assert_eq!(refused(|numbers| numbers.inertia_e5_kg_m2[2] = 2400), VehicleFault::Inertia);
        assert_eq!(refused(|numbers| numbers.lift_min_mn = 2400), VehicleFault::LiftRange);
        assert_eq!(refused(|numbers| numbers.mass_g = 3000), VehicleFault::TooWeak);
        assert_eq!(refused(|numbers| numbers.mass_g = 800), VehicleFault::Hover);
        assert_eq!(refused(|numbers| numbers.inertia_e5_kg_m2 = [30; 3]), VehicleFault::Authority);
        for fault in [
            VehicleFault::Missing,
            VehicleFault::Hover,
            VehicleFault::Inertia,
            VehicleFault::LiftRange,
            VehicleFault::TooWeak,
        ] {
            // they go out as STATUSTEXT
            assert!(fault.to_string().len() <= 50, "{fault}");
        }
        // a rig carries what its motors do not lift
        let weak = VehicleNumbers { mass_g: 3000, ..VehicleNumbers::DEFAULT };
        assert!(weak.vehicle(Rig::Gimbal, HOVER).is_ok_and(|vehicle| vehicle.yaw_locked));
    }
}
