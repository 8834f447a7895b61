//! What lies between a command and the lift it makes, as numbers that effects can change:
//!
//! ```text
//! command -> delay -> clipping -> lag -> ESC map -> motor -> factors on lift
//! ```

/// The links of the chain that effects can change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ActuatorChain {
    /// Delay, s.
    pub(crate) delay_s: f64,
    /// Commands below are done as this.
    pub(crate) command_min: f64,
    /// Commands above are done as this.
    pub(crate) command_max: f64,
    /// Time constant of the lag on the command, s; 0 for none.
    pub(crate) lag_s: f64,
    /// Factors on the lifts of motors 1 to 4.
    pub(crate) lift_scale: [f64; 4],
    /// Share of the lift that is lost a second, 1/s.
    pub(crate) loss_per_s: f64,
    /// Share of the lift that is lost a volt, 1/V.
    pub(crate) loss_per_volt: f64,
    /// The battery.
    pub(crate) battery: Battery,
}

impl Default for ActuatorChain {
    fn default() -> Self {
        Self {
            delay_s: 0.0,
            command_min: 0.0,
            command_max: 1.0,
            lag_s: 0.0,
            lift_scale: [1.0; 4],
            loss_per_s: 0.0,
            loss_per_volt: 0.0,
            battery: Battery { fall_v_s: 0.0 },
        }
    }
}

/// A battery as simple as can be: its voltage falls steadily.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Battery {
    /// How fast, V/s.
    pub(crate) fall_v_s: f64,
}

/// Voltage of three lithium cells under load at the start, V.
const START_V: f64 = 12.0;

/// The reference of `battery_sag` is the mean of the first second: the voltage at half a second.
const REFERENCE_S: f64 = 0.5;

impl Battery {
    /// Voltage, V.
    pub(crate) fn voltage_v(&self, time_s: f64) -> f64 {
        START_V - self.fall_v_s * time_s
    }

    /// How far the voltage is below the mean of the first second, V.
    pub(crate) fn drop_v(&self, time_s: f64) -> f64 {
        self.fall_v_s * (time_s - REFERENCE_S)
    }
}
