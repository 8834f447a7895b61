//! The extended model, and what it predicts for the rows of a window from a start state on.

use crate::diagnosis::effects::SOFTENING_RAD_S;
use crate::diagnosis::vehicle::actuation::{Chain, Commands, Drive, ForceTrack, Step};
use crate::diagnosis::vehicle::body::{Body, Moment, State};
use crate::diagnosis::vehicle::sensor::Sensors;

/// Parts of a step of the body in which dry friction turns round, a millisecond or two.
const DRY_PARTS: u8 = 8;

/// A model with whatever effects it is given; [`crate::diagnosis::effects::Effect::apply`] changes it.
pub(in crate::diagnosis) struct Model {
    pub(in crate::diagnosis) drive: Drive,
    pub(in crate::diagnosis) chain: Chain,
    /// Factors on the four lifts.
    pub(in crate::diagnosis) lift_factor: [f64; 4],
    /// Loss of lift per second.
    pub(in crate::diagnosis) sag_per_s: f64,
    /// Loss of lift per volt that the battery has lost.
    pub(in crate::diagnosis) sag_per_volt: f64,
    pub(in crate::diagnosis) body: Body,
    pub(in crate::diagnosis) moments: Vec<Box<dyn Moment>>,
    pub(in crate::diagnosis) sensors: Sensors,
    /// Axes with dry friction, whose moment turns round while the rate goes through 0.
    pub(in crate::diagnosis) dry: [bool; 3],
}

/// Angles (roll, pitch, yaw) and body rates (p, q, r) as a log would report them.
pub(in crate::diagnosis) type Report = [f64; 6];

impl Model {
    /// Nothing but the nominal vehicle.
    pub(in crate::diagnosis) fn nominal(drive: Drive, body: Body) -> Model {
        Model {
            drive,
            chain: Chain::NOMINAL,
            lift_factor: [1.0; 4],
            sag_per_s: 0.0,
            sag_per_volt: 0.0,
            body,
            moments: Vec::new(),
            sensors: Sensors::NOMINAL,
            dry: [false; 3],
        }
    }

    /// The reports at the rows `first..end` from a state at the first of them.
    pub(in crate::diagnosis) fn predict(
        &self,
        scene: &Scene<'_>,
        start: &State,
        first: usize,
        end: usize,
    ) -> Vec<Report> {
        let mut reports = Vec::with_capacity(end - first);
        let mut past = Past::before(self, scene, start, first);
        let mut state = *start;
        for row in first..end {
            let rate = self.sensors.rate_rad_s(&self.body, &state);
            let angle = self.sensors.angle_rad(&past.seen(&state, scene.time_s[row], self.sensors.attitude_delay_s));
            reports.push([angle[0], angle[1], angle[2], rate[0], rate[1], rate[2]]);
            if row + 1 < end {
                for step in scene.track.of_row(row) {
                    state = self.step(scene, step, &state, step.duration_s);
                    past.remember(step.start_s + step.duration_s, &state);
                }
            }
        }
        reports
    }

    /// One step of the body; backwards from its end where `duration_s` is negative.
    fn step(&self, scene: &Scene<'_>, step: &Step, x: &State, duration_s: f64) -> State {
        let factor = self.factors(scene, step);
        // the forces along the step, from -1 at its beginning to 1 at its end
        let force = |place: f64| -> [f64; 4] {
            core::array::from_fn(|i| factor[i] * (step.mean[i] + place * step.half_change[i]))
        };
        let (begin, from_s) =
            if duration_s < 0.0 { (1.0, step.start_s + step.duration_s) } else { (-1.0, step.start_s) };
        let count = self.parts(from_s, x, &force(begin), duration_s);
        let parts = f64::from(count);
        let part_s = duration_s / parts;
        let mut state = *x;
        for part in 0..count {
            let passed = f64::from(part) / parts;
            let place = |share: f64| begin * (1.0 - 2.0 * (passed + share / parts));
            let forces = [force(place(0.0)), force(place(0.5)), force(place(1.0))];
            state = self.part(from_s + passed * duration_s, &state, &forces, part_s);
        }
        state
    }

    /// Into how many parts a step is cut: more than one where a rate goes through 0 against dry friction.
    fn parts(&self, from_s: f64, x: &State, force: &[f64; 4], duration_s: f64) -> u8 {
        if self.dry == [false; 3] {
            return 1;
        }
        let change = self.body.derivative(from_s, x, force, &self.moments);
        let turns_round = (0..3).any(|axis| {
            let passed_rad_s = (change[3 + axis] * duration_s).abs();
            self.dry[axis]
                && passed_rad_s > 0.25 * SOFTENING_RAD_S
                && x[3 + axis].abs() < passed_rad_s + 4.0 * SOFTENING_RAD_S
        });
        if turns_round { DRY_PARTS } else { 1 }
    }

