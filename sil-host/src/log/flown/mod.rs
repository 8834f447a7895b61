//! Which part of a log flew, found from the log alone: a log often begins long before the motors start and ends long
//! after they stop, and what the ground does to a vehicle is not the vehicle's.
//!
//! A *flight* is a stretch in which the motors lift. Where the log has a collective (motors, or a thrust command), that
//! is where it lies above half of what it usually is while the motors run: lift goes with its square or less, so that
//! below half no vehicle is held up; less than a second below is a manoeuvre. Where the motors are steered on and the
//! vehicle turns, as on a bench, which needs no lift, or in a dive, a low collective is no idling: on the ground motors
//! may be steered too, but turn nothing. Take-off and landing are left out (`ground`). Without a collective nothing
//! says more than the rows in which the motors run ([`Log::active_rows`]).
//!
//! A flight ends before a *crash*: within its last seconds the accelerometer shows a blow, or at the end the vehicle
//! lies on its side or back, however long. *Saturation* and *end stops* are shown, not cut: the diagnosis knows the
//! former, and a stop is certain only to who sees the bench.

mod ground;

use self::ground::off_the_ground;
use super::runs::runs;
use super::{Log, LogError, Quantity};
use crate::axis::Axis;
use crate::statistics::{median, wrapped};
use crate::vehicle::signed_sums;
use std::ops::Range;

/// So many flights of a log are told.
const LISTED_MAX: usize = 5;
/// Share of the usual collective below which nothing is held up.
const IDLE: f64 = 0.5;
/// Motors that do less than this share of the usual collective turn idly or stand, however they differ.
const NOTHING: f64 = 0.05;
/// A shorter time below is a manoeuvre, and a shorter one above a test of the motors, s.
const SHORTEST_S: f64 = 1.0;
/// Motors whose commands differ by this share of what they usually do, each as a share of the collective, steer: idling
/// motors are told one and the same.
const STEERED: f64 = 0.2;
/// A vehicle whose rates are, over [`STANDS_S`], this share of what they are while its motors lift stands.
const STANDS: f64 = 0.03;
/// So long it must stand, s: any swing has a turning point.
const STANDS_S: f64 = 0.5;
/// A blow is looked for so long before a flight's end, or before the vehicle lay down, s.
const CRASH_WITHIN_S: f64 = 3.0;
/// What happens before a crash belongs to it: the motors or the pilot gave up, s.
const BEFORE_CRASH_S: f64 = 0.5;
/// No quadrotor's motors push so hard, m/s^2: 10 g.
const BLOW_M_S2: f64 = 98.0;
/// Cosine of a tilt from which no quadrotor is held up.
const COS_LYING: f64 = 0.17;
/// A command this near to its end is at it.
const AT_LIMIT: f64 = 0.005;
/// A turn that is stopped by so many times the usual deviation of angular accelerations is stopped by a thing.
const STOPPED: f64 = 6.0;
/// As near to its extreme as this share of its range an angle is at its end.
const AT_END: f64 = 0.1;
/// What motors do within so long shows in the turn, s.
const PUSH_S: f64 = 0.1;
/// So many times at least an end stop is hit before it is called one.
const STOPS_MIN: usize = 3;

/// A stretch in which the vehicle flew, or a bench's motors ran.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Its first row, s.
    pub from_s: f64,
    /// Its last row, s.
    pub to_s: f64,
    /// Why it begins there.
    pub began: &'static str,
    /// Why it ends there.
    pub ended: &'static str,
}

/// What flew.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flown {
    /// In the order of time; none where nothing was recognised as a flight.
    pub flights: Vec<Flight>,
    /// What else was seen in them: saturation, end stops.
    pub notes: Vec<String>,
}

