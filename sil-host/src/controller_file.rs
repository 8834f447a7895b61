//! Controllers by name or by file: `pid`, `mpc`, `mpc-quick`, or a TOML file with the gains that flew.
//!
//! ```toml
//! controller = "pid"            # or "mpc"
//! rate_hz = 400                 # optional
//! control_horizon = 1           # optional, MPC
//! quick = true                  # optional, MPC: by the fronts of docs/mpc-against-cascade.md
//! [tuning]                      # optional; any field of the core's Tuning; the rest follows the motors' lag
//! angle_gain_1_s = [8.0, 7.0, 4.0]
//! ```

use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize, de::Error};
use shared_control::config::{Controller, Tuning};
use shared_control::mpc::{HORIZON, ReferenceAhead};
use shared_control::torque_observer::DisturbanceAlert;
use shared_control::vehicle::VehicleParameters;

use crate::document::with_hint;

/// A controller with everything that can be chosen about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerChoice {
    /// Cascade or MPC.
    pub controller: Controller,
    /// Gains and weights that differ from those that follow from the vehicle.
    pub tuning: TuningChange,
    /// Steps per second; 400 unless the file says otherwise.
    pub rate_hz: u32,
    /// Free inputs per axis of the MPC.
    pub control_horizon: usize,
    /// The MPC is that of [`Tuning::quick`].
    pub quick: bool,
}

/// Free inputs per axis where nothing else is said.
pub const CONTROL_HORIZON_DEFAULT: usize = 5;

/// A controller file that can't be used.
#[derive(Debug, thiserror::Error)]
pub enum ControllerFileError {
    /// Neither a known name nor a readable file.
    #[error("--controller {given}: neither \"pid\" nor \"mpc\" nor \"mpc-quick\" nor a readable file: {source}")]
    Unreadable {
        /// What was given.
        given: String,
        /// Why the file can't be read.
        source: std::io::Error,
    },
    /// Not TOML of the expected form; the message has line and column.
    #[error("{file}: {message}")]
    Malformed {
        /// The file.
        file: String,
        /// What and where.
        message: String,
    },
}

impl ControllerChoice {
    /// A controller with the tuning that follows from the vehicle.
    pub fn nominal(controller: Controller) -> Self {
        let (tuning, control_horizon) = (TuningChange::default(), CONTROL_HORIZON_DEFAULT);
        Self { controller, tuning, rate_hz: 400, control_horizon, quick: false }
    }

    /// Gains and weights for a vehicle: those that follow from it, and what differs.
    pub fn tuning_for(&self, vehicle: &VehicleParameters) -> Tuning {
        self.tuning.over(Tuning::for_flight(vehicle, self.controller, self.quick))
    }

    /// `pid`, `mpc`, `mpc-quick`, or the path of a file.
    ///
    /// # Errors
    /// [`ControllerFileError`], with the place.
    pub fn from_argument(argument: &str) -> Result<Self, ControllerFileError> {
        match argument {
            "pid" => Ok(Self::nominal(Controller::Cascade)),
            "mpc" => Ok(Self::nominal(Controller::Mpc)),
            "mpc-quick" => Ok(Self { quick: true, ..Self::nominal(Controller::Mpc) }),
            path => match std::fs::read_to_string(Path::new(path)) {
                Ok(text) => Self::parse(&text, path),
                Err(source) => Err(ControllerFileError::Unreadable { given: path.into(), source }),
            },
        }
    }

    /// `pid`, `mpc`, `mpc-quick`, the path of a file, or the text of one, which has a `=`.
    ///
    /// # Errors
    /// [`ControllerFileError`], with the place.
    pub fn from_argument_or_text(given: &str) -> Result<Self, ControllerFileError> {
        if given.contains('=') { Self::parse(given, "controller") } else { Self::from_argument(given) }
    }

    /// Reads the text of a file; `file` is what messages call it.
    ///
    /// # Errors
    /// [`ControllerFileError::Malformed`].
    pub fn parse(text: &str, file: &str) -> Result<Self, ControllerFileError> {
        let document: Document = toml::from_str(text).map_err(|error| ControllerFileError::Malformed {
            file: file.into(),
            message: with_hint(&error.to_string()),
        })?;
        let controller = match document.controller {
            Kind::Pid => Controller::Cascade,
            Kind::Mpc => Controller::Mpc,
        };
        if document.quick && controller == Controller::Cascade {
            let message = "quick = true is of the MPC: the cascade has no such tuning".into();
            return Err(ControllerFileError::Malformed { file: file.into(), message });
        }
        let nominal = Self::nominal(controller);
        Ok(Self {
            quick: document.quick,
            tuning: document.tuning.unwrap_or_default(),
            rate_hz: document.rate_hz.unwrap_or(nominal.rate_hz),
            control_horizon: document.control_horizon.unwrap_or(nominal.control_horizon),
            ..nominal
        })
    }

