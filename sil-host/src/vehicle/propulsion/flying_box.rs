//! The conceptual flying box (thesis 3.3.2): a lift force at each corner, straight from the command.

use crate::document::{ModelError, Section, Table, admissible};

/// Lift along a straight line, `lift_offset_n + lift_slope_n * command`, never below zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingBox {
    /// Lift at command 0 if the line went on, N; negative where the line meets zero above command 0.
    pub lift_offset_n: f64,
    /// Lift per unit of command, N.
    pub lift_slope_n: f64,
    /// Reaction torque over lift, m; negative where all rotors turn the other way than in docs/rig.md.
    pub reaction_torque_per_lift_m: f64,
    /// Battery voltage at which it lifts so, V; `None` where nobody said.
    pub battery_v: Option<f64>,
}

impl FlyingBox {
    /// The same lift at a command, another share of it at none.
    pub(crate) fn with_offset(&self, share: f64, at_command: f64) -> Self {
        let lift_n = self.lift_offset_n + self.lift_slope_n * at_command;
        let lift_slope_n = (1.0 - share) * lift_n / at_command;
        Self { lift_offset_n: share * lift_n, lift_slope_n, ..*self }
    }

    /// The same at another battery voltage, and the old one over it; `None` where its own is not known. Lift goes with
    /// command times voltage, so that a command larger by that share lifts as before.
    pub(crate) fn at_voltage(&self, battery_v: f64) -> Option<(Self, f64)> {
        let lower = self.battery_v? / battery_v;
        let lift_slope_n = self.lift_slope_n / lower;
        Some((Self { lift_slope_n, battery_v: Some(battery_v), ..*self }, lower))
    }

    pub(super) fn lift_n(&self, command: f64) -> f64 {
        (self.lift_offset_n + self.lift_slope_n * command).max(0.0)
    }

    pub(super) fn read(section: &Section<'_>) -> Result<Self, ModelError> {
        let offset = admissible(-100.0, 100.0, "the lift line's value at command 0 in newton");
        let slope = admissible(1e-3, 500.0, "the lift per unit of command in newton");
        let ratio = admissible(-1.0, 1.0, "reaction torque over lift in metres");
        let battery = admissible(1.0, 100.0, "the battery's voltage at which it lifts so in volt");
        Ok(Self {
            lift_offset_n: section.number("lift_offset_n", offset)?,
            lift_slope_n: section.number("lift_slope_n", slope)?,
            reaction_torque_per_lift_m: section.number("reaction_torque_per_lift_m", ratio)?,
            battery_v: section.optional_number("battery_v", battery)?,
        })
    }

    pub(super) fn write(&self, table: &mut Table) {
        table.number("lift_offset_n", self.lift_offset_n);
        table.number("lift_slope_n", self.lift_slope_n);
        table.number("reaction_torque_per_lift_m", self.reaction_torque_per_lift_m);
        if let Some(battery_v) = self.battery_v {
            table.number("battery_v", battery_v);
        }
    }
}