impl Flown {
    /// Looks for it.
    pub fn of(log: &Log) -> Flown {
        let active = log.active_rows();
        let collective = log.collective().unwrap_or_else(|| vec![1.0; log.rows()]);
        let (mut lifts, usual) = lifting(&log.time_s, &collective, &active);
        keep_what_is_steered(log, &active, (&collective, usual), &mut lifts);
        fill_short(&log.time_s, &mut lifts);
        let flights: Vec<Flight> = stretches(&lifts)
            .into_iter()
            .filter(|rows| lifts[rows.start])
            .map(|rows| flight(log, off_the_ground(log, &collective, usual, rows)))
            .filter(|flight| flight.to_s - flight.from_s >= SHORTEST_S)
            .collect();
        let mut notes: Vec<String> = saturation(log, &flights).into_iter().collect();
        if !log.shows_free_flight() {
            notes.extend([Axis::Roll, Axis::Pitch].into_iter().filter_map(|axis| end_stop(log, axis, &flights)));
        }
        Flown { flights, notes }
    }

    /// The part of a log that flew: all flights, or one of them counted from 1. The log says what was taken and why.
    ///
    /// # Errors
    /// There is no such flight, in words that list them; or it has too few rows.
    pub fn part(&self, log: &Log, flight: Option<usize>) -> Result<Log, FlownError> {
        let chosen: Vec<&Flight> = match flight {
            None => self.flights.iter().collect(),
            Some(number) => {
                let found = number.checked_sub(1).and_then(|index| self.flights.get(index));
                vec![found.ok_or_else(|| FlownError::NoSuchFlight { number, list: self.list() })?]
            }
        };
        let ends = [log.time_s.first(), log.time_s.last()].map(|time_s| time_s.copied().unwrap_or_default());
        let spans: Vec<[f64; 2]> = chosen.iter().map(|flight| [flight.from_s, flight.to_s]).collect();
        let mut part = match log.within(&spans) {
            Ok(part) => part,
            // nothing like a flight: better the whole log than none
            Err(_) if flight.is_none() => {
                let mut whole = log.clone();
                whole.notes.insert(0, "no part was recognised as a flight: the whole log is taken".to_owned());
                return Ok(whole);
            }
            Err(error) => return Err(FlownError::Log(error)),
        };
        let said = if part.rows() == log.rows() {
            format!("flown: the whole log, {:.2} s", log.duration_s())
        } else {
            let which = match (flight, self.flights.len()) {
                (Some(number), count) => format!("flight {number} of {count}"),
                (None, 1) => "one flight".to_owned(),
                (None, count) => format!("{count} flights (--flight N takes one)"),
            };
            let mut list: Vec<String> = chosen.iter().take(LISTED_MAX).map(|flight| flight.to_string()).collect();
            if chosen.len() > LISTED_MAX {
                list.push(format!("{} more (--flight 0 lists all)", chosen.len() - LISTED_MAX));
            }
            format!("flown: {which}: {}; of {:.2} s to {:.2} s (--whole takes all)", list.join("; "), ends[0], ends[1])
        };
        part.notes.splice(0..0, std::iter::once(said).chain(self.notes.iter().cloned()));
        Ok(part)
    }

    /// All flights, a line each.
    fn list(&self) -> String {
        let line = |(index, flight): (usize, &Flight)| format!("\n  {}: {flight}", index + 1);
        self.flights.iter().enumerate().map(line).collect()
    }
}

impl std::fmt::Display for Flight {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{:.2} s ({}) to {:.2} s ({})", self.from_s, self.began, self.to_s, self.ended)
    }
}

/// Why there is no such part.
#[derive(Debug, thiserror::Error)]
pub enum FlownError {
    /// The file has other flights.
    #[error("--flight {number}: the log has no such flight; it has:{list}")]
    NoSuchFlight {
        /// As it was asked for.
        number: usize,
        /// What there is.
        list: String,
    },
    /// It is too short.
    #[error(transparent)]
    Log(LogError),
}

/// Rows in which the motors lift, by the collective alone, and what the collective usually is in them.
pub(super) fn lifting(time_s: &[f64], collective: &[f64], active: &[bool]) -> (Vec<bool>, f64) {
    let usual = usual(collective, active);
    let mut lifts: Vec<bool> =
        collective.iter().zip(active).map(|(value, active)| *active && *value > IDLE * usual).collect();
    fill_short(time_s, &mut lifts);
    (lifts, usual)
}