    /// What reports call it.
    pub fn name(&self) -> &'static str {
        controller_name(self.controller)
    }
}

/// What commands and reports call a controller.
pub fn controller_name(controller: Controller) -> &'static str {
    match controller {
        Controller::Cascade => "pid",
        Controller::Mpc => "mpc",
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    controller: Kind,
    #[serde(default, deserialize_with = "rate_hz")]
    rate_hz: Option<u32>,
    #[serde(default, deserialize_with = "control_horizon")]
    control_horizon: Option<usize>,
    #[serde(default)]
    quick: bool,
    tuning: Option<TuningChange>,
}

fn rate_hz<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u32>, D::Error> {
    let rate_hz = u32::deserialize(deserializer)?;
    match rate_hz {
        50..=1000 => Ok(Some(rate_hz)),
        _ => Err(D::Error::custom("expected 50 to 1000 steps per second")),
    }
}

fn control_horizon<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    let steps = usize::deserialize(deserializer)?;
    match steps {
        1..=HORIZON => Ok(Some(steps)),
        _ => Err(D::Error::custom(format!("expected 1 to {HORIZON} free inputs"))),
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Pid,
    Mpc,
}

/// A value of a tuning as a file gives it; none where a file leaves it out.
trait InFile<T> {
    fn in_file(self) -> Option<T>;
}

impl<T> InFile<T> for T {
    fn in_file(self) -> Option<T> {
        Some(self)
    }
}

impl InFile<f32> for Option<f32> {
    fn in_file(self) -> Option<f32> {
        self
    }
}

impl InFile<ReferenceName> for ReferenceAhead {
    fn in_file(self) -> Option<ReferenceName> {
        Some(match self {
            ReferenceAhead::Setpoint => ReferenceName::Setpoint,
            ReferenceAhead::Held => ReferenceName::Held,
            ReferenceAhead::Shaped => ReferenceName::Shaped,
        })
    }
}

impl InFile<AlertName> for DisturbanceAlert {
    fn in_file(self) -> Option<AlertName> {
        Some(match self {
            DisturbanceAlert::Never => AlertName::Never,
            DisturbanceAlert::Significant => AlertName::Significant,
            DisturbanceAlert::Always => AlertName::Always,
        })
    }
}

macro_rules! tuning_fields {
    ($($field:ident: $kind:ty),* $(,)?) => {
        /// Fields of [`Tuning`] that are given; the rest keeps what follows from the vehicle.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
        #[serde(deny_unknown_fields)]
        pub struct TuningChange {
            $(
                #[doc = concat!("See [`Tuning::", stringify!($field), "`].")]
                pub $field: Option<$kind>,
            )*
        }

        impl TuningChange {
            /// The tuning with the given fields in it.
            pub fn over(self, tuning: Tuning) -> Tuning {
                Tuning { $($field: self.$field.map_or(tuning.$field, Into::into),)* }
            }

            /// All fields of a tuning, as a file would give them.
            pub fn all_of(tuning: &Tuning) -> Self {
                Self { $($field: InFile::<$kind>::in_file(tuning.$field),)* }
            }
        }
    };
}

tuning_fields! {
    shaping_gain_1_s: [f32; 3],
    acceleration_share: f32,
    acceleration_feed_forward: f32,
    rate_max_rad_s: [f32; 3],
    tilt_max_rad: f32,
    angle_gain_1_s: [f32; 3],
    rate_proportional_1_s: [f32; 3],
    rate_integral_1_s2: [f32; 3],
    rate_derivative: [f32; 3],
    rate_derivative_cutoff_hz: f32,
    integral_share: f32,
    gyro_cutoff_hz: f32,
    mpc_tracking_weight: [f32; 3],
    mpc_increment_weight: [f32; 3],
    mpc_horizon: usize,
    mpc_prediction_step_s: f32,
    mpc_tilt_max_rad: f32,
    mpc_lead_s: [f32; 3],
    mpc_reference: ReferenceName,
    mpc_knows_actuation: bool,
    mpc_disturbance_bandwidth_rad_s: f32,
    mpc_disturbance_alert: AlertName,
    mpc_gyro_delay_s: f32,
    mpc_motor_limits: bool,
    mpc_torque_reserve: f32,
    mpc_work_limit: usize,
    mpc_linearisations: usize,
    ground_idle_command: f32,
    flight_idle_command: f32,
    motor_loss: bool,
    learning: bool,
}

