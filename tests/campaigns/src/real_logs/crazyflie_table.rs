//! The Crazyflie's numbers as tables: literature, this log by the diagnosis and by the authors' way, the authors'.

use std::fmt;

use sil_host::axis::Axis;
use sil_host::diagnosis::Estimate;
use sil_host::log::Log;
use sil_host::model::VehicleModel;

use super::crazyflie::{
    HOVER, ROLL_PITCH_S, Sizes, ThrustCurve, YAW_S, Yaw, authors, by_fifths, lift_n, lift_slope_n,
    regressed_inertia_kg_m2, roll_and_pitch, thrust_curve, yaw,
};

/// Commands at which lifts are told.
const COMMANDS: [f64; 3] = [0.5, HOVER, 0.8];

/// What the log for roll and pitch says.
pub struct RollPitch<'a> {
    vehicle: &'a VehicleModel,
    /// The thrust curve of the whole flight.
    pub curve: ThrustCurve,
    /// Of its fifths: lag, lift at the three commands, slope at hover.
    curve_by_fifths: [Estimate; 5],
    /// The diagnosis' sizes.
    pub sizes: Sizes,
    /// Of the fifths: inertia's scale about roll and pitch, lag.
    sizes_by_fifths: [Estimate; 3],
    /// By the authors' way and by its opposite, about roll and pitch, kg m^2.
    pub regressed_kg_m2: [[f64; 2]; 2],
}

impl<'a> RollPitch<'a> {
    /// Looks at the flying part of the log.
    ///
    /// # Panics
    /// It is another log.
    pub fn of(log: &Log, vehicle: &'a VehicleModel) -> RollPitch<'a> {
        let log = log.between(ROLL_PITCH_S[0], ROLL_PITCH_S[1]).expect("the flight");
        let curve_by_fifths = by_fifths(&log, |part| {
            let curve = thrust_curve(part, vehicle);
            let [low, hover, high] = COMMANDS.map(|command| lift_n(curve.lift_n, command));
            [curve.time_constant_s, low, hover, high, lift_slope_n(curve.lift_n, HOVER)]
        });
        let sizes_by_fifths = by_fifths(&log, |part| {
            let Sizes { inertia_scale: [roll, pitch], lag_s } = roll_and_pitch(part, vehicle);
            [roll, pitch, lag_s]
        });
        let regressed_kg_m2 = [Axis::Roll, Axis::Pitch]
            .map(|axis| regressed_inertia_kg_m2(&log, authors::LIFT_N, authors::TIME_CONSTANT_S, axis));
        let (curve, sizes) = (thrust_curve(&log, vehicle), roll_and_pitch(&log, vehicle));
        RollPitch { vehicle, curve, curve_by_fifths, sizes, sizes_by_fifths, regressed_kg_m2 }
    }

    /// Inertia about an axis, kg m^2: the diagnosis' scale, and with it the slope that the accelerometer gives to the thrust curve in the place of
    /// the model's.
    pub fn inertia_kg_m2(&self, axis: usize) -> Estimate {
        let (scale, slope) = (self.sizes_by_fifths[axis], self.curve_by_fifths[4]);
        let per_slope = self.vehicle.inertia_kg_m2[axis] / self.nominal_slope_n();
        let value = self.sizes.inertia_scale[axis] * lift_slope_n(self.curve.lift_n, HOVER) * per_slope;
        let share = |estimate: Estimate| estimate.std / estimate.value;
        Estimate { value, std: value * (share(scale) * share(scale) + share(slope) * share(slope)).sqrt() }
    }

    fn nominal_slope_n(&self) -> f64 {
        const STEP: f64 = 1e-4;
        let lift_n = |command| self.vehicle.propulsion.lift_n(command);
        (lift_n(HOVER + STEP) - lift_n(HOVER - STEP)) / (2.0 * STEP)
    }
}

impl fmt::Display for RollPitch<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "| | literature (the model) | this log, diagnosis | this log, the authors' way | authors |")?;
        writeln!(out, "|---|---|---|---|---|")?;
        for (axis, name) in ["Ixx", "Iyy"].into_iter().enumerate() {
            let own = self.inertia_kg_m2(axis);
            let [forward, backward] = self.regressed_kg_m2[axis].map(|inertia| 1e5 * inertia);
            writeln!(
                out,
                "| {name}, 1e-5 kg m^2 | {:.3} | {:.2} +- {:.2} | {forward:.2} (other way round {backward:.2}) | {:.3} |",
                1e5 * self.vehicle.inertia_kg_m2[axis],
                1e5 * own.value,
                1e5 * own.std,
                1e5 * authors::INERTIA_KG_M2[axis]
            )?;
            writeln!(
                out,
                "| {name} over the model's, at the model's lift | 1 | {:.3} +- {:.3} | | |",
                self.sizes.inertia_scale[axis], self.sizes_by_fifths[axis].std
            )?;
        }
        writeln!(
            out,
            "| motors' lag, ms | {:.1} | {:.1} +- {:.1} | {:.0} +- {:.0} | {:.0} |",
            1e3 * nominal_lag_s(self.vehicle),
            1e3 * self.sizes.lag_s,
            1e3 * self.sizes_by_fifths[2].std,
            1e3 * self.curve.time_constant_s,
            1e3 * self.curve_by_fifths[0].std,
            1e3 * authors::TIME_CONSTANT_S
        )?;
        for (place, command) in COMMANDS.into_iter().enumerate() {
            writeln!(
                out,
                "| lift of a motor at {command}, mN | {:.1} | - | {:.1} +- {:.1} | {:.1} |",
                1e3 * self.vehicle.propulsion.lift_n(command),
                1e3 * lift_n(self.curve.lift_n, command),
                1e3 * self.curve_by_fifths[1 + place].std,
                1e3 * lift_n(authors::LIFT_N, command)
            )?;
        }
        writeln!(
            out,
            "| slope at {HOVER}, mN | {:.0} | - | {:.0} +- {:.0} | {:.0} |",
            1e3 * self.nominal_slope_n(),
            1e3 * lift_slope_n(self.curve.lift_n, HOVER),
            1e3 * self.curve_by_fifths[4].std,
            1e3 * lift_slope_n(authors::LIFT_N, HOVER)
        )?;
        let curve = |[constant, linear, square]: [f64; 3]| format!("{constant:.4} {linear:+.4} u {square:+.4} u^2");
        writeln!(out, "| lift, N | | - | {} | {} |", curve(self.curve.lift_n), curve(authors::LIFT_N))
    }
}

