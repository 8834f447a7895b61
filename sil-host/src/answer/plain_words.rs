//! Quantities, sizes and findings in the words of a person who flies: "pitch rate" for `q`, 8 ms for 0.008 s.

use crate::diagnosis::{Estimate, Finding, motor_place, per_unit_inertia};
use crate::effects::{CatalogueEntry, Effect, Parameter};
use crate::log::GRAVITY_M_S2;
use crate::statistics::decimals;

/// Between a number and its unit, so that no line ends there.
const NO_BREAK: char = '\u{a0}';

/// The lever that such a mass is given at, m.
const LEVER_M: f64 = 0.1;

/// What a channel or its derivative is called.
pub fn quantity(name: &str) -> &str {
    match name {
        "roll" => "roll angle",
        "pitch" => "pitch angle",
        "yaw" => "yaw angle",
        "p" => "roll rate",
        "q" => "pitch rate",
        "r" => "yaw rate",
        "p_dot" => "roll acceleration",
        "q_dot" => "pitch acceleration",
        "r_dot" => "yaw acceleration",
        "ax" => "acceleration forward",
        "ay" => "acceleration to the right",
        "az" => "acceleration down",
        "vn" => "velocity north",
        "ve" => "velocity east",
        "vd" => "velocity down",
        other => other,
    }
}

/// The axis of a quantity of turning.
pub fn axis_of(name: &str) -> Option<&'static str> {
    match name {
        "roll" | "p" | "p_dot" => Some("roll"),
        "pitch" | "q" | "q_dot" => Some("pitch"),
        "yaw" | "r" | "r_dot" => Some("yaw"),
        _ => None,
    }
}

/// A unit as it is written.
pub fn unit(unit: &str) -> String {
    unit.replace("s2", "s²").replace("^2", "²")
}

/// A number with two significant digits, or all that stand before the point.
pub fn rough(value: f64) -> String {
    let decimals = |value| decimals(value, 2, 9);
    // 9.96 becomes 10, which has one digit less behind the point
    let rounded = format!("{value:.*}", decimals(value)).parse().unwrap_or(value);
    format!("{value:.*}", decimals(rounded)).replace('-', "\u{2212}")
}

/// Decimals with which a number of a table has three significant digits, or all that stand before the point.
pub fn table_decimals(value: f64) -> usize {
    decimals(value, 3, 9)
}

/// A number with two significant digits and its unit.
pub fn with_unit(value: f64, unit: &str) -> String {
    let unit = unit.replace(' ', "\u{a0}");
    format!("{}{NO_BREAK}{unit}", rough(value)).trim_end().to_owned()
}

/// A parameter in the unit that people use for it.
#[derive(Clone, Copy)]
pub struct Size {
    estimate: Estimate,
    unit: &'static str,
}

impl Size {
    /// Of a parameter by its name in docs/effects.md.
    pub fn new(name: &str, estimate: Estimate) -> Self {
        let degrees = 1f64.to_degrees();
        let (nominal, factor, unit) = match name {
            "scale" => (1.0, 100.0, "%"),
            "delay_s" | "time_constant_s" => (0.0, 1e3, "ms"),
            "per_s" => (0.0, 100.0, "% a second"),
            "per_volt" => (0.0, 100.0, "% a volt"),
            "stiffness_nm_rad" => (0.0, 1.0, "N m/rad"),
            "stiffness_1_s2" => (0.0, 1.0, "1/s²"),
            "coefficient_nms" => (0.0, 1.0, "N m s"),
            "coefficient_1_s" => (0.0, 1.0, "1/s"),
            "inertia_kg_m2" | "product_kg_m2" => (0.0, 1.0, "kg m²"),
            "drag_area_m2" => (0.0, 1.0, "m²"),
            "frequency_hz" => (0.0, 1.0, "Hz"),
            _ if name.ends_with("_rad_s2") => (0.0, degrees, "deg/s²"),
            _ if name.ends_with("_rad_s") => (0.0, degrees, "deg/s"),
            _ if name.ends_with("_rad") => (0.0, degrees, "deg"),
            _ if name.ends_with("_nm") => (0.0, 1.0, "N m"),
            _ if name.ends_with("_m_s") => (0.0, 1.0, "m/s"),
            _ if name.ends_with("_m") => (0.0, 1.0, "m"),
            _ if name.ends_with("_s") => (0.0, 1.0, "s"),
            _ => (0.0, 1.0, ""),
        };
        let estimate = Estimate { value: factor * (estimate.value - nominal), std: factor * estimate.std };
        Self { estimate, unit }
    }

