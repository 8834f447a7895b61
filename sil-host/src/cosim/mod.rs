//! Co-simulation: the continuous-time plant and the discrete-event controller, each on its own clock, joined by the
//! [`contract`] alone.
//!
//! ```text
//!   CT: plant (RK4) ---- truth ---> IMU clock: sensors ---- Monitored ---.
//!        ^                                                               v
//!        '---- Controlled (held) <--- control clock: fast, follow, plan (DE) <--- Events (scenario)
//! ```

pub mod clock;
pub mod contract;
pub mod control_side;
pub mod idle_learning;
mod pilot;
pub mod record;

use shared_control::flight_core::TorqueSource;
use shared_control::signals::{Plan, PlanStatus, RawImuSample};

use crate::cosim::contract::{Controlled, DesignParameters, Events, HELD_US, Monitored, events_at, flight_time_s};
use crate::cosim::control_side::ControlSide;
use crate::cosim::pilot::Pilot;
use crate::cosim::record::FlightRecord;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::sensors::Sensors;

/// Looks at the plant at every tick of the IMU's clock and answers with the torque from outside that acts on the body
/// until the next, N m.
pub type Probe<'a> = &'a mut dyn FnMut(&Plant) -> [f64; 3];

/// Flies a scenario and records it. The flight ends early if the plant's state is no longer finite.
pub fn fly(
    parameters: &DesignParameters,
    plant: &mut Plant,
    sensors: &mut Sensors,
    control: &mut ControlSide,
    scenario: &Scenario,
    probe: Option<Probe<'_>>,
) -> FlightRecord {
    let end_us = HELD_US + (scenario.duration_s * 1e6).round() as u64;
    let delay_s = sensors.attitude_delay_s();
    if delay_s > 0.0 {
        plant.look_at(flight_ticks_s(parameters, end_us).map(|time_s| (time_s - delay_s).max(0.0)));
    }
    let mut record = run(parameters, plant, sensors, control, scenario, end_us, probe);
    if delay_s > 0.0 {
        for (logged, seen) in record.logged_angle_rad.iter_mut().zip(plant.take_seen()) {
            *logged = sensors.attitude([seen.roll_rad, seen.pitch_rad, seen.yaw_rad]);
        }
    }
    record
}

/// Times of the control steps that are recorded, s since the rig let go.
pub fn flight_ticks_s(parameters: &DesignParameters, end_us: u64) -> impl Iterator<Item = f64> {
    let mut clock = parameters.control_clock();
    let ticks_us = std::iter::from_fn(move || {
        let tick_us = clock.next_us();
        (tick_us < end_us && clock.tick(tick_us)).then_some(tick_us)
    });
    ticks_us.filter(|tick_us| *tick_us >= HELD_US).map(flight_time_s)
}

fn run(
    parameters: &DesignParameters,
    plant: &mut Plant,
    sensors: &mut Sensors,
    control: &mut ControlSide,
    scenario: &Scenario,
    end_us: u64,
    mut probe: Option<Probe<'_>>,
) -> FlightRecord {
    let (mut imu_clock, mut control_clock) = (parameters.imu_clock(), parameters.control_clock());
    let mut record = FlightRecord::default();
    let mut monitored = Monitored::default();
    let mut last_sample = RawImuSample::default();
    let mut pilot = Pilot::default();
    let mut now_us = 0;
    loop {
        // CT: up to the next tick of either clock
        let next_us = imu_clock.next_us().min(control_clock.next_us());
        if next_us >= end_us {
            return record;
        }
        if now_us >= HELD_US {
            plant.advance((next_us - now_us) as f64 * 1e-6);
        }
        now_us = next_us;
        if imu_clock.tick(now_us) {
            if let Some(probe) = &mut probe {
                let torque_body_nm = probe(plant);
                plant.set_disturbance_torque_body_nm(torque_body_nm);
            }
            // what holds the vehicle carries its weight, whatever the motors would lift
            last_sample = if now_us < HELD_US {
                sensors.imu_at_rest(parameters.gravity_m_s2, now_us)
            } else {
                sensors.imu(plant, now_us)
            };
            // the contract's rates are such that a batch never overflows
            let _ = monitored.imu.push(last_sample);
        }
        // DE: one step of the controller
        if control_clock.tick(now_us) {
            let mut events = events_at(scenario, parameters, now_us);
            if let (Some(climb_m), false) = (events.waypoint.climb_m, events.held) {
                events.setpoint.throttle = pilot.throttle(parameters, &plant.truth(), climb_m) as f32;
            }
            let (output, plan) = control.step(now_us, &mut monitored, &events);
            let controlled = Controlled { motors: output.mix.commands.0.map(f64::from) };
            if !events.held {
                plant.set_commands(controlled.motors);
                let row = Row { now_us, plant, sensors, control, events: &events, last_sample, controlled, plan };
                if !row.append(&mut record, &output) {
                    record.ended_early = true;
                    return record;
                }
            }
        }
    }
}

/// One control step's worth of the record.
struct Row<'a> {
    now_us: u64,
    plant: &'a Plant,
    sensors: &'a mut Sensors,
    control: &'a ControlSide,
    events: &'a Events,
    last_sample: RawImuSample,
    controlled: Controlled,
    plan: Option<Plan>,
}

impl Row<'_> {
    /// False if the plant left the numbers.
    fn append(self, record: &mut FlightRecord, output: &shared_control::flight_core::StepOutput) -> bool {
        let truth = self.plant.truth();
        let angles = [truth.roll_rad, truth.pitch_rad, truth.yaw_rad];
        let imu = &self.control.config().sensing.imu;
        let gyro = imu.gyro_rad_s(&self.last_sample);
        let force = imu.specific_force_m_s2(&self.last_sample);
        let shaped = self.control.shaped_reference_rad();
        record.time_s.push(flight_time_s(self.now_us));
        record.reference_rad.push([self.events.waypoint.roll_rad, self.events.waypoint.pitch_rad]);
        record.shaped_reference_rad.push([f64::from(shaped[0]), f64::from(shaped[1])]);
        record.angle_rad.push(angles);
        record.rate_body_rad_s.push(truth.rate_body_rad_s);
        // what is reported late is known at the flight's end
        let delayed = self.sensors.attitude_delay_s() > 0.0;
        record.logged_angle_rad.push(if delayed { angles } else { self.sensors.attitude(angles) });
        record.logged_rate_body_rad_s.push([gyro.x, gyro.y, gyro.z].map(f64::from));
        record.logged_force_m_s2.push([force.x, force.y, force.z].map(f64::from));
        if self.plant.flies_free() {
            record.logged_navigation.push(self.sensors.navigation(&truth));
        }
        record.commands.push(self.controlled.motors);
        record.compare_counts.push(output.compare_counts);
        record.torque_body_nm.push(output.wrench.torque_body_nm.map(f64::from));
        record.source.push(output.source);
        if let TorqueSource::CascadeNoPlan | TorqueSource::CascadeUnsolved(_) = output.source {
            record.planning.fallbacks += 1;
        }
        if let Some(plan) = self.plan {
            record.planning.iterations_max = record.planning.iterations_max.max(u32::from(plan.iterations));
            record.planning.unsolved += u32::from(plan.status != PlanStatus::Solved);
        }
        angles.iter().all(|angle| angle.is_finite())
    }
}
