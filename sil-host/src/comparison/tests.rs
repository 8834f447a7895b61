use super::*;
use crate::diagnosis::{Diagnosis, diagnose};
use crate::effects::{BatterySag, BatterySagLaw, Effect};
use crate::log::Column;
use crate::model::{Rig, VehicleModel};
use crate::sensors::random::RandomStream;
use crate::synthesis::Synthesis;
use shared_control::config::Controller;

fn log_of(choice: ControllerChoice, effect: Option<&str>, throttle: f64) -> Log {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.effects.extend(effect.map(|text| Effect::parse(text, Rig::Gimbal).unwrap()));
    Synthesis { choice, throttle: Some(throttle), seed: 11, ..Synthesis::of(model) }.log().unwrap()
}

fn compared(log: &Log, choice: ControllerChoice) -> Comparison {
    compare(log, &Subject::Vehicle(&VehicleModel::nominal(Rig::Gimbal)), Some(choice)).unwrap()
}

/// What is left between the same flight with and without noise is the log's noise (0.002 rad: a mean |x| of 0.09
/// degrees) and the estimator's drift with the gyro noise (a tenth of a degree).
#[test]
fn a_nominal_log_deviates_by_its_noise_only() {
    let cascade = ControllerChoice::nominal(Controller::Cascade);
    let comparison = compared(&log_of(cascade, None, 0.45), cascade);
    let closed_loop = comparison.closed_loop.as_ref().unwrap().deviation;
    assert!(closed_loop.roll_mean_abs_deg < 0.2 && closed_loop.pitch_mean_abs_deg < 0.2, "{closed_loop:?}");
    let error = comparison.prediction_error();
    let ratio = error.nominal.pitch_deg.unwrap() / error.noise_floor.pitch_deg.unwrap();
    assert!((0.85..1.15).contains(&ratio), "nominal over noise floor: {ratio}");
}

/// Under the thesis' MPC, which estimates no disturbance.
#[test]
fn an_off_balance_ring_shows_in_the_pitch_of_both() {
    let thesis = crate::thesis::thesis_mpc().unwrap();
    let ring = Some("cg_offset:axis=pitch,cos_moment_nm=0.1");
    let comparison = compared(&log_of(thesis, ring, 0.5), thesis);
    let deviation = comparison.closed_loop.as_ref().unwrap().deviation;
    assert!(deviation.pitch_mean_abs_deg > 5.0 * deviation.roll_mean_abs_deg, "{deviation:?}");
    let error = comparison.prediction_error();
    assert!(error.nominal.pitch_deg.unwrap() > 3.0 * error.noise_floor.pitch_deg.unwrap());
    // roll is not quite free of it: a wrong pitch rate enters it through J'(phi)
    assert!(error.nominal.roll_deg.unwrap() < 0.1 * error.nominal.pitch_deg.unwrap());
}

/// A log of 10 s with these effects, made by the plant: another integrator and another program than the prediction's.
fn log_with(rig: Rig, effects: &[&str], log_rate_hz: u32, seed: u64) -> (Log, VehicleModel) {
    let mut model = VehicleModel::nominal(rig);
    model.effects = effects.iter().map(|short| Effect::parse(short, rig).unwrap()).collect();
    let mut synthesis = Synthesis { log_rate_hz, duration_s: 10.0, seed, ..Synthesis::of(model.clone()) };
    synthesis.choice.rate_hz = log_rate_hz;
    (synthesis.log().unwrap(), model)
}

