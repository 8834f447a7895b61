//! A vehicle model as the parameters of a board: the file that ground stations load.

use shared_control::params::table::Field;
use shared_control::params::vehicle::{FlownVehicle, VehicleFault, VehicleNumbers};
use shared_control::params::{Params, Rig};

use crate::control_setup::vehicle_parameters;
use crate::effects::Effect;
use crate::model::{Mounting, VehicleModel};

/// Small step of the command about hover, for the slope of the rotors' speed.
const COMMAND_STEP: f32 = 0.01;
/// Effects whose sizes are in `VEH_...`.
const WITH_PARAMETERS: [&str; 5] = ["inertia_error", "mass_error", "thrust_scale", "motor_lag", "actuation_delay"];

/// Effects of a model for which a board has no parameter, each once: it flies the vehicle without them.
pub fn without_parameters(vehicle_model: &VehicleModel) -> Vec<&'static str> {
    let mut names: Vec<&str> = vehicle_model.effects.iter().map(Effect::name).collect();
    names.retain(|name| !WITH_PARAMETERS.contains(name));
    names.sort_unstable();
    names.dedup();
    names
}

/// The parameters that make a board fly this vehicle: all of `VEH_...`, `VEHICLE`, `RIG` and, free, `HOVER_PERMILLE`.
/// What the model's effects make of its inertia, mass, lift, lag and delay is in them.
///
/// # Errors
/// What a board would say against it, or which number it has no room for.
pub fn board_parameters(vehicle_model: &VehicleModel) -> Result<Vec<(&'static str, u16)>, String> {
    let vehicle = vehicle_parameters(vehicle_model);
    let curve = &vehicle.lift_curve;
    let (rig, mass_kg) = match vehicle_model.mounting {
        Mounting::Free { mass_kg } => (Rig::Free, (vehicle_model.changes().body.mass_scale * mass_kg) as f32),
        Mounting::Gimbal { .. } => (Rig::Gimbal, f32::from(VehicleNumbers::DEFAULT.mass_g) / 1000.0),
    };
    let hover = match rig {
        Rig::Free => curve.command(mass_kg * vehicle.gravity_m_s2 / 4.0),
        Rig::Gimbal => vehicle_model.base_command as f32,
    };
    // the straight line of speeds that touches the model's curve where it hovers
    let root = |command: f32| curve.lift(command).sqrt();
    let slope = (root(hover + COMMAND_STEP) - root(hover - COMMAND_STEP)) / (2.0 * COMMAND_STEP);
    let slowest = (root(hover) - slope * hover).max(0.0);
    let fastest = slowest + (root(hover) - slowest) / hover;
    let [roll, pitch, yaw] = vehicle.inertia_kg_m2;
    let numbers = VehicleNumbers {
        flown: FlownVehicle::Own,
        mass_g: whole("mass_kg", mass_kg, 1e3)?,
        arm_mm: whole("arm_m", vehicle.arm_m, 1e3)?,
        inertia_e5_kg_m2: [
            whole("ixx_kg_m2", roll, 1e5)?,
            whole("iyy_kg_m2", pitch - vehicle.ring_inertia_kg_m2, 1e5)?,
            whole("izz_kg_m2", yaw, 1e5)?,
        ],
        ring_e5_kg_m2: whole("ring inertia", vehicle.ring_inertia_kg_m2, 1e5)?,
        torque_per_lift_um: whole("reaction torque per lift", vehicle.torque_per_lift_m, 1e6)?,
        lift_min_mn: whole("lift at no command", slowest * slowest, 1e3)?,
        lift_max_mn: whole("lift at full command", fastest * fastest, 1e3)?,
        lag_e4_s: whole("lag of the motors", vehicle.actuation.lag_s, 1e4)?,
        delay_e4_s: whole("delay of the actuation", vehicle.actuation.delay_s, 1e4)?,
    };
    let hover_throttle_permille = whole("hovering command", hover, 1e3)?;
    let params = Params { rig, vehicle: numbers, hover_throttle_permille, ..Params::DEFAULT };
    let of_vehicle = |field: &Field| matches!(field, Field::Vehicle(_) | Field::Rig | Field::HoverThrottle);
    let fields: Vec<Field> = Field::ALL.into_iter().filter(of_vehicle).collect();
    for field in &fields {
        let row = field.row();
        if !row.allowed.contains(params.get(*field)) {
            return Err(format!("{}: {}, a board takes {}", row.name, params.get(*field), row.allowed));
        }
    }
    numbers.vehicle(rig, hover).map_err(|fault: VehicleFault| fault.to_string())?;
    Ok(fields.into_iter().map(|field| (field.row().name, params.get(field))).collect())
}

/// To the nearest whole unit of a parameter.
fn whole(what: &str, value: f32, units: f32) -> Result<u16, String> {
    let number = (value * units).round();
    if number >= 0.0 && number <= f32::from(u16::MAX) {
        Ok(number as u16)
    } else {
        Err(format!("{what}: {value} is beyond a board's parameter"))
    }
}

