//! Forces of rotors that follow a thousand commands a second, against a plain integration in steps of 5 us.

use super::drive::Drive;
use super::force_track::{Commands, ForceTrack};
use crate::vehicle::CommandPath;
use crate::vehicle::propulsion::{GenericRotor, Propulsion};

const ROWS: usize = 100;
/// Of the log that is compared, and of its commands, s.
const ROW_S: f64 = 0.005;
const COMMAND_S: f64 = 0.001;
const FINE_S: f64 = 5e-6;
const ROTOR: GenericRotor = GenericRotor {
    speed_offset_rad_s: 700.0,
    speed_slope_rad_s: 2850.0,
    time_constant_s: 0.065,
    lift_n_s2: 1.28e-8,
    reaction_torque_nm_s2: 7.6e-11,
};

/// As rough as commands come: steps, a fast ramp, and noise from one to the next.
fn commands() -> Commands {
    let value = |k: usize| {
        let noise = 0.05 * (((k * 7919) % 101) as f64 / 50.0 - 1.0);
        let step = if k % 160 < 80 { 0.15 } else { -0.15 };
        let of = |sign: f64| 0.55 + sign * step + noise + 0.1 * libm::sin(0.03 * k as f64);
        [of(1.0), of(-1.0), of(0.3), of(0.0)]
    };
    // off the rows' grid
    let time_s = |k: usize| 0.0003 + COMMAND_S * k as f64;
    let count = 1 + (ROWS as f64 * ROW_S / COMMAND_S) as usize;
    Commands { time_s: (0..count).map(time_s).collect(), value: (0..count).map(value).collect() }
}

/// Per row interval and motor: mean lift and half the change of the line with its first moment, N; and the lift at the
/// end.
fn finely(commands: &Commands, path: &CommandPath) -> Vec<[[f64; 3]; 4]> {
    let target = |command: f64| ROTOR.speed_offset_rad_s + ROTOR.speed_slope_rad_s * path.bent(command);
    let lift = |speed: f64| ROTOR.lift_n_s2 * speed * speed;
    let mut lagged = commands.value[0];
    let mut speed = lagged.map(target);
    let per_row = (ROW_S / FINE_S).round() as usize;
    let mut now = 0;
    let mut of_row = |_| {
        let mut sums = [[0.0; 3]; 4];
        for k in 0..per_row {
            // the middle of a fine step, and the command that is in force there
            let time_s = (now as f64 + 0.5) * FINE_S;
            let place = commands.time_s.partition_point(|at_s| at_s + path.delay_s <= time_s);
            let command = commands.value[place.saturating_sub(1)];
            let along = (2.0 * k as f64 + 1.0) / per_row as f64 - 1.0;
            for motor in 0..4 {
                let half = |from: f64, to: f64, lag_s: f64| from + (to - from) * 0.5 * FINE_S / lag_s;
                let [before, c] = [lagged[motor], command[motor]];
                let middle = if path.lag_s > 0.0 { half(before, c, path.lag_s) } else { c };
                lagged[motor] = if path.lag_s > 0.0 { half(middle, c, path.lag_s) } else { c };
                let speed_middle = half(speed[motor], target(middle), ROTOR.time_constant_s);
                speed[motor] += (target(middle) - speed_middle) * FINE_S / ROTOR.time_constant_s;
                sums[motor][0] += lift(speed_middle) / per_row as f64;
                sums[motor][1] += 3.0 * along * lift(speed_middle) / per_row as f64;
                sums[motor][2] = lift(speed[motor]);
            }
            now += 1;
        }
        sums
    };
    (0..ROWS).map(&mut of_row).collect()
}

/// Largest errors of a track's means, first moments and forces at rows, N.
fn errors(path: &CommandPath) -> [f64; 3] {
    let (commands, drive) = (commands(), Drive::Motors(Propulsion::Generic(ROTOR)));
    let rows_s: Vec<f64> = (0..=ROWS).map(|row| row as f64 * ROW_S).collect();
    let track = ForceTrack::new(&rows_s, &commands, path, &drive);
    let mut worst = [0.0_f64; 3];
    for (row, exact) in finely(&commands, path).iter().enumerate() {
        let [step] = track.of_row(row) else { panic!("a row of 5 ms is a step") };
        let at = |place: f64| step.at(place, &[1.0; 4]).force;
        let (mean, end) = (at(0.0), track.at_row(row + 1));
        for motor in 0..4 {
            let half_change = 0.5 * (at(1.0)[motor] - at(-1.0)[motor]);
            let found = [mean[motor], half_change, end[motor]];
            let errors = found.into_iter().zip(exact[motor]).map(|(found, exact)| (found - exact).abs());
            worst.iter_mut().zip(errors).for_each(|(worst, error)| *worst = worst.max(error));
        }
    }
    worst
}

/// Within a step of h = T/13 the commands range over 0.4 at most, targets over 1140 rad/s. What a line leaves of them
/// has a second moment of 0.032 h^3 of that at most, whatever they do. By it a speed in the end errs by half of it over
/// T^3, 0.008 rad/s, and a first moment by three times it over T h^2, 8.4 rad/s. Where a lift of 0.1 N goes by 7.2e-5 N
/// per rad/s these are 6e-7 N, remembered for thirteen steps with changing signs, and 6e-4 N. The latter moves an angle
/// within its step, and no rate.
#[test]
fn slow_rotors_follow_the_mean_and_the_moment_of_many_commands() {
    let shared = CommandPath { delay_s: 0.0074, ..CommandPath::default() };
    for lag_s in [0.0, 5e-5, 1e-3, 0.02] {
        let [mean, half_change, end] = errors(&CommandPath { lag_s, ..shared });
        assert!(mean < 3e-6 && half_change < 6e-4 && end < 3e-6, "{lag_s}: {mean:e} {half_change:e} {end:e}");
    }
}