/// The collective of flight: of what lies above half of the most there is, the middle, so that a long idle does not
/// count.
fn usual(collective: &[f64], active: &[bool]) -> f64 {
    let mut running: Vec<f64> =
        collective.iter().zip(active).filter(|(value, active)| **active && **value > 0.0).map(|(c, _)| *c).collect();
    running.sort_by(f64::total_cmp);
    let Some(most) = running.get(running.len() * 19 / 20) else { return 0.0 };
    let high = &running[running.partition_point(|value| *value <= IDLE * most)..];
    median(high.to_vec())
}

/// Stretches of rows of one kind.
fn stretches<T: PartialEq>(kinds: &[T]) -> Vec<Range<usize>> {
    runs(kinds.len(), |row| kinds[row] == kinds[row - 1])
}

/// A low collective between lifting stretches, or beside one, is part of the flight where the axes are steered.
fn keep_what_is_steered(log: &Log, active: &[bool], (collective, usual): (&[f64], f64), lifts: &mut [bool]) {
    let steering = steering(log);
    // root mean square of what turns the axes, as a share of the collective
    let share = |rows: &[usize]| {
        let square = |row: usize| steering.iter().map(|values| values[row] * values[row]).sum::<f64>();
        let squares: f64 = rows.iter().map(|row| square(*row)).sum();
        let collective: f64 = rows.iter().map(|row| collective[*row]).sum();
        if collective > 0.0 { f64::sqrt(squares * rows.len() as f64) / collective } else { 0.0 }
    };
    let lifting: Vec<usize> = (0..lifts.len()).filter(|row| lifts[*row]).collect();
    let usual_share = share(&lifting);
    let stands = standing(log, &lifting);
    // motors at nothing stand, whatever the log says of its active rows
    let runs = (0..lifts.len()).map(|row| (lifts[row], active[row] && collective[row] > 0.0));
    for rows in stretches(&runs.collect::<Vec<(bool, bool)>>()) {
        let low: Vec<usize> = rows.clone().collect();
        let runs = active[rows.start] && collective[rows.start] > 0.0;
        let mean = low.iter().map(|row| collective[*row]).sum::<f64>() / low.len().max(1) as f64;
        let does_something = runs && mean > NOTHING * usual;
        if !lifts[rows.start] && does_something && usual_share > 0.0 && share(&low) > STEERED * usual_share {
            rows.for_each(|row| lifts[row] = !stands[row]);
        }
    }
}

/// In which rows the vehicle turns about no axis; in none where the log has no rates.
fn standing(log: &Log, lifting: &[usize]) -> Vec<bool> {
    let rates: Vec<&[f64]> = Axis::ALL.iter().filter_map(|axis| log.column(Quantity::Rate(*axis))).collect();
    let square = |row: usize| rates.iter().map(|rate| rate[row] * rate[row]).sum::<f64>();
    let usual = lifting.iter().map(|row| square(*row)).sum::<f64>() / lifting.len().max(1) as f64;
    let mut stands = vec![false; log.rows()];
    let (mut from, mut sum) = (0, 0.0);
    for row in 0..log.rows() {
        sum += square(row);
        while log.time_s[from] < log.time_s[row] - STANDS_S {
            sum -= square(from);
            from += 1;
        }
        if sum < STANDS * STANDS * usual * (row + 1 - from) as f64 {
            stands[from..=row].fill(true);
        }
    }
    stands
}

/// What turns the axes that the log has commands of.
fn steering(log: &Log) -> Vec<Vec<f64>> {
    Axis::ALL.iter().filter_map(|axis| steering_of(log, *axis)).collect()
}

/// What turns an axis: its command, or the part that the motors' commands have in it.
fn steering_of(log: &Log, axis: Axis) -> Option<Vec<f64>> {
    let Some(motors) = log.motors() else { return log.column(Quantity::Command(axis)).map(<[f64]>::to_vec) };
    let part = |row: usize| signed_sums(motors.map(|motor| motor[row]))[axis.index()];
    Some((0..log.rows()).map(part).collect())
}