/// As `QGroundControl` saves and loads parameters: tool, component, name, value, and 9 for `REAL32`.
pub fn params_file<Value: std::fmt::Display>(name: &str, parameters: &[(&'static str, Value)]) -> String {
    let mut text = format!("# {name}\n# Vehicle-Id\tComponent-Id\tName\tValue\tType\n");
    for (name, value) in parameters {
        text.push_str(&format!("1\t1\t{name}\t{value}\t9\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model;
    use shared_control::setup::Setup;

    /// From the model file to what flies on a board: the same vehicle, to what a whole number rounds and, about hover,
    /// to what a straight line of speeds leaves of its lift.
    #[test]
    fn a_board_with_these_parameters_flies_the_model() {
        for rig in [model::Rig::Free, model::Rig::Gimbal] {
            let vehicle_model = VehicleModel::nominal(rig);
            let mut params = Params::DEFAULT;
            for (name, value) in board_parameters(&vehicle_model).unwrap() {
                params = params.with(Field::by_name(name.as_bytes()).unwrap(), value).unwrap();
            }
            let setup = Setup::new(&params).unwrap();
            assert_eq!(setup.vehicle_fault, None);
            let (found, known) = (setup.vehicle, vehicle_parameters(&vehicle_model));
            let near = |found: f32, known: f32, within: f32| (found - known).abs() <= within * known.abs();
            assert!(
                near(found.arm_m, known.arm_m, 5e-3) && near(found.torque_per_lift_m, known.torque_per_lift_m, 1e-3)
            );
            assert!((0..3).all(|axis| near(found.inertia_kg_m2[axis], known.inertia_kg_m2[axis], 1e-3)), "{found:?}");
            // half a unit of 0.1 ms beside the gimbal's 2 ms
            assert!(near(found.actuation.lag_s, known.actuation.lag_s, 0.03), "{:?}", found.actuation);
            let hover = vehicle_model.base_command as f32;
            for command in [0.9 * hover, hover, 1.1 * hover] {
                let (found, known) = (found.lift_curve.lift(command), known.lift_curve.lift(command));
                assert!(near(found, known, 0.03), "{rig:?} at {command}: {found} {known}");
            }
        }
    }

    /// As a diagnosis extends a model: the numbers are those of the vehicle with its effects.
    #[test]
    fn effects_are_in_the_numbers_and_what_has_no_parameter_is_named() {
        let number = |model: &VehicleModel, name: &str| {
            let found = board_parameters(model).unwrap().into_iter().find(|(known, _)| *known == name);
            f64::from(found.unwrap().1)
        };
        for rig in [model::Rig::Free, model::Rig::Gimbal] {
            let nominal = VehicleModel::nominal(rig);
            let mut extended = nominal.clone();
            let mut texts = vec![
                "thrust_scale:scale=1.5",
                "inertia_error:axis=roll,scale=1.2",
                "motor_lag:time_constant_s=0.02",
                "actuation_delay:delay_s=0.01",
                "cg_offset:axis=pitch,cos_moment_nm=0.01",
                "cg_offset:axis=roll,cos_moment_nm=0.01",
            ];
            texts.extend((rig == model::Rig::Free).then_some("mass_error:scale=1.3"));
            let effects = texts.iter().map(|text| Effect::parse_for(text, rig, nominal.inertia_kg_m2).unwrap());
            extended.effects.extend(effects);
            assert_eq!(without_parameters(&extended), ["cg_offset"]);
            let grown = |name: &str| number(&extended, name) - number(&nominal, name);
            // half a unit at either end
            assert!((grown("VEH_LAG_E4") - 200.0).abs() <= 1.0 && (grown("VEH_DELAY_E4") - 100.0).abs() <= 1.0);
            let scale = |name: &str| number(&extended, name) / number(&nominal, name);
            assert!((scale("VEH_IXX_E5") - 1.2).abs() < 1e-3 && (scale("VEH_IYY_E5") - 1.0).abs() < 1e-3);
            match rig {
                model::Rig::Free => assert!((scale("VEH_MASS_G") - 1.3).abs() < 1e-3),
                // of the same command; free, another command hovers, where another line touches the curve
                model::Rig::Gimbal => assert!((scale("VEH_LIFT_MAX_MN") - 1.5).abs() < 1e-3),
            }
        }
    }

    #[test]
    fn what_no_board_flies_is_refused_with_its_reason() {
        let mut heavy = VehicleModel::nominal(model::Rig::Free);
        heavy.mounting = Mounting::Free { mass_kg: 3.5 };
        assert!(board_parameters(&heavy).unwrap_err().contains("does not lift"));
        let mut tiny = VehicleModel::nominal(model::Rig::Free);
        tiny.arm_m = 0.03;
        assert!(board_parameters(&tiny).unwrap_err().contains("VEH_ARM_MM"));
    }

    #[test]
    fn the_file_is_what_ground_stations_load() {
        let text = params_file("F450", &[("VEHICLE", 1), ("VEH_MASS_G", 1200)]);
        assert!(text.ends_with("1\t1\tVEHICLE\t1\t9\n1\t1\tVEH_MASS_G\t1200\t9\n"), "{text}");
    }
}
