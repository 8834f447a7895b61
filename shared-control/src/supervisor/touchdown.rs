//! Does the ground carry a vehicle that comes down by itself? It finds out by lifting less for a moment.
//!
//! Nothing on board measures height, and a vehicle that stands with most of its weight lifted feels the same 1 g as one
//! that sinks steadily. They differ in what follows when the lift changes: in the air the specific force follows, on
//! the ground the ground carries the rest.
//!
//! ```text
//!   share of the lift   1.0  ----.            .----                            jolt: ----.
//!   with which it sinks           \          /                                           \
//!                       0.8        '--------'--.                .---- carried: landed     \
//!                                    follows  ' \ carried      /                           \
//!                       0.35                     '------------'                             '----------.
//!                                                    carried                                  carried   \
//!                       0.1                                                                              '---- landed
//! ```
//! At each level it waits until motors (0.05 s) and the filter of the force ([`super::flight_watch`], 0.08 s) have
//! settled. Then the ground carries if for 0.3 s without a break the force follows by less than [`FOLLOWS`] of the
//! change in lift over the vehicle's mass; if it follows for 0.2 s, the whole lift comes back, and 0.8 s later it tries
//! again.
//!
//! - **In the air** the force follows by what is wrong about the throttle for hovering (15 % of throttle are 0.72 to
//!   1.32 of the lift), less what the sinking rotor wins back meanwhile: its lift grows by 5 % per m/s (10 inches), so
//!   that 0.85 are left. That makes 0.6 or more. A gust may hide one dip; to hide the next, of twice the size, it must
//!   begin anew, and to hide the return it must turn round.
//! - **On the ground** the force follows by nothing, whatever the slope and the accelerometer's offset, once legs and
//!   soil have come to rest.
//!
//! Legs that meet the ground are felt: what stops 1 m/s within 0.1 s makes more than `JOLT` of the filtered force,
//! for which the air would have to rise by 12 m/s faster. Then it goes down to 0.35 at once, where a bounce is short,
//! and waits for 1 s without support before it lifts again; at last it goes lower still, as a return would have it
//! bounce again. There the force is compared with what is felt in a steady sink, since bounces end with anything.

use super::flight_watch::since;
use super::throttle::HOLD_US;
use super::{Arming, IDLE_THROTTLE_MAX};
use crate::elementary::{limit, magnitude};
use crate::record::state_words::StateWords;

/// Time between two dips in the air, µs.
pub const BETWEEN_US: u64 = 800_000;
/// Time until motors and filter have followed a change of the lift, µs.
const SETTLED_US: u64 = 250_000;
/// Time for which the ground must carry, µs.
const CARRIES_US: u64 = 300_000;
/// Time for which the force must follow before the lift comes back, µs.
const FOLLOWS_US: u64 = 200_000;
/// The same after a jolt, when it may bounce.
const BOUNCES_US: u64 = 1_000_000;
/// Longest time at one level, µs.
const UNDECIDED_US: u64 = 5_000_000;

/// Shares of the lift with which it sinks: in the first dip and back from the second, in the second, and at last.
const SHARES: [f32; 3] = [0.8, 0.35, 0.1];
/// How fast the share changes, 1/s.
const SHARE_RATE_1_S: f32 = 4.0;
/// Share of a change in lift by which the force follows in the air, at least. Of 0.6 that are expected and 0 on the
/// ground a bit nearer to the latter: motors that run on are less than a vehicle that falls.
pub const FOLLOWS: f32 = 0.25;
/// A change in lift too small to be judged, over the lift that hovers.
const SMALLEST_CHANGE: f32 = 0.05;
/// Least force on the ground, g: an accelerometer may be off by 0.08 (MPU-6000 product specification 6.2).
const CARRIED: f32 = 0.75;
/// Force that is felt when legs meet the ground, g.
const JOLT: f32 = 1.6;

/// Share of the lift that is lost to the dips of a vehicle in the air.
pub const LOST_TO_DIPS: f32 =
    (1.0 - SHARES[0]) * (SETTLED_US + FOLLOWS_US) as f32 / (SETTLED_US + FOLLOWS_US + BETWEEN_US) as f32;

/// What it needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchdownConfig {
    gravity_m_s2: f32,
    /// Lift of each motor that hovers, N, as far as that is known; 0 where a rig holds the vehicle.
    hover_lift_n: f32,
    share_per_step: f32,
}

impl TouchdownConfig {
    /// For a vehicle on a rig, which is never asked, and a loop of this rate.
    pub fn on_rig(gravity_m_s2: f32, loop_rate_hz: f32) -> Self {
        Self { gravity_m_s2, hover_lift_n: 0.0, share_per_step: SHARE_RATE_1_S / loop_rate_hz }
    }

    /// The same for one that hovers with this lift of each motor, N.
    #[must_use]
    pub fn hovering_with(self, hover_lift_n: f32) -> Self {
        Self { hover_lift_n, ..self }
    }
}

/// What carries the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Length of the specific force, m/s^2, without vibration.
    pub force_m_s2: f32,
    /// Lift of each motor that was asked for, N.
    pub lift_n: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    #[default]
    Between,
    First,
    Second,
    /// Back up from the second.
    Raised,
    /// At once as low as in the second, since it was jolted.
    Jolted,
    /// Lower still.
    Last,
}

/// The dips, and what the present one has shown so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touchdown {
    stage: Stage,
    since_us: u64,
    share: f32,
    /// What the dip is compared with.
    before: Load,
    carries_since_us: Option<u64>,
    follows_since_us: Option<u64>,
    /// Force since the ground carries, summed over steps, and their number.
    carried_m_s2: f32,
    carried_steps: f32,
}

