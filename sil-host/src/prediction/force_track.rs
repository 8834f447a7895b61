//! From the logged commands to the forces that turn the vehicle: delay, clipping, lag, ESC, motor, rotor.
//!
//! What the motors do depends on the commands alone, not on the motion, so it is computed once per log and reused by
//! every window. The motors are integrated in fine steps that end at every change of a command, the body in coarser
//! ones; per coarse step the force's mean and first moment are kept, with which a rigid body's step is exact in impulse
//! and in displacement whatever the force does within it. So are those of the rotors' net spin and of its change.

use super::drive::{Drive, QUICKEST_S};
use super::drive_curve::DriveCurve;
use crate::vehicle::propulsion::{Propulsion, RotorState};
use crate::vehicle::{CommandPath, NetSpin, StraightLine, on_the_way, spin_sum};

/// Longest step of a vehicle's body, s.
const BODY_STEP_MAX_S: f64 = 5e-3;
/// The same of separate axes, whose forces are straight lines: where 15 1/s brake them, Runge-Kutta 4 errs by 6e-7 of a
/// rate in one; a sine of 10 Hz is read to 5e-5.
const AXES_STEP_MAX_S: f64 = 10e-3;
/// Longest step of the motors as a share of what is quickest in them: the thesis' motors ring with 98 Hz, 1.6 ms for
/// the reciprocal of that in rad/s, and take 0.4 ms. Runge-Kutta 4 then errs by 8e-6 of an exponential.
const MOTOR_STEP_SHARE: f64 = 0.25;
/// The same of the lag before them, whose exponential is exact; Simpson's rule loses 2e-5 of it.
const LAG_STEP_SHARE: f64 = 0.5;
/// Of a longer interval between two rows only the end is followed, s: a gap, so that no window holds it; what the
/// commands were in it nobody knows, and few motors remember more.
pub(super) const INTERVAL_MAX_S: f64 = 2.0;
/// A step shorter than this is rounding of a time.
const TIME_ROUNDING_S: f64 = 1e-9;

/// Commands, each in force until the next.
#[derive(Clone, Debug)]
pub(crate) struct Commands {
    /// When they are given, s.
    pub(crate) time_s: Vec<f64>,
    /// Motors 1 to 4, or (roll, pitch, yaw, 0).
    pub(crate) value: Vec<[f64; 4]>,
}

/// What the motors do at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ForceAndSpin {
    /// The four forces.
    pub(crate) force: [f64; 4],
    /// How the rotors turn; still without motors.
    pub(crate) spin: NetSpin,
}

/// One step of the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Where it begins, s.
    pub(crate) start_s: f64,
    /// How long it is, s.
    pub(crate) duration_s: f64,
    /// Mean over the step.
    mean: ForceAndSpin,
    /// Half the change of the straight line with the mean and the first moment.
    half_change: ForceAndSpin,
}

impl Step {
    /// Along the step, from -1 at its beginning to 1 at its end, with factors on the forces.
    #[inline]
    pub(crate) fn at(&self, place: f64, factor: &[f64; 4]) -> ForceAndSpin {
        let (mean, half_change) = (&self.mean, &self.half_change);
        let acceleration_rad_s2 = mean.spin.acceleration_rad_s2 + place * half_change.spin.acceleration_rad_s2;
        ForceAndSpin {
            force: core::array::from_fn(|i| factor[i] * (mean.force[i] + place * half_change.force[i])),
            spin: NetSpin {
                speed_rad_s: mean.spin.speed_rad_s + place * half_change.spin.speed_rad_s,
                acceleration_rad_s2,
            },
        }
    }
}

/// The forces over a whole log.
#[derive(Clone, Debug)]
pub(crate) struct ForceTrack {
    steps: Vec<Step>,
    /// Per row, which step begins there.
    first_step: Vec<usize>,
    /// Per row, the forces before its own command acts.
    at_row: Vec<[f64; 4]>,
}

