//! A log with something hidden in it, made by a number and its length.

use sil_host::log::{self, Log};
use sil_host::model::VehicleModel;
use sil_host::sensors::random::RandomStream;

use super::behaviour::Named;
use super::conditions::{Conditions, wanted_ratio};
use super::hidden::{EFFECTS, EFFECTS_IN_FREE_FLIGHT, Hidden};
use super::outside::Outside;
use super::reality::{Reality, log_within};

/// Causes of vehicles that imitate real ones; what is in a base model, and the file's inertia, is off in all of them.
const CAUSES: [&str; 13] = [
    "cg_offset",
    "viscous_friction",
    "coulomb_friction",
    "spring",
    "inertia_coupling",
    "weak_motor",
    "battery_sag",
    "command_clipping",
    "gyro_scale",
    "attitude_delay",
    "imu_misalignment",
    "periodic_disturbance",
    "step_disturbance",
];
/// How much more than the gusts such a cause shows.
const OVER_GUSTS: [f64; 2] = [1.0, 4.0];

/// A case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number.
    pub seed: u64,
    /// Effects of the catalogue that are hidden in it, and the true values of their [`Hidden::parameter`].
    pub hidden: Vec<(Hidden, f64)>,
    /// What is in it besides, that no catalogue has.
    pub outside: Option<Outside>,
    /// The vehicle beside what is hidden, where it imitates a real one.
    pub reality: Option<Reality>,
    /// How it was made.
    pub conditions: Conditions,
    /// Held-out error of the nominal model over the noise floor.
    pub ratio: f64,
    /// The true vehicle, but for what is outside the catalogue.
    pub vehicle: VehicleModel,
    /// The log as CSV.
    pub csv: String,
}

impl Case {
    /// One effect.
    pub fn single(seed: u64, duration_s: f64) -> Case {
        let mut draws = RandomStream::new(seed, "blind");
        let conditions = Conditions::draw(seed, duration_s, &mut draws);
        Case::with_effects(seed, &[EFFECTS[(seed % EFFECTS.len() as u64) as usize]], conditions, &mut draws)
    }

    /// One effect in free flight.
    pub fn free(seed: u64, duration_s: f64) -> Case {
        let mut draws = RandomStream::new(seed, "blind, free flight");
        let conditions = Conditions::draw_free(seed, duration_s, &mut draws);
        let name = EFFECTS_IN_FREE_FLIGHT[(seed % EFFECTS_IN_FREE_FLIGHT.len() as u64) as usize];
        Case::with_effects(seed, &[name], conditions, &mut draws)
    }

    /// One effect, and a controller that runs faster than the log.
    pub fn with_lost_commands(seed: u64, duration_s: f64) -> Case {
        let mut draws = RandomStream::new(seed, "blind, lost commands");
        let conditions = Conditions::draw_with_lost_commands(seed, duration_s, &mut draws);
        Case::with_effects(seed, &[EFFECTS[(seed % EFFECTS.len() as u64) as usize]], conditions, &mut draws)
    }

    /// So many different effects, each as large as it would be alone.
    pub fn combined(seed: u64, duration_s: f64, count: usize) -> Case {
        let mut draws = RandomStream::new(seed, "blind, combined");
        let conditions = Conditions::draw(seed, duration_s, &mut draws);
        let mut names: Vec<&'static str> = Vec::new();
        while names.len() < count {
            let name = EFFECTS[(draws.uniform() * EFFECTS.len() as f64) as usize];
            if !names.contains(&name) {
                names.push(name);
            }
        }
        Case::with_effects(seed, &names, conditions, &mut draws)
    }

    /// The nominal vehicle.
    pub fn nominal(seed: u64, duration_s: f64) -> Case {
        let mut draws = RandomStream::new(seed, "blind, nominal");
        let conditions = Conditions::draw(seed, duration_s, &mut draws);
        Case::with_effects(seed, &[], conditions, &mut draws)
    }

