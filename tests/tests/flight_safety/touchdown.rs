//! A vehicle that lost its link comes down by itself and is disarmed on the ground, and nowhere else.

use sil_host::effects::RotorVibration;
use sil_host::sensors::random::RandomStream;

use super::outside::{Air, Ground};
use super::rig::{Rig, RigFlight, STEP_US, Scene};
use shared_control::config::Controller;
use shared_control::flight_core::TorqueSource;
use shared_control::signals::MotorCommands;
use shared_control::supervisor::flight_watch::LANDED_AFTER_US;
use shared_control::supervisor::{Arming, DisarmedBecause};

/// From the touch of the ground to the end of the motors.
const WITHIN_S: f64 = 3.0;
/// Speed of the rotors in hover, rad/s.
const HOVER_RAD_S: f64 = 516.0;

/// How a flight without a link ended.
#[derive(Clone, Copy, Debug)]
struct End {
    because: DisarmedBecause,
    /// Since the legs met the ground for good, s, and how fast they did, m/s; none in the air.
    after_s: Option<f64>,
    speed_m_s: f64,
}

fn calm() -> Scene {
    Scene::calm(Rig::Free, Controller::Cascade)
}

fn shaken(mut scene: Scene, peak_m_s2: f64) -> Scene {
    // the push at the end of an arm turns the body, too
    let peak_rad_s = 0.006 * peak_m_s2;
    scene.model.effects.push(RotorVibration { peak_m_s2, peak_rad_s, at_rad_s: HOVER_RAD_S }.into());
    scene
}

/// The link is lost at once; how it ends within so long, or how fast it sinks then, m/s.
fn lose_link(scene: &Scene, within_s: f64) -> Result<End, f64> {
    let mut flight = RigFlight::in_scene(scene);
    flight.silence(true);
    for _ in 0..(within_s * 1e6) as u64 / STEP_US {
        let output = flight.step();
        let Arming::Disarmed(because) = output.arming else { continue };
        assert_eq!(output.mix.commands, MotorCommands([0.0; 4]), "no motor is driven");
        let touched = flight.touched();
        let after_s = touched.map(|touched| 1e-6 * (flight.now_us() - touched.at_us) as f64);
        return Ok(End { because, after_s, speed_m_s: touched.map_or(0.0, |touched| touched.speed_m_s) });
    }
    Err(flight.sinks_m_s())
}

/// Whatever it stands on, from whatever height, by either controller.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn on_the_ground_it_is_disarmed_within_three_seconds() {
    let grounds = [
        ("flat", Ground::FLAT),
        ("slope of 15 degrees", Ground { slope_deg: 15.0, ..Ground::FLAT }),
        ("slope of 15 degrees, slippery", Ground { slope_deg: 15.0, friction: 0.3, ..Ground::FLAT }),
        ("turf that yields by 5 cm", Ground { yields_m: 0.05, ..Ground::FLAT }),
        ("bush that yields by 10 cm", Ground { yields_m: 0.1, damping: 0.5, ..Ground::FLAT }),
        ("bounce to a third of the speed", Ground { damping: 0.33, ..Ground::FLAT }),
        ("bounce to three quarters of the speed", Ground { damping: 0.1, ..Ground::FLAT }),
    ];
    for (what, ground) in grounds {
        let (mut ends, mut fastest_m_s) = (Vec::new(), 0.0);
        // a period of the dips is half a metre to three
        for (place, below_m) in [2.0, 3.1, 4.2, 5.3, 6.4, 7.5].into_iter().enumerate() {
            let controller = [Controller::Cascade, Controller::Mpc][place % 2];
            let ground = Ground { below_m, ..ground };
            let end = lose_link(&Scene { ground, controller, ..calm() }, 25.0).expect(what);
            assert_eq!(end.because, DisarmedBecause::LinkLost, "{what}, {below_m} m");
            assert!(end.speed_m_s < 2.0, "{what}, {below_m} m: {end:?}");
            ends.push(end.after_s.expect("on the ground"));
            fastest_m_s = f64::max(fastest_m_s, end.speed_m_s);
        }
        ends.sort_by(f64::total_cmp);
        let (median_s, longest_s) = (ends[ends.len() / 2], ends[ends.len() - 1]);
        println!("{what}: median {median_s:.2} s, longest {longest_s:.2} s, at up to {fastest_m_s:.2} m/s");
        assert!(longest_s < WITHIN_S && median_s < longest_s, "{what}: {ends:?}");
    }
}

