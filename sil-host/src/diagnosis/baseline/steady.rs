//! What steady flight needs of the motors. Over a whole flight a vehicle hardly accelerates on average, so that the
//! mean commands balance all constant moments and the weight: they show what pulls, whether or not the log excites
//! anything, and whether or not it has gyro and attitude.

use super::numbers::{Number, NumberOf};
use crate::axis::Axis;
use crate::diagnosis::Estimate;
use crate::log::Log;
use crate::log::sanity::Figure;
use crate::prediction::window::{Window, windows};
use crate::prediction::{NotPredictable, Subject};
use crate::statistics::median;
use crate::vehicle::signed_sums;

/// The median's deviation over the mean's, of many normal values.
const OF_MEDIAN: f64 = 1.2533;
/// A normal variable's deviation over its median absolute one.
const OF_ABSOLUTE: f64 = 1.4826;
/// Neighbouring windows that have about one independent value.
const BLOCK: f64 = 4.0;

/// Change of each motor's command per unit of an axis' command, for a log that does not say: that of commands in -1..1
/// which are half the motors' signed sum, as this project's.
const PER_AXIS_COMMAND: f64 = 0.5;

/// In a steady flight the mean command of all but a third of the windows is within a tenth of the median, and motors
/// are steered in them: run-ups on the ground, idling, hops and acrobatics balance no weight.
const STRAYS: f64 = 0.1;
const STRAYING_MAX: f64 = 1.0 / 3.0;

/// Steady commands of a flight.
pub(super) struct Steady {
    /// Trims and collective, of vehicles that no rig holds.
    pub(super) numbers: Vec<Number>,
    pub(super) collective: Option<f64>,
    pub(super) battery_v: Option<f64>,
    pub(super) knows_motors: bool,
    /// False where the mean command strays too much for any of them to balance weight and moments.
    pub(super) is_steady: bool,
}

/// What stands for all windows' mean commands.
pub(super) type Centre = fn(Vec<f64>) -> Centred;

/// A number of all windows, and the figure that it is, for a record that is compared with another one of its flight.
#[derive(Clone)]
pub(super) struct Centred {
    own: Estimate,
    figure: Option<Figure>,
}

/// The steady commands of a log.
///
/// # Errors
/// The log has no window.
pub(super) fn steady(log: &Log, subject: &Subject<'_>, centre: Centre) -> Result<Steady, NotPredictable> {
    let windows = windows(log)?;
    let means_of = |command: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let mean = |start: usize, end: usize| (start..end).map(command).sum::<f64>() / (end - start).max(1) as f64;
        windows.iter().map(|window| mean(window.start, window.end)).collect()
    };
    let centre_of = |command: &dyn Fn(usize) -> f64| -> Centred { centre(means_of(command)) };
    let motors = log.motors();
    let stands = |window: &Window| {
        let is_one =
            |motor: &[f64]| motor[window.start..window.end].iter().all(|command| *command == motor[window.start]);
        motors.is_some_and(|motors| motors.into_iter().all(is_one))
    };
    let standing: Vec<bool> = windows.iter().map(stands).collect();
    let is_steady = log.collective().is_none_or(|collective| is_steady(&means_of(&|row| collective[row]), &standing));
    let collective = log.collective().map(|collective| centre_of(&|row| collective[row]));
    let trim = |axis: Axis| match (motors, &log.axis_command[axis.index()]) {
        (Some(motors), _) => Some(centre_of(&|row| 0.25 * signed_sums(motors.map(|motor| motor[row]))[axis.index()])),
        (None, Some(command)) => {
            let per_command = log.motor_per_axis_command.map_or(PER_AXIS_COMMAND, |per| per[axis.index()]);
            Some(centre_of(&|row| per_command * command[row]))
        }
        (None, None) => None,
    };
    let mut numbers = Vec::new();
    if !subject.is_held() {
        let trims = Axis::ALL.into_iter().filter_map(|axis| Some((NumberOf::Trim(axis), trim(axis)?)));
        // where the accelerometer shows lift over mass, the base model has it, whether or not a height was held
        let balances = collective.clone().filter(|_| !subject.scope(log).pushed);
        let all = trims.chain(balances.map(|of| (NumberOf::Collective, of)));
        numbers.extend(all.map(|(of, Centred { own, figure })| Number { of, own, figure }));
    }
    Ok(Steady {
        numbers,
        collective: collective.map(|of| of.own.value),
        battery_v: log.battery_v.as_ref().map(|battery_v| centre_of(&|row| battery_v[row]).own.value),
        knows_motors: motors.is_some() || log.motor_per_axis_command.is_some(),
        is_steady,
    })
}

/// By the mean command of each window, and whether the motors' commands stand in it.
fn is_steady(collective: &[f64], standing: &[bool]) -> bool {
    let usual = median(collective.to_vec());
    let strays = |(command, stands): (&f64, &bool)| *stands || (command - usual).abs() > STRAYS * usual;
    let straying = collective.iter().zip(standing).filter(|window| strays(*window)).count();
    straying as f64 <= STRAYING_MAX * collective.len() as f64
}

/// Mean command of the motors in steady flight; `None` for a log that has none.
///
/// # Errors
/// The log has no window.
pub(in crate::diagnosis) fn steady_collective(log: &Log) -> Result<Option<f64>, NotPredictable> {
    Ok(steady(log, &Subject::Axes, around_median)?.collective)
}