/// The largest error over its floor among the channels.
fn worst_ratio(log: &Log, model: &VehicleModel) -> (f64, &'static str) {
    let errors = compare(log, &Subject::Vehicle(model), None).unwrap().prediction_error().channels;
    let ratios = errors.iter().map(|channel| (channel.nominal / channel.noise_floor, channel.quantity));
    ratios.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// A log of fewer rows than commands: what it misses is the noise floor if each command acts at its own time, and the
/// floor is that of the readings alone.
#[test]
fn commands_between_the_rows_act_at_their_own_times() {
    let logs = [5, 6, 7].map(slow_log);
    // one log's ratio scatters by a tenth with its noise
    let ratio = logs.each_ref().map(|(log, model)| worst_ratio(log, model).0).iter().sum::<f64>() / 3.0;
    assert!((0.85..1.2).contains(&ratio), "{ratio}");
    let [(mut slow, model), ..] = logs;
    let floor = |log: &Log| {
        let comparison = compare(log, &Subject::Vehicle(&model), None).unwrap();
        comparison.prediction_error().noise_floor.q_deg_s.unwrap()
    };
    let with = floor(&slow);
    slow.sent_commands = None;
    assert!(with < 0.9 * floor(&slow), "{with} {}", floor(&slow));
}

/// One row in four of a nominal flight, all of its commands kept beside.
fn slow_log(seed: u64) -> (Log, VehicleModel) {
    let (fast, model) = log_with(Rig::Gimbal, &[], 400, seed);
    let fourth = |column: &Column| -> Column { Some(column.as_ref()?.iter().step_by(4).copied().collect()) };
    let slow = Log {
        axes: fast.axes,
        time_s: fast.time_s.iter().step_by(4).copied().collect(),
        angle_rad: fast.angle_rad.each_ref().map(fourth),
        rate_rad_s: fast.rate_rad_s.each_ref().map(fourth),
        motor_command: fast.motor_command.each_ref().map(fourth),
        sent_commands: Some(Box::new(fast)),
        ..Log::default()
    };
    (slow, model)
}

/// A log with an effect held against the model that has it: what is missed is the noise floor, where the nominal model
/// misses by much more.
fn assert_explained(rig: Rig, effects: &[&str]) {
    let (log, mut model) = log_with(rig, effects, 400, 5);
    // a measured battery takes the place of the simulated one
    for effect in &mut model.effects {
        if let Effect::BatterySag(BatterySag { law: BatterySagLaw::Voltage { fall_v_s, .. } }) = effect {
            *fall_v_s = 0.0;
        }
    }
    // the share that a finite log leaves to chance, in the worst of up to thirteen channels
    let (extended, channel) = worst_ratio(&log, &model);
    assert!((0.9..1.15).contains(&extended), "{effects:?}: {extended} in {channel}");
    let (nominal, _) = worst_ratio(&log, &VehicleModel::nominal(rig));
    assert!(nominal > 1.4, "{effects:?}: nominal {nominal}");
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn an_extended_model_explains_the_log_of_its_effects() {
    for effects in [
        &["cg_offset:axis=pitch,cos_moment_nm=0.1,sin_moment_nm=0.02"][..],
        &["torque_bias:axis=roll,torque_nm=0.02"],
        &["spring:axis=roll,stiffness_nm_rad=0.05", "viscous_friction:axis=pitch,coefficient_nms=0.02"],
        &["coulomb_friction:axis=pitch,torque_nm=0.05"],
        &["step_disturbance:axis=pitch,torque_nm=0.03,start_s=7.3"],
        &["periodic_disturbance:axis=roll,amplitude_nm=0.03,frequency_hz=1.7,phase_rad=1"],
        &["actuation_delay:delay_s=0.013", "motor_lag:time_constant_s=0.02"],
        &["command_clipping:min=0.4,max=0.6"],
        &["thrust_scale:scale=0.9"],
        &["thrust_curve:expo=0.3", "motor_lag:time_constant_s=0.03"],
        &["battery_sag:per_volt=0.3,fall_v_s=0.05"],
        &["battery_sag:per_s=0.01", "weak_motor:motor=4,scale=0.96"],
        &["inertia_error:axis=pitch,scale=1.3", "inertia_coupling:product_kg_m2=0.003"],
        &["rotor_inertia:inertia_kg_m2=6e-4"],
        &["gyro_bias:axis=yaw,bias_rad_s=0.05"],
        &["gyro_bias:axis=pitch,bias_rad_s=0.05", "gyro_scale:axis=roll,scale=1.05"],
        &["attitude_delay:delay_s=0.02"],
        &["imu_misalignment:yaw_rad=0.05"],
    ] {
        assert_explained(Rig::Gimbal, effects);
    }
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn an_extended_model_explains_the_log_of_its_effects_in_free_flight() {
    for effects in [
        &["cg_offset:axis=pitch,cos_moment_nm=0.1"][..],
        &["torque_bias:axis=roll,torque_nm=0.02", "viscous_friction:axis=pitch,coefficient_nms=0.02"],
        &["mass_error:scale=1.1"],
        &["rotor_inertia:inertia_kg_m2=4e-4"],
        &["rotor_drag:coefficient_ns_m=0.5"],
        &["wind:north_m_s=3,east_m_s=-1,drag_area_m2=0.02"],
        &["thrust_scale:scale=0.9", "motor_lag:time_constant_s=0.02"],
        &["imu_misalignment:yaw_rad=0.05"],
        &["gyro_bias:axis=roll,bias_rad_s=0.05", "attitude_delay:delay_s=0.02"],
    ] {
        assert_explained(Rig::Free, effects);
    }
}

/// One axis on a spring, 12 rad/s^2 per unit of its command; by Euler's method in steps of 0.1 ms.
fn bench() -> Log {
    let mut random = RandomStream::new(3, "bench");
    let (mut angle, mut rate) = (0.0, 0.0);
    let [mut times, mut angles, mut rates, mut commands] = [const { Vec::new() }; 4];
    for row in 0..3000 {
        let time_s = f64::from(row) * 0.005;
        let square = if ((time_s / 0.9) as u32).is_multiple_of(2) { 0.3 } else { -0.3 };
        let command = square + 0.2 * libm::sin(7.0 * time_s);
        times.push(time_s);
        angles.push(angle + 1e-3 * random.normal());
        rates.push(rate + 5e-3 * random.normal());
        commands.push(command);
        for _ in 0..50 {
            rate += 1e-4 * (12.0 * command - 0.3 * angle);
            angle += 1e-4 * rate;
        }
    }
    let mut log = Log { axes: [false, true, false], time_s: times, ..Log::default() };
    (log.angle_rad[1], log.rate_rad_s[1], log.axis_command[1]) = (Some(angles), Some(rates), Some(commands));
    log
}

/// What `sil compare` and `sil diagnose` say of the same log and the same model is the same: one prediction.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn the_figures_are_those_of_the_diagnosis() {
    let gimbal = VehicleModel::nominal(Rig::Gimbal);
    let free = VehicleModel::nominal(Rig::Free);
    let spring = log_with(Rig::Gimbal, &["spring:axis=roll,stiffness_nm_rad=0.1"], 200, 3).0;
    let cases = [
        (log_with(Rig::Gimbal, &[], 100, 1).0, Subject::Vehicle(&gimbal)),
        (spring, Subject::Vehicle(&gimbal)),
        (log_with(Rig::Free, &[], 100, 2).0, Subject::Vehicle(&free)),
        (log_with(Rig::Free, &["mass_error:scale=1.1"], 200, 4).0, Subject::Vehicle(&free)),
        (bench(), Subject::Axes),
    ];
    for (log, subject) in &cases {
        let answer = diagnose(log, subject).unwrap();
        let compared = compare(log, subject, None).unwrap().prediction_error();
        assert_same_figures(&compared, &answer);
    }
}

fn assert_same_figures(compared: &PredictionError, answer: &Diagnosis) {
    let figures = |errors: &ChannelErrors| [errors.roll_deg, errors.pitch_deg, errors.p_deg_s, errors.q_deg_s];
    let diagnosed = &answer.prediction_error;
    for (own, other) in figures(&compared.nominal).into_iter().zip(figures(&diagnosed.nominal)) {
        assert_eq!(own.is_some(), other.is_some());
        let (own, other) = (own.unwrap_or(1.0), other.unwrap_or(1.0));
        assert!((own / other - 1.0).abs() < 1e-9, "{own} {other}");
    }
    // the floor of an exact model is taken along the model that is nearest to it: with the findings, where there are
    // any; and none of the diagnosis' models is better than an exact one
    let tolerance = if answer.findings.is_empty() { 1e-9 } else { 0.1 };
    let floor = compared.noise_floor.at_most(&[diagnosed.nominal, diagnosed.base, diagnosed.extended]);
    for (own, other) in figures(&floor).into_iter().zip(figures(&diagnosed.noise_floor)) {
        let (own, other) = (own.unwrap_or(1.0), other.unwrap_or(1.0));
        assert!((own / other - 1.0).abs() < tolerance, "{own} {other} {:?}", answer.findings);
    }
    // channel by channel as in the table of horizons, which is of windows of this length too
    let horizon = answer.horizons.iter().find(|horizon| horizon.horizon_s == WINDOW_S).unwrap();
    let channels = horizon.errors.iter().filter(|error| !error.quantity.ends_with("_dot"));
    for (own, other) in compared.channels.iter().zip(channels) {
        assert_eq!((own.quantity, own.unit), (other.quantity, other.unit));
        assert!((own.nominal / other.nominal - 1.0).abs() < 1e-9, "{own:?} {other:?}");
    }
}
