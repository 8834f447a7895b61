//! A motor fails in free flight: when the core notices, which motor it names, and how the vehicle fares with today's
//! core and with the one that knows of it. The figures of docs/motor-loss.md.

pub mod flight;
pub mod real_logs;
pub mod recorded;

use rayon::prelude::*;
use serde::Serialize;

use flight::{BuiltIn, Case, Failure, Flown, Outcome, Vehicle};

/// One line of the table: many seeds of one failure.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What fails.
    pub failure: &'static str,
    /// `hover`, `steps`, `gusts` or `strong gusts`.
    pub flown: &'static str,
    /// Whether the core knows of lost motors.
    pub noticed: bool,
    /// Yaw drag over the assumed one.
    pub yaw_drag: f64,
    /// The rotors' inertia over the believed one.
    pub rotor_inertia: f64,
    /// Least command of a motor in flight.
    pub flight_idle_command: f32,
    /// Inertia and lift up to this share off.
    pub model_error: f64,
    /// From the centre of gravity to the IMU, body axes, m.
    pub imu_at_m: [f64; 3],
    /// What its gyro says about yaw over the rate.
    pub gyro_yaw_scale: f64,
    /// Flights.
    pub flights: usize,
    /// Share in which the right motor was suspected within 20 ms, %.
    pub suspected_in_20_ms_pct: f64,
    /// Time in which it was in 99 of 100, ms; none where it was in fewer.
    pub suspected_99_ms: Option<f64>,
    /// Share in which the right motor was found lost within 60 ms, %.
    pub lost_in_60_ms_pct: f64,
    /// Time in which it was in 99 of 100, ms; none where it was in fewer.
    pub lost_99_ms: Option<f64>,
    /// Flights in which another motor was found lost, or one before the failure.
    pub wrong: usize,
    /// Largest tilt, median and 95th percentile, degrees.
    pub tilt_deg: [f64; 2],
    /// Within 30 degrees for good after 2 s, %.
    pub upright_in_2_s_pct: f64,
    /// The same after 4 s, %.
    pub upright_in_4_s_pct: f64,
    /// Largest tilt of the last five of ten seconds, 95th percentile, degrees.
    pub late_tilt_95_deg: f64,
    /// Largest error of roll or pitch against what is flown, 95th percentile, degrees.
    pub deviation_95_deg: f64,
    /// Largest change of the heading in two seconds, 95th percentile, degrees.
    pub heading_95_deg: f64,
    /// Median rate of the spin at the end, rad/s.
    pub spin_rad_s: f64,
}

/// Hours without a failure.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Alarms {
    /// `hover`, `steps`, `gusts` or `strong gusts`.
    pub flown: &'static str,
    /// Inertia and lift up to this share off.
    pub model_error: f64,
    /// Simulated time, h.
    pub hours: f64,
    /// Motors found lost that were not.
    pub latched: usize,
    /// Suspicions an hour.
    pub suspicions_per_h: f64,
    /// Share of the time under suspicion, %.
    pub suspected_pct: f64,
    /// Root mean square tilt, degrees, with the feature and without.
    pub tilt_deg: [f64; 2],
}

/// The board's `MOT_SPIN_MIN_PCT`.
const FLIGHT_IDLE: f32 = 0.15;

const FAILURES: [(&str, Failure); 7] = [
    ("propeller gone", Failure::Lift { lost: 1.0, within_s: 0.0 }),
    ("spins down", Failure::SpinsDown),
    ("fades in 0.3 s", Failure::Lift { lost: 1.0, within_s: 0.3 }),
    ("80 % lost", Failure::Lift { lost: 0.8, within_s: 0.0 }),
    ("60 % lost", Failure::Lift { lost: 0.6, within_s: 0.0 }),
    ("40 % lost", Failure::Lift { lost: 0.4, within_s: 0.0 }),
    ("20 % lost", Failure::Lift { lost: 0.2, within_s: 0.0 }),
];
/// In gusts of 0.2 N m that is three standard deviations, as on the other pages, in strong ones it is one.
const FLOWN: [(&str, Flown); 4] = [
    ("hover", Flown::Hover),
    ("steps", Flown::Steps),
    ("gusts", Flown::Gusts { deviation_nm: 0.2 / 3.0 }),
    ("strong gusts", Flown::Gusts { deviation_nm: 0.2 }),
];

/// With so much of the assumed yaw drag the vehicle ends up spinning at 42 rad/s, after 20 s nearly so, where the first
/// IMU's gyro shows 34.9 at most and the second's 40.0.
const BEYOND_YAW_DRAG: f64 = 0.38;