    /// "170 ± 12 ms", with the digits that its uncertainty leaves.
    pub fn exact(self) -> String {
        let Estimate { value, std } = self.estimate;
        let number = |value: f64| match self.estimate.decimals() {
            Some(digits) if value.abs().max(std) >= 1e-5 => format!("{value:.digits$}"),
            Some(_) => format!("{value:.1e}"),
            None => rough(value),
        };
        let spread = if std > 0.0 { format!(" ± {}", number(std)) } else { String::new() };
        let text = format!("{}{spread} {}", number(value), self.unit);
        text.trim_end().replace('-', "\u{2212}").replace(' ', "\u{a0}")
    }

    /// "170 ms".
    pub fn rough(self) -> String {
        with_unit(self.estimate.value, self.unit)
    }

    /// The same without its sign.
    fn magnitude(self) -> String {
        let estimate = Estimate { value: self.estimate.value.abs(), ..self.estimate };
        Self { estimate, ..self }.rough()
    }

    fn is_negative(self) -> bool {
        self.estimate.value < 0.0
    }

    /// One of two words by its sign.
    fn either(self, positive: &'static str, negative: &'static str) -> &'static str {
        if self.is_negative() { negative } else { positive }
    }
}

/// What the catalogue says of an effect; the controller's part is not in it.
fn entry_of(effect: &str) -> Option<&'static CatalogueEntry> {
    Effect::CATALOGUE.iter().find(|entry| entry.name == effect)
}

/// The parameter that says how large a finding is.
pub fn main_parameter(finding: &Finding) -> Option<(&'static str, Size)> {
    let sizes = || finding.parameters.iter().map(|(name, estimate)| (*name, *estimate));
    // both parts of a moment of gravity have one unit: the larger says what it is
    let largest_moment = sizes()
        .filter(|(name, _)| name.contains("_moment_"))
        .max_by(|a, b| a.1.value.abs().total_cmp(&b.1.value.abs()));
    let entry = entry_of(finding.effect);
    let first = entry.into_iter().flat_map(|entry| entry.parameters);
    let first = first.filter_map(|parameter| sizes().find(|(name, _)| is_named(parameter, name))).next();
    let any = || sizes().find(|(name, estimate)| *name != "motor" && estimate.std > 0.0);
    largest_moment.or(first).or_else(any).map(|(name, estimate)| (name, Size::new(name, estimate)))
}

/// Is this a name of the parameter, on a vehicle or on separate axes?
fn is_named(parameter: &Parameter, name: &str) -> bool {
    parameter.name == name || per_unit_inertia(parameter.name) == name
}