impl ForceTrack {
    /// Follows the commands through path and drive, everything settled at the first command; steps end at the rows of a
    /// log.
    pub(crate) fn new(rows_s: &[f64], commands: &Commands, path: &CommandPath, drive: &Drive) -> ForceTrack {
        let mut track = ForceTrack {
            steps: Vec::new(),
            first_step: Vec::with_capacity(rows_s.len()),
            at_row: Vec::with_capacity(rows_s.len()),
        };
        let mut motors = Motors::settled(commands, path, drive);
        let step_max_s = match drive {
            Drive::Motors(_) => BODY_STEP_MAX_S,
            Drive::Direct(_) => AXES_STEP_MAX_S,
        };
        for interval in rows_s.windows(2) {
            track.first_step.push(track.steps.len());
            track.at_row.push(motors.forces());
            let from_s = interval[0].max(interval[1] - INTERVAL_MAX_S);
            let count = ((interval[1] - from_s) / step_max_s - 1e-6).ceil().max(1.0);
            let duration_s = (interval[1] - from_s) / count;
            for k in 0..count as usize {
                let start_s = from_s + k as f64 * duration_s;
                track.steps.push(motors.body_step(commands, start_s, duration_s));
            }
        }
        track.first_step.push(track.steps.len());
        track.at_row.push(motors.forces());
        track
    }

    /// Number of its steps.
    pub(crate) fn len(&self) -> usize {
        self.steps.len()
    }

    /// The steps from one row to a later one.
    pub(crate) fn between(&self, first_row: usize, end_row: usize) -> &[Step] {
        &self.steps[self.first_step[first_row]..self.first_step[end_row]]
    }

    /// The forces at a row, before its own command acts.
    pub(crate) fn at_row(&self, row: usize) -> [f64; 4] {
        self.at_row[row]
    }

    /// The steps from one row to the next.
    pub(crate) fn of_row(&self, row: usize) -> &[Step] {
        self.between(row, row + 1)
    }
}

/// Commands on their way and motors in motion.
struct Motors<'a> {
    path: &'a CommandPath,
    drive: &'a Drive,
    /// Longest step, s.
    step_max_s: f64,
    /// Row whose command has arrived, and the one that arrives next.
    row: usize,
    arrived: [f64; 4],
    /// Behind the lag.
    lagged: [f64; 4],
    /// A step, s, the share of its way that the lag has left after half of it, and that over the step as a line.
    half_left: (f64, f64),
    line_left: StraightLine,
    /// What that makes the motors do: computed only where the command changes.
    driving: [f64; 4],
    /// The same over a command, where it is costly.
    curve: Option<DriveCurve>,
    rotors: RotorState,
    /// How the rotors change at the end of the last step, if nothing has changed since.
    change: Option<RotorState>,
}

