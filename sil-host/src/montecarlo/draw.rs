//! Vehicles drawn from the tolerances of a model. Draw `k` of a seed depends on nothing but the two: not on how many
//! are drawn, by whom, or in which order.

use std::str::FromStr;

use crate::document::Replaced;
use crate::flight::FlightSetup;
use crate::model::{Extent, ModelError, Spread, Template, Tolerance, VehicleModel};
use crate::sensors::random::RandomStream;

/// So often a vehicle is drawn again that can't be, such as one whose inertias break the triangle inequality.
const ATTEMPTS_MAX: u32 = 100;

/// Draws of one number outside of the cut that are passed over: 3 in 1000 are.
const CUT_TRIES_MAX: u32 = 100;

/// One vehicle out of those that a seed stands for, and the noise of its sensors: `SEED:NUMBER`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The study's seed.
    pub seed: u64,
    /// Which, from 0.
    pub number: u64,
}

/// A vehicle that can't be drawn.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// Nothing to draw.
    #[error("the model {model} has no tolerances: expected a table [tolerance] in its file (docs/montecarlo.md)")]
    NoTolerances {
        /// Its name.
        model: String,
    },
    /// The model itself.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// None of many could be.
    #[error("draw {draw}: none of {ATTEMPTS_MAX} vehicles drawn can be; the last: {reason}")]
    Impossible {
        /// Which.
        draw: Draw,
        /// Why the last can't be.
        reason: Box<ModelError>,
    },
}

impl FromStr for Draw {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once(':').and_then(|(seed, number)| Some((seed.parse().ok()?, number.parse().ok()?)));
        let (seed, number) = numbers.ok_or("expected SEED:NUMBER, two whole numbers from 0, such as 1:417")?;
        Ok(Self { seed, number })
    }
}

impl std::fmt::Display for Draw {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}:{}", self.seed, self.number)
    }
}

/// A drawn vehicle.
#[derive(Clone, Debug)]
pub struct DrawnVehicle {
    /// The vehicle.
    pub model: VehicleModel,
    /// What was drawn, in the order of [`Lot::columns`].
    pub values: Vec<f64>,
}

/// The vehicles that a model with tolerances stands for.
#[derive(Clone, Debug)]
pub struct Lot {
    nominal: VehicleModel,
    template: Template,
    /// Its numbers, by address.
    values: Replaced,
}

impl Lot {
    /// Of a model.
    ///
    /// # Errors
    /// [`DrawError::NoTolerances`], and a model that its own file could not be read back from.
    pub fn of(model: &VehicleModel) -> Result<Self, DrawError> {
        if model.tolerances.is_empty() {
            return Err(DrawError::NoTolerances { model: model.name.clone() });
        }
        let template = Template::of(model);
        let values = template.nominals()?;
        Ok(Self { nominal: model.clone(), template, values })
    }

    /// What every vehicle would be without tolerances.
    pub fn nominal(&self) -> &VehicleModel {
        &self.nominal
    }

    /// The model's value of what a tolerance is about.
    fn nominal_of(&self, key: &str) -> f64 {
        self.values.get(key).copied().unwrap_or(f64::NAN)
    }

    /// The model's values of what is drawn, in the order of [`Lot::columns`].
    pub fn nominal_values(&self) -> Vec<f64> {
        self.drawn().flat_map(|tolerance| places(tolerance).map(|_| self.nominal_of(&tolerance.key))).collect()
    }

    fn drawn(&self) -> impl Iterator<Item = &Tolerance> {
        self.nominal.tolerances.iter().filter(|tolerance| !matches!(tolerance.spread, Spread::Like(_)))
    }

    /// What is drawn: addresses in the model file, those of each motor's own with `.motor1` to `.motor4` behind.
    pub fn columns(&self) -> Vec<String> {
        self.drawn().flat_map(|tolerance| places(tolerance).map(|place| column(&tolerance.key, place))).collect()
    }

