//! The extended model, and what it predicts for the rows of a window from a start state on.

use core::ops::Range;

use crate::axis::Axis;
use crate::effects::Effect;
use crate::model::VehicleModel;
use crate::prediction::Channel;
use crate::prediction::body::{Body, FLYING, Moment, State, TURNING, Turning, turning};
use crate::prediction::drive::{DirectInput, Drive};
use crate::prediction::force_track::{Commands, ForceAndSpin, ForceTrack, Step};
use crate::prediction::past::Past;
use crate::prediction::scene::{Passing, Scene};
use crate::vehicle::propulsion::Propulsion;
use crate::vehicle::{Airframe, Changes, NominalBody, signed_sums};

/// Most parts of a step of the body in which dry friction turns round, a millisecond or two each.
const DRY_PARTS: f64 = 8.0;
/// The rate changes in each by no more than this share of that within which friction turns round: 1e-4 of the
/// friction's impulse in a part is lost then.
const DRY_SHARE: f64 = 0.5;

/// A model with whatever effects it is given.
pub(crate) struct Model {
    /// None for separate axes.
    vehicle: Option<(Airframe, NominalBody)>,
    pub(crate) drive: Drive,
    /// What effects change of the vehicle's numbers.
    pub(crate) changes: Changes,
    pub(crate) body: Body,
    /// Moments beside the motors'.
    pub(crate) moments: Vec<Box<dyn Moment>>,
    /// Per axis, the rate within which a moment turns round while the rate goes through 0, rad/s.
    turns_round_rad_s: [Option<f64>; 3],
    /// True where a moment beside the motors' goes by an angle of a free vehicle.
    acts_by_angle: bool,
    /// True where one goes by its own axis' angle or rate.
    pub(super) restores: bool,
    /// True where one may act across separate axes.
    acts_across: bool,
}

/// What a log would report in the rows of a window.
pub(crate) struct Reports {
    turning: Vec<TurningReport>,
    /// Empty where the vehicle does not fly free.
    flying: Vec<FlyingReport>,
}

/// Angles and body rates in one row.
struct TurningReport {
    angle_rad: [f64; 3],
    rate_rad_s: [f64; 3],
}

/// What only a free vehicle reports in one row.
struct FlyingReport {
    force_m_s2: [f64; 3],
    velocity_ned_m_s: [f64; 3],
    height_m: f64,
}

impl Reports {
    /// What a channel reads in a row, counted from the first that was predicted.
    #[inline]
    pub(crate) fn at(&self, row: usize, channel: Channel) -> f64 {
        match channel {
            Channel::Angle(axis) => self.turning[row].angle_rad[axis.index()],
            Channel::Rate(axis) => self.turning[row].rate_rad_s[axis.index()],
            Channel::Force(axis) => self.flying[row].force_m_s2[axis.index()],
            Channel::Velocity(axis) => self.flying[row].velocity_ned_m_s[axis.index()],
            Channel::Height => self.flying[row].height_m,
        }
    }
}

/// How the numbers of a motion change: at a time, from a state, under what the motors do.
trait Change<const N: usize>: Fn(f64, &[f64; N], &ForceAndSpin) -> [f64; N] {}
impl<const N: usize, F: Fn(f64, &[f64; N], &ForceAndSpin) -> [f64; N]> Change<N> for F {}

impl Model {
    /// A vehicle with the effects that its model has.
    pub(crate) fn of(vehicle: &VehicleModel) -> Model {
        let (airframe, nominal) = (vehicle.airframe(), vehicle.nominal_body());
        let changes = vehicle.own_changes();
        let body = Body::of(airframe, nominal.changed(&changes.body));
        let mut model = Model {
            vehicle: Some((airframe, nominal)),
            drive: Drive::Motors(vehicle.propulsion),
            changes,
            body,
            moments: Vec::new(),
            turns_round_rad_s: [None; 3],
            acts_by_angle: false,
            restores: false,
            acts_across: false,
        };
        vehicle.effects.iter().for_each(|effect| model.add(effect));
        model
    }

    /// Separate axes, with the input gain of each and what they are driven by.
    pub(crate) fn of_axes(gain_rad_s2: [f64; 3], input: DirectInput) -> Model {
        Model {
            vehicle: None,
            drive: Drive::Direct(input),
            changes: Changes::default(),
            body: Body::Axes { gain_rad_s2, input },
            moments: Vec::new(),
            turns_round_rad_s: [None; 3],
            acts_by_angle: false,
            restores: false,
            acts_across: false,
        }
    }

