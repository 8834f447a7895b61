//! The specific device (thesis 3.3.4, 3.5 and appendix C): speed controller, motor winding, rotor.
//!
//! - Speed controller, static: [`Esc`]
//! - Winding: `L di/dt = u - R i - (w - B_m)/A_m`  (figure C.1 with C.2; back-EMF from the affine speed line)
//! - Rotor: `(I_r + I_m) dw/dt = i/A_m - M_lo w - R_d w|w|`, w >= 0  (C.3, C.7)
//! - Lift `R_l w^2`, reaction torque `R_t w^2`  (C.5, C.6)
//!
//! Departure from the thesis: (C.4) takes the speed constant A_m as torque constant; in SI units it is 1/A_m.

use super::{LookUpTable, RotorState};
use crate::document::{ModelError, Section, Table, admissible};

/// All constants of the electro-mechanical propulsion of one arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DevicePropulsion {
    /// From command to the winding's equivalent direct voltage.
    pub esc: Esc,
    /// Winding resistance R_m, ohm.
    pub resistance_ohm: f64,
    /// Winding inductance L_m, H.
    pub inductance_h: f64,
    /// Speed constant A_m, rad/s/V; its inverse is the torque constant, N m/A.
    pub speed_constant_rad_s_v: f64,
    /// Offset B_m of the speed line, rad/s.
    pub speed_offset_rad_s: f64,
    /// Motor loss M_lo, N m s.
    pub loss_nm_s: f64,
    /// Inertia of the motor's rotating part I_m, kg m².
    pub motor_inertia_kg_m2: f64,
    /// Inertia of the rotor (propeller) I_r, kg m².
    pub rotor_inertia_kg_m2: f64,
    /// Lift coefficient R_l, N s²/rad².
    pub lift_n_s2: f64,
    /// Reaction torque coefficient R_t, N m s²/rad².
    pub reaction_torque_nm_s2: f64,
    /// Aerodynamic drag coefficient R_d of the rotor, as the motor feels it, N m s²/rad².
    pub drag_nm_s2: f64,
    /// Lift over speed as it was measured, instead of `R_l w²`; the reaction torque stays `R_t/R_l` of the lift.
    pub lift_table: Option<LookUpTable>,
}

/// Shortest electrical time constant that is simulated, s; a shorter one would only cost steps.
const WINDING_TIME_MIN_S: f64 = 2e-5;

/// The static map of the speed controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a table lies in the model itself, so that models stay plain values; they are few and passed by reference"
)]
pub enum Esc {
    /// Thesis C.1: `u = A exp(B s) + C exp(D s)` with the set-point `s = 100 command`.
    Exponential {
        /// A_esc, V.
        gain1_v: f64,
        /// B_esc, per unit of set-point.
        rate1: f64,
        /// C_esc, V.
        gain2_v: f64,
        /// D_esc, per unit of set-point.
        rate2: f64,
    },
    /// The command is the duty cycle of the battery's voltage.
    Duty {
        /// Voltage under load, V.
        battery_v: f64,
    },
    /// Voltage over command as it was measured (thesis 6.3).
    Table(LookUpTable),
}

/// The names of a speed controller's maps.
#[derive(Clone, Copy)]
enum Map {
    Exponential,
    Duty,
    Table,
}

impl DevicePropulsion {
    /// The winding's voltage at a command (0..1), V.
    pub fn voltage_v(&self, command: f64) -> f64 {
        match self.esc {
            Esc::Exponential { gain1_v, rate1, gain2_v, rate2 } => {
                let setpoint = 100.0 * command;
                gain1_v * libm::exp(rate1 * setpoint) + gain2_v * libm::exp(rate2 * setpoint)
            }
            Esc::Duty { battery_v } => battery_v * command,
            Esc::Table(table) => table.value(command),
        }
    }

    /// Time constant of the rotor's speed about a steady one, the winding's current following at once, s: what the
    /// torque `(u - (w - B)/A)/(R A) - M_lo w - R_d w^2` loses with speed, over the inertia.
    pub fn lag_s(&self, speed_rad_s: f64) -> f64 {
        let inertia_kg_m2 = self.motor_inertia_kg_m2 + self.rotor_inertia_kg_m2;
        let constant = self.speed_constant_rad_s_v;
        let electric = 1.0 / (self.resistance_ohm * constant * constant);
        inertia_kg_m2 / (electric + self.loss_nm_s + 2.0 * self.drag_nm_s2 * speed_rad_s)
    }