/// Half a minute of sinking in each of them, by the cascade; half of those that are drawn are flown by the MPC.
#[test]
fn in_the_air_it_is_never_disarmed() {
    let rising = |up_m_s| Scene { air: Air { up_m_s, ..Air::STILL }, ..calm() };
    let hover_wrong = |factor| Scene { hover_throttle_factor: factor, ..calm() };
    let scenes = [
        ("steady sink", calm()),
        ("gusts of 1.5 m/s", Scene { air: Air { gust_m_s: 1.5, ..Air::STILL }, ..calm() }),
        ("short gusts of 1.5 m/s", Scene { air: Air { gust_m_s: 1.5, gust_s: 0.3, ..Air::STILL }, ..calm() }),
        ("thermal of 1 m/s", rising(1.0)),
        ("thermal of 2 m/s", rising(2.0)),
        ("thermal of 3 m/s", rising(3.0)),
        ("downwind of 3 m/s", rising(-3.0)),
        ("throttle for hovering 15 % too low", hover_wrong(0.85)),
        ("throttle for hovering 15 % too high", hover_wrong(1.15)),
        ("vibration of 30 m/s^2", shaken(calm(), 30.0)),
        ("vibration of 60 m/s^2", shaken(calm(), 60.0)),
        ("a plate of 0.15 m^2 in the air", Scene { air: Air { drag_1_m: 0.08, ..Air::STILL }, ..calm() }),
        ("a rotor that wins back much", Scene { air: Air { inflow_1_s: 0.8, ..Air::STILL }, ..calm() }),
        ("an accelerometer off by 0.08 g", Scene { accel_bias_m_s2: [0.5, 0.5, -0.8], ..calm() }),
        ("the other way", Scene { accel_bias_m_s2: [-0.5, 0.5, 0.8], ..calm() }),
    ];
    for (what, scene) in scenes {
        match lose_link(&scene, 33.0) {
            Err(sinks_m_s) => println!("{what}: sinks at {sinks_m_s:.2} m/s"),
            Ok(end) => panic!("{what}: {end:?}"),
        }
    }
}

/// What it loses by dips of the lift is in the descent: a steady 2 m/s by the rotors of this vehicle.
#[test]
fn it_sinks_slowly_and_hardly_faster_for_the_dips() {
    let mut flight = RigFlight::in_scene(&calm());
    flight.silence(true);
    flight.fly_for(25.0);
    let (mut slowest_m_s, mut fastest_m_s, mut sum_m_s) = (f64::MAX, 0.0, 0.0);
    for _ in 0..2000 {
        flight.step();
        let sinks_m_s = flight.sinks_m_s();
        (slowest_m_s, fastest_m_s) = (f64::min(slowest_m_s, sinks_m_s), f64::max(fastest_m_s, sinks_m_s));
        sum_m_s += sinks_m_s / 2000.0;
    }
    println!("sinks at {sum_m_s:.2} m/s, {slowest_m_s:.2} to {fastest_m_s:.2}");
    // a tenth of the weight over 0.5 1/s of the mass
    assert!((sum_m_s - 1.96).abs() < 0.15 && fastest_m_s - slowest_m_s < 0.8, "{sum_m_s}");
}

/// A vehicle, its air, and what its owner knows of it, all drawn. Gusts of up to 1 m/s upwards and sideways belong to a
/// wind of 10 m/s (MIL-F-8785C 3.7.3.4: a tenth of the wind at 6 m), in which such a vehicle is hardly flown.
fn drawn(seed: u64) -> Scene {
    let mut draws = RandomStream::new(seed, "touchdown");
    let mut between = |low: f64, high: f64| low + (high - low) * draws.uniform();
    let controller = if seed.is_multiple_of(2) { Controller::Cascade } else { Controller::Mpc };
    let scene = Scene {
        controller,
        hover_throttle_factor: between(0.85, 1.15),
        accel_bias_m_s2: [between(-0.5, 0.5), between(-0.5, 0.5), between(-0.8, 0.8)],
        air: Air {
            inflow_1_s: between(0.3, 0.8),
            drag_1_m: between(0.0, 0.06),
            up_m_s: between(-1.0, 3.0),
            gust_m_s: between(0.0, 1.0),
            gust_s: between(0.3, 2.0),
            ..Air::STILL
        },
        ground: Ground {
            below_m: between(2.0, 8.0),
            slope_deg: between(0.0, 15.0),
            yields_m: 0.008 * between(0.0, 2.3).exp(),
            damping: between(0.15, 0.7),
            friction: between(0.4, 1.0),
        },
        seed,
        ..calm()
    };
    shaken(scene, between(0.0, 30.0))
}

