//! The Crazyflie flown for identification, its mass known: what of mass and lift is then left to be found.

use sil_host::diagnosis::{Diagnosis, Effort, Fact, Known, Subject, diagnose_observed};
use sil_host::log::Log;
use sil_host::model::VehicleModel;

/// What the authors weighed, kg.
const MASS_KG: f64 = 0.027;
/// The flight and its halves, s.
pub const PARTS_S: [[f64; 2]; 3] = [[16.0, 51.0], [16.0, 33.5], [33.5, 51.0]];

/// The diagnosis of a part of the flight (`--known mass_kg=0.027`).
///
/// # Panics
/// The part is too short, or the model is of no free vehicle.
pub fn diagnosis(log: &Log, vehicle: &VehicleModel, [from_s, to_s]: [f64; 2]) -> Diagnosis {
    let known = [Fact { name: "mass_kg", value: MASS_KG, std: 0.0 }];
    let (vehicle, known) = Known::of(vehicle, &known).expect("a free vehicle");
    let part = log.between(from_s, to_s).expect("a part of the flight");
    diagnose_observed(&part, &Subject::Vehicle(&vehicle), &known, Effort::Quick, &|_| ()).expect("a log with windows")
}
