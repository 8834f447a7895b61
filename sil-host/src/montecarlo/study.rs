//! A study: the flights of every drawn vehicle, each under the same controllers, as a row of numbers.

use serde::{Deserialize, Serialize};
use shared_control::config::Controller;

use super::draw::{Draw, DrawError, DrawnVehicle, Lot};
use crate::cosim::control_side::ControlSide;
use crate::cosim::record::FlightRecord;
use crate::flight::{FlightSetup, SetupError};
use crate::metrics::{self, AxisMetrics};

/// A vehicle whose roll or pitch goes beyond this has fallen out of the sky, rad: 90 degrees.
const TUMBLED_RAD: f64 = core::f64::consts::FRAC_PI_2;

/// A study that can't be flown.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The vehicles.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// The flights.
    #[error(transparent)]
    Setup(#[from] SetupError),
}

/// What a column of a study holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A number of the vehicle.
    Drawn,
    /// A figure of a flight; more is worse.
    Figure,
    /// 1 where the flight was lost, else 0.
    Lost,
}

/// A column of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// `body.mass_kg`, `pid.roll.rms_error_deg`.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
}

/// One vehicle: what was drawn and how it flew.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its number.
    pub run: u64,
    /// In the order of [`Study::columns`]; none for a figure that the flight does not have, such as the settling time
    /// of one that never settles.
    pub values: Vec<Option<f64>>,
}

/// A figure of an axis.
type AxisFigure = (&'static str, fn(&AxisMetrics) -> Option<f64>);

const OF_AXES: [AxisFigure; 6] = [
    ("rise_time_s", |axis| axis.rise_time_s),
    ("overshoot_pct", |axis| axis.overshoot_pct),
    ("settling_time_s", |axis| axis.settling_time_s),
    ("steady_error_deg", |axis| axis.steady_error_deg),
    ("largest_late_error_deg", |axis| axis.largest_late_error_deg),
    ("rms_error_deg", |axis| Some(axis.rms_error_deg)),
];

/// One controller of a study, ready to fly.
struct Flown {
    name: String,
    nominal: FlightSetup,
    /// What the controller knows is the same in every run, so that it is prepared once.
    control: ControlSide,
}

/// All flights of all vehicles that could be drawn.
pub struct Study {
    lot: Lot,
    seed: u64,
    flown: Vec<Flown>,
    columns: Vec<Column>,
}

impl Study {
    /// Of flights that differ in their controller alone, each by a name of its own; their model has the tolerances.
    ///
    /// # Errors
    /// [`StudyError`] for a model without tolerances, and a configuration that can't be flown.
    pub fn new(flights: Vec<(String, FlightSetup)>, seed: u64) -> Result<Self, StudyError> {
        let no_vehicle = || DrawError::NoTolerances { model: String::new() };
        let lot = Lot::of(&flights.first().ok_or_else(no_vehicle)?.1.model)?;
        let mut columns: Vec<Column> =
            lot.columns().into_iter().map(|name| Column { name, kind: Kind::Drawn }).collect();
        let mut flown = Vec::new();
        for (name, nominal) in flights {
            columns.extend(columns_of(&name, nominal.choice.controller));
            let control = nominal.control_side()?;
            flown.push(Flown { name, nominal, control });
        }
        Ok(Self { lot, seed, flown, columns })
    }

    /// What its rows hold.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The seed of all draws.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The names of its controllers.
    pub fn controllers(&self) -> impl Iterator<Item = &str> {
        self.flown.iter().map(|flown| flown.name.as_str())
    }

    /// The vehicle without tolerances.
    pub fn lot(&self) -> &Lot {
        &self.lot
    }

    /// What decides about every row, as text: two studies of the same text have the same rows.
    pub fn identity(&self) -> String {
        let controllers = self.flown.iter().map(|Flown { name, nominal: setup, .. }| {
            let known = setup.known_model().to_toml();
            format!("{name}: {:?}\n{}\n{known}", setup.choice, setup.scenario.to_script())
        });
        let controllers: Vec<String> = controllers.collect();
        let (version, model) = (env!("CARGO_PKG_VERSION"), self.lot.nominal().to_toml());
        format!("sil {version}, seed {}\n{model}\n{}", self.seed, controllers.join("\n"))
    }

    /// Flies one drawn vehicle.
    ///
    /// # Errors
    /// [`DrawError`] where the tolerances leave hardly any vehicle that can be.
    pub fn fly(&self, run: u64) -> Result<Row, DrawError> {
        let draw = Draw { seed: self.seed, number: run };
        let vehicle = self.lot.draw(draw)?;
        let mut values: Vec<Option<f64>> = vehicle.values.iter().copied().map(Some).collect();
        for flown in &self.flown {
            let setup = draw.of_flight(&flown.nominal, vehicle.clone());
            values.extend(flown.figures(&setup));
        }
        Ok(Row { run, values })
    }

    /// The row of the vehicle without tolerances, its sensors' noise that of run 0.
    pub fn fly_nominal(&self) -> Row {
        let nominal = self.lot.nominal();
        let mut values: Vec<Option<f64>> = self.lot.nominal_values().into_iter().map(Some).collect();
        let draw = Draw { seed: self.seed, number: 0 };
        for flown in &self.flown {
            let vehicle = DrawnVehicle { model: nominal.clone(), values: Vec::new() };
            values.extend(flown.figures(&draw.of_flight(&flown.nominal, vehicle)));
        }
        Row { run: 0, values }
    }
}

impl Flown {
    fn figures(&self, setup: &FlightSetup) -> Vec<Option<f64>> {
        let record = setup.fly_under(self.control.clone());
        let axes = FlightSetup::axes(&record);
        let mut figures: Vec<Option<f64>> =
            [&axes.roll, &axes.pitch].into_iter().flat_map(|axis| OF_AXES.map(|(_, of)| of(axis))).collect();
        figures.push(Some(metrics::effort(&record.commands, setup.model.base_command)));
        figures.push(Some(metrics::saturated_pct(&record.commands)));
        if setup.choice.controller == Controller::Mpc {
            figures.push(Some(f64::from(record.planning.fallbacks)));
        }
        figures.push(Some(f64::from(u8::from(is_lost(&record)))));
        figures
    }
}

fn columns_of(flown: &str, controller: Controller) -> Vec<Column> {
    let figure = |name: String| Column { name, kind: Kind::Figure };
    let mut columns: Vec<Column> = ["roll", "pitch"]
        .into_iter()
        .flat_map(|axis| OF_AXES.map(|(name, _)| figure(format!("{flown}.{axis}.{name}"))))
        .collect();
    columns.push(figure(format!("{flown}.effort")));
    columns.push(figure(format!("{flown}.saturated_pct")));
    if controller == Controller::Mpc {
        columns.push(figure(format!("{flown}.fallbacks")));
    }
    columns.push(Column { name: format!("{flown}.lost"), kind: Kind::Lost });
    columns
}

fn is_lost(record: &FlightRecord) -> bool {
    let is_over = |[roll, pitch, _]: &[f64; 3]| roll.abs() > TUMBLED_RAD || pitch.abs() > TUMBLED_RAD;
    record.ended_early || record.angle_rad.iter().any(is_over)
}
