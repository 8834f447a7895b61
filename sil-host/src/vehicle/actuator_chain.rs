//! What lies between a command and the lift it makes, as numbers that effects can change:
//!
//! ```text
//! command -> delay -> clipping -> lag -> bend -> ESC map -> motor -> factors on lift
//! '------------- CommandPath ----------------'   '-- propulsion -'   '- LiftFactors -'
//! ```

/// The links of the chain that effects can change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ActuatorChain {
    /// Before the ESC.
    pub(crate) path: CommandPath,
    /// Behind the motor.
    pub(crate) lift: LiftFactors,
}

/// What happens to a command before the ESC, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CommandPath {
    /// Delay, s.
    pub(crate) delay_s: f64,
    /// Commands below are done as this.
    pub(crate) command_min: f64,
    /// Commands above are done as this.
    pub(crate) command_max: f64,
    /// Time constant of the lag on the command, s; 0 for none.
    pub(crate) lag_s: f64,
    /// What a motor's command acts as beside itself, per unit of it and of its square.
    pub(crate) bend: [f64; 2],
}

/// What the lifts, and with them the reaction torques, are multiplied with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LiftFactors {
    /// Of motors 1 to 4.
    pub(crate) scale: [f64; 4],
    /// Share that is lost a second, 1/s.
    pub(crate) loss_per_s: f64,
    /// Share that is lost a volt, 1/V.
    pub(crate) loss_per_volt: f64,
    /// The battery.
    pub(crate) battery: Battery,
}

/// A battery as simple as can be: its voltage falls steadily.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Battery {
    /// How fast, V/s.
    pub(crate) fall_v_s: f64,
}

impl Default for CommandPath {
    fn default() -> Self {
        Self { delay_s: 0.0, command_min: 0.0, command_max: 1.0, lag_s: 0.0, bend: [0.0; 2] }
    }
}

impl CommandPath {
    /// The command that the ESC obeys, 0..1, where this one has arrived; not a number counts as 0.
    pub(crate) fn clipped(&self, command: f64) -> f64 {
        let command = if command.is_nan() { 0.0 } else { command.clamp(0.0, 1.0) };
        // the limits of several effects may have crossed
        command.max(self.command_min).min(self.command_max)
    }

    /// The same of an axis command, -1..1 in the unit of the log: the upper limit holds on either side.
    pub(crate) fn clipped_about_zero(&self, command: f64) -> f64 {
        command.max(-self.command_max).min(self.command_max)
    }

    /// What a motor's command acts as behind the lag.
    #[inline]
    pub(crate) fn bent(&self, command: f64) -> f64 {
        let [linear, square] = self.bend;
        (command * (1.0 + linear + square * command)).clamp(0.0, 1.0)
    }

    /// The share of its way that the lag has left after a time, s, under one command.
    #[inline]
    pub(crate) fn left_after(&self, duration_s: f64) -> f64 {
        libm::exp(-duration_s / self.lag_s)
    }
}

/// Commands behind the lag with a share of their way to `target` left.
#[inline]
pub(crate) fn on_the_way(from: [f64; 4], target: [f64; 4], left: f64) -> [f64; 4] {
    core::array::from_fn(|motor| target[motor] + (from[motor] - target[motor]) * left)
}

impl Default for LiftFactors {
    fn default() -> Self {
        Self { scale: [1.0; 4], loss_per_s: 0.0, loss_per_volt: 0.0, battery: Battery::default() }
    }
}

impl LiftFactors {
    /// The factors of motors 1 to 4, so long after the start, s, the battery so far below its mean of the first second,
    /// V.
    #[inline]
    pub(crate) fn at(&self, time_s: f64, drop_v: f64) -> [f64; 4] {
        let left = (1.0 - self.loss_per_s * time_s) * (1.0 - self.loss_per_volt * drop_v);
        self.scale.map(|scale| scale * left.max(0.0))
    }
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
