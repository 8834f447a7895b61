//! The detector of lost motors on flights that other people recorded: whether it gives up a motor that nobody lost,
//! and whether it finds one that was taken away. No vehicle of those logs lost a motor; some have a cut propeller.
//!
//! A loss is put into a log as its sensors would have shown it: from an instant on a motor's lift, by its command and
//! lag, is missing from angular acceleration and specific force. For 0.1 s the recorded commands are taken to go on,
//! which is as long as the flight controller's answer is behind the motors' lag.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use shared_control::airframe::TORQUE_SIGNS;
use shared_control::motor_loss::Stage;
use shared_control::motor_loss::detector::{DetectorConfig, DetectorState};
use shared_control::signals::AttitudeEstimate;
use shared_control::vehicle::VehicleParameters;

use super::recorded::{self, LOOP_RATE_HZ, Recorded, Step};

/// Of a step, s.
const STEP_S: f64 = 1.0 / LOOP_RATE_HZ;
/// After so many steps the detector judges, and a loss may be put in; then every so many.
const SETTLED_STEPS: usize = 400;
const BETWEEN_LOSSES_STEPS: usize = 7;
/// A loss is watched for so many steps.
const WATCHED_STEPS: usize = 41;
/// Motors that spin down do so with this lag, or with that which is believed of them.
const LOSSES: [(&str, Loss); 3] =
    [("propeller gone", Loss::Gone), ("spins down", Loss::SpinsDown), ("40 % lost", Loss::Part(0.4))];

#[derive(Clone, Copy, Debug)]
enum Loss {
    Gone,
    SpinsDown,
    Part(f64),
}

/// A vehicle that is believed to be another than it is: its lifts' torques and its motors' lag over the identified.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Belief {
    /// Of the angular acceleration per lift.
    pub gain: f64,
    /// Of the motors' lag.
    pub lag: f64,
}

/// As identified, and up to a quarter off.
pub const BELIEFS: [Belief; 5] = [
    Belief { gain: 1.0, lag: 1.0 },
    Belief { gain: 0.8, lag: 1.0 },
    Belief { gain: 1.25, lag: 1.0 },
    Belief { gain: 1.0, lag: 0.7 },
    Belief { gain: 1.0, lag: 1.4 },
];

impl Belief {
    fn of(&self, vehicle: &VehicleParameters) -> VehicleParameters {
        let mut believed = *vehicle;
        believed.inertia_kg_m2 = vehicle.inertia_kg_m2.map(|inertia_kg_m2| inertia_kg_m2 / self.gain as f32);
        believed.actuation.lag_s *= self.lag as f32;
        believed
    }
}

/// What came of a log's flights without a loss.
#[derive(Clone, Debug, Serialize)]
pub struct Quiet {
    /// The logs.
    pub name: String,
    /// What was believed of their vehicle.
    pub belief: Belief,
    /// In flight, s.
    pub flown_s: f64,
    /// Motors given up.
    pub latched: usize,
    /// Suspicions raised.
    pub suspicions: usize,
    /// For how long there was one, s.
    pub suspected_s: f64,
}

/// What came of losses that were put in.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// The logs.
    pub name: String,
    /// What was lost.
    pub loss: &'static str,
    /// How many.
    pub losses: usize,
    /// The right motor was suspected or given up within 20 ms.
    pub suspected_in_20_ms: usize,
    /// It was given up within 60 ms.
    pub named_in_60_ms: usize,
    /// It was given up within 100 ms.
    pub named_in_100_ms: usize,
    /// Another one was given up first.
    pub wrong: usize,
}

/// The detector as it goes through a flight.
#[derive(Clone, Copy)]
struct Watch {
    config: DetectorConfig,
    state: DetectorState,
}

impl Watch {
    fn new(vehicle: &VehicleParameters) -> Self {
        let config = DetectorConfig::new(vehicle, LOOP_RATE_HZ as f32);
        Self { config, state: DetectorState::default() }
    }

