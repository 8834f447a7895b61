//! From the command that is given to the one that drives the motors, and from the motors' lift to the true one:
//!
//! ```text
//! command -> delay -> clipping -> lag -> bend -> ESC map -> motor -> factors on lift
//! ```
//! Without effects each link passes on what it gets.

use std::collections::VecDeque;

use crate::vehicle::{ActuatorChain, on_the_way};

/// The chain with what is under way in it.
#[derive(Clone, Debug)]
pub(crate) struct Actuation {
    pub(crate) chain: ActuatorChain,
    /// Commands under way, each with the time at which it takes effect.
    under_way: VecDeque<(f64, [f64; 4])>,
    /// Commands in force behind delay and clipping.
    target: [f64; 4],
    /// Where the lag is at the start of the stretch that is integrated.
    lagged: [f64; 4],
    /// How far a measured battery is below its mean of the first second, V; in place of the simulated one.
    measured_drop_v: Option<f64>,
    /// What is left of each motor's lift, 0..1.
    lift_left: [f64; 4],
}

impl Actuation {
    /// At rest under commands.
    pub(crate) fn new(chain: ActuatorChain, commands: [f64; 4]) -> Self {
        let mut actuation = Self {
            chain,
            under_way: VecDeque::new(),
            target: commands,
            lagged: commands,
            measured_drop_v: None,
            lift_left: [1.0; 4],
        };
        actuation.settle(commands);
        actuation
    }

    /// Has every link at rest under commands, none under way.
    pub(crate) fn settle(&mut self, commands: [f64; 4]) {
        self.under_way.clear();
        self.target = self.clipped(commands);
        self.lagged = self.target;
    }

    /// Gives commands at a time. True if they take effect at once.
    pub(crate) fn command(&mut self, time_s: f64, commands: [f64; 4]) -> bool {
        if self.chain.path.delay_s > 0.0 {
            self.under_way.push_back((time_s + self.chain.path.delay_s, commands));
            return false;
        }
        self.target = self.clipped(commands);
        true
    }

    /// What drives the motors once the lag has settled.
    pub(crate) fn settled(&self) -> [f64; 4] {
        self.target.map(|command| self.chain.path.bent(command))
    }

    /// When the next command takes effect, s.
    pub(crate) fn next_s(&self) -> Option<f64> {
        self.under_way.front().map(|(due_s, _)| *due_s)
    }

    /// Puts those commands in force that are due.
    pub(crate) fn put_in_force(&mut self, time_s: f64) {
        while let Some((due_s, commands)) = self.under_way.front().copied() {
            if due_s > time_s {
                return;
            }
            self.target = self.clipped(commands);
            self.under_way.pop_front();
        }
    }

    /// Lets a stretch of time pass for the lag.
    pub(crate) fn pass(&mut self, duration_s: f64) {
        self.lagged = self.behind_lag(duration_s);
    }

    /// Commands at the speed controllers, so long after the start of the stretch.
    #[inline]
    pub(crate) fn driving(&self, after_s: f64) -> [f64; 4] {
        self.behind_lag(after_s).map(|command| self.chain.path.bent(command))
    }

    /// Between two commands the lag's motion is an exponential.
    #[inline]
    fn behind_lag(&self, after_s: f64) -> [f64; 4] {
        if self.chain.path.lag_s <= 0.0 {
            return self.target;
        }
        on_the_way(self.lagged, self.target, self.chain.path.left_after(after_s))
    }

    /// True if the commands at the speed controllers change by themselves.
    pub(crate) fn lags(&self) -> bool {
        self.chain.path.lag_s > 0.0
    }

    /// What the lifts are multiplied with at a time.
    #[inline]
    pub(crate) fn lift_factors(&self, time_s: f64) -> [f64; 4] {
        let lift = &self.chain.lift;
        let factors = lift.at(time_s, self.measured_drop_v.unwrap_or_else(|| lift.battery.drop_v(time_s)));
        core::array::from_fn(|motor| factors[motor] * self.lift_left[motor])
    }

    /// What is left of each motor's lift from now on, 0..1.
    pub(crate) fn set_lift_left(&mut self, lift_left: [f64; 4]) {
        self.lift_left = lift_left;
    }

    /// Takes a measured battery's drop below its mean of the first second in place of the simulated one, V.
    pub(crate) fn set_measured_drop_v(&mut self, drop_v: f64) {
        self.measured_drop_v = Some(drop_v);
    }

    fn clipped(&self, commands: [f64; 4]) -> [f64; 4] {
        commands.map(|command| self.chain.path.clipped(command))
    }
}
