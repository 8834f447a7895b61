//! What no propeller, motor or vehicle can have: constants held against each other and against physics.
//!
//! Each number by itself may pass; together they often do not. Bounds are wide: a check that fails says that a
//! measurement, a unit or a formula is wrong, not that a design is bad.

use serde::Serialize;

use crate::vehicle::propulsion::DevicePropulsion;

/// What is known of the vehicle beside its constants; what is not given is not checked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Diameter of the propeller, m.
    pub diameter_m: Option<f64>,
    /// Mass of the vehicle that four of these propulsions lift, kg.
    pub mass_kg: Option<f64>,
    /// Rated speed constant of the motor, rpm/V.
    pub kv_rpm_v: Option<f64>,
    /// Highest voltage of the supply, V.
    pub supply_v: Option<f64>,
}

/// What a check found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Found {
    /// Within the bounds.
    Plausible,
    /// Outside of them: this can't be.
    Impossible,
    /// Something that it needs was not given.
    NotChecked,
}

/// A check and what it found.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Its name.
    pub name: &'static str,
    /// Its result.
    pub found: Found,
    /// The numbers, and what they should be.
    pub says: String,
}

/// Density of air at 15 degrees and sea level, kg/m^3 (ISO 2533).
const AIR_KG_M3: f64 = 1.225;
/// One torque, measured twice: benches repeat it within some percent.
const TORQUE_RATIO: [f64; 2] = [0.8, 1.25];
/// Share of the ideal power that a hovering propeller needs, inverted. Above 1 momentum theory is violated; propellers
/// of 5 to 20 inches have 0.4 to 0.75 (Brandt and Selig, AIAA 2011-1255; the tables were not at hand).
const FIGURE_OF_MERIT: [f64; 2] = [0.3, 0.85];
/// Lift over `rho n^2 D^4`: static values of the same tables lie between 0.06 and 0.18.
const LIFT_COEFFICIENT: [f64; 2] = [0.04, 0.25];
/// Mass of a propeller of 10 inches (0.254 m), kg: 8 to 15 g; others by the cube of their diameter.
const PROPELLER_10_INCH_KG: f64 = 0.011;
/// Inertia over that of a slender rod of this mass: 0.4 for heavy hubs, 2 for heavy propellers.
const INERTIA_RATIO: [f64; 2] = [0.3, 2.5];
/// Full lift over weight: below 1.3 nothing is left to steer with; racers reach 10 and more.
const LIFT_OVER_WEIGHT: [f64; 2] = [1.3, 15.0];
/// Rated speed constants are good to a tenth; the line's slope over the rated one.
const KV_RATIO: [f64; 2] = [0.85, 1.15];
/// Speed constant's offset as a share of the voltage range: brushes stick, brushless motors hardly do.
const OFFSET_SHARE_MAX: f64 = 0.05;
/// The motor's lag at half command, s: 5 inch racers 10 ms, 15 inch lifters 150 ms.
const LAG_S: [f64; 2] = [0.008, 0.3];

/// All checks of a propulsion.
pub fn checks(device: &DevicePropulsion, given: &Given, gravity_m_s2: f64) -> Vec<Check> {
    let full_v = device.voltage_v(1.0);
    let (full_rad_s, full_a) = device.equilibrium(full_v);
    vec![
        reaction_against_drag(device),
        lift_against_momentum_theory(device, given.diameter_m),
        lift_against_size(device, given.diameter_m),
        inertia_against_size(device, given.diameter_m),
        lag_of_motor(device),
        hover_against_mass(device.lift_n(full_rad_s), given.mass_kg, gravity_m_s2),
        power_balance(device, full_rad_s, full_v * full_a),
        voltage_against_supply(device, given.supply_v),
        idle_voltage(device),
        slope_against_rating(device, given.kv_rpm_v),
        offset_of_motor(device, full_v),
    ]
}

fn within(name: &'static str, value: f64, [low, high]: [f64; 2], says: String) -> Check {
    let found = if (low..=high).contains(&value) { Found::Plausible } else { Found::Impossible };
    Check { name, found, says: format!("{says}: expected {low} to {high}") }
}

fn unchecked(name: &'static str, needs: &str) -> Check {
    Check { name, found: Found::NotChecked, says: format!("needs {needs}") }
}