    /// Speed (rad/s) and current (A) at rest under `voltage_v`.
    ///
    /// With both derivatives zero, `R A (M_lo w + R_d w^2) + (w - B)/A = u`: a quadratic with one root w >= 0.
    pub fn equilibrium(&self, voltage_v: f64) -> (f64, f64) {
        let constant = self.speed_constant_rad_s_v;
        let drive_v = voltage_v + self.speed_offset_rad_s / constant;
        if drive_v <= 0.0 {
            return (0.0, drive_v / self.resistance_ohm);
        }
        let square = self.resistance_ohm * constant * self.drag_nm_s2;
        let linear = self.resistance_ohm * constant * self.loss_nm_s + 1.0 / constant;
        // the form that stays exact as the quadratic term vanishes
        let speed = 2.0 * drive_v / (linear + (linear * linear + 4.0 * square * drive_v).sqrt());
        let torque_nm = self.loss_nm_s * speed + self.drag_nm_s2 * speed * speed;
        (speed, torque_nm * constant)
    }

    /// Lift at a speed, N.
    #[inline]
    pub fn lift_n(&self, speed_rad_s: f64) -> f64 {
        match &self.lift_table {
            None => self.lift_n_s2 * speed_rad_s * speed_rad_s,
            Some(table) => table.value(speed_rad_s),
        }
    }

    /// Winding and rotor equations of all four motors.
    #[inline]
    pub(crate) fn derivative(&self, voltage_v: &[f64; 4], rotors: &RotorState) -> RotorState {
        let mut change = [0.0; 8];
        for motor in 0..4 {
            let of_motor = self.derivative_of_motor(voltage_v[motor], [rotors[motor], rotors[4 + motor]]);
            [change[motor], change[4 + motor]] = of_motor;
        }
        change
    }

    /// Rates of change of a motor's speed (rad/s) and winding current (A).
    #[inline]
    pub(super) fn derivative_of_motor(&self, voltage_v: f64, [speed, current]: [f64; 2]) -> [f64; 2] {
        let per_speed_constant = 1.0 / self.speed_constant_rad_s_v;
        let per_inductance = 1.0 / self.inductance_h;
        let per_inertia = 1.0 / (self.motor_inertia_kg_m2 + self.rotor_inertia_kg_m2);
        let back_emf_v = (speed - self.speed_offset_rad_s) * per_speed_constant;
        let load_nm = speed * (self.loss_nm_s + self.drag_nm_s2 * speed.abs());
        let acceleration = (current * per_speed_constant - load_nm) * per_inertia;
        // a rotor at rest does not turn backwards
        let stopped = speed <= 0.0 && acceleration < 0.0;
        let current_change = (voltage_v - self.resistance_ohm * current - back_emf_v) * per_inductance;
        [if stopped { 0.0 } else { acceleration }, current_change]
    }

    pub(super) fn read(section: &Section<'_>) -> Result<Self, ModelError> {
        let esc = section.section("esc")?;
        let motor = section.section("motor")?;
        let rotor = section.section("rotor")?;
        let resistance = admissible(1e-3, 10.0, "the winding's resistance in ohm");
        let inductance = admissible(1e-7, 1e-2, "the winding's inductance in henry");
        let constant = admissible(1.0, 5e3, "the speed constant in rad/s/V (kv * 0.10472)");
        let offset = admissible(-2e3, 2e3, "the speed line's value at 0 V in rad/s");
        let loss = admissible(0.0, 1e-2, "the motor's loss in N m s");
        let inertia = admissible(1e-10, 1e-2, "a moment of inertia in kg m^2");
        let drag = admissible(0.0, 1e-4, "the rotor's drag coefficient in N m s^2/rad^2");
        let device = Self {
            esc: Esc::read(&esc)?,
            resistance_ohm: motor.number("resistance_ohm", resistance)?,
            inductance_h: motor.number("inductance_h", inductance)?,
            speed_constant_rad_s_v: motor.number("speed_constant_rad_s_v", constant)?,
            speed_offset_rad_s: motor.number("speed_offset_rad_s", offset)?,
            loss_nm_s: motor.number("loss_nm_s", loss)?,
            motor_inertia_kg_m2: motor.number("inertia_kg_m2", inertia)?,
            rotor_inertia_kg_m2: rotor.number("inertia_kg_m2", inertia)?,
            lift_n_s2: rotor.number("lift_n_s2", super::LIFT)?,
            reaction_torque_nm_s2: rotor.number("reaction_torque_nm_s2", super::TORQUE)?,
            drag_nm_s2: rotor.number("drag_nm_s2", drag)?,
            lift_table: read_lift_table(&rotor)?,
        };
        esc.finish()?;
        motor.finish()?;
        rotor.finish()?;
        // the integration step follows the winding; real ones have 1e-4 to 1e-3 s
        if device.inductance_h / device.resistance_ohm < WINDING_TIME_MIN_S {
            return Err(motor.impossible(format!(
                "the winding's time constant inductance_h / resistance_ohm is {:.1e} s: expected at least \
                 {WINDING_TIME_MIN_S} s",
                device.inductance_h / device.resistance_ohm
            )));
        }
        Ok(device)
    }