/// A short time below is a manoeuvre, then a short one above is a test of the motors.
fn fill_short(time_s: &[f64], lifts: &mut [bool]) {
    [false, true].iter().for_each(|kind| fill(time_s, lifts, *kind));
}

/// Turns stretches of one kind that are too short to mean it, at the ends of a log too, but for lifting ones there.
fn fill(time_s: &[f64], kinds: &mut [bool], kind: bool) {
    let mut from = 0;
    while from < kinds.len() {
        let end = (from..kinds.len()).find(|row| kinds[*row] != kinds[from]).unwrap_or(kinds.len());
        let until_s = time_s[end.min(kinds.len() - 1)];
        let is_inside = from > 0 && end < kinds.len();
        if kinds[from] == kind && is_inside && until_s - time_s[from] < SHORTEST_S {
            kinds[from..end].fill(!kind);
        }
        from = end;
    }
}

/// The flight of some rows, without a crash at its end.
fn flight(log: &Log, Range { start: from, end }: Range<usize>) -> Flight {
    let began = if from == 0 { "the log begins" } else { "it lifts off, or the motors start" };
    let ended = if end == log.rows() { "the log ends" } else { "it lands, or the motors stop" };
    let (from_s, to_s) = (log.time_s[from], log.time_s[end - 1]);
    // a vehicle on its back may lie there for long, its motors running; one that never is upright wears its sensor so
    let lying = (from..end).rev().take_while(|row| is_lying(log, *row)).last().filter(|row| *row > from);
    let crashed_s = lying.map_or(to_s, |row| log.time_s[row]);
    let looked_at = log.time_s[from..end].partition_point(|time_s| *time_s < crashed_s - CRASH_WITHIN_S) + from;
    let blow = (looked_at..end).find(|row| blow_m_s2(log, *row).is_some_and(|blow| blow > BLOW_M_S2));
    match (blow, lying) {
        (None, None) => Flight { from_s, to_s, began, ended },
        (first, other) => {
            let row = first.unwrap_or(end).min(other.unwrap_or(end));
            let ended = if first.is_some() { "a crash: a blow" } else { "a crash: it lies" };
            Flight { from_s, to_s: (log.time_s[row] - BEFORE_CRASH_S).max(from_s), began, ended }
        }
    }
}

/// The size of the specific force.
fn blow_m_s2(log: &Log, row: usize) -> Option<f64> {
    let part = |axis: Axis| Some(log.column(Quantity::Accel(axis))?[row]);
    let squares: Option<f64> = Axis::ALL.into_iter().map(|axis| part(axis).map(|value| value * value)).sum();
    squares.map(f64::sqrt)
}

fn is_lying(log: &Log, row: usize) -> bool {
    let cos = |axis: Axis| log.column(Quantity::Angle(axis)).map_or(1.0, |angle| libm::cos(angle[row]));
    cos(Axis::Roll) * cos(Axis::Pitch) < COS_LYING
}

fn is_in(flights: &[Flight], time_s: f64) -> bool {
    flights.iter().any(|flight| (flight.from_s..=flight.to_s).contains(&time_s))
}

/// In how many of the flights' rows a motor is at an end of its range.
fn saturation(log: &Log, flights: &[Flight]) -> Option<String> {
    let motors = log.motors()?;
    let rows: Vec<usize> = (0..log.rows()).filter(|row| is_in(flights, log.time_s[*row])).collect();
    let share = |is_at: &dyn Fn(f64) -> bool| {
        let at = rows.iter().filter(|row| motors.iter().any(|motor| is_at(motor[**row]))).count();
        100.0 * at as f64 / rows.len().max(1) as f64
    };
    let (full, stopped) = (share(&|command| command > 1.0 - AT_LIMIT), share(&|command| command < AT_LIMIT));
    (full + stopped >= 1.0)
        .then(|| format!("in {full:.0} % of the flown rows a motor is at full command, in {stopped:.0} % at none"))
}

