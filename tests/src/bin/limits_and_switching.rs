//! What the motors' limits and several linearisations do in flight, as the tables of docs/motor-limits.md and
//! docs/switching-mpc.md: `cargo run --release -p integration-tests --bin limits_and_switching`.

use shared_control::config::Controller;
use sil_host::controller_file::{ControllerChoice, ReferenceName, TuningChange};
use sil_host::flight::FlightSetup;
use sil_host::metrics::AxisMetrics;
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::effects::Effect;
use sil_host::scenario::{Scenario, Waypoint};

/// Time between set-points, s.
const SEGMENT_S: f64 = 1.75;
/// Flights with different noise that each row is the mean of.
const SEEDS: u64 = 3;

/// (roll, pitch), degrees.
type Position = (f64, f64);

fn main() {
    motor_limits();
    switching();
}

fn motor_limits() {
    let corners = [(60.0, 60.0), (0.0, 0.0), (60.0, -60.0), (0.0, 0.0), (-60.0, 60.0), (0.0, 0.0), (-60.0, -60.0)];
    let base = TuningChange { mpc_linearisations: Some(4), ..TuningChange::default() };
    let limits =
        |reserve: f32| TuningChange { mpc_motor_limits: Some(true), mpc_torque_reserve: Some(reserve), ..base };
    let raw = |tuning: TuningChange| TuningChange { mpc_reference: Some(ReferenceName::Setpoint), ..tuning };
    let brisk =
        |tuning: TuningChange| TuningChange { acceleration_share: Some(1.4), rate_max_rad_s: Some([8.0; 3]), ..tuning };
    let gentle = |tuning: TuningChange| TuningChange { mpc_increment_weight: Some([3.0, 3.0, 3000.0]), ..tuning };
    for throttle in [0.35, 0.5, 0.7] {
        heading(&format!("60/60 steps at throttle {throttle}"));
        for (reference, change) in [
            ("shaped", &(|tuning| tuning) as &dyn Fn(TuningChange) -> TuningChange),
            ("brisk", &brisk),
            ("setpoint", &raw),
            ("setpoint rho 3", &|tuning| gentle(raw(tuning))),
        ] {
            for (name, tuning) in [("boxes", base), ("motors, span", limits(0.5)), ("motors, throttle", limits(0.0))] {
                let flown = Flown::mean(Rig::Gimbal, &[], change(tuning), &route(&corners, Some(throttle)));
                flown.print(&format!("{reference}: {name}"));
            }
        }
    }
}

fn switching() {
    let rolled = |roll: f64, pitch: f64| vec![(roll, 0.0), (roll, pitch), (roll, 0.0), (roll, -pitch), (roll, 0.0)];
    let combined = vec![(60.0, 60.0), (0.0, 0.0), (60.0, -60.0), (0.0, 0.0), (-60.0, 60.0), (0.0, 0.0)];
    let small = vec![(10.0, 10.0), (0.0, 0.0), (-10.0, 10.0), (0.0, 0.0), (0.0, -10.0), (0.0, 0.0)];
    let gravity = ["cg_offset:axis=pitch,cos_moment_nm=0.1"];
    for (rig, effects) in [(Rig::Gimbal, &[][..]), (Rig::Gimbal, &gravity[..]), (Rig::Free, &[][..])] {
        for (name, positions) in [
            ("pitch 60 while level", rolled(0.0, 60.0)),
            ("pitch 60 while rolled 60", rolled(60.0, 60.0)),
            ("pitch 20 while rolled 60", rolled(60.0, 20.0)),
            ("pitch 20 while rolled 45", rolled(45.0, 20.0)),
            ("60/60 together", combined.clone()),
            ("10/10", small.clone()),
        ] {
            heading(&format!("{} {:?} {name}", rig.name(), effects));
            for linearisations in [1, 2, 4] {
                let tuning = TuningChange { mpc_linearisations: Some(linearisations), ..TuningChange::default() };
                let flown = Flown::mean(rig, effects, tuning, &route(&positions, None));
                flown.print(&format!("{linearisations} linearisations"));
            }
        }
    }
}

/// Level first, then one position after the other.
fn route(positions: &[Position], throttle: Option<f64>) -> Scenario {
    let all: Vec<Position> = [(0.0, 0.0)].into_iter().chain(positions.iter().copied()).collect();
    let waypoints = all.iter().enumerate().map(|(index, (roll_deg, pitch_deg))| Waypoint {
        start_s: index as f64 * SEGMENT_S,
        roll_rad: roll_deg.to_radians(),
        pitch_rad: pitch_deg.to_radians(),
        yaw_rate_rad_s: 0.0,
        throttle,
    });
    Scenario { name: "steps".into(), duration_s: all.len() as f64 * SEGMENT_S, waypoints: waypoints.collect() }
}