    /// Something that no catalogue has.
    pub fn outside(seed: u64, duration_s: f64) -> Case {
        let mut draws = RandomStream::new(seed, "blind, outside");
        let conditions = Conditions::draw(seed, duration_s, &mut draws);
        let outside = Outside::draw(seed, &mut draws);
        let log_of = |size: f64| conditions.flown(&[], Some(&mut outside.at_work(size, seed)));
        let size = conditions.size(outside.first_size(), wanted_ratio(&mut draws), log_of);
        let case = Case::of_log(seed, Vec::new(), conditions, &log_of(size));
        Case { outside: Some(outside), ..case }
    }

    /// A vehicle that imitates a real one, with a cause that shows at least as much as its gusts do, or none.
    pub fn reality(seed: u64, duration_s: f64) -> Case {
        let mut draws = RandomStream::new(seed, "blind, reality");
        let conditions = Conditions::draw_imitating_reality(seed, duration_s, &mut draws);
        let reality = Reality::draw(&conditions.vehicle(&[]), duration_s, seed, &mut draws);
        let mut effects = reality.ordinary.clone();
        let mut hidden = Vec::new();
        if let Some(name) = CAUSES.get((seed % (CAUSES.len() as u64 + 1)) as usize) {
            let cause = Hidden::draw(name, duration_s, conditions.rig, &mut draws);
            let by_gusts = conditions.ratio(&conditions.flown(&[], Some(&mut reality.gusts())));
            let wanted = by_gusts * log_within(&mut draws, OVER_GUSTS);
            let size = conditions.size(cause.first_size, wanted, |size| conditions.flown(&[cause.short(size)], None));
            // it takes the place of what is ordinary of its kind
            let own = Named::of_short(&cause.short(size));
            effects.retain(|short| !Named::of_short(short).is_at(&own));
            effects.push(cause.short(size));
            hidden.push((cause, size));
        }
        let log = conditions.flown(&effects, Some(&mut reality.gusts()));
        let case = Case::of_log(seed, hidden, conditions, &log);
        Case { vehicle: conditions.vehicle(&effects), reality: Some(reality), ..case }
    }

    fn with_effects(seed: u64, names: &[&'static str], conditions: Conditions, draws: &mut RandomStream) -> Case {
        let mut hidden = Vec::new();
        for name in names {
            let effect = Hidden::draw(name, conditions.duration_s, conditions.rig, draws);
            let log_of = |size: f64| conditions.flown(&[effect.short(size)], None);
            let size = conditions.size(effect.first_size, wanted_ratio(draws), log_of);
            hidden.push((effect, size));
        }
        let effects: Vec<String> = hidden.iter().map(|(effect, size)| effect.short(*size)).collect();
        let mut case = Case::of_log(seed, hidden, conditions, &conditions.synthesised(&effects));
        case.vehicle = conditions.vehicle(&effects);
        case
    }

    /// `hidden` with the effects' sizes.
    fn of_log(seed: u64, hidden: Vec<(Hidden, f64)>, conditions: Conditions, log: &Log) -> Case {
        let mut csv = Vec::new();
        log::write(log, &mut csv).expect("memory takes all");
        Case {
            seed,
            hidden: hidden.into_iter().map(|(effect, size)| (effect.clone(), effect.value(size))).collect(),
            outside: None,
            reality: None,
            conditions,
            ratio: conditions.ratio(log),
            vehicle: conditions.vehicle(&[]),
            csv: String::from_utf8(csv).expect("a log is text"),
        }
    }

    /// What is hidden, in words.
    pub fn label(&self) -> String {
        let mut labels: Vec<String> = self.hidden.iter().map(|(effect, _)| effect.label()).collect();
        labels.extend(self.outside.map(|outside| outside.label()));
        labels.join(" + ")
    }

    /// The log as the diagnosis gets it.
    ///
    /// # Panics
    /// If what was written can't be read.
    pub fn log(&self) -> Log {
        log::parse("blind.csv", &self.csv, None).expect("what is written can be read")
    }
}
