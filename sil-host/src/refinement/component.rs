//! The components of the propulsion: what of each is measured, over what, and which forms its curve may have.

use super::bench::Bench;
use super::form::{
    CONSTANT, FASTER_WITH_SPEED, Form, Formula, LINE, POWER, PROPORTIONAL, Points, SATURATING, SQUARE,
    SQUARE_WITH_TARE, TWO_EXPONENTIALS,
};
use super::reading::Reading;
use super::step::Step;

/// A part of the propulsion that a bench shows by one curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// Direct voltage over direct current of the winding at rest.
    Resistance,
    /// Reactance of the winding over the angular frequency.
    Inductance,
    /// Voltage of the motor over the command (thesis C.1).
    SpeedController,
    /// Speed over the voltage behind the winding's resistance (C.2).
    Motor,
    /// Torque of the motor without a propeller, by its current, over the speed (C.3, C.4).
    Loss,
    /// Lift over the speed (C.5).
    Lift,
    /// Torque on the mounting over the speed (C.6).
    ReactionTorque,
    /// What the propeller adds to the motor's torque, by its current, over the speed (C.7).
    Drag,
    /// Time constant of steps that speed the motor up, over the speed halfway.
    LagRising,
    /// The same of steps that slow it down.
    LagFalling,
}

/// What a component is seen in: the steady readings of a file, and its steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    pub(super) steady: Bench,
    pub(super) steps: Vec<Step>,
}

/// Numbers of other components that one needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Upstream {
    pub(super) resistance_ohm: f64,
    pub(super) speed_constant_rad_s_v: f64,
    pub(super) loss_nm_s: f64,
}

impl Component {
    /// All, in an order in which each follows those it needs.
    pub const ALL: [Component; 10] = [
        Self::Resistance,
        Self::Inductance,
        Self::SpeedController,
        Self::Motor,
        Self::Loss,
        Self::Lift,
        Self::ReactionTorque,
        Self::Drag,
        Self::LagRising,
        Self::LagFalling,
    ];