fn reaction_against_drag(device: &DevicePropulsion) -> Check {
    let (reaction, drag) = (device.reaction_torque_nm_s2, device.drag_nm_s2);
    let says = format!(
        "what turns the frame ({reaction:.3e} N m s^2) and what brakes the motor ({drag:.3e}) are one torque: \
         their ratio is {:.2}",
        reaction / drag
    );
    within("reaction torque against drag torque", reaction / drag, TORQUE_RATIO, says)
}

/// Ideal power of a hovering rotor `T^1.5 / sqrt(2 rho A)`, over torque times speed: both go with the speed's cube.
fn lift_against_momentum_theory(device: &DevicePropulsion, diameter_m: Option<f64>) -> Check {
    let name = "lift against momentum theory";
    let Some(diameter_m) = diameter_m else { return unchecked(name, "the propeller's diameter") };
    let area_m2 = core::f64::consts::FRAC_PI_4 * diameter_m * diameter_m;
    let ideal = device.lift_n_s2 * device.lift_n_s2.sqrt() / (2.0 * AIR_KG_M3 * area_m2).sqrt();
    let merits = [ideal / device.reaction_torque_nm_s2, ideal / device.drag_nm_s2];
    let says = format!(
        "ideal over actual power is {:.2} by the reaction torque and {:.2} by the drag torque",
        merits[0], merits[1]
    );
    let worst = if merits[0] > FIGURE_OF_MERIT[1] || merits[1] > FIGURE_OF_MERIT[1] {
        merits[0].max(merits[1])
    } else {
        merits[0].min(merits[1])
    };
    within(name, worst, FIGURE_OF_MERIT, says)
}

fn lift_against_size(device: &DevicePropulsion, diameter_m: Option<f64>) -> Check {
    let name = "lift against propeller size";
    let Some(diameter_m) = diameter_m else { return unchecked(name, "the propeller's diameter") };
    let per_turn = core::f64::consts::TAU * core::f64::consts::TAU;
    let coefficient = device.lift_n_s2 * per_turn / (AIR_KG_M3 * diameter_m.powi(4));
    let says = format!("lift over rho n^2 D^4 is {coefficient:.4} with {diameter_m} m");
    within(name, coefficient, LIFT_COEFFICIENT, says)
}

fn inertia_against_size(device: &DevicePropulsion, diameter_m: Option<f64>) -> Check {
    let name = "rotor inertia against propeller size";
    let Some(diameter_m) = diameter_m else { return unchecked(name, "the propeller's diameter") };
    let mass_kg = PROPELLER_10_INCH_KG * (diameter_m / 0.254).powi(3);
    let rod_kg_m2 = mass_kg * diameter_m * diameter_m / 12.0;
    let ratio = device.rotor_inertia_kg_m2 / rod_kg_m2;
    let says = format!(
        "{:.2e} kg m^2 is {ratio:.2} of a rod's of {diameter_m} m and {:.1} g ({rod_kg_m2:.2e})",
        device.rotor_inertia_kg_m2,
        1e3 * mass_kg
    );
    within(name, ratio, INERTIA_RATIO, says)
}

fn lag_of_motor(device: &DevicePropulsion) -> Check {
    let (speed, _) = device.equilibrium(device.voltage_v(0.5));
    let lag_s = device.lag_s(speed);
    within("lag of the motor", lag_s, LAG_S, format!("the motor would follow a command at half range in {lag_s:.3} s"))
}

fn hover_against_mass(full_lift_n: f64, mass_kg: Option<f64>, gravity_m_s2: f64) -> Check {
    let name = "hover thrust against mass";
    let Some(mass_kg) = mass_kg else { return unchecked(name, "the vehicle's mass") };
    let ratio = 4.0 * full_lift_n / (mass_kg * gravity_m_s2);
    let says = format!("full lift {:.2} N is {ratio:.2} of the weight of {mass_kg} kg", 4.0 * full_lift_n);
    within(name, ratio, LIFT_OVER_WEIGHT, says)
}