    fn step(&mut self, vehicle: &VehicleParameters, step: &Step) -> Stage {
        let rate_body_rad_s = step.rate_rad_s.map(|rate| rate as f32).into();
        // of which it takes the rates alone
        let estimate = AttitudeEstimate {
            q_world_from_body: UnitQuaternion::identity(),
            rate_body_rad_s,
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        };
        let force = [0.0, 0.0, step.force_z_m_s2 as f32].into();
        let stage = self.state.judge(&self.config, &estimate, Some(force));
        let lifts_n = step.motors.map(|command| vehicle.lift_curve.lift(command as f32));
        self.state.command(&self.config, lifts_n, None);
        stage
    }
}

/// All recorded flights in groups that belong together, as they are and with losses; none where the logs are absent.
pub fn searched() -> (Vec<Quiet>, Vec<Found>) {
    let flights = recorded::all();
    let mut names: Vec<&str> = Vec::new();
    flights.iter().map(group).for_each(|name| {
        if !names.contains(&name) {
            names.push(name)
        }
    });
    let of = |name: &str| flights.iter().filter(|flight| group(flight) == name).collect::<Vec<_>>();
    let quiets = names.iter().flat_map(|name| BELIEFS.map(|belief| quiet(name, &of(name), belief))).collect();
    (quiets, names.iter().flat_map(|name| with_losses(name, &of(name))).collect())
}

/// Which vehicle, and what was done to it.
fn group(flight: &Recorded) -> &'static str {
    let has = |part: &str| flight.name.contains(part);
    match () {
        () if has("log15") => "Crazyflie, steps (log15, identified from it)",
        () if has("log16") => "Crazyflie, turns (log16)",
        () if has("log171") => "ArduPilot outdoors (log171)",
        () if has("40mm") || has("42mm") => "CrazyPAD, propeller cut to 40 and 42 mm",
        () if has("cut_propeller") => "CrazyPAD, propeller cut to 43 and 46 mm",
        () if has("weight") => "CrazyPAD, with a weight",
        () => "CrazyPAD, normal",
    }
}

/// Goes through all of them as they are.
pub fn quiet(name: &str, flights: &[&Recorded], belief: Belief) -> Quiet {
    let mut found = Quiet { name: name.to_owned(), belief, flown_s: 0.0, latched: 0, suspicions: 0, suspected_s: 0.0 };
    for flight in flights {
        let vehicle = belief.of(&flight.vehicle);
        let mut watch = Watch::new(&vehicle);
        let mut before = Stage::Whole;
        for step in &flight.steps {
            let stage = watch.step(&vehicle, step);
            let is_new = std::mem::discriminant(&stage) != std::mem::discriminant(&before);
            match stage {
                Stage::Whole => {}
                Stage::Suspected(_) => {
                    found.suspected_s += STEP_S;
                    found.suspicions += usize::from(is_new);
                }
                Stage::Lost(_) => found.latched += usize::from(is_new),
            }
            before = stage;
        }
        found.flown_s += STEP_S * flight.steps.len() as f64;
    }
    found
}

/// Takes motors away, one after the other, all along them.
pub fn with_losses(name: &str, flights: &[&Recorded]) -> Vec<Found> {
    let one = |(loss_name, loss): (&'static str, Loss)| {
        let counts = Found {
            name: name.to_owned(),
            loss: loss_name,
            losses: 0,
            suspected_in_20_ms: 0,
            named_in_60_ms: 0,
            named_in_100_ms: 0,
            wrong: 0,
        };
        flights.iter().fold(counts, |counts, flight| take_away(flight, loss, counts))
    };
    LOSSES.into_iter().map(one).collect()
}

fn take_away(flight: &Recorded, loss: Loss, mut found: Found) -> Found {
    let mut watch = Watch::new(&flight.vehicle);
    // a motor that hardly lifts is not missed
    let lifts_from_n = 0.5 * flight.vehicle.lift_curve.lift(mean(&flight.steps) as f32);
    for (at, step) in flight.steps.iter().enumerate() {
        let is_due = at >= SETTLED_STEPS && (at - SETTLED_STEPS).is_multiple_of(BETWEEN_LOSSES_STEPS);
        let motor = at / BETWEEN_LOSSES_STEPS % 4;
        let lifts = |step: &Step| flight.vehicle.lift_curve.lift(step.motors[motor] as f32) > lifts_from_n;
        if is_due
            && lifts(step)
            && let Some(rest) = flight.steps.get(at..at + WATCHED_STEPS)
        {
            let (suspected, named) = first_seen(watch, &flight.vehicle, rest, motor, loss);
            found.losses += 1;
            let within = |step: usize, limit_s: f64| STEP_S * step as f64 <= limit_s + 1e-6;
            found.suspected_in_20_ms += usize::from(suspected.is_some_and(|step| within(step, 0.02)));
            let named_right = named.filter(|(which, _)| *which == motor);
            found.named_in_60_ms += usize::from(named_right.is_some_and(|(_, step)| within(step, 0.06)));
            found.named_in_100_ms += usize::from(named_right.is_some());
            found.wrong += usize::from(named.is_some_and(|(which, _)| which != motor));
        }
        watch.step(&flight.vehicle, step);
    }
    found
}