/// Every failure over all that is flown: so many seeds each.
pub fn rows(seeds: u64) -> Vec<Row> {
    let mut rows = Vec::new();
    for (noticed, yaw_drag, rotor_inertia, model_error, idle, imu) in [
        (false, 1.0, 1.0, 0.0, 0.0, BuiltIn::IDEAL),
        (true, 1.0, 1.0, 0.0, 0.0, BuiltIn::IDEAL),
        (true, 1.0, 1.0, 0.1, 0.0, BuiltIn::IDEAL),
        (true, 0.5, 1.0, 0.0, 0.0, BuiltIn::IDEAL),
        (true, 2.0, 1.0, 0.0, 0.0, BuiltIn::IDEAL),
        (true, 1.0, 0.5, 0.0, 0.0, BuiltIn::IDEAL),
        (true, 1.0, 2.0, 0.0, 0.0, BuiltIn::IDEAL),
        (true, 1.0, 1.0, 0.0, FLIGHT_IDLE, BuiltIn::IDEAL),
        (true, 2.0, 1.0, 0.0, FLIGHT_IDLE, BuiltIn::IDEAL),
        (true, 1.0, 1.0, 0.0, FLIGHT_IDLE, BuiltIn::USUAL),
        (true, BEYOND_YAW_DRAG, 1.0, 0.0, FLIGHT_IDLE, BuiltIn::USUAL),
    ] {
        // with another yaw drag, other rotors or motors that never rest the two hardest
        let few = yaw_drag != 1.0 || rotor_inertia != 1.0 || idle != 0.0;
        let failures = if few { &FAILURES[..2] } else { &FAILURES[..] };
        let vehicle = Vehicle::new(noticed, idle);
        for ((name, failure), (flown_name, flown)) in
            failures.iter().flat_map(|one| FLOWN.iter().map(move |f| (one, f)))
        {
            let case = |seed| Case {
                seed,
                flown: *flown,
                failure: *failure,
                yaw_drag,
                rotor_inertia,
                model_error,
                imu,
                noticed,
                duration_s: if yaw_drag == BEYOND_YAW_DRAG { 20.0 } else { 10.0 },
            };
            let outcomes: Vec<Outcome> = (1..=seeds).into_par_iter().map(|seed| vehicle.fly(&case(seed))).collect();
            rows.push(row((name, flown_name), &case(1), idle, &outcomes));
        }
    }
    rows
}

fn row(
    (failure, flown): (&'static str, &'static str),
    case: &Case,
    flight_idle_command: f32,
    outcomes: &[Outcome],
) -> Row {
    let share = |holds: &dyn Fn(&Outcome) -> bool| {
        100.0 * outcomes.iter().filter(|outcome| holds(outcome)).count() as f64 / outcomes.len() as f64
    };
    let quantile = |of: &dyn Fn(&Outcome) -> f64, at: f64| {
        let mut values: Vec<f64> = outcomes.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[((values.len() as f64 * at).ceil() as usize).clamp(1, values.len()) - 1]
    };
    let time_99_ms = |of: &dyn Fn(&Outcome) -> Option<f64>| {
        let time_s = quantile(&|outcome| of(outcome).unwrap_or(f64::INFINITY), 0.99);
        time_s.is_finite().then_some(1e3 * time_s)
    };
    let lost_s = |outcome: &Outcome| outcome.lost_s.filter(|_| outcome.right);
    let within = |time_s: Option<f64>, limit_s: f64| time_s.is_some_and(|time_s| (0.0..=limit_s).contains(&time_s));
    Row {
        failure,
        flown,
        noticed: case.noticed,
        yaw_drag: case.yaw_drag,
        rotor_inertia: case.rotor_inertia,
        flight_idle_command,
        model_error: case.model_error,
        imu_at_m: case.imu.at_m,
        gyro_yaw_scale: case.imu.yaw_scale,
        flights: outcomes.len(),
        suspected_in_20_ms_pct: share(&|outcome| within(outcome.suspected_s, 0.0201)),
        suspected_99_ms: time_99_ms(&|outcome| outcome.suspected_s),
        lost_in_60_ms_pct: share(&|outcome| within(lost_s(outcome), 0.0601)),
        lost_99_ms: time_99_ms(&lost_s),
        wrong: outcomes
            .iter()
            .filter(|outcome| outcome.lost_s.is_some_and(|lost_s| !outcome.right || lost_s < 0.0))
            .count(),
        tilt_deg: [0.5, 0.95].map(|at| quantile(&|outcome| outcome.tilt_deg, at)),
        upright_in_2_s_pct: share(&|outcome| outcome.upright_s <= 2.0),
        upright_in_4_s_pct: share(&|outcome| outcome.upright_s <= 4.0),
        late_tilt_95_deg: quantile(&|outcome| outcome.late_tilt_deg, 0.95),
        deviation_95_deg: quantile(&|outcome| outcome.deviation_deg, 0.95),
        heading_95_deg: quantile(&|outcome| outcome.heading_deg, 0.95),
        spin_rad_s: quantile(&|outcome| outcome.spin_rad_s.abs(), 0.5),
    }
}