/// An end of an angle's range at which turns are stopped as no motor stops them: a pilot's or a controller's limit of
/// tilt is an end of the range too, at which the motors push back.
fn end_stop(log: &Log, axis: Axis, flights: &[Flight]) -> Option<String> {
    let angle = log.column(Quantity::Angle(axis))?;
    let rate = log.column(Quantity::Rate(axis))?;
    let rows: Vec<usize> = (0..log.rows().saturating_sub(1)).filter(|row| is_in(flights, log.time_s[*row])).collect();
    let acceleration = |row: usize| (rate[row + 1] - rate[row]) / (log.time_s[row + 1] - log.time_s[row]);
    // a normal deviation is 1.48 times the median of sizes
    let usual = 1.48 * median(rows.iter().map(|row| acceleration(*row).abs()).collect());
    let pushed = pushes(log, axis, &rows);
    let (least, most) = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), row| {
        let angle_rad = wrapped(angle[*row]);
        (least.min(angle_rad), most.max(angle_rad))
    });
    let hits_at = |end_rad: f64, outward: f64| {
        let is_hit = |row: &&usize| {
            let is_near = (wrapped(angle[**row]) - end_rad).abs() < AT_END * (most - least);
            let is_stopped = outward * rate[**row] > 0.0 && -outward * acceleration(**row) > STOPPED * usual;
            is_near && is_stopped && !pushed(**row, -outward)
        };
        let hits: Vec<f64> = rows.iter().filter(is_hit).map(|row| log.time_s[*row]).collect();
        // one hit may take several rows
        hits.windows(2).filter(|pair| pair[1] - pair[0] > 0.1).count() + usize::from(!hits.is_empty())
    };
    let said: Vec<String> = [(least, -1.0), (most, 1.0)]
        .into_iter()
        .map(|(end_rad, outward)| (end_rad, hits_at(end_rad, outward)))
        .filter(|(_, hits)| *hits >= STOPS_MIN)
        .map(|(end_rad, hits)| format!("{:.0} deg ({hits} times)", end_rad.to_degrees()))
        .collect();
    (!said.is_empty()).then(|| {
        format!("{} seems to hit an end stop at {}: cut it away with --from, --to", axis.name(), said.join(" and "))
    })
}