    pub(super) fn write(&self, table: &mut Table) {
        table.header("[propulsion.esc]");
        self.esc.write(table);
        table.header("[propulsion.motor]");
        table.number("resistance_ohm", self.resistance_ohm);
        table.number("inductance_h", self.inductance_h);
        table.number("speed_constant_rad_s_v", self.speed_constant_rad_s_v);
        table.number("speed_offset_rad_s", self.speed_offset_rad_s);
        table.number("loss_nm_s", self.loss_nm_s);
        table.number("inertia_kg_m2", self.motor_inertia_kg_m2);
        table.header("[propulsion.rotor]");
        table.number("inertia_kg_m2", self.rotor_inertia_kg_m2);
        table.number("lift_n_s2", self.lift_n_s2);
        table.number("reaction_torque_nm_s2", self.reaction_torque_nm_s2);
        table.number("drag_nm_s2", self.drag_nm_s2);
        if let Some(lift) = &self.lift_table {
            table.header("[propulsion.rotor.lift_table]");
            lift.write(table, "speed_rad_s", "lift_n");
        }
    }
}

/// A rotor whose lift is a table of measurements, where the file has one.
fn read_lift_table(rotor: &Section<'_>) -> Result<Option<LookUpTable>, ModelError> {
    let Some(section) = rotor.optional_section("lift_table")? else { return Ok(None) };
    let speed = admissible(0.0, 2e4, "the speeds of a table in rad/s");
    let lift = admissible(-50.0, 500.0, "their lifts in newton");
    let table = LookUpTable::read(&section, ("speed_rad_s", speed), ("lift_n", lift))?;
    section.finish()?;
    Ok(Some(table))
}

impl Esc {
    fn read(section: &Section<'_>) -> Result<Self, ModelError> {
        let gain = admissible(-100.0, 100.0, "a voltage in volt");
        let rate = admissible(-1.0, 1.0, "a rate per unit of set-point (0..100)");
        let battery = admissible(1.0, 100.0, "the battery's voltage in volt");
        match section.choice("map", &[("exponential", Map::Exponential), ("duty", Map::Duty), ("table", Map::Table)])? {
            Map::Exponential => Ok(Self::Exponential {
                gain1_v: section.number("gain1_v", gain)?,
                rate1: section.number("rate1", rate)?,
                gain2_v: section.number("gain2_v", gain)?,
                rate2: section.number("rate2", rate)?,
            }),
            Map::Duty => Ok(Self::Duty { battery_v: section.number("battery_v", battery)? }),
            Map::Table => {
                let command = admissible(0.0, 1.0, "the commands of a table");
                let voltage = admissible(-100.0, 100.0, "their voltages in volt");
                LookUpTable::read(section, ("command", command), ("voltage_v", voltage)).map(Self::Table)
            }
        }
    }

    fn write(&self, table: &mut Table) {
        match *self {
            Self::Exponential { gain1_v, rate1, gain2_v, rate2 } => {
                table.string("map", "exponential");
                table.number("gain1_v", gain1_v);
                table.number("rate1", rate1);
                table.number("gain2_v", gain2_v);
                table.number("rate2", rate2);
            }
            Self::Duty { battery_v } => {
                table.string("map", "duty");
                table.number("battery_v", battery_v);
            }
            Self::Table(voltages) => {
                table.string("map", "table");
                voltages.write(table, "command", "voltage_v");
            }
        }
    }
}