/// [`ReferenceAhead`] by name: `setpoint`, `held` or `shaped`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)] // named after what they stand for
pub enum ReferenceName {
    Setpoint,
    Held,
    Shaped,
}

impl From<ReferenceName> for ReferenceAhead {
    fn from(name: ReferenceName) -> Self {
        match name {
            ReferenceName::Setpoint => ReferenceAhead::Setpoint,
            ReferenceName::Held => ReferenceAhead::Held,
            ReferenceName::Shaped => ReferenceAhead::Shaped,
        }
    }
}

/// [`DisturbanceAlert`] by name: `never`, `significant` or `always`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)] // named after what they stand for
pub enum AlertName {
    Never,
    Significant,
    Always,
}

impl From<AlertName> for DisturbanceAlert {
    fn from(name: AlertName) -> Self {
        match name {
            AlertName::Never => DisturbanceAlert::Never,
            AlertName::Significant => DisturbanceAlert::Significant,
            AlertName::Always => DisturbanceAlert::Always,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_changes_what_it_names_and_keeps_the_rest() {
        let text = "controller = \"mpc\"\nrate_hz = 100\n\
                    [tuning]\nangle_gain_1_s = [9.0, 7.0, 4.0]\nmpc_reference = \"held\"\n";
        let choice = ControllerChoice::parse(text, "c.toml").unwrap();
        assert_eq!((choice.controller, choice.rate_hz, choice.control_horizon), (Controller::Mpc, 100, 5));
        let nominal = Tuning::for_motor_lag(0.0);
        assert_eq!(TuningChange::all_of(&nominal).over(Tuning::for_motor_lag(0.1)), nominal);
        let tuning = choice.tuning.over(nominal);
        assert_eq!(tuning.angle_gain_1_s, [9.0, 7.0, 4.0]);
        assert_eq!(tuning.mpc_reference, ReferenceAhead::Held);
        assert_eq!(tuning.rate_derivative, nominal.rate_derivative);
    }

    #[test]
    fn quick_is_what_a_file_changes_then() {
        let vehicle = VehicleParameters::F450_FREE;
        let by_name = ControllerChoice::from_argument("mpc-quick").unwrap();
        let by_file = ControllerChoice::parse("controller = \"mpc\"\nquick = true\n", "c.toml").unwrap();
        assert_eq!(by_name, by_file);
        assert_eq!(by_name.tuning_for(&vehicle), Tuning::for_vehicle(&vehicle).quick(&vehicle));
        let changed = "controller = \"mpc\"\nquick = true\n[tuning]\nacceleration_share = 0.5\n";
        let changed = ControllerChoice::parse(changed, "c.toml").unwrap().tuning_for(&vehicle);
        assert_eq!(changed, Tuning { acceleration_share: 0.5, ..by_name.tuning_for(&vehicle) });
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (text, expected) in [
            ("controller = \"pdi\"\n", "line 1"),
            ("controller = \"pid\"\n[tuning]\nangle_gain = 3\n", "line 3"),
            ("controller = \"mpc\"\n[tuning]\nmpc_reference = \"ahead\"\n", "line 3"),
            ("controller = \"pid\"\nrate_hz = 0\n", "line 2"),
            ("controller = \"pid\"\nquick = true\n", "is of the MPC"),
            ("controller = \"pid\"\nrate_hz = 1001\n", "expected 50 to 1000"),
            ("controller = \"pid\"\ncontrol_horizon = 0\n", "line 2"),
            ("controller = \"pid\"\ncontrol_horizon = 31\n", "expected 1 to 30"),
            ("controller = \"pid\"\n[tuning]\nangle_gain_1_s = [1.0]\n", "line 3"),
        ] {
            let message = ControllerChoice::parse(text, "c.toml").unwrap_err().to_string();
            assert!(message.contains("c.toml") && message.contains(expected), "{message}");
        }
        assert!(ControllerChoice::from_argument("no-such-file.toml").unwrap_err().to_string().contains("no-such-file"));
    }
}