/// Do motors push one way before a row, by more than they usually do?
fn pushes<'a>(log: &'a Log, axis: Axis, rows: &[usize]) -> impl Fn(usize, f64) -> bool + 'a {
    let steering = steering_of(log, axis);
    let squares = steering.iter().flat_map(|of| rows.iter().map(|row| of[*row] * of[*row])).sum::<f64>();
    let usual = (squares / rows.len().max(1) as f64).sqrt();
    move |row, way| {
        let Some(steering) = &steering else { return false };
        let from = log.time_s.partition_point(|time_s| *time_s < log.time_s[row] - PUSH_S);
        steering[from..=row].iter().any(|steered| way * steered > usual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared_control::airframe::TORQUE_SIGNS;

    /// Rows at 100 Hz of motors at one command each.
    fn log_of(commands: &[(f64, f64)]) -> Log {
        let mut log = Log { axes: [true, true, false], ..Log::default() };
        let mut motors = Vec::new();
        for (duration_s, command) in commands {
            motors.extend(std::iter::repeat_n(*command, (100.0 * duration_s) as usize));
        }
        log.time_s = (0..motors.len()).map(|row| 0.01 * row as f64).collect();
        log.motor_command = core::array::from_fn(|_| Some(motors.clone()));
        log
    }

    fn spans(log: &Log) -> Vec<[f64; 2]> {
        let round = |time_s: f64| (10.0 * time_s).round() / 10.0;
        Flown::of(log).flights.iter().map(|flight| [round(flight.from_s), round(flight.to_s)]).collect()
    }

    #[test]
    fn idle_and_stopped_motors_are_no_flight_and_several_flights_are_told_apart() {
        let log = log_of(&[(2.0, 0.0), (3.0, 0.1), (8.0, 0.5), (5.0, 0.05), (4.0, 0.55), (6.0, 0.0)]);
        assert_eq!(spans(&log), [[5.0, 13.0], [18.0, 22.0]]);
        let flown = Flown::of(&log);
        assert!(flown.flights[0].began.contains("lifts off"));
        let both = flown.part(&log, None).unwrap();
        assert_eq!(both.rows(), 1200);
        assert!(both.notes[0].contains("2 flights") && both.notes[0].contains("--whole"), "{:?}", both.notes);
        assert_eq!(flown.part(&log, Some(2)).unwrap().rows(), 400);
        for number in [0, 3] {
            let message = flown.part(&log, Some(number)).unwrap_err().to_string();
            assert!(message.contains("no such flight") && message.contains("2: 18.00 s"), "{message}");
        }
    }

    #[test]
    fn a_low_collective_is_idling_only_where_nothing_is_steered() {
        let mut log = log_of(&[(2.0, 0.0), (8.0, 0.5), (5.0, 0.1), (2.0, 0.0)]);
        log.motor_command[0]
            .iter_mut()
            .flatten()
            .enumerate()
            .for_each(|(row, command)| *command *= 1.0 + 0.1 * libm::sin(row as f64));
        let steered = log.clone();
        assert_eq!(spans(&steered), [[2.0, 15.0]]);
        log.motor_command[0].as_mut().unwrap()[1000..1500].fill(0.1);
        assert_eq!(spans(&log), [[2.0, 10.0]]);
    }

    /// PX4's stopped motors of a vehicle that waits on the ground: [0, 0.002, 0, 0.002], which differ by all they are.
    #[test]
    fn motors_that_do_next_to_nothing_are_no_flight_however_they_differ() {
        let mut log = log_of(&[(6.0, 0.0), (8.0, 0.5), (5.0, 0.0)]);
        for motor in [1, 3] {
            log.motor_command[motor].iter_mut().flatten().for_each(|command| *command = command.max(0.002));
        }
        log.rate_rad_s = [Some((0..1900).map(|row| 0.1 * libm::sin(row as f64)).collect()), None, None];
        assert_eq!(spans(&log), [[6.0, 14.0]]);
    }

    #[test]
    fn on_the_ground_motors_may_be_steered_but_turn_nothing() {
        let mut log = log_of(&[(6.0, 0.1), (8.0, 0.5), (5.0, 0.1)]);
        let steer = |(row, command): (usize, &mut f64)| *command *= 1.0 + 0.1 * libm::sin(row as f64);
        log.motor_command[0].iter_mut().flatten().enumerate().for_each(steer);
        let turns = |from: usize, to: usize| {
            let rate = |row: usize| if (from..to).contains(&row) { libm::sin(0.1 * row as f64) } else { 1e-3 };
            [Some((0..1900).map(rate).collect()), None, None]
        };
        // it dives with idling motors, which only its turns tell from standing
        for (from, to) in [(600, 1400), (200, 1900), (0, 1900)] {
            log.rate_rad_s = turns(from, to);
            let found = spans(&log);
            assert!(found.len() == 1 && (found[0][0] - 0.01 * from as f64).abs() < 0.6, "{from} {found:?}");
            assert!((found[0][1] - 0.01 * to as f64).abs() < 0.6, "{to} {found:?}");
        }
    }

    #[test]
    fn a_dive_is_a_manoeuvre_and_a_test_of_the_motors_no_flight() {
        let log = log_of(&[(1.0, 0.0), (0.3, 0.5), (3.0, 0.0), (5.0, 0.5), (0.6, 0.1), (5.0, 0.6), (2.0, 0.0)]);
        assert_eq!(spans(&log), [[4.3, 14.9]]);
    }

    #[test]
    fn a_bench_whose_motors_run_throughout_flies_from_end_to_end() {
        let log = log_of(&[(3.0, 0.3), (3.0, 0.35), (3.0, 0.3)]);
        let part = Flown::of(&log).part(&log, None).unwrap();
        assert_eq!(part.time_s, log.time_s);
        assert!(part.notes[0].contains("the whole log"), "{:?}", part.notes);
        // without a collective nothing says when
        let silent = Log { motor_command: [None, None, None, None], ..log.clone() };
        assert_eq!(spans(&silent), [[0.0, 9.0]]);
    }

    #[test]
    fn a_flight_ends_before_its_crash() {
        let mut log = log_of(&[(10.0, 0.5), (5.0, 0.0)]);
        let flying = |row: usize| if row == 880 { 150.0 } else { -9.8 };
        log.accel_body_m_s2 = [Some(vec![0.0; 1500]), Some(vec![0.0; 1500]), Some((0..1500).map(flying).collect())];
        assert_eq!(spans(&log), [[0.0, 8.3]]);
        log.accel_body_m_s2 = [None, None, None];
        log.angle_rad = [Some((0..1500).map(|row| if row < 940 { 0.1 } else { 1.7 }).collect()), None, None];
        assert_eq!(spans(&log), [[0.0, 8.9]]);
        assert_eq!(Flown::of(&log).flights[0].ended, "a crash: it lies");
        // it lay for long, its motors running
        log.angle_rad[0] = Some((0..1500).map(|row| if row < 340 { 0.1 } else { 3.1 }).collect());
        assert_eq!(spans(&log), [[0.0, 2.9]]);
        // a sensor that is mounted upside down is no crash
        log.angle_rad[0] = Some(vec![3.1; 1500]);
        assert_eq!(Flown::of(&log).flights[0].ended, "it lands, or the motors stop");
    }

    #[test]
    fn what_is_no_flight_at_all_is_taken_whole() {
        let log = log_of(&[(5.0, 0.0)]);
        let part = Flown::of(&log).part(&log, None).unwrap();
        assert_eq!(part.rows(), 500);
        assert!(part.notes[0].contains("no part was recognised"), "{:?}", part.notes);
    }

    #[test]
    fn end_stops_and_saturation_are_shown() {
        // a ball between two walls: a constant rate that turns around in one row
        let mut log = log_of(&[(20.0, 1.0)]);
        let phase = |row: usize| row % 200;
        let rate = |row: usize| if phase(row) < 100 { 1.0 } else { -1.0 };
        let angle = |row: usize| 0.01 * (if phase(row) < 100 { phase(row) } else { 200 - phase(row) }) as f64;
        log.rate_rad_s[0] = Some((0..2000).map(|row| rate(row) + 1e-3 * libm::sin(row as f64)).collect());
        log.angle_rad[0] = Some((0..2000).map(angle).collect());
        let notes = Flown::of(&log).notes.join("; ");
        assert!(notes.contains("100 % of the flown rows a motor is at full command"), "{notes}");
        assert!(notes.contains("roll seems to hit an end stop at 0 deg") && notes.contains("57 deg"), "{notes}");
        // nothing stops what flies free
        let free = Log { comments: vec!["free flight".to_owned()], ..log.clone() };
        assert!(!Flown::of(&free).notes.join("; ").contains("end stop"));
        // motors that turn it back are no stop: a controller's limit of tilt
        let turning_back = |row: usize| match phase(row) {
            95..105 => -0.1,
            195..200 | 0..5 => 0.1,
            _ => 0.0,
        };
        let mut limited = log.clone();
        for (motor, sign) in TORQUE_SIGNS[0].into_iter().enumerate() {
            let command = |row: usize| 0.5 + f64::from(sign) * turning_back(row);
            limited.motor_command[motor] = Some((0..2000).map(command).collect());
        }
        assert!(!Flown::of(&limited).notes.join("; ").contains("end stop"), "{:?}", Flown::of(&limited).notes);
        // the same turning smoothly
        let swing = |of: fn(f64) -> f64| Some((0..2000).map(|row| of(0.05 * row as f64)).collect());
        log.rate_rad_s[0] = swing(libm::cos);
        log.angle_rad[0] = swing(|t| 0.2 * libm::sin(t));
        assert!(!Flown::of(&log).notes.join("; ").contains("end stop"));
    }
}