impl<'a> Motors<'a> {
    fn settled(commands: &Commands, path: &'a CommandPath, drive: &'a Drive) -> Motors<'a> {
        let arrived = drive.clipped(commands.value.first().copied().unwrap_or_default(), path);
        let (mut rotors, mut curve) = ([0.0; 8], None);
        if let Drive::Motors(propulsion) = drive {
            curve = DriveCurve::of(propulsion);
            for motor in 0..4 {
                let settled = propulsion.equilibrium(path.bent(arrived[motor]));
                (rotors[motor], rotors[4 + motor]) = (settled.speed_rad_s, settled.current_a);
            }
        }
        let lag_step_s = match drive {
            Drive::Motors(_) if path.lag_s > 0.0 => LAG_STEP_SHARE * path.lag_s.max(QUICKEST_S),
            _ => f64::INFINITY,
        };
        let step_max_s = lag_step_s.min(MOTOR_STEP_SHARE * drive.quickest_s().max(QUICKEST_S));
        Motors {
            path,
            drive,
            step_max_s,
            row: 0,
            arrived,
            lagged: arrived,
            half_left: (0.0, 1.0),
            line_left: StraightLine::default(),
            driving: drive.of_commands(&drive.bent(arrived, path)),
            curve,
            rotors,
            change: None,
        }
    }

    /// What commands make the motors do.
    fn driven(&self, commands: &[f64; 4]) -> [f64; 4] {
        let bent = self.drive.bent(*commands, self.path);
        match &self.curve {
            Some(curve) => bent.map(|command| curve.at(command)),
            None => self.drive.of_commands(&bent),
        }
    }

    /// The forces now.
    fn forces(&self) -> [f64; 4] {
        match self.drive {
            Drive::Direct(_) => self.driving,
            Drive::Motors(propulsion) => propulsion.lifts_n(&self.driving, &self.rotors),
        }
    }

    /// The rotors' net spin now, rad/s.
    fn spin_rad_s(&self) -> f64 {
        let [a, b, c, d, ..] = self.rotors;
        spin_sum([a, b, c, d])
    }

    /// One step of the body, in motor steps that end where a command arrives.
    fn body_step(&mut self, commands: &Commands, start_s: f64, duration_s: f64) -> Step {
        let (end_s, centre_s) = (start_s + duration_s, start_s + 0.5 * duration_s);
        let (mut sum, mut moment) = ([0.0; 5], [0.0; 5]);
        let spin_before = self.spin_rad_s();
        let mut now_s = start_s;
        while now_s < end_s - TIME_ROUNDING_S {
            let next_change_s = self.receive(commands, now_s);
            let until_s = end_s.min(next_change_s);
            let count = ((until_s - now_s) / self.step_max_s - 1e-6).ceil().max(1.0);
            let step_s = (until_s - now_s) / count;
            for _ in 0..count as usize {
                let [begin, middle, end] = self.motor_step(step_s);
                for i in 0..5 {
                    // Simpson's rule for each and for each times its distance from the centre
                    let at = now_s - centre_s;
                    sum[i] += step_s / 6.0 * (begin[i] + 4.0 * middle[i] + end[i]);
                    moment[i] +=
                        step_s / 6.0 * (begin[i] * at + 4.0 * middle[i] * (at + 0.5 * step_s) + end[i] * (at + step_s));
                }
                now_s += step_s;
            }
            now_s = until_s;
        }
        let [force @ .., speed_rad_s]: Tracked = core::array::from_fn(|i| sum[i] / duration_s);
        let [force_change @ .., speed_change]: Tracked =
            core::array::from_fn(|i| 6.0 * moment[i] / (duration_s * duration_s));
        // the integrals of the acceleration and of its first moment, the latter by parts
        let (before, after) = (spin_before, self.spin_rad_s());
        let acceleration_rad_s2 = (after - before) / duration_s;
        let acceleration_change = 6.0 * (0.5 * (before + after) - speed_rad_s) / duration_s;
        let of = |force, speed_rad_s, acceleration_rad_s2| ForceAndSpin {
            force,
            spin: NetSpin { speed_rad_s, acceleration_rad_s2 },
        };
        Step {
            start_s,
            duration_s,
            mean: of(force, speed_rad_s, acceleration_rad_s2),
            half_change: of(force_change, speed_change, acceleration_change),
        }
    }

    /// Takes the commands that have arrived by now; when the next one will.
    fn receive(&mut self, commands: &Commands, now_s: f64) -> f64 {
        loop {
            let Some(next_s) = commands.time_s.get(self.row + 1) else { return f64::INFINITY };
            let arrival_s = next_s + self.path.delay_s;
            if arrival_s > now_s + TIME_ROUNDING_S {
                return arrival_s;
            }
            self.row += 1;
            self.arrived = self.drive.clipped(commands.value[self.row], self.path);
            if self.path.lag_s <= 0.0 {
                self.lagged = self.arrived;
                self.driving = self.driven(&self.arrived);
                self.change = None;
            }
        }
    }

    /// At the begin, in the middle and at the end of a step under one command.
    fn motor_step(&mut self, step_s: f64) -> [Tracked; 3] {
        let (begin, behind) = (self.driving, self.lagged);
        let (middle, end) = if self.path.lag_s > 0.0 {
            if step_s != self.half_left.0 {
                self.half_left = (step_s, self.path.left_after(0.5 * step_s));
                self.line_left = self.path.line_left(step_s);
            }
            let (_, half_left) = self.half_left;
            let after = |left: f64| on_the_way(behind, self.arrived, left);
            let (middle, end) = (after(half_left), after(half_left * half_left));
            self.lagged = end;
            (self.driven(&middle), self.driven(&end))
        } else {
            (begin, begin)
        };
        self.driving = end;
        match self.drive {
            // Simpson's rule of a straight line is exact, so that one step serves however short the lag is
            Drive::Direct(_) if self.path.lag_s > 0.0 => {
                let StraightLine { mean, half_change } = self.line_left;
                let left = [mean - half_change, mean, mean + half_change];
                left.map(|left| tracked(self.driven(&on_the_way(behind, self.arrived, left)), 0.0))
            }
            Drive::Direct(_) => [begin, middle, end].map(|force| tracked(force, 0.0)),
            Drive::Motors(propulsion) => {
                let drives = [begin, middle, end];
                let mut step = RotorStep { rotors: self.rotors, change: self.change };
                let along = match propulsion {
                    Propulsion::Box(_) => drives.map(|lifts_n| tracked(lifts_n, 0.0)),
                    Propulsion::Generic(rotor) => {
                        step.along(&drives, step_s, |d, x| rotor.derivative(d, x), |speed| rotor.lift_n(speed))
                    }
                    Propulsion::Device(device) => {
                        step.along(&drives, step_s, |d, x| device.derivative(d, x), |speed| device.lift_n(speed))
                    }
                };
                (self.rotors, self.change) = (step.rotors, step.change);
                along
            }
        }
    }
}

