//! A model at another battery voltage than the one at which it was identified.

use super::VehicleModel;
use crate::effects::Effect;
use crate::vehicle::propulsion::Propulsion;

impl VehicleModel {
    /// The model as it flies at this battery voltage (V), and the voltage it is of; `None` where it does not say one,
    /// as only a model does whose lift is a line of the command.
    pub(crate) fn at_voltage(&self, battery_v: f64) -> Option<(VehicleModel, f64)> {
        let Propulsion::Box(flying_box) = self.propulsion else { return None };
        let (at_voltage, lower) = flying_box.at_voltage(battery_v)?;
        let effects = self.effects.iter().map(|effect| match effect {
            Effect::ThrustCurve(curve) => curve.of_weaker(lower).map(Effect::ThrustCurve),
            other => Some(*other),
        });
        let effects = effects.collect::<Option<Vec<Effect>>>()?;
        let base_command = (self.base_command * lower).min(1.0);
        let model = VehicleModel { propulsion: Propulsion::Box(at_voltage), base_command, effects, ..self.clone() };
        Some((model, battery_v * lower))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::ThrustCurve;
    use crate::model::Rig;

    const BOX: &str = include_str!("../../../models/box-free.toml");

    /// A vehicle that was identified on a battery of 12 V, where it hovers on half of the command.
    fn identified() -> VehicleModel {
        let mut model = VehicleModel::parse(BOX, "box-free.toml").unwrap();
        model.base_command = 0.5;
        let Propulsion::Box(flying_box) = &mut model.propulsion else { panic!("a box") };
        flying_box.battery_v = Some(12.0);
        model
    }

    #[test]
    fn what_command_times_voltage_does_stays() {
        let model = identified();
        let (lower, of_v) = model.at_voltage(10.0).unwrap();
        assert_eq!((of_v, lower.base_command), (12.0, 0.6));
        let lift = |model: &VehicleModel| model.propulsion.lift_n(model.base_command);
        assert!((lift(&lower) - lift(&model)).abs() < 1e-12, "{} {}", lift(&lower), lift(&model));
        // about hover a command does as much less
        let slope = |model: &VehicleModel| model.propulsion.lift_n(0.7) - model.propulsion.lift_n(0.6);
        assert!((slope(&lower) * 12.0 - slope(&model) * 10.0).abs() < 1e-12);
        let (again, _) = lower.at_voltage(12.0).unwrap();
        assert!((again.base_command - 0.5).abs() < 1e-12 && (lift(&again) - lift(&model)).abs() < 1e-12);
        let read = VehicleModel::parse(&lower.to_toml(), "at 10 V").unwrap();
        assert_eq!(read, lower);
    }

    #[test]
    fn a_curve_goes_along() {
        let mut model = identified();
        model.effects.push(ThrustCurve { expo: 0.6, fixed_at: 0.5 }.into());
        let (lower, _) = model.at_voltage(10.0).unwrap();
        let acts = |model: &VehicleModel, command: f64| {
            let Some(Effect::ThrustCurve(ThrustCurve { expo, fixed_at })) = model.effects.first() else { panic!() };
            let line = |command: f64| 1.0 - expo + expo * command;
            model.propulsion.lift_n(command * line(command) / line(*fixed_at))
        };
        for command in [0.2, 0.5, 0.8] {
            let (here, there) = (acts(&model, command), acts(&lower, 1.2 * command));
            assert!((here - there).abs() < 1e-12, "{command}: {here} N, {there} N");
        }
        // a curve that is fixed at the full command can't be told of a weaker one
        let Some(Effect::ThrustCurve(curve)) = model.effects.first_mut() else { panic!() };
        curve.fixed_at = 1.0;
        assert!(model.at_voltage(10.0).is_none());
    }

    #[test]
    fn a_model_that_says_no_voltage_is_of_none() {
        assert!(VehicleModel::parse(BOX, "box-free.toml").unwrap().at_voltage(10.0).is_none());
        assert!(VehicleModel::nominal(Rig::Free).at_voltage(10.0).is_none());
    }
}