/// What a parameter of an effect is.
pub fn parameter(effect: &str, name: &'static str) -> &'static str {
    let entry = entry_of(effect);
    let parameters = entry.map_or(&[][..], |entry| entry.parameters);
    match parameters.iter().find(|parameter| is_named(parameter, name)) {
        // shown as the difference from the nominal value
        Some(parameter) if name == "scale" => match parameter.meaning {
            "true lift over nominal" => "change of lift",
            "true inertia over nominal" => "change of inertia",
            "true mass over nominal" => "change of mass",
            "reported rate over true" => "error of the scale",
            other => other,
        },
        Some(parameter) => parameter.meaning,
        None if name == "motor" => "number of the motor",
        None => "",
    }
}

/// What a finding is, without its size: "the centre of gravity lies off the axis (pitch)".
pub fn cause(finding: &Finding) -> String {
    let entry = entry_of(finding.effect);
    let place = match finding.axis {
        Some(axis) => format!(" ({axis})"),
        None if finding.parameters.contains_key("motor") => format!(" ({})", motor(finding)),
        None => String::new(),
    };
    let statement = entry.map_or_else(|| finding.effect.replace('_', " "), |entry| entry.statement.to_owned());
    capitalised(&format!("{statement}{place}"))
}

/// What was found in a sentence, without its full stop.
pub fn sentence(finding: &Finding) -> String {
    capitalised(&clause(finding))
}

/// What was found in a sentence that says so where it may as well be something else, without its full stop.
pub fn doubted(finding: &Finding) -> String {
    match is_doubtful(finding) {
        true => format!("It may be that {}", clause(finding)),
        false => sentence(finding),
    }
}

/// True where something else may be in its place.
pub fn is_doubtful(finding: &Finding) -> bool {
    finding.one_of.len() > 1 || !finding.confounded_with.is_empty()
}

/// What was found, as a part of a sentence.
fn clause(finding: &Finding) -> String {
    let axis = finding.axis.unwrap_or("the vehicle");
    let Some((name, size)) = main_parameter(finding).filter(|_| finding.controller_parameter.is_none()) else {
        return finding.statement.trim_end_matches('.').to_owned();
    };
    let (rough, magnitude) = (size.rough(), size.magnitude());
    match finding.effect {
        "cg_offset" if name.starts_with("cos") => {
            format!("{axis} is out of balance by {magnitude}{}", as_mass(name, size))
        }
        "cg_offset" => format!(
            "the centre of gravity lies {} the {axis} axis: {magnitude} when turned by 90 degrees{}",
            size.either("below", "above"),
            as_mass(name, size)
        ),
        "torque_bias" => format!("a constant moment of {rough} acts on {axis}"),
        "viscous_friction" => format!("friction in proportion to the rate acts on {axis}: {rough}"),
        "coulomb_friction" => format!("dry friction of {rough} brakes {axis}"),
        "spring" => format!("a spring of {rough} pulls {axis} towards an angle"),
        "inertia_error" => {
            format!("the inertia of {axis} is {magnitude} {} than the model's", size.either("larger", "smaller"))
        }
        "thrust_scale" => format!("the motors lift {magnitude} {} than the model's", size.either("more", "less")),
        "weak_motor" => {
            format!("{} lifts {magnitude} {} than the others", motor(finding), size.either("more", "less"))
        }
        "mass_error" => {
            format!("the vehicle is {magnitude} {} than the model", size.either("heavier", "lighter"))
        }
        "motor_lag" => format!("the motors follow with {rough} more lag than the model's"),
        "actuation_delay" => format!("commands act {rough} later than in the model"),
        "attitude_delay" => format!("the attitude is reported {rough} late"),
        "gyro_bias" => format!("the gyro reports {rough} of {axis} at rest"),
        "gyro_scale" => {
            format!("the gyro reports {axis} {magnitude} too {}", size.either("fast", "slow"))
        }
        "battery_sag" => format!("thrust falls by {rough}"),
        "imu_misalignment" => format!("the IMU is turned about the vertical axis by {rough}"),
        _ => {
            let place = finding.axis.map(|axis| format!(" ({axis})")).unwrap_or_default();
            format!("{}{place}: {rough}", entry_of(finding.effect).map_or(finding.effect, |entry| entry.statement))
        }
    }
}

/// A moment as the mass that makes it on a lever; nothing for a moment per unit of inertia.
fn as_mass(name: &str, size: Size) -> String {
    if !name.ends_with("_nm") {
        return String::new();
    }
    let grams = 1e3 * size.estimate.value.abs() / (GRAVITY_M_S2 * LEVER_M);
    format!(", as {} would at {}", with_unit(grams, "g"), with_unit(100.0 * LEVER_M, "cm"))
}

fn motor(finding: &Finding) -> String {
    let number = finding.parameters.get("motor").map_or(0, |motor| motor.value as usize);
    match number.checked_sub(1).filter(|index| *index < 4).map(motor_place) {
        Some(place) => format!("motor {number} ({place})"),
        None => "one motor".to_owned(),
    }
}

/// A statement of the terminal as a page shows it: its first letter a capital, ± for +-.
pub fn on_a_page(statement: &str) -> String {
    capitalised(&statement.replace(" +- ", " ± "))
}

/// A text with a capital first letter.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Origin;

    fn finding(effect: &'static str, axis: Option<&'static str>, parameters: &[(&'static str, f64, f64)]) -> Finding {
        let estimates = parameters.iter().map(|&(name, value, std)| (name, Estimate { value, std }));
        Finding {
            effect,
            axis,
            origin: Origin::Plant,
            controller_parameter: None,
            parameters: estimates.collect(),
            gain_pct: 90.0,
            confounded_with: Vec::new(),
            stability_pct: None,
            one_of: Vec::new(),
            statement: "as it is.".to_owned(),
            extension: None,
        }
    }

    #[test]
    fn findings_are_said_in_units_that_people_use() {
        let said = |effect, axis, parameters: &[_]| sentence(&finding(effect, axis, parameters)).replace(NO_BREAK, " ");
        let moment = [("cos_moment_nm", -0.166928, 9e-5), ("sin_moment_nm", 0.002, 1e-4)];
        // 0.166928 N m / (9.80665 m/s^2 * 0.1 m) = 0.1702 kg
        assert_eq!(
            said("cg_offset", Some("pitch"), &moment),
            "Pitch is out of balance by 0.17 N m, as 170 g would at 10 cm"
        );
        assert_eq!(
            said("cg_offset", Some("roll"), &[("sin_moment_rad_s2", 2.4, 1.0)]),
            "The centre of gravity lies below the roll axis: 138 deg/s² when turned by 90 degrees"
        );
        // on separate axes numbers have other names, and mean the same
        let friction = finding("coulomb_friction", Some("pitch"), &[("torque_rad_s2", 1.33, 0.22)]);
        let (name, _) = main_parameter(&friction).unwrap();
        assert_eq!(parameter("coulomb_friction", name), parameter("coulomb_friction", "torque_nm"));
        let weak = [("motor", 3.0, 0.0), ("scale", 0.9, 0.004)];
        assert_eq!(said("weak_motor", None, &weak), "Motor 3 (front left) lifts 10 % less than the others");
        assert_eq!(
            said("actuation_delay", None, &[("delay_s", 0.0123, 1e-4)]),
            "Commands act 12 ms later than in the model"
        );
        assert_eq!(said("nobody_knows", None, &[]), "As it is");
    }

    #[test]
    fn what_may_as_well_be_something_else_is_not_said_as_a_fact() {
        let certain = finding("actuation_delay", None, &[("delay_s", 0.0123, 1e-4)]);
        let one_of = vec!["actuation_delay".to_owned(), "nothing".to_owned()];
        let of_several = Finding { one_of, ..certain.clone() };
        let confounded = Finding { confounded_with: vec!["motor_lag".to_owned()], ..certain.clone() };
        let said = [&certain, &of_several, &confounded].map(|of| doubted(of).replace(NO_BREAK, " "));
        let doubt = "It may be that commands act 12 ms later than in the model";
        assert_eq!(said, ["Commands act 12 ms later than in the model", doubt, doubt]);
    }

    #[test]
    fn every_effect_of_the_catalogue_is_said_with_a_size() {
        for entry in Effect::CATALOGUE {
            let parameters: Vec<_> = entry.parameters.iter().map(|parameter| (parameter.name, 1.5, 0.1)).collect();
            let said = sentence(&finding(entry.name, Some("roll"), &parameters));
            assert!(!said.contains('_') && said.chars().any(|c| c.is_ascii_digit()), "{}: {said}", entry.name);
        }
    }

    #[test]
    fn numbers_have_the_digits_that_mean_something() {
        let texts = [0.166928, 79.47, 9.96, 0.000123, 1234.4, -0.05, 0.0].map(rough);
        assert_eq!(texts, ["0.17", "79", "10", "0.00012", "1234", "\u{2212}0.050", "0"]);
        let size = |name, value, std| Size::new(name, Estimate { value, std }).exact().replace(NO_BREAK, " ");
        assert_eq!(size("delay_s", 0.012345, 0.00012), "12.35 ± 0.12 ms");
        assert_eq!(size("scale", 0.9, 0.0041), "\u{2212}10.00 ± 0.41 %");
    }
}
