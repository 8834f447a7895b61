//! Rotors that shake the frame: what reaches the motors with the notches that the board comes with, and without.

use emulated_board::pilot::{HALF_US, ROLL};
use emulated_board::{Flight, MILLISECOND, SecondGyro};
use shared_control::params::Params;
use sil_host::effects::{RotorVibration, WeakMotor};
use sil_host::model::{Rig, VehicleModel};

use crate::FREE;

/// Peak of the vibration at hover, m/s^2: what ArduPilot takes for the end of fine.
const PEAK_M_S2: f64 = 30.0;
/// The same of the rate, rad/s: 6 mrad/s per m/s^2 (docs/attitude-error.md).
const PEAK_RAD_S: f64 = 0.18;
/// Speed of the rotors in hover, rad/s (models/f450-free.toml).
const HOVER_RAD_S: f64 = 516.0;
/// Of the lifts, so that the rotors do not stay in step.
const SCATTER: [f64; 4] = [1.02, 0.97, 1.0, 1.03];
/// The rotors' lines in hover, Hz.
const LINES_HZ: core::ops::Range<usize> = 76..90;
const STEP_HZ: f64 = 400.0;
const SECONDS: usize = 2;
const HEIGHT_M: f64 = 1.5;
/// The goal.
const DOWN_DB: f64 = 20.0;

fn shaken(params: &Params) -> Flight {
    let mut model = VehicleModel::nominal(Rig::Free).with_rotor_drag(0.3);
    let shakes = RotorVibration { peak_m_s2: PEAK_M_S2, peak_rad_s: PEAK_RAD_S, at_rad_s: HOVER_RAD_S };
    model.effects.push(shakes.into());
    for (motor, scale) in (1..).zip(SCATTER) {
        model.effects.push(WeakMotor { motor, scale }.into());
    }
    let mut flight = Flight::of_model(params, &model, SecondGyro::L3gd20, 1);
    flight.arm_from_power_on();
    flight.take_off_to(HEIGHT_M);
    flight
}

/// Root mean square over the motors of the commands' noise at the rotors' lines, over two seconds of hover.
fn noise_at_the_lines(flight: &mut Flight) -> f64 {
    let mut commands: Vec<[f64; 4]> = Vec::new();
    let mut step = flight.last().step;
    while commands.len() < SECONDS * STEP_HZ as usize {
        flight.run_for(MILLISECOND / 2);
        if flight.last().step != step {
            step = flight.last().step;
            commands.push(flight.last().commands.map(|word| f64::from(f32::from_bits(word))));
        }
    }
    let bins = (SECONDS * LINES_HZ.start..SECONDS * LINES_HZ.end).map(|bin| bin as f64 / SECONDS as f64);
    let power: f64 = bins.flat_map(|hz| [0, 1, 2, 3].map(|motor| line_power(&commands, motor, hz))).sum();
    f64::sqrt(power / 4.0)
}

/// Mean square of a command's part at a frequency.
fn line_power(commands: &[[f64; 4]], motor: usize, frequency_hz: f64) -> f64 {
    let phase = |step: usize| core::f64::consts::TAU * frequency_hz * step as f64 / STEP_HZ;
    let [re, im] = commands.iter().enumerate().fold([0.0; 2], |[re, im], (step, command)| {
        let (sin, cos) = phase(step).sin_cos();
        [re + command[motor] * cos, im + command[motor] * sin]
    });
    2.0 * (re * re + im * im) / (commands.len() * commands.len()) as f64
}

#[test]
fn notches_keep_the_rotors_lines_from_the_motors() {
    let without = noise_at_the_lines(&mut shaken(&Params { gyro_notches: false, ..FREE }));
    // what the board comes with
    const { assert!(FREE.gyro_notches) };
    let mut flight = shaken(&FREE);
    let with = noise_at_the_lines(&mut flight);
    let down_db = 20.0 * (without / with).log10();
    println!("commands at the rotors' lines: {without:.4} without notches, {with:.4} with, {down_db:.1} dB down");
    assert!(down_db > DOWN_DB, "{down_db} dB");
    flight.set_stick(ROLL, HALF_US);
    flight.fly_at(HEIGHT_M, 800);
    let tilt_deg = flight.tilt_deg();
    assert!((tilt_deg[0] - 15.0).abs() < 2.0 && tilt_deg[1].abs() < 2.0, "{tilt_deg:?}");
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
}