    /// Adds an effect.
    pub(crate) fn add(&mut self, effect: &Effect) {
        effect.change(&mut self.changes);
        if let Some((airframe, nominal)) = self.vehicle {
            self.body = Body::of(airframe, nominal.changed(&self.changes.body));
        }
        if effect.has_moment() {
            self.moments.push(Box::new(*effect));
            self.acts_by_angle |= effect.acts_by_angle();
            self.restores |= effect.restores();
            self.acts_across |= !effect.keeps_to_axis();
        }
        if let (Some(axis), Some(rate_rad_s)) = (effect.axis(), effect.turns_round_rad_s()) {
            self.turns_round_rad_s[axis.index()] = Some(rate_rad_s);
        }
    }

    /// True of axes none of which changes anything of what is predicted of the others.
    pub(crate) fn has_separate_axes(&self) -> bool {
        matches!(self.body, Body::Axes { .. }) && !self.acts_across && self.changes.sensors.yaw_rad == 0.0
    }

    /// Sets the input gain of a separate axis; a vehicle has none.
    pub(crate) fn set_input_gain(&mut self, axis: Axis, own_rad_s2: f64) {
        if let Body::Axes { gain_rad_s2, .. } = &mut self.body {
            gain_rad_s2[axis.index()] = own_rad_s2;
        }
    }

    /// Sets where the line of lift over command meets no command, as a share of the lift at a command, which stays; on
    /// level `box` alone.
    pub(crate) fn set_lift_offset(&mut self, share: f64, at_command: f64) {
        if let Drive::Motors(Propulsion::Box(motor)) = &mut self.drive {
            *motor = motor.with_offset(share, at_command);
        }
    }

    /// Multiplies the reaction torque over lift; separate axes have none.
    pub(crate) fn scale_reaction_torque(&mut self, scale: f64) {
        if let Some((airframe, nominal)) = &mut self.vehicle {
            airframe.reaction_torque_per_lift_m *= scale;
            self.body = Body::of(*airframe, nominal.changed(&self.changes.body));
        }
    }

    /// The reports at the rows `first..end` from a state at the first of them; velocity and height stay at the start's
    /// where nobody looks at them, as do a free vehicle's angles.
    pub(crate) fn predict(&self, scene: &Scene<'_>, start: &State, first: usize, end: usize) -> Reports {
        let passing = Passing::from(scene, first);
        let air = &self.changes.air;
        let by_air = |at_s: f64| if air.turns() { air.torque_body_nm(passing.airspeed_m_s(at_s)) } else { [0.0; 3] };
        let mut flying = Vec::with_capacity(if self.body.flies_free() { end - first } else { 0 });
        // in air that does nothing no moment and no felt force knows where the vehicle flies
        let turning = if self.body.flies_free() && (scene.shows_travel || !self.changes.air.is_void()) {
            let change = |at_s: f64, x: &State, motors: &ForceAndSpin| {
                let by_air = (!scene.shows_velocity).then(|| by_air(at_s));
                self.body.flying_derivative(at_s, x, motors, &self.moments, &self.changes.air, by_air)
            };
            self.follow::<FLYING>(scene, start, first..end, change, |row, x| flying.push(self.flying(scene, row, x)))
        } else {
            let is_seen = scene.shows_attitude || self.acts_by_angle;
            let change = |at_s: f64, x: &Turning, motors: &ForceAndSpin| {
                let by_air = by_air(at_s);
                if !is_seen {
                    return self.body.spinning(at_s, x, motors, &self.moments, by_air);
                }
                let mut change = self.body.derivative(at_s, x, motors, &self.moments, by_air);
                if let Some(turn) = passing.turn(at_s, &self.changes.sensors) {
                    let both = turn.per_own.iter().zip(turn.by_others_rad_s);
                    change.iter_mut().zip(both).for_each(|(own, (per_own, others))| *own = per_own * *own + others);
                }
                change
            };
            let standing = |x: &Turning| {
                let ([a, b, c, d, e, f], [.., north, east, down, height]) = (*x, *start);
                [a, b, c, d, e, f, north, east, down, height]
            };
            self.follow::<TURNING>(scene, &turning(start), first..end, change, |row, x| {
                if self.body.flies_free() {
                    flying.push(self.flying(scene, row, &standing(x)));
                }
            })
        };
        Reports { turning, flying }
    }

