//! What the thesis prints: its constants beside those of the model that this project flies.

use serde::Serialize;

use crate::model::{Mounting, Rig, VehicleModel};
use crate::vehicle::propulsion::{DevicePropulsion, Esc, Propulsion};

/// A constant of the thesis beside ours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PrintedConstant {
    /// The table.
    pub table: &'static str,
    /// As the thesis calls it.
    pub symbol: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// SI, with the rad that the thesis leaves out.
    pub unit: &'static str,
    /// As printed.
    pub printed: f64,
    /// Of the testbed's model (`models/f450-gimbal.toml`).
    pub testbed: f64,
    /// Of the F450 as people fly it (`models/f450-free.toml`); none where that has no such constant.
    pub free_flight: Option<f64>,
}

/// Mean deviation of roll and pitch, simulated against measured, degrees (table 5.1).
pub const TABLE_5_1_MPC_DEG: [f64; 2] = [1.84, 8.08];
/// The same of the PID cascade.
pub const TABLE_5_1_PID_DEG: [f64; 2] = [2.26, 5.80];

/// Tables 3.3 and C.1 to C.3, which repeat each other, and 3.4.
pub fn constants() -> Vec<PrintedConstant> {
    let (testbed, free) = (VehicleModel::nominal(Rig::Gimbal), VehicleModel::nominal(Rig::Free));
    let mut constants = Vec::new();
    if let (Some(testbed), Some(free)) = (device(&testbed), device(&free)) {
        constants.extend(of_esc(testbed, free));
        constants.extend(of_motor_and_rotor(testbed, free));
    }
    constants.extend(of_inertia(&testbed, &free));
    constants
}

/// The electro-mechanical propulsion of a vehicle that has one.
pub fn device(model: &VehicleModel) -> Option<&DevicePropulsion> {
    match &model.propulsion {
        Propulsion::Device(device) => Some(device),
        Propulsion::Box(_) | Propulsion::Generic(_) => None,
    }
}

fn of_esc(testbed: &DevicePropulsion, free: &DevicePropulsion) -> Vec<PrintedConstant> {
    let numbers = |device: &DevicePropulsion| match device.esc {
        Esc::Exponential { gain1_v, rate1, gain2_v, rate2 } => Some([gain1_v, rate1, gain2_v, rate2]),
        Esc::Duty { .. } | Esc::Table(_) => None,
    };
    let Some(ours) = numbers(testbed) else { return Vec::new() };
    let free = numbers(free);
    let rows = [("A_esc", "V", 16.45), ("B_esc", "1", 0.001704), ("C_esc", "V", -12.95), ("D_esc", "1", -0.04282)];
    let of_row = |(index, (symbol, unit, printed)): (usize, (&'static str, &'static str, f64))| PrintedConstant {
        table: "C.1",
        symbol,
        meaning: "speed controller, set-point 0 to 100 to voltage",
        unit,
        printed,
        testbed: ours[index],
        free_flight: free.map(|numbers| numbers[index]),
    };
    rows.into_iter().enumerate().map(of_row).collect()
}

fn of_motor_and_rotor(testbed: &DevicePropulsion, free: &DevicePropulsion) -> Vec<PrintedConstant> {
    type Of = fn(&DevicePropulsion) -> f64;
    let rows: [(&str, &str, &str, &str, f64, Of); 10] = [
        ("C.2", "R_m", "motor resistance", "ohm", 0.127, |of| of.resistance_ohm),
        ("C.2", "L_m", "motor inductance", "H", 1.6968e-4, |of| of.inductance_h),
        ("C.2", "I_m", "inertia of the motor's rotor", "kg m^2", 3.38e-7, |of| of.motor_inertia_kg_m2),
        ("C.2", "M_lo", "motor loss", "N m s/rad", 4.4528e-6, |of| of.loss_nm_s),
        ("C.2", "A_m", "motor speed over voltage", "rad/s/V", 70.930, |of| of.speed_constant_rad_s_v),
        ("C.2", "B_m", "offset of that line", "rad/s", -213.76, |of| of.speed_offset_rad_s),
        ("C.3", "R_l", "lift", "N s^2/rad^2", 1.5064e-6, |of| of.lift_n_s2),
        ("C.3", "R_t", "reaction torque", "N m s^2/rad^2", 5.6977e-8, |of| of.reaction_torque_nm_s2),
        ("C.3", "R_d", "aerodynamic drag", "N m s^2/rad^2", 2.0066e-8, |of| of.drag_nm_s2),
        ("C.3", "I_r", "inertia of the rotor", "kg m^2", 2.8e-6, |of| of.rotor_inertia_kg_m2),
    ];
    let of_row = |(table, symbol, meaning, unit, printed, of): (_, _, _, _, f64, Of)| PrintedConstant {
        table,
        symbol,
        meaning,
        unit,
        printed,
        testbed: of(testbed),
        free_flight: Some(of(free)),
    };
    rows.into_iter().map(of_row).collect()
}

fn of_inertia(testbed: &VehicleModel, free: &VehicleModel) -> Vec<PrintedConstant> {
    let ring_kg_m2 = match testbed.mounting {
        Mounting::Gimbal { ring_inertia_kg_m2 } => ring_inertia_kg_m2,
        Mounting::Free { .. } => 0.0,
    };
    let [ixx, iyy, _] = testbed.inertia_kg_m2;
    [
        ("I_xx", "inertia about x", 0.0115118, ixx, 0),
        ("I_yy", "about y, with both rings", 0.0365651, iyy + ring_kg_m2, 1),
    ]
    .map(|(symbol, meaning, printed, testbed, axis)| PrintedConstant {
        table: "3.4",
        symbol,
        meaning,
        unit: "kg m^2",
        printed,
        testbed,
        free_flight: Some(free.inertia_kg_m2[axis]),
    })
    .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The testbed's model is the thesis' in every constant that it prints.
    #[test]
    fn the_testbed_has_the_printed_constants() {
        let constants = constants();
        assert_eq!(constants.len(), 16);
        for constant in constants {
            let off = (constant.testbed - constant.printed).abs();
            assert!(off <= 1e-9 * constant.printed.abs(), "{constant:?}");
        }
    }
}