    /// One vehicle.
    ///
    /// # Errors
    /// [`DrawError::Impossible`] where the tolerances leave hardly any vehicle that can be.
    pub fn draw(&self, draw: Draw) -> Result<DrawnVehicle, DrawError> {
        let mut reason = None;
        for attempt in 0..ATTEMPTS_MAX {
            let (values, of_vehicle, of_arms) = self.numbers(draw, attempt);
            match self.template.read(&of_vehicle, &of_arms) {
                Ok(mut model) => {
                    model.name.clone_from(&self.nominal.name);
                    return Ok(DrawnVehicle { model, values });
                }
                Err(why) => reason = Some(why),
            }
        }
        match reason {
            Some(reason) => Err(DrawError::Impossible { draw, reason: Box::new(reason) }),
            None => Err(DrawError::NoTolerances { model: self.nominal.name.clone() }),
        }
    }

    /// What was drawn, as columns, and as numbers of the vehicle and of its arms.
    fn numbers(&self, draw: Draw, attempt: u32) -> (Vec<f64>, Replaced, [Replaced; 4]) {
        let (mut values, mut of_vehicle, mut of_arms) = (Vec::new(), Replaced::new(), [const { Replaced::new() }; 4]);
        let drawn_first = |tolerance: &&Tolerance| matches!(tolerance.spread, Spread::Like(_));
        let mut tolerances: Vec<&Tolerance> = self.nominal.tolerances.iter().collect();
        tolerances.sort_by_key(drawn_first);
        for tolerance in tolerances {
            for place in places(tolerance) {
                let of_place = match place {
                    None => &mut of_vehicle,
                    Some(motor) => &mut of_arms[motor],
                };
                let nominal = self.nominal_of(&tolerance.key);
                let value = match &tolerance.spread {
                    Spread::Like(leader) => {
                        let share = of_place.get(leader).map_or(1.0, |value| value / self.nominal_of(leader));
                        nominal * share
                    }
                    spread => {
                        let name = format!("draw {} of {}, {attempt}", draw.number, column(&tolerance.key, place));
                        let value = nominal + deviation(spread, nominal, draw.seed, &name);
                        values.push(value);
                        value
                    }
                };
                of_place.insert(tolerance.key.clone(), value);
            }
        }
        (values, of_vehicle, of_arms)
    }
}

impl Draw {
    /// The seed of its sensors' noise.
    pub fn noise_seed(self) -> u64 {
        // all of the 53 bits that a uniform number has
        let uniform = RandomStream::new(self.seed, &format!("noise of draw {}", self.number)).uniform();
        (uniform * (1_u64 << 53) as f64) as u64
    }

    /// The flight of a drawn vehicle in place of the nominal one's. The controller goes on to take it for what it took
    /// the nominal one for: nobody measures the parts of a vehicle before its first flight.
    pub fn of_flight(self, setup: &FlightSetup, vehicle: DrawnVehicle) -> FlightSetup {
        FlightSetup {
            model: vehicle.model,
            controller_model: Some(setup.known_model()),
            seed: self.noise_seed(),
            ..setup.clone()
        }
    }
}

/// Where a number stands: once in the vehicle, or with each motor (0 to 3).
fn places(tolerance: &Tolerance) -> impl Iterator<Item = Option<usize>> + use<> {
    let motors = if tolerance.is_per_motor() { 0..4 } else { 0..0 };
    let once = (!tolerance.is_per_motor()).then_some(None);
    once.into_iter().chain(motors.map(Some))
}

fn column(key: &str, place: Option<usize>) -> String {
    place.map_or_else(|| key.to_owned(), |motor| format!("{key}.motor{}", motor + 1))
}

/// How far a number lies from its nominal value.
fn deviation(spread: &Spread, nominal: f64, seed: u64, stream: &str) -> f64 {
    let mut stream = RandomStream::new(seed, stream);
    let of = |extent: &Extent| extent.about(nominal);
    match spread {
        Spread::Normal(sd) => {
            let within = |_| Some(stream.normal()).filter(|number| number.abs() <= crate::model::CUT_SD);
            of(sd) * (0..CUT_TRIES_MAX).find_map(within).unwrap_or(0.0)
        }
        Spread::Uniform(half_width) => of(half_width) * (2.0 * stream.uniform() - 1.0),
        Spread::Like(_) => 0.0,
    }
}