    /// Reports of the turning at some rows; `at_row` sees every row's state.
    fn follow<const N: usize>(
        &self,
        scene: &Scene<'_>,
        start: &[f64; N],
        rows: Range<usize>,
        change: impl Change<N>,
        mut at_row: impl FnMut(usize, &[f64; N]),
    ) -> Vec<TurningReport> {
        let sensors = &self.changes.sensors;
        let mut reports = Vec::with_capacity(rows.len());
        let mut past = self.past(scene, start, rows.start, &change);
        let mut state = *start;
        for row in rows.clone() {
            let now = turned(&state);
            let rate_rad_s = sensors.gyro_rad_s(self.body.rate_body_rad_s(&now));
            let seen = past.seen(&now, scene.time_s[row], sensors.attitude_delay_s);
            let angle_rad = sensors.attitude_rad([seen[0], seen[1], seen[2]]);
            reports.push(TurningReport { angle_rad, rate_rad_s });
            at_row(row, &state);
            if row + 1 < rows.end {
                for step in scene.track.of_row(row) {
                    state = self.step(scene, step, &state, step.duration_s, &change);
                    past.remember(step.start_s + step.duration_s, &turned(&state));
                }
            }
        }
        reports
    }

    /// What a free vehicle's log reports beside its turning.
    fn flying(&self, scene: &Scene<'_>, row: usize, x: &State) -> FlyingReport {
        let factor = self.factors(scene, scene.time_s[row], scene.time_s[row]);
        let at_row = scene.track.at_row(row);
        let lifts_n = core::array::from_fn(|motor| factor[motor] * at_row[motor]);
        let force_m_s2 = self.changes.sensors.turned(self.body.felt_m_s2(x, &lifts_n, &self.changes.air));
        FlyingReport { force_m_s2, velocity_ned_m_s: [x[6], x[7], x[8]], height_m: x[9] }
    }

    /// One step of the body; backwards from its end where `duration_s` is negative.
    fn step<const N: usize>(
        &self,
        scene: &Scene<'_>,
        step: &Step,
        x: &[f64; N],
        duration_s: f64,
        change: &impl Change<N>,
    ) -> [f64; N] {
        let factor = self.factors(scene, step.start_s, step.start_s + 0.5 * step.duration_s);
        let motors = |place: f64| step.at(place, &factor);
        let (begin, from_s) =
            if duration_s < 0.0 { (1.0, step.start_s + step.duration_s) } else { (-1.0, step.start_s) };
        let mut first = change(from_s, x, &motors(begin));
        let count = self.parts(x, &first, duration_s);
        let parts = f64::from(count);
        let part_s = duration_s / parts;
        let mut state = *x;
        for part in 0..count {
            let passed = f64::from(part) / parts;
            let place = |share: f64| begin * (1.0 - 2.0 * (passed + share / parts));
            let part_from_s = from_s + passed * duration_s;
            if part > 0 {
                first = change(part_from_s, &state, &motors(place(0.0)));
            }
            let along = [motors(place(0.5)), motors(place(1.0))];
            state = runge_kutta_4(part_from_s, &state, &first, &along, part_s, change);
        }
        state
    }

    /// Into how many parts a step is cut, from how the state changes at its begin: more than one where a rate goes
    /// through 0 against dry friction.
    #[inline]
    fn parts<const N: usize>(&self, x: &[f64; N], change: &[f64; N], duration_s: f64) -> u8 {
        if self.turns_round_rad_s == [None; 3] {
            return 1;
        }
        let of_axis = |axis: usize| {
            let (within, passed_rad_s) = (self.turns_round_rad_s[axis]?, (change[3 + axis] * duration_s).abs());
            let turns_round = x[3 + axis].abs() < passed_rad_s + 4.0 * within;
            turns_round.then(|| (passed_rad_s / (DRY_SHARE * within)).ceil())
        };
        let parts = (0..3).filter_map(of_axis).fold(1.0, f64::max);
        parts.min(DRY_PARTS) as u8
    }

    /// The motion before a row, gone back from its state; nothing where no report is late.
    fn past<const N: usize>(&self, scene: &Scene<'_>, start: &[f64; N], first: usize, change: &impl Change<N>) -> Past {
        let mut states = Vec::new();
        let delay_s = self.changes.sensors.attitude_delay_s;
        if delay_s > 0.0 {
            let (mut state, mut row) = (*start, first);
            states.push((scene.time_s[first], turned(&state)));
            while row > 0 && scene.time_s[row] > scene.time_s[first] - delay_s {
                row -= 1;
                for step in scene.track.of_row(row).iter().rev() {
                    state = self.step(scene, step, &state, -step.duration_s, change);
                    states.push((step.start_s, turned(&state)));
                }
            }
            states.reverse();
        }
        Past { states }
    }