fn nominal_lag_s(vehicle: &VehicleModel) -> f64 {
    match vehicle.propulsion {
        sil_host::vehicle::propulsion::Propulsion::Generic(rotor) => rotor.time_constant_s,
        _ => 0.0,
    }
}

/// What the log for yaw says.
///
/// # Panics
/// It is another log.
pub fn yaw_of(log: &Log) -> Yaw {
    let parts = YAW_S.map(|[from_s, to_s]| log.between(from_s, to_s).expect("the flight"));
    yaw(&parts, authors::LIFT_N, authors::TIME_CONSTANT_S)
}

impl fmt::Display for Yaw {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let theirs = authors::TORQUE_PER_LIFT_M / authors::INERTIA_KG_M2[2];
        writeln!(out, "| yaw, at the authors' lift and lag | this log | authors |\n|---|---|---|")?;
        writeln!(
            out,
            "| torque over lift over Izz, 1/(kg m) | {:.0} | {theirs:.0} |",
            self.torque_per_lift_over_inertia
        )?;
        writeln!(
            out,
            "| rate that the rotors' speeding up gives, rad/s per unit of command | {:.2} | - |",
            self.rate_per_command_rad_s
        )?;
        writeln!(out, "| braking, 1/s | {:.2} | - |", self.damping_1_s)?;
        let [with, without] = self.left_rad_s;
        writeln!(
            out,
            "| left of the rate, rad/s: torque alone, with rotors and braking | {without:.2}, {with:.2} | - |"
        )
    }
}