    /// Runge-Kutta 4.
    fn part(&self, from_s: f64, x: &State, [first, middle, last]: &[[f64; 4]; 3], duration_s: f64) -> State {
        let along = |k: &State, scale: f64| -> State { core::array::from_fn(|i| x[i] + scale * k[i]) };
        let derivative = |at_s, x: &State, force| self.body.derivative(at_s, x, force, &self.moments);
        let half_s = 0.5 * duration_s;
        let k1 = derivative(from_s, x, first);
        let k2 = derivative(from_s + half_s, &along(&k1, half_s), middle);
        let k3 = derivative(from_s + half_s, &along(&k2, half_s), middle);
        let k4 = derivative(from_s + duration_s, &along(&k3, duration_s), last);
        core::array::from_fn(|i| x[i] + duration_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// What one unit of each command adds to the angular accelerations, rad/s^2, level and settled.
    pub(in crate::diagnosis) fn acceleration_per_command(&self, commands: &[f64; 4]) -> [[f64; 3]; 4] {
        const STEP: f64 = 0.01;
        let acceleration = |commands: &[f64; 4]| -> [f64; 3] {
            let change = self.body.derivative(0.0, &[0.0; 6], &self.drive.settled(commands), &[]);
            [change[3], change[4], change[5]]
        };
        core::array::from_fn(|i| {
            let [mut less, mut more] = [*commands; 2];
            (less[i], more[i]) = (less[i] - STEP, more[i] + STEP);
            let (less, more) = (acceleration(&less), acceleration(&more));
            core::array::from_fn(|axis| (more[axis] - less[axis]) / (2.0 * STEP))
        })
    }

    fn factors(&self, scene: &Scene<'_>, step: &Step) -> [f64; 4] {
        let mut common = 1.0 - self.sag_per_s * (step.start_s + 0.5 * step.duration_s - scene.time_s[0]);
        if self.sag_per_volt != 0.0 {
            common -= self.sag_per_volt * scene.volts_lost(step.start_s);
        }
        self.lift_factor.map(|factor| factor * common)
    }
}

/// What a log gives to a model: its times, the forces that its commands make, its battery.
pub(in crate::diagnosis) struct Scene<'a> {
    pub(in crate::diagnosis) time_s: &'a [f64],
    pub(in crate::diagnosis) track: &'a ForceTrack,
    /// Per row, what the battery has lost against the first second, V; empty where the log has no voltage.
    pub(in crate::diagnosis) volts_lost: &'a [f64],
}

impl Scene<'_> {
    fn volts_lost(&self, time_s: f64) -> f64 {
        let row = self.time_s.partition_point(|at| *at <= time_s).saturating_sub(1);
        self.volts_lost.get(row).copied().unwrap_or_default()
    }
}

/// The forces of a model under commands, from row to row.
pub(in crate::diagnosis) fn track(model: &Model, rows_s: &[f64], commands: &Commands) -> ForceTrack {
    ForceTrack::new(rows_s, commands, &model.chain, &model.drive)
}

/// States a little back in time, for an attitude that is reported late.
struct Past {
    states: Vec<(f64, State)>,
}

impl Past {
    /// The motion before the first row, gone back from its state; nothing where no report is late.
    fn before(model: &Model, scene: &Scene<'_>, start: &State, first: usize) -> Past {
        let mut states = Vec::new();
        let delay_s = model.sensors.attitude_delay_s;
        if delay_s > 0.0 {
            let (mut state, mut row) = (*start, first);
            states.push((scene.time_s[first], state));
            while row > 0 && scene.time_s[row] > scene.time_s[first] - delay_s {
                row -= 1;
                for step in scene.track.of_row(row).iter().rev() {
                    state = model.step(scene, step, &state, -step.duration_s);
                    states.push((step.start_s, state));
                }
            }
            states.reverse();
        }
        Past { states }
    }

    fn remember(&mut self, time_s: f64, state: &State) {
        if !self.states.is_empty() {
            self.states.push((time_s, *state));
        }
    }

    /// The state whose attitude is reported now: a straight line between neighbours corrected by their rates (angles of the
    /// gimbal and of separate axes; when free the body's rates stand in, to the accuracy of half a step).
    fn seen(&self, now: &State, now_s: f64, delay_s: f64) -> State {
        if self.states.is_empty() {
            return *now;
        }
        let at_s = now_s - delay_s;
        let after = self.states.partition_point(|(time_s, _)| *time_s < at_s);
        let (Some((t1, x1)), Some((t0, x0))) = (self.states.get(after), self.states.get(after.wrapping_sub(1))) else {
            return self.states.first().map_or(*now, |(time_s, state)| drifted(state, at_s - time_s));
        };
        let (h, s) = (t1 - t0, (at_s - t0) / (t1 - t0));
        let mut seen = *x0;
        for i in 0..3 {
            // Hermite's cubic; its slope terms act on h/4 of the difference of rates at most
            let (s2, s3) = (s * s, s * s * s);
            seen[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * x0[i]
                + (s3 - 2.0 * s2 + s) * h * x0[3 + i]
                + (3.0 * s2 - 2.0 * s3) * x1[i]
                + (s3 - s2) * h * x1[3 + i];
        }
        seen
    }
}

fn drifted(state: &State, by_s: f64) -> State {
    let mut drifted = *state;
    for i in 0..3 {
        drifted[i] += by_s * state[3 + i];
    }
    drifted
}