/// Those of so many drawn flights that end in the air.
fn ended_in_the_air(seeds: core::ops::Range<u64>) -> Vec<(u64, End)> {
    let end = |seed| Some((seed, lose_link(&Scene { ground: Ground::NONE, ..drawn(seed) }, 33.0).ok()?));
    seeds.filter_map(end).collect()
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn none_of_fifteen_drawn_vehicles_is_disarmed_in_the_air() {
    let ended = ended_in_the_air(0..15);
    assert!(ended.is_empty(), "{ended:?}");
}

/// Seven hours in the air.
#[test]
#[ignore = "a minute"]
fn none_of_a_thousand_drawn_vehicles_is_disarmed_in_the_air() {
    let ended = ended_in_the_air(0..1000);
    assert!(ended.is_empty(), "{ended:?}");
}

/// On ground and in wind as they come, with a throttle for hovering that is right to 5 %: nine of ten in time, and
/// each soon. What takes longer is blown along a slope and bounces down it.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn of_twenty_drawn_vehicles_most_are_disarmed_in_time() {
    let (mut ends_s, mut fastest_m_s) = (Vec::new(), 0.0);
    for seed in 0..20 {
        let mut scene = drawn(seed);
        scene.hover_throttle_factor = 1.0 + (scene.hover_throttle_factor - 1.0) / 3.0;
        scene.air.up_m_s *= 0.3;
        scene.air.gust_m_s *= 0.5;
        let end = lose_link(&scene, 33.0).unwrap_or_else(|_| panic!("{seed} is not down: {scene:?}"));
        ends_s.push(end.after_s.unwrap_or_else(|| panic!("{seed}: {end:?} in the air")));
        fastest_m_s = f64::max(fastest_m_s, end.speed_m_s);
    }
    ends_s.sort_by(f64::total_cmp);
    let late = ends_s.iter().filter(|end_s| **end_s >= WITHIN_S).count();
    println!("median {:.2} s, longest {:?} s, {late} late; down at up to {fastest_m_s:.2} m/s", ends_s[10], ends_s[19]);
    assert!(10 * late <= ends_s.len() && ends_s[19] < 2.0 * WITHIN_S, "{ends_s:?}");
}

/// Armed, half of the lift, on the ground: nobody heard from there on.
#[test]
fn on_the_ground_with_throttle_it_is_disarmed_too() {
    let ground = Ground { below_m: 0.0, ..Ground::FLAT };
    let mut flight = RigFlight::in_scene(&Scene { ground, ..calm() });
    flight.throttle_stick(0.35);
    flight.fly_for(3.0);
    flight.silence(true);
    let steps = flight.steps_until(4000, |output| !output.arming.motors_turn());
    assert_eq!(flight.arming(), Arming::Disarmed(DisarmedBecause::LinkLost));
    // 3 s of silence and 2 s of hold, then as after any landing
    let seconds = (steps * STEP_US) as f64 * 1e-6;
    assert!(seconds < 5.0 + WITHIN_S, "{seconds} s");
}

/// By stick the throttle goes to idle, which tells a landing by itself; a link that is lost there disarms at once.
#[test]
fn landed_by_stick_it_idles_and_a_lost_link_disarms_it() {
    let mut flight = RigFlight::in_scene(&Scene { ground: Ground { below_m: 1.0, ..Ground::FLAT }, ..calm() });
    flight.throttle_stick(0.5);
    while flight.touched().is_none() {
        flight.step();
    }
    flight.throttle_stick(0.0);
    let landed = flight.steps_until(1200, |output| output.source == TorqueSource::Idle);
    assert!(landed * STEP_US < LANDED_AFTER_US + 1_500_000, "{landed} steps");
    flight.silence(true);
    flight.steps_until(1300, |output| !output.arming.motors_turn());
    assert_eq!(flight.arming(), Arming::Disarmed(DisarmedBecause::LinkLost));
}
