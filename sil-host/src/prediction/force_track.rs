//! From the logged commands to the forces that turn the vehicle: delay, clipping, lag, ESC, motor, rotor.
//!
//! What the motors do depends on the commands alone, not on the motion, so it is computed once per log and reused by
//! every window. The motors are integrated in fine steps that end at every change of a command, the body in coarser
//! ones; per coarse step the force's mean and first moment are kept, with which a rigid body's step is exact in impulse
//! and in displacement whatever the force does within it. So are those of the rotors' net spin and of its change.

use super::drive::{Drive, QUICKEST_S};
use super::drive_curve::DriveCurve;
use super::rotor_step::{RotorStep, Tracked, tracked};
use crate::vehicle::propulsion::{GenericRotor, Propulsion, RotorState};
use crate::vehicle::{CommandPath, NetSpin, StraightLine, on_the_way, spin_sum};

/// Longest step of a vehicle's body, s.
const BODY_STEP_MAX_S: f64 = 5e-3;
/// The same of separate axes, whose forces are straight lines: where 15 1/s brake them, Runge-Kutta 4 errs by 6e-7 of a
/// rate in one; a sine of 10 Hz is read to 5e-5.
const AXES_STEP_MAX_S: f64 = 10e-3;
/// Longest step of the motors as a share of what is quickest in them: the thesis' motors ring with 98 Hz, 1.6 ms for
/// the reciprocal of that in rad/s, and take 0.4 ms. Runge-Kutta 4 then errs by 8e-6 of an exponential.
const MOTOR_STEP_SHARE: f64 = 0.25;
/// The same of the lag before them, of whose exponential mean and first moment are exact over any step.
const LAG_STEP_SHARE: f64 = 0.5;
/// Steps of the body, as a share of the rotors' lag, up to which the targets within one are taken as the straight line
/// with their mean and first moment. Speeds in the end miss what third moments of the lag's memory make of the rest:
/// (h/T)^3 / 2 times at most 0.032 of what the targets range over in the step, 1.6e-5.
const AVERAGED_SHARE: f64 = 0.1;
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
    /// What the command makes the motors do where there is no lag, once somebody asked.
    driving: Option<[f64; 4]>,
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
        Motors { path, drive, step_max_s, row: 0, arrived, lagged: arrived, driving: None, curve, rotors, change: None }
    }

    /// What commands make the motors do.
    fn driven(&self, commands: &[f64; 4]) -> [f64; 4] {
        let bent = self.drive.bent(*commands, self.path);
        match &self.curve {
            Some(curve) => bent.map(|command| curve.at(command)),
            None => self.drive.of_commands(&bent),
        }
    }

    /// What drives the motors now.
    fn driving(&mut self) -> [f64; 4] {
        if self.path.lag_s > 0.0 {
            return self.driven(&self.lagged);
        }
        let driving = self.driving.unwrap_or_else(|| self.driven(&self.lagged));
        self.driving = Some(driving);
        driving
    }

    /// The forces now.
    fn forces(&mut self) -> [f64; 4] {
        let driving = self.driving();
        match self.drive {
            Drive::Direct(_) => driving,
            Drive::Motors(propulsion) => propulsion.lifts_n(&driving, &self.rotors),
        }
    }

    /// The rotors' net spin now, rad/s.
    fn spin_rad_s(&self) -> f64 {
        let [a, b, c, d, ..] = self.rotors;
        spin_sum([a, b, c, d])
    }

    /// One step of the body: in motor steps that end where a command arrives, or in a single one.
    fn body_step(&mut self, commands: &Commands, start_s: f64, duration_s: f64) -> Step {
        let spin_before = self.spin_rad_s();
        let mut sums = Sums::about(start_s + 0.5 * duration_s);
        match self.drive {
            Drive::Motors(Propulsion::Generic(rotor)) if duration_s < AVERAGED_SHARE * rotor.time_constant_s => {
                let along = self.averaged_step(rotor, commands, start_s, duration_s);
                sums.add(start_s, duration_s, &along);
            }
            _ => self.motor_steps(commands, start_s, start_s + duration_s, &mut sums),
        }
        let [force @ .., speed_rad_s]: Tracked = sums.sum.map(|sum| sum / duration_s);
        let [force_change @ .., speed_change]: Tracked = core::array::from_fn(|i| sums.half_change(i, duration_s));
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

    /// The motors' own steps up to a time.
    fn motor_steps(&mut self, commands: &Commands, start_s: f64, end_s: f64, sums: &mut Sums<5>) {
        let mut now_s = start_s;
        while now_s < end_s - TIME_ROUNDING_S {
            let until_s = end_s.min(self.receive(commands, now_s));
            let count = ((until_s - now_s) / self.step_max_s - 1e-6).ceil().max(1.0);
            let step_s = (until_s - now_s) / count;
            for _ in 0..count as usize {
                sums.add(now_s, step_s, &self.motor_step(step_s));
                now_s += step_s;
            }
            now_s = until_s;
        }
    }

    /// One step of slow rotors under the straight line that has the mean and the first moment of what is commanded
    /// behind the lag, however many commands arrive in it.
    fn averaged_step(
        &mut self,
        rotor: &GenericRotor,
        commands: &Commands,
        start_s: f64,
        duration_s: f64,
    ) -> [Tracked; 3] {
        let end_s = start_s + duration_s;
        let mut sums = Sums::about(start_s + 0.5 * duration_s);
        let mut now_s = start_s;
        while now_s < end_s - TIME_ROUNDING_S {
            let until_s = end_s.min(self.receive(commands, now_s));
            sums.add(now_s, until_s - now_s, &self.behind_lag(until_s - now_s));
            now_s = until_s;
        }
        let target = |place: f64| -> [f64; 4] {
            self.driven(&core::array::from_fn(|i| sums.sum[i] / duration_s + place * sums.half_change(i, duration_s)))
        };
        let mut step = RotorStep { rotors: self.rotors, change: None };
        let along = step.lagging(rotor, &[-1.0, 0.0, 1.0].map(target), duration_s);
        self.rotors = step.rotors;
        along
    }

    /// What is behind the lag over a time under one command: at its ends and in the middle of the straight line that
    /// has the same mean and first moment, so that no lag is the limit of a short one.
    fn behind_lag(&mut self, duration_s: f64) -> [[f64; 4]; 3] {
        if self.path.lag_s <= 0.0 {
            return [self.arrived; 3];
        }
        let StraightLine { mean, half_change } = self.path.line_left(duration_s);
        let (behind, arrived) = (self.lagged, self.arrived);
        // a lag's mean over a time says how much of it is left in the end
        self.lagged = on_the_way(behind, arrived, 1.0 - mean * duration_s / self.path.lag_s);
        [mean - half_change, mean, mean + half_change].map(|left| on_the_way(behind, arrived, left))
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
                (self.driving, self.change) = (None, None);
            }
        }
    }

    /// At the begin, in the middle and at the end of a step under one command.
    fn motor_step(&mut self, step_s: f64) -> [Tracked; 3] {
        let targets = if self.path.lag_s > 0.0 {
            self.behind_lag(step_s).map(|commands| self.driven(&commands))
        } else {
            [self.driving(); 3]
        };
        let Drive::Motors(propulsion) = self.drive else { return targets.map(|force| tracked(force, 0.0)) };
        let mut step = RotorStep { rotors: self.rotors, change: self.change };
        let along = match propulsion {
            Propulsion::Box(_) => targets.map(|lifts_n| tracked(lifts_n, 0.0)),
            Propulsion::Generic(rotor) => step.lagging(rotor, &targets, step_s),
            Propulsion::Device(device) => {
                step.along(&targets, step_s, |d, x| device.derivative(d, x), |speed| device.lift_n(speed))
            }
        };
        self.rotors = step.rotors;
        // the next step's line behind a lag does not begin where this one ends
        self.change = step.change.filter(|_| self.path.lag_s <= 0.0);
        along
    }
}

/// Integrals of some quantities and of their first moments about a time, by Simpson's rule.
struct Sums<const N: usize> {
    about_s: f64,
    sum: [f64; N],
    moment: [f64; N],
}

impl<const N: usize> Sums<N> {
    fn about(about_s: f64) -> Sums<N> {
        Sums { about_s, sum: [0.0; N], moment: [0.0; N] }
    }

    /// A part of the time, the quantities at its begin, in its middle and at its end.
    #[inline]
    fn add(&mut self, from_s: f64, duration_s: f64, [begin, middle, end]: &[[f64; N]; 3]) {
        let (at, share) = (from_s - self.about_s, duration_s / 6.0);
        for i in 0..N {
            self.sum[i] += share * (begin[i] + 4.0 * middle[i] + end[i]);
            self.moment[i] +=
                share * (begin[i] * at + 4.0 * middle[i] * (at + 0.5 * duration_s) + end[i] * (at + duration_s));
        }
    }

    /// Half the change of the straight line with a quantity's mean and first moment over a time.
    fn half_change(&self, i: usize, duration_s: f64) -> f64 {
        6.0 * self.moment[i] / (duration_s * duration_s)
    }
}