/// After how many steps this motor is suspected, and which one is given up when.
fn first_seen(
    mut watch: Watch,
    vehicle: &VehicleParameters,
    steps: &[Step],
    motor: usize,
    loss: Loss,
) -> (Option<usize>, Option<(usize, usize)>) {
    let mass_kg = 4.0 * f64::from(vehicle.lift_curve.lift(mean(steps) as f32)) / f64::from(vehicle.gravity_m_s2);
    let levers_m = [vehicle.lever_m(), vehicle.lever_m(), vehicle.torque_per_lift_m].map(f64::from);
    let mut turned_rad_s = [0.0; 3];
    let mut suspected = None;
    for (count, step) in steps.iter().enumerate() {
        let lift_n = f64::from(vehicle.lift_curve.lift(step.motors[motor] as f32));
        let since_s = STEP_S * count as f64;
        let missing_n = lift_n
            * match loss {
                Loss::Gone => 1.0,
                Loss::SpinsDown => -libm::expm1(-since_s / f64::from(vehicle.actuation.lag_s)),
                Loss::Part(share) => share,
            };
        let felt = Step {
            rate_rad_s: core::array::from_fn(|axis| step.rate_rad_s[axis] + turned_rad_s[axis]),
            force_z_m_s2: step.force_z_m_s2 + if count > 0 { missing_n / mass_kg } else { 0.0 },
            motors: step.motors,
        };
        for axis in 0..3 {
            let torque_nm = -f64::from(TORQUE_SIGNS[axis][motor]) * levers_m[axis] * missing_n;
            turned_rad_s[axis] += STEP_S * torque_nm / f64::from(vehicle.inertia_kg_m2[axis]);
        }
        match watch.step(vehicle, &felt) {
            Stage::Suspected(suspicion) if suspicion.motor == motor => suspected = suspected.or(Some(count)),
            Stage::Lost(which) => {
                let suspected = suspected.or((which == motor).then_some(count));
                return (suspected, Some((which, count)));
            }
            Stage::Suspected(_) | Stage::Whole => {}
        }
    }
    (suspected, None)
}

/// Of all motors' commands.
fn mean(steps: &[Step]) -> f64 {
    steps.iter().flat_map(|step| step.motors).sum::<f64>() / (4 * steps.len()) as f64
}

/// Both as tables.
pub fn table(quiet: &[Quiet], found: &[Found]) -> String {
    let mut text = String::from(
        "| log | believed gain, lag over identified | flown, s | given up | suspicions | under suspicion, % |\n\
         |---|---|---|---|---|---|\n",
    );
    for one in quiet {
        let Belief { gain, lag } = one.belief;
        text += &format!(
            "| {} | {gain}, {lag} | {:.0} | {} | {} | {:.2} |\n",
            one.name,
            one.flown_s,
            one.latched,
            one.suspicions,
            100.0 * one.suspected_s / one.flown_s,
        );
    }
    text += "\n| log | loss put in | times | suspected in 20 ms, % | named in 60 ms, % | in 100 ms, % | \
             another named |\n|---|---|---|---|---|---|---|\n";
    for one in found {
        let share = |count: usize| 100.0 * count as f64 / one.losses.max(1) as f64;
        text += &format!(
            "| {} | {} | {} | {:.1} | {:.1} | {:.1} | {} |\n",
            one.name,
            one.loss,
            one.losses,
            share(one.suspected_in_20_ms),
            share(one.named_in_60_ms),
            share(one.named_in_100_ms),
            one.wrong,
        );
    }
    text
}