/// The four forces, then the rotors' net spin, rad/s.
type Tracked = [f64; 5];

fn tracked([a, b, c, d]: [f64; 4], spin_rad_s: f64) -> Tracked {
    [a, b, c, d, spin_rad_s]
}

/// The four rotors, and how they change where that is known already.
struct RotorStep {
    rotors: RotorState,
    change: Option<RotorState>,
}

impl RotorStep {
    /// One step (Runge-Kutta 4), and lifts and spin at its begin, middle and end; the speed in the middle by the cubic
    /// through both ends.
    #[inline]
    fn along(
        &mut self,
        drives: &[[f64; 4]; 3],
        step_s: f64,
        derivative: impl Fn(&[f64; 4], &RotorState) -> RotorState,
        lift_n: impl Fn(f64) -> f64,
    ) -> [Tracked; 3] {
        let rotors = self.rotors;
        let shifted =
            |by: &RotorState, scale: f64| -> RotorState { core::array::from_fn(|i| rotors[i] + scale * by[i]) };
        let k1 = self.change.unwrap_or_else(|| derivative(&drives[0], &rotors));
        let k2 = derivative(&drives[1], &shifted(&k1, 0.5 * step_s));
        let k3 = derivative(&drives[1], &shifted(&k2, 0.5 * step_s));
        let k4 = derivative(&drives[2], &shifted(&k3, step_s));
        let mut end: RotorState =
            core::array::from_fn(|i| rotors[i] + step_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        for speed in &mut end[..4] {
            *speed = speed.max(0.0);
        }
        let slope = derivative(&drives[2], &end);
        let middle: [f64; 4] = core::array::from_fn(|i| 0.5 * (rotors[i] + end[i]) + step_s / 8.0 * (k1[i] - slope[i]));
        let at = |speeds: [f64; 4]| tracked(core::array::from_fn(|motor| lift_n(speeds[motor])), spin_sum(speeds));
        let speeds = |[a, b, c, d, ..]: RotorState| [a, b, c, d];
        (self.rotors, self.change) = (end, Some(slope));
        [at(speeds(rotors)), at(middle), at(speeds(end))]
    }
}