/// What turns the air comes from the supply.
fn power_balance(device: &DevicePropulsion, speed_rad_s: f64, electric_w: f64) -> Check {
    let shaft_w = device.reaction_torque_nm_s2 * speed_rad_s.powi(3);
    let says = format!("at full command the propeller takes {shaft_w:.1} W of {electric_w:.1} W put into the motor");
    let found = if shaft_w <= electric_w { Found::Plausible } else { Found::Impossible };
    Check { name: "power of propeller against motor", found, says: format!("{says}: expected less") }
}

fn voltage_against_supply(device: &DevicePropulsion, supply_v: Option<f64>) -> Check {
    let name = "motor voltage against supply";
    let Some(supply_v) = supply_v else { return unchecked(name, "the supply's voltage") };
    let full_v = device.voltage_v(1.0);
    let found = if full_v <= supply_v * 1.02 { Found::Plausible } else { Found::Impossible };
    Check { name, found, says: format!("full command gives {full_v:.2} V: expected at most the supply's {supply_v} V") }
}

fn idle_voltage(device: &DevicePropulsion) -> Check {
    let (idle_v, full_v) = (device.voltage_v(0.0), device.voltage_v(1.0));
    let found = if idle_v.abs() <= 0.1 * full_v { Found::Plausible } else { Found::Impossible };
    let says = format!("no command gives {idle_v:.2} V: expected none, within a tenth of {full_v:.2} V");
    Check { name: "voltage at no command", found, says }
}

fn slope_against_rating(device: &DevicePropulsion, kv_rpm_v: Option<f64>) -> Check {
    let name = "speed constant against rating";
    let Some(kv) = kv_rpm_v else { return unchecked(name, "the motor's rated rpm/V") };
    let measured = device.speed_constant_rad_s_v * 30.0 / core::f64::consts::PI;
    let says = format!("{measured:.0} rpm/V is {:.2} of the rated {kv}", measured / kv);
    within(name, measured / kv, KV_RATIO, says)
}

fn offset_of_motor(device: &DevicePropulsion, full_v: f64) -> Check {
    let dead_v = -device.speed_offset_rad_s / device.speed_constant_rad_s_v;
    let found = if dead_v.abs() <= OFFSET_SHARE_MAX * full_v { Found::Plausible } else { Found::Impossible };
    let says = format!(
        "its line reaches no speed at {dead_v:.2} V: expected 0, within {OFFSET_SHARE_MAX} of {full_v:.2} V; a motor \
         without load stands still at 0 V, the drop over its resistance may be in the line"
    );
    Check { name: "offset of the motor's line", found, says }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Rig, VehicleModel};
    use crate::vehicle::propulsion::Propulsion;

    fn impossible(rig: Rig, given: &Given) -> Vec<&'static str> {
        let Propulsion::Device(device) = VehicleModel::nominal(rig).propulsion else { panic!("a device") };
        let checks = checks(&device, given, 9.81);
        checks.iter().filter(|check| check.found == Found::Impossible).map(|check| check.name).collect()
    }

    /// An F450 with propellers of 10 inches, motors of 920 rpm/V and three cells at their fullest (docs/rig.md); the
    /// thesis gives no mass, published ones are from 1.0 kg on.
    const F450: Given =
        Given { diameter_m: Some(0.254), mass_kg: Some(1.0), kv_rpm_v: Some(920.0), supply_v: Some(12.6) };

    #[test]
    fn the_thesis_values_fail_by_name() {
        assert_eq!(
            impossible(Rig::Gimbal, &F450),
            [
                "reaction torque against drag torque",
                "lift against momentum theory",
                "lift against propeller size",
                "rotor inertia against propeller size",
                "lag of the motor",
                "hover thrust against mass",
                "power of propeller against motor",
                "motor voltage against supply",
                "voltage at no command",
                "speed constant against rating",
                "offset of the motor's line",
            ]
        );
    }

    #[test]
    fn a_real_vehicles_values_pass() {
        assert_eq!(impossible(Rig::Free, &Given { mass_kg: Some(1.2), ..F450 }), [] as [&str; 0]);
    }

    #[test]
    fn what_is_not_given_is_not_checked() {
        let Propulsion::Device(device) = VehicleModel::nominal(Rig::Free).propulsion else { panic!("a device") };
        let checks = checks(&device, &Given::default(), 9.81);
        let not_checked = checks.iter().filter(|check| check.found == Found::NotChecked).count();
        assert_eq!(not_checked, 6);
    }
}