/// Flights of a minute without a failure.
pub fn alarms(minutes: u64) -> Vec<Alarms> {
    let vehicles = [false, true].map(|noticed| Vehicle::new(noticed, 0.0));
    let cases = FLOWN.iter().flat_map(|flown| [(flown, 0.0), (flown, 0.2)]);
    cases
        .map(|((name, flown), model_error)| {
            let case = |seed, noticed| Case {
                seed,
                flown: *flown,
                failure: Failure::None,
                yaw_drag: 1.0,
                rotor_inertia: 1.0,
                model_error,
                imu: BuiltIn::IDEAL,
                noticed,
                duration_s: 60.0,
            };
            let fly = |noticed: bool| -> Vec<Outcome> {
                let vehicle = &vehicles[usize::from(noticed)];
                (1..=minutes).into_par_iter().map(|seed| vehicle.fly_whole(&case(seed, noticed))).collect()
            };
            let (without, with) = (fly(false), fly(true));
            let hours = minutes as f64 / 60.0;
            let tilt_deg = |of: &[Outcome]| {
                (of.iter().map(|outcome| outcome.calm_tilt_deg * outcome.calm_tilt_deg).sum::<f64>() / of.len() as f64)
                    .sqrt()
            };
            Alarms {
                flown: name,
                model_error,
                hours,
                latched: with.iter().filter(|outcome| outcome.lost_s.is_some()).count(),
                suspicions_per_h: with.iter().map(|outcome| f64::from(outcome.suspicions)).sum::<f64>() / hours,
                suspected_pct: with.iter().map(|outcome| outcome.suspected_for_s).sum::<f64>() / (36.0 * hours),
                tilt_deg: [tilt_deg(&with), tilt_deg(&without)],
            }
        })
        .collect()
}

/// Failures as a table.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| failure | flown | noticed | yaw drag | rotors | idle | model off by | IMU | suspected in 20 ms, % | \
         99 % in, ms | lost in 60 ms, % | 99 % in, ms | wrong | tilt: median / 95 %, deg | upright in 2 s / 4 s, % | \
         late tilt 95 %, deg | deviation 95 %, deg | heading 95 %, deg | spin, rad/s |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let cell = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.0}"));
    for row in rows {
        let [median, most] = row.tilt_deg;
        text += &format!(
            "| {} | {} | {} | {} | {} | {} | {:.0} % | {} | {:.1} | {} | {:.1} | {} | {} | {median:.0} / {most:.0} \
             | {:.1} / {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |\n",
            row.failure,
            row.flown,
            if row.noticed { "yes" } else { "no" },
            row.yaw_drag,
            row.rotor_inertia,
            row.flight_idle_command,
            100.0 * row.model_error,
            if row.imu_at_m == [0.0; 3] { "ideal" } else { "usual" },
            row.suspected_in_20_ms_pct,
            cell(row.suspected_99_ms),
            row.lost_in_60_ms_pct,
            cell(row.lost_99_ms),
            row.wrong,
            row.upright_in_2_s_pct,
            row.upright_in_4_s_pct,
            row.late_tilt_95_deg,
            row.deviation_95_deg,
            row.heading_95_deg,
            row.spin_rad_s,
        );
    }
    text
}

/// Hours without a failure as a table.
pub fn alarm_table(alarms: &[Alarms]) -> String {
    let mut text = String::from(
        "| flown | model off by | hours | found lost | suspicions an hour | under suspicion, % | \
         tilt RMS with / without, deg |\n|---|---|---|---|---|---|---|\n",
    );
    for alarm in alarms {
        let [with, without] = alarm.tilt_deg;
        text += &format!(
            "| {} | {:.0} % | {:.2} | {} | {:.1} | {:.2} | {with:.2} / {without:.2} |\n",
            alarm.flown,
            100.0 * alarm.model_error,
            alarm.hours,
            alarm.latched,
            alarm.suspicions_per_h,
            alarm.suspected_pct,
        );
    }
    text
}