/// The median with its standard deviation, as windows scatter from one to the next: what changes slowly over a mission
/// changes so in every flight of it. Take-off and landing, which are a few windows, do not count.
pub(super) fn around_median(values: Vec<f64>) -> Centred {
    let independent = (values.len() as f64 / BLOCK).max(1.0);
    let steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    // one window alone shows no scatter
    let usual_step = if steps.is_empty() { 0.0 } else { median(steps) };
    let scatter = OF_ABSOLUTE * usual_step / core::f64::consts::SQRT_2;
    let own = Estimate { value: median(values), std: OF_MEDIAN * scatter / independent.sqrt() };
    Centred { own, figure: None }
}

/// The mean, of which two records of one flight differ by what they differ by window by window: take-off and landing
/// are in both.
pub(super) fn mean_of_record(values: Vec<f64>) -> Centred {
    let sum: f64 = values.iter().sum();
    let count = values.len() as f64;
    let mean =
        |left_out: Option<usize>| Some(left_out.map_or(sum / count, |window| (sum - values[window]) / (count - 1.0)));
    let figure = if values.len() > 1 { Figure::of(values.len(), mean) } else { None };
    let own = Estimate { value: sum / count, std: figure.as_ref().map_or(0.0, |figure| figure.std) };
    Centred { own, figure }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// 12 s at 100 Hz of one command: on the ground at 0.1 for the first two seconds, then 0.6 with noise.
    fn log(mut command: impl FnMut(&mut RandomStream) -> [f64; 4], seed: u64) -> Log {
        let mut random = RandomStream::new(seed, "commands");
        let rows: Vec<[f64; 4]> =
            (0..1200).map(|row| if row < 200 { [0.1; 4] } else { command(&mut random) }).collect();
        let motor = |place: usize| Some(rows.iter().map(|row| row[place]).collect());
        Log {
            time_s: (0..1200).map(|row| f64::from(row) * 0.01).collect(),
            motor_command: [motor(0), motor(1), motor(2), motor(3)],
            ..Log::default()
        }
    }

    #[test]
    fn trims_are_what_each_motor_is_off_the_mean_and_the_ground_does_not_count() {
        // rear left (motor 2) by 0.08 more: a quarter of it in each trim, with the signs of its torque
        let noisy = log(|random| [0.6, 0.68, 0.6, 0.6].map(|command| command + 0.02 * random.normal()), 1);
        let steady = steady(&noisy, &Subject::Axes, around_median).unwrap();
        let expected = [0.02, -0.02, 0.02, 0.62];
        assert_eq!(steady.numbers.len(), 4);
        for (number, expected) in steady.numbers.iter().zip(expected) {
            let Estimate { value, std } = number.own;
            assert!((value - expected).abs() < 4.0 * std && std < 2e-3, "{number:?}");
        }
        assert!(steady.knows_motors);
    }

    #[test]
    fn run_ups_on_the_ground_are_no_steady_flight() {
        let hover = log(|random| [0.6 + 0.03 * random.normal(); 4], 3);
        assert!(steady(&hover, &Subject::Axes, around_median).unwrap().is_steady);
        // throttle up and down again, as before a flight
        let mut row = 0.0;
        let run_ups = log(
            |_| {
                row += 1.0;
                [0.35 + 0.15 * libm::sin(0.02 * row); 4]
            },
            4,
        );
        let steady = steady(&run_ups, &Subject::Axes, around_median).unwrap();
        assert!(!steady.is_steady, "{:?}", steady.numbers);
        let idle = log(|_| [0.185; 4], 5);
        assert!(!super::steady(&idle, &Subject::Axes, around_median).unwrap().is_steady);
    }

    #[test]
    fn axis_commands_with_their_share_of_each_motor_give_the_same_trims() {
        let of_motors = log(|_| [0.6, 0.68, 0.62, 0.6], 2);
        let motors = of_motors.motors().unwrap();
        let sums = |row: usize| signed_sums(motors.map(|motor| motor[row]));
        let mut of_axes = Log { time_s: of_motors.time_s.clone(), ..Log::default() };
        let per_command = [0.25, 0.25, 0.5];
        for (axis, per) in per_command.into_iter().enumerate() {
            of_axes.axis_command[axis] = Some((0..1200).map(|row| 0.25 * sums(row)[axis] / per).collect());
        }
        of_axes.motor_per_axis_command = Some(per_command);
        let thrust = |row: usize| 0.25 * motors.iter().map(|motor| motor[row]).sum::<f64>();
        of_axes.thrust_command = Some((0..1200).map(thrust).collect());
        let [motors, axes] = [&of_motors, &of_axes].map(|log| steady(log, &Subject::Axes, around_median).unwrap());
        for (motors, axes) in motors.numbers.iter().zip(&axes.numbers) {
            assert!(motors.of == axes.of && (motors.own.value - axes.own.value).abs() < 1e-12, "{motors:?} {axes:?}");
        }
        of_axes.motor_per_axis_command = None;
        assert!(axes.knows_motors && !steady(&of_axes, &Subject::Axes, around_median).unwrap().knows_motors);
    }
}