/// Means over a few flights.
#[derive(Clone, Copy, Default)]
struct Flown {
    rms_deg: [f64; 2],
    overshoot_pct: [f64; 2],
    steady_deg: [f64; 2],
    settling_s: [f64; 2],
    aside_deg: f64,
    effort: f64,
    saturated_pct: f64,
    lift_changed_pct: f64,
    iterations_max: u32,
    fallbacks: u32,
}

impl Flown {
    fn mean(rig: Rig, effects: &[&str], tuning: TuningChange, scenario: &Scenario) -> Self {
        let mut model = VehicleModel::nominal(rig);
        model.effects = effects.iter().map(|text| Effect::parse(text, rig).expect("an effect")).collect();
        let choice = ControllerChoice { tuning, ..ControllerChoice::nominal(Controller::Mpc) };
        let mut mean = Self::default();
        for seed in 0..SEEDS {
            let setup =
                FlightSetup { model: model.clone(), controller_model: None, choice, scenario: scenario.clone(), seed };
            mean.add(&setup);
        }
        mean
    }

    fn add(&mut self, setup: &FlightSetup) {
        let flight = setup.fly().expect("a configuration that flies");
        let share = 1.0 / SEEDS as f64;
        let axes: [AxisMetrics; 2] = [flight.summary.axes.roll, flight.summary.axes.pitch];
        for (axis, metrics) in axes.iter().enumerate() {
            self.rms_deg[axis] += share * metrics.rms_error_deg;
            self.overshoot_pct[axis] += share * metrics.overshoot_pct.unwrap_or(f64::NAN);
            self.steady_deg[axis] += share * metrics.steady_error_deg.unwrap_or(f64::NAN);
            self.settling_s[axis] += share * metrics.settling_time_s.unwrap_or(f64::NAN);
        }
        self.aside_deg += share * aside_deg(&flight.record.reference_rad, &flight.record.angle_rad);
        self.effort += share * flight.summary.effort;
        self.saturated_pct += share * flight.summary.saturated_pct;
        self.lift_changed_pct += share * lift_changed_pct(&setup.model, &setup.scenario, &flight.record.commands);
        let mpc = flight.summary.mpc.expect("an MPC flew");
        self.iterations_max = self.iterations_max.max(mpc.iterations_max);
        self.fallbacks += mpc.fallbacks;
    }

    fn print(&self, name: &str) {
        let pooled = ((self.rms_deg[0].powi(2) + self.rms_deg[1].powi(2)) / 2.0).sqrt();
        println!(
            "| {name} | {:.2} | {:.2} / {:.2} | {:.1} / {:.1} | {:.2} / {:.2} | {:.2} / {:.2} | {:.2} | {:.3} | {:.1} | {:.1} | {} | {} |",
            pooled,
            self.rms_deg[0],
            self.rms_deg[1],
            self.overshoot_pct[0],
            self.overshoot_pct[1],
            self.settling_s[0],
            self.settling_s[1],
            self.steady_deg[0],
            self.steady_deg[1],
            self.aside_deg,
            self.effort,
            self.saturated_pct,
            self.lift_changed_pct,
            self.iterations_max,
            self.fallbacks
        );
    }
}

fn heading(title: &str) {
    println!("\n{title}\n");
    println!(
        "| | RMS, deg | roll / pitch | overshoot, % | settling, s | steady, deg | aside, deg | effort | saturated, % | lift changed, % | iterations | fallbacks |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
}

/// RMS distance from the straight way between the set-point before and the present one, in the plane of roll and pitch.
fn aside_deg(reference_rad: &[[f64; 2]], angle_rad: &[[f64; 3]]) -> f64 {
    let (mut from, mut to, mut sum) = (reference_rad[0], reference_rad[0], 0.0);
    for (reference, angle) in reference_rad.iter().zip(angle_rad) {
        if *reference != to {
            (from, to) = (to, *reference);
        }
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = way[0].hypot(way[1]);
        let beside = (angle[0] - from[0]) * way[1] - (angle[1] - from[1]) * way[0];
        if length > 0.0 {
            sum += (beside / length).powi(2);
        }
    }
    (sum / reference_rad.len() as f64).sqrt().to_degrees()
}

/// Mean change of the motors' mean lift (in equilibrium) from what the throttle asks for, %.
fn lift_changed_pct(model: &VehicleModel, scenario: &Scenario, commands: &[[f64; 4]]) -> f64 {
    let lift_n = |command: f64| model.propulsion.equilibrium(command).lift_n;
    let asked_n = lift_n(scenario.waypoints[0].throttle.unwrap_or(model.base_command));
    let changes =
        commands.iter().map(|motors| (motors.iter().map(|c| lift_n(*c)).sum::<f64>() / 4.0 / asked_n - 1.0).abs());
    100.0 * changes.sum::<f64>() / commands.len() as f64
}