impl Default for Touchdown {
    fn default() -> Self {
        Self {
            stage: Stage::Between,
            since_us: 0,
            share: 1.0,
            before: Load::default(),
            carries_since_us: None,
            follows_since_us: None,
            carried_m_s2: 0.0,
            carried_steps: 0.0,
        }
    }
}

impl Touchdown {
    /// Share of the lift that is to be flown now.
    pub fn lift_share(&self) -> f32 {
        self.share
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { stage, since_us, share, before: Load { force_m_s2, lift_n }, .. } = self;
        let Self { carries_since_us, follows_since_us, carried_m_s2, carried_steps, .. } = self;
        words.word(*stage as u32);
        words.time_us(*since_us);
        words.numbers(&[*share, *force_m_s2, *lift_n, *carried_m_s2, *carried_steps]);
        words.optional_time_us(*carries_since_us);
        words.optional_time_us(*follows_since_us);
    }

    /// Takes what a step felt that was flown with this throttle; true once the ground carries the vehicle.
    pub fn feel(&mut self, config: &TouchdownConfig, arming: Arming, throttle: f32, load: &Load, time_us: u64) -> bool {
        let may_stand = config.hover_lift_n > 0.0 && throttle > IDLE_THROTTLE_MAX && has_begun_to_sink(arming, time_us);
        let stands = may_stand && self.dip(config, load, time_us);
        if !may_stand {
            self.begin(Stage::Between, load, time_us);
        }
        let way = self.stage.share() - self.share;
        self.share += limit(way, -config.share_per_step, config.share_per_step);
        stands
    }

    fn begin(&mut self, stage: Stage, before: &Load, time_us: u64) {
        let share = self.share;
        *self = Self { stage, since_us: time_us, share, before: *before, ..Self::default() };
    }

    fn dip(&mut self, config: &TouchdownConfig, load: &Load, time_us: u64) -> bool {
        let lasts_us = time_us.saturating_sub(self.since_us);
        match self.stage {
            Stage::Between | Stage::First if load.force_m_s2 > JOLT * config.gravity_m_s2 => {
                self.begin(Stage::Jolted, &self.steady(config, load), time_us);
            }
            Stage::Between if lasts_us >= BETWEEN_US => self.begin(Stage::First, load, time_us),
            Stage::First | Stage::Second | Stage::Raised | Stage::Jolted | Stage::Last if lasts_us >= SETTLED_US => {
                return self.judge(config, load, time_us);
            }
            Stage::Between | Stage::First | Stage::Second | Stage::Raised | Stage::Jolted | Stage::Last => {}
        }
        false
    }

    /// What the force says about the dip so far. Not a number is nothing that carries.
    fn judge(&mut self, config: &TouchdownConfig, load: &Load, time_us: u64) -> bool {
        let less_lift = (self.before.lift_n - load.lift_n) / config.hover_lift_n;
        let less_force = (self.before.force_m_s2 - load.force_m_s2) / config.gravity_m_s2;
        let carries = load.force_m_s2 > CARRIED * config.gravity_m_s2
            && magnitude(less_lift) > SMALLEST_CHANGE
            && less_force / less_lift < FOLLOWS;
        if carries {
            (self.carried_m_s2, self.carried_steps) = (self.carried_m_s2 + load.force_m_s2, self.carried_steps + 1.0);
        } else {
            (self.carried_m_s2, self.carried_steps) = (0.0, 0.0);
        }
        let carried = since(&mut self.carries_since_us, time_us, carries) >= CARRIES_US;
        let followed = since(&mut self.follows_since_us, time_us, !carries) >= self.stage.patience_us();
        let undecided = time_us.saturating_sub(self.since_us) >= UNDECIDED_US;
        match self.stage {
            Stage::First if carried => self.begin(Stage::Second, load, time_us),
            Stage::Second if carried => {
                let force_m_s2 = self.carried_m_s2 / self.carried_steps;
                self.begin(Stage::Raised, &Load { force_m_s2, ..*load }, time_us);
            }
            Stage::Jolted if carried => self.begin(Stage::Last, &self.steady(config, load), time_us),
            Stage::Raised | Stage::Last if carried => return true,
            _ if followed || undecided => self.begin(Stage::Between, load, time_us),
            _ => {}
        }
        false
    }

    /// What it feels when it sinks steadily with the whole of its lift.
    fn steady(&self, config: &TouchdownConfig, load: &Load) -> Load {
        Load { force_m_s2: config.gravity_m_s2, lift_n: load.lift_n / self.share }
    }
}

impl Stage {
    fn share(self) -> f32 {
        let [first, second, last] = SHARES;
        match self {
            Stage::Between => 1.0,
            Stage::First | Stage::Raised => first,
            Stage::Second | Stage::Jolted => second,
            Stage::Last => last,
        }
    }

    fn patience_us(self) -> u64 {
        match self {
            Stage::Jolted => BOUNCES_US,
            Stage::Between | Stage::First | Stage::Second | Stage::Raised | Stage::Last => FOLLOWS_US,
        }
    }
}

/// Has the vehicle begun to come down by itself?
fn has_begun_to_sink(arming: Arming, time_us: u64) -> bool {
    arming.descends_since_us().is_some_and(|since_us| time_us.saturating_sub(since_us) >= HOLD_US)
}

#[cfg(test)]
mod tests;
