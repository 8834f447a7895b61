//! A flight of the reference vehicle, the same flight of the plant, and the log of it before the prediction.

use sil_host::diagnosis::{Subject, channel_prediction_errors};
use sil_host::effects::Effect;
use sil_host::log::Log;
use sil_host::model::VehicleModel;
use sil_host::plant::Plant;
use sil_host::prediction::Channel;

use crate::reference::{INERTIA_KG_M2, Page, ROW_S, Reference, Rig, Row, hover, model_file};

/// Rows of a flight: 10 s.
const ROWS: usize = 2000;

/// An effect as a model file has it, and as its page has it.
pub struct Case {
    pub rig: Rig,
    /// The effect in its short form.
    pub short: &'static str,
    pub page: Page,
    /// Height of the rotors above ground at the start, m.
    pub start_height: f64,
    /// Fall of the battery's voltage, V/s.
    pub fall_v_s: f64,
}

impl Case {
    pub fn of(rig: Rig, short: &'static str, page: Page) -> Case {
        Case { rig, short, page, start_height: 10.0, fall_v_s: 0.0 }
    }

    pub fn model(&self) -> VehicleModel {
        let mut model = self.nominal();
        model.effects.push(Effect::parse_for(self.short, model.rig(), INERTIA_KG_M2).unwrap());
        model
    }

    fn nominal(&self) -> VehicleModel {
        VehicleModel::parse(&model_file(self.rig, self.page.rotor_lag_s), "test").unwrap()
    }

    fn flown(&self) -> Vec<Row> {
        let mut reference = Reference::new(self.rig, self.page, self.start_height, self.fall_v_s);
        (0..ROWS).map(|_| reference.row(|row| commands(row, self.start_height))).collect()
    }
}

/// A controller that keeps the vehicle near swinging set-points: any will do, as long as it moves every axis.
fn commands(row: &Row, start_height: f64) -> [f64; 4] {
    let t = row.time_s;
    let target = [0.25 * (1.3 * t).sin(), 0.2 * (0.9 * t + 0.4).sin(), 0.3 * (0.7 * t).sin()];
    let want: [f64; 3] = std::array::from_fn(|axis| {
        let (stiffness, damping) = ([0.06, 0.12, 0.03][axis], [0.02, 0.04, 0.02][axis]);
        stiffness * (target[axis] - row.angle[axis]) - damping * row.rate[axis]
    });
    let climb = 0.05 * (start_height - row.height + 0.3 * (1.1 * t).sin()) + 0.06 * row.velocity[2];
    let [roll, pitch, yaw] = want;
    [
        hover() + climb - roll + pitch + yaw,
        hover() + climb + roll - pitch + yaw,
        hover() + climb + roll + pitch - yaw,
        hover() + climb - roll - pitch - yaw,
    ]
}

/// (a) The plant under the same controller goes the same way.
///
/// Both integrate to far less than 1e-9 of the motion; dry friction has a corner of 0.02 rad/s on which either spends
/// some of that.
pub fn the_plant_moves_as_the_page_says(case: &Case) {
    let mut plant = Plant::new(&case.model());
    plant.integrate_adaptively(1e-11);
    plant.set_start_height_m(case.start_height);
    for (index, row) in case.flown().iter().enumerate() {
        let truth = plant.truth();
        let ours = Row {
            angle: [truth.roll_rad, truth.pitch_rad, truth.yaw_rad],
            rate: truth.rate_body_rad_s,
            velocity: truth.velocity_ned_m_s,
            height: truth.height_m,
            ..*row
        };
        let pairs = [(ours.angle, row.angle), (ours.rate, row.rate), (ours.velocity, row.velocity)];
        for (ours, page) in pairs.iter().flat_map(|(ours, page)| ours.iter().zip(page)) {
            let tolerance = 1e-6 * (1.0 + page.abs());
            assert!((ours - page).abs() < tolerance, "{}: row {index}: {ours} {page}", case.short);
        }
        if case.rig == Rig::Free {
            assert!((ours.height - row.height).abs() < 1e-6, "{}: row {index}", case.short);
            // before the first command the reference's lag is settled as the plant's is
            for (felt, page) in truth.specific_force_body_m_s2.iter().zip(row.specific_force) {
                assert!((felt - page).abs() < 1e-5, "{}: row {index}: {felt} {page}", case.short);
            }
        }
        plant.set_commands(commands(&ours, case.start_height));
        plant.advance(ROW_S);
    }
}

/// (b) A model that has the effect predicts the log of the reference's flight; one without it does not.
///
/// The prediction walks in steps of 5 ms. What it misses is at most a hundredth of what the effect does, or a tenth of
/// the least noise that the diagnosis takes a channel to have.
pub fn the_prediction_expects_what_the_page_says(case: &Case) {
    let log = case.log();
    // without a measured voltage the model's own battery stands for it
    if log.battery_v.is_some() {
        a_log_is_predicted(case, &Log { battery_v: None, ..log.clone() });
    }
    a_log_is_predicted(case, &log);
}

fn a_log_is_predicted(case: &Case, log: &Log) {
    // the reference's commands change at its rows
    let errors =
        |model: &VehicleModel| channel_prediction_errors(log, &Subject::Vehicle(model), Some(1.0 / ROW_S)).unwrap();
    let (with, without) = (errors(&case.model()), errors(&case.nominal()));
    let mut shows = false;
    for ((channel, with), (_, without)) in with.iter().zip(&without) {
        let least = match channel {
            Channel::Angle(_) => 2e-6,
            Channel::Rate(_) => 2e-5,
            Channel::Force(_) => 2e-4,
            Channel::Velocity(_) | Channel::Height => 1e-5,
        };
        let (with, without) = (with.error, without.error);
        assert!(with < 0.01 * without + least, "{}: {channel:?}: {with} with, {without} without", case.short);
        shows |= without > 20.0 * (with + least);
    }
    assert!(shows, "{}: the flight does not show it: {with:?} {without:?}", case.short);
}

impl Case {
    /// What the sensors make of the flight.
    fn log(&self) -> Log {
        let rows = self.flown();
        let late = (self.page.angle_delay_s / ROW_S).round() as usize;
        let column = |of: &dyn Fn(&Row) -> f64| Some(rows.iter().map(of).collect::<Vec<f64>>());
        let late_angle = |axis: usize| {
            let angle = |index: usize| (self.page.reported_angle)(rows[index.saturating_sub(late)].angle)[axis];
            Some((0..rows.len()).map(angle).collect::<Vec<f64>>())
        };
        let flies = self.rig == Rig::Free;
        Log {
            path: self.short.to_owned(),
            axes: [true, true, flies],
            time_s: rows.iter().map(|row| row.time_s).collect(),
            angle_rad: [0, 1, 2].map(|axis| late_angle(axis).filter(|_| flies || axis < 2)),
            rate_rad_s: [0, 1, 2].map(|axis| column(&|row| (self.page.reported_rate)(row.rate)[axis])),
            motor_command: [0, 1, 2, 3].map(|motor| column(&|row| row.command[motor])),
            battery_v: column(&|row| row.battery_v).filter(|_| self.fall_v_s != 0.0),
            accel_body_m_s2: [0, 1, 2]
                .map(|axis| column(&|row| (self.page.reported_force)(row.specific_force)[axis]).filter(|_| flies)),
            velocity_ned_m_s: [0, 1, 2].map(|axis| column(&|row| row.velocity[axis]).filter(|_| flies)),
            height_m: column(&|row| row.height).filter(|_| flies),
            ..Log::default()
        }
    }
}