    /// What the moments beside the motors' add to the angular accelerations, rad/s^2, level and at rest.
    pub(crate) fn acceleration_by_moments(&self) -> [f64; 3] {
        let (rest, no_force) = ([0.0; TURNING], ForceAndSpin::default());
        let with = self.body.derivative(0.0, &rest, &no_force, &self.moments, [0.0; 3]);
        let without = self.body.derivative(0.0, &rest, &no_force, &[], [0.0; 3]);
        core::array::from_fn(|axis| with[3 + axis] - without[3 + axis])
    }

    /// What air that comes from ahead adds to the angular acceleration about pitch, level, rad/s^2 per m/s.
    pub(crate) fn acceleration_per_airspeed(&self) -> f64 {
        let [ahead, still] = [1.0, 0.0].map(|north| [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, north, 0.0, 0.0, f64::MAX]);
        let change =
            |x: &State| self.body.flying_derivative(0.0, x, &ForceAndSpin::default(), &[], &self.changes.air, None);
        change(&ahead)[4] - change(&still)[4]
    }

    /// What one unit of each command adds to the angular accelerations, rad/s^2, level and settled.
    pub(crate) fn acceleration_per_command(&self, commands: &[f64; 4]) -> [[f64; 3]; 4] {
        const STEP: f64 = 0.01;
        let acceleration = |commands: &[f64; 4]| -> [f64; 3] {
            let settled = ForceAndSpin { force: self.settled_lifts(commands), ..ForceAndSpin::default() };
            let change = self.body.derivative(0.0, &[0.0; TURNING], &settled, &[], [0.0; 3]);
            [change[3], change[4], change[5]]
        };
        core::array::from_fn(|i| {
            let [mut less, mut more] = [*commands; 2];
            (less[i], more[i]) = (less[i] - STEP, more[i] + STEP);
            let (less, more) = (acceleration(&less), acceleration(&more));
            core::array::from_fn(|axis| (more[axis] - less[axis]) / (2.0 * STEP))
        })
    }

    /// What one unit of an axis' command adds to its angular acceleration, rad/s^2: of a vehicle around a command of
    /// all motors, each of which has half of an axis' command.
    pub(crate) fn acceleration_per_axis_command(&self, around: f64) -> [f64; 3] {
        if let Body::Axes { gain_rad_s2, .. } = &self.body {
            return *gain_rad_s2;
        }
        let by_motor = self.acceleration_per_command(&[around; 4]);
        Axis::ALL.map(|axis| 0.5 * signed_sums(by_motor.map(|of_motor| of_motor[axis.index()]))[axis.index()])
    }

    /// The four forces once lag and motors have settled, each motor's own factor in them; a battery is as at the start.
    pub(crate) fn settled_lifts(&self, commands: &[f64; 4]) -> [f64; 4] {
        let settled = self.drive.settled(commands, &self.changes.chain.path);
        core::array::from_fn(|motor| self.changes.chain.lift.scale[motor] * settled[motor])
    }

    /// Factors on the lifts at a time, the battery's voltage read at another.
    fn factors(&self, scene: &Scene<'_>, volts_at_s: f64, at_s: f64) -> [f64; 4] {
        let lift = &self.changes.chain.lift;
        let passed_s = at_s - scene.time_s[0];
        let drop_v = if lift.loss_per_volt == 0.0 { Some(0.0) } else { scene.volts_lost(volts_at_s) };
        lift.at(passed_s, drop_v.unwrap_or_else(|| lift.battery.drop_v(passed_s)))
    }
}

/// The part of a motion's numbers that turns.
#[inline]
fn turned<const N: usize>(x: &[f64; N]) -> Turning {
    const { assert!(N >= TURNING) };
    core::array::from_fn(|i| x[i])
}

/// Runge-Kutta 4, given how the state changes at the beginning, under what the motors do in the middle and at the end.
#[inline]
fn runge_kutta_4<const N: usize>(
    from_s: f64,
    x: &[f64; N],
    k1: &[f64; N],
    [middle, last]: &[ForceAndSpin; 2],
    duration_s: f64,
    change: &impl Change<N>,
) -> [f64; N] {
    let along = |k: &[f64; N], scale: f64| -> [f64; N] { core::array::from_fn(|i| x[i] + scale * k[i]) };
    let half_s = 0.5 * duration_s;
    let k2 = change(from_s + half_s, &along(k1, half_s), middle);
    let k3 = change(from_s + half_s, &along(&k2, half_s), middle);
    let k4 = change(from_s + duration_s, &along(&k3, duration_s), last);
    core::array::from_fn(|i| x[i] + duration_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

/// The forces of a model under commands, from row to row.
pub(crate) fn track(model: &Model, rows_s: &[f64], commands: &Commands) -> ForceTrack {
    ForceTrack::new(rows_s, commands, &model.changes.chain.path, &model.drive)
}