    /// Its name in options and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Resistance => "resistance",
            Self::Inductance => "inductance",
            Self::SpeedController => "esc",
            Self::Motor => "motor",
            Self::Loss => "loss",
            Self::Lift => "lift",
            Self::ReactionTorque => "reaction_torque",
            Self::Drag => "drag",
            Self::LagRising => "lag_rising",
            Self::LagFalling => "lag_falling",
        }
    }

    /// What is drawn to the right and upwards, each with its unit.
    pub fn axes(self) -> [(&'static str, &'static str); 2] {
        let speed = ("speed", "rad/s");
        match self {
            Self::Resistance => [("direct current", "A"), ("voltage", "V")],
            Self::Inductance => [("angular frequency", "rad/s"), ("reactance", "ohm")],
            Self::SpeedController => [("command", ""), ("voltage of the motor", "V")],
            Self::Motor => [("voltage behind the resistance", "V"), speed],
            Self::Loss => [speed, ("torque without propeller", "N m")],
            Self::Lift => [speed, ("lift", "N")],
            Self::ReactionTorque => [speed, ("reaction torque", "N m")],
            Self::Drag => [speed, ("torque of the propeller", "N m")],
            Self::LagRising => [speed, ("time constant, speeding up", "s")],
            Self::LagFalling => [speed, ("time constant, slowing down", "s")],
        }
    }

    /// The forms that are compared; those of a model file, from which its constants come, first.
    pub fn forms(self) -> Vec<Form> {
        let formulas: &[&'static Formula] = match self {
            Self::Resistance | Self::Inductance | Self::Loss => &[&PROPORTIONAL, &LINE],
            Self::SpeedController => &[&PROPORTIONAL, &TWO_EXPONENTIALS, &SATURATING, &LINE],
            Self::Motor => &[&PROPORTIONAL, &LINE],
            Self::Lift | Self::ReactionTorque | Self::Drag => &[&SQUARE, &SQUARE_WITH_TARE, &POWER],
            Self::LagRising | Self::LagFalling => &[&CONSTANT, &FASTER_WITH_SPEED],
        };
        formulas.iter().map(|formula| Form::Formula(formula)).chain([Form::Table]).collect()
    }

    /// Why a form is taken on request alone: model files do not have it, or it leaves out what every scale has, a
    /// tare. To leave that out because one bench does not show it would make the constant's interval too narrow.
    pub fn not_by_itself(self, form: Form) -> Option<&'static str> {
        match form {
            Form::Formula(formula) if self.keys(formula).is_none() => Some("not in model files"),
            Form::Formula(formula) if formula.name == SQUARE.name => Some("without a tare: by --form"),
            Form::Table if !matches!(self, Self::SpeedController | Self::Lift) => Some("not in model files"),
            _ => None,
        }
    }

    /// The names in a model file of a form's parameters, and their units; empty names are of the stand and not of the
    /// component. None where the model has no such form. Lags have names although model files don't.
    pub(super) fn keys(self, formula: &Formula) -> Option<&'static [(&'static str, &'static str)]> {
        let square = |keys: &'static [(&'static str, &'static str)]| match formula.name {
            "square" => Some(&keys[..1]),
            "square with tare" => Some(keys),
            _ => None,
        };
        let through_origin = |keys: &'static [(&'static str, &'static str)]| match formula.name {
            "proportional" => Some(&keys[..1]),
            "affine" => Some(keys),
            _ => None,
        };
        match self {
            Self::Resistance => through_origin(&[("resistance_ohm", "ohm"), ("", "V")]),
            Self::Inductance => through_origin(&[("inductance_h", "H"), ("", "ohm")]),
            Self::Motor => through_origin(&[("speed_constant_rad_s_v", "rad/s/V"), ("speed_offset_rad_s", "rad/s")]),
            Self::Loss => through_origin(&[("loss_nm_s", "N m s"), ("", "N m")]),
            Self::Lift => square(&[("lift_n_s2", "N s^2"), ("", "N")]),
            Self::ReactionTorque => square(&[("reaction_torque_nm_s2", "N m s^2"), ("", "N m")]),
            Self::Drag => square(&[("drag_nm_s2", "N m s^2"), ("", "N m")]),
            Self::LagRising if formula.name == "constant" => Some(&[("lag_rising_s", "s")]),
            Self::LagRising => Some(&[("lag_rising_at_1000_s", "s"), ("lag_rising_k", "")]),
            Self::LagFalling if formula.name == "constant" => Some(&[("lag_falling_s", "s")]),
            Self::LagFalling => Some(&[("lag_falling_at_1000_s", "s"), ("lag_falling_k", "")]),
            Self::SpeedController => match formula.name {
                "proportional" => Some(&[("battery_v", "V")]),
                "exponential" => Some(&[("gain1_v", "V"), ("rate1", ""), ("gain2_v", "V"), ("rate2", "")]),
                "saturating" => Some(&[("gain1_v", "V"), ("gain2_v", "V"), ("rate2", "")]),
                _ => None,
            },
        }
    }

    /// Which components' numbers its points are made with.
    pub(super) fn needs(self) -> &'static [Component] {
        match self {
            Self::Inductance | Self::Motor => &[Self::Resistance],
            Self::Loss => &[Self::Motor],
            Self::Drag => &[Self::Motor, Self::Loss],
            _ => &[],
        }
    }

    /// Its points in a file.
    pub(super) fn points(self, measured: &Measured, upstream: &Upstream) -> Points {
        let is_rising = match self {
            Self::LagRising => true,
            Self::LagFalling => false,
            _ => return self.steady_points(&measured.steady, upstream),
        };
        let steps = measured.steps.iter().filter(|step| step.is_rising() == is_rising);
        let (x, y) = steps.map(|step| (step.middle_rad_s(), step.lag_s)).unzip();
        Points { x, y }
    }

    fn steady_points(self, bench: &Bench, upstream: &Upstream) -> Points {
        let column = |reading| bench.column(reading);
        let (speed, current) = (column(Reading::Speed), column(Reading::Current));
        let (command, volt) = (column(Reading::Command), column(Reading::MotorVoltage));
        let (winding_a, winding_v) = (column(Reading::WindingCurrent), column(Reading::WindingVoltage));
        let (ac_v, ac_a) = (column(Reading::AlternatingVoltage), column(Reading::AlternatingCurrent));
        let (lift, torque) = (column(Reading::Lift), column(Reading::Torque));
        let (hertz, propeller) = (column(Reading::Frequency), column(Reading::Propeller));
        // a stand may count torque the other way
        let way = if torque.iter().filter(|torque| !torque.is_nan()).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        let has_current = current.iter().any(|current| !current.is_nan());
        let row = |row: usize| -> (f64, f64) {
            let turning = if speed[row] > 0.0 { speed[row] } else { f64::NAN };
            let is_bare = propeller[row] == 0.0;
            let with_propeller = if is_bare { f64::NAN } else { turning };
            let torque_nm = current[row] / upstream.speed_constant_rad_s_v;
            match self {
                Self::Resistance => (winding_a[row], winding_v[row]),
                Self::Inductance => {
                    let impedance = ac_v[row] / ac_a[row];
                    let square = impedance * impedance - upstream.resistance_ohm * upstream.resistance_ohm;
                    (core::f64::consts::TAU * hertz[row], square.max(0.0).sqrt())
                }
                Self::SpeedController => (command[row], volt[row]),
                Self::Motor => {
                    let drop_v = if has_current { upstream.resistance_ohm * current[row] } else { 0.0 };
                    (volt[row] - drop_v, turning)
                }
                Self::Loss if is_bare => (turning, torque_nm),
                Self::Loss => (f64::NAN, f64::NAN),
                Self::Lift => (with_propeller, lift[row]),
                Self::ReactionTorque => (with_propeller, way * torque[row]),
                Self::Drag => (with_propeller, torque_nm - upstream.loss_nm_s * turning),
                Self::LagRising | Self::LagFalling => (f64::NAN, f64::NAN),
            }
        };
        let rows = (0..bench.rows()).map(row).filter(|(x, y)| x.is_finite() && y.is_finite());
        let (x, y) = rows.unzip();
        Points { x, y }
    }
}
