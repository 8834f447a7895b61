//! What was identified beside what was drawn.

use std::fmt;

use sil_host::diagnosis::{Identification, KnownScale, effectiveness_rad_s2, identify};
use sil_host::effects::Effect;
use sil_host::log::{Log, Quantity};
use sil_host::vehicle::propulsion::Propulsion;

use super::Drawn;

/// A number with its truth.
#[derive(Clone, Debug)]
pub struct Held {
    /// Its name.
    pub name: String,
    /// As drawn.
    pub truth: f64,
    /// As identified.
    pub value: f64,
    /// The interval of 95 %.
    pub interval: [f64; 2],
}

impl Held {
    /// Does the interval hold the truth?
    pub fn is_right(&self) -> bool {
        (self.interval[0]..=self.interval[1]).contains(&self.truth)
    }
}

/// One vehicle of the campaign.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was drawn.
    pub drawn: Drawn,
    /// Were order of the motors and signs found?
    pub has_right_columns: bool,
    /// Effectiveness of each motor about each axis, and the motors' lag; empty where nothing was identified.
    pub held: Vec<Held>,
    /// The log as it was read back, and what was identified from it.
    pub identified: Option<(Log, Identification)>,
    /// Why nothing was.
    pub failure: String,
}

impl Outcome {
    /// Flies and identifies a vehicle.
    pub fn of(drawn: Drawn) -> Outcome {
        let flown = drawn.log();
        let failed = |drawn: Drawn, has_right_columns, failure: String| Outcome {
            drawn,
            has_right_columns,
            held: Vec::new(),
            identified: None,
            failure,
        };
        let log = match drawn.read_back(&flown) {
            Ok(log) => log,
            Err(problem) => return failed(drawn, false, problem),
        };
        let has_right_columns = is_the_same(&log, &flown);
        match identify(std::slice::from_ref(&log), KnownScale::default()) {
            Ok(identified) => {
                let held = held(&drawn, &identified);
                let identified = Some((log, identified));
                Outcome { drawn, has_right_columns, held, identified, failure: String::new() }
            }
            Err(error) => failed(drawn, has_right_columns, error.to_string()),
        }
    }
}

/// Do columns and signs mean what they meant before the log was written?
fn is_the_same(read: &Log, flown: &Log) -> bool {
    // an angle is the same after a full turn
    let distance = |quantity: &Quantity, read: f64, flown: f64| match quantity {
        Quantity::Angle(_) => libm::remainder(read - flown, std::f64::consts::TAU).abs(),
        _ => (read - flown).abs(),
    };
    let is_near = |quantity: &Quantity| match (read.column(*quantity), flown.column(*quantity)) {
        (Some(read), Some(flown)) => {
            read.iter().zip(flown).all(|(read, flown)| distance(quantity, *read, *flown) < 1e-5)
        }
        (read, _) => read.is_none(),
    };
    read.rows() == flown.rows() && read.motors().is_some() && Quantity::ALL.iter().all(is_near)
}

fn held(drawn: &Drawn, identified: &Identification) -> Vec<Held> {
    let truth = effectiveness_rad_s2(&drawn.model, identified.model.base_command);
    let mut truths: Vec<(String, f64)> = Vec::new();
    for (motor, of) in truth.iter().enumerate() {
        let axes = ["roll", "pitch", "yaw"].into_iter().zip(of);
        truths.extend(axes.map(|(axis, truth)| (format!("motor{}_{axis}", motor + 1), *truth)));
    }
    if let Propulsion::Generic(rotor) = drawn.model.propulsion {
        truths.push(("motor_lag_s".to_owned(), rotor.time_constant_s));
        let delay_s = drawn.model.effects.iter().find_map(|effect| match effect {
            Effect::ActuationDelay(delay) => Some(delay.delay_s),
            _ => None,
        });
        truths.push(("lag_and_delay_s".to_owned(), rotor.time_constant_s + delay_s.unwrap_or_default()));
    }
    let of = |(name, truth): (String, f64)| {
        let number = identified.numbers.iter().find(|number| number.name == name)?;
        Some(Held { truth, value: number.own.value, interval: number.interval(), name })
    };
    truths.into_iter().filter_map(of).collect()
}

/// A line of the table.
impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Drawn { seed, rate_hz, is_flu, is_plus, order, .. } = self.drawn;
        let (frame, arms) = (if is_flu { "FLU" } else { "FRD" }, if is_plus { "plus" } else { "X" });
        let order: Vec<String> = order.iter().map(|motor| (motor + 1).to_string()).collect();
        let columns = if self.has_right_columns { "right" } else { "WRONG" };
        let mass_kg = match self.drawn.model.mounting {
            sil_host::model::Mounting::Free { mass_kg } => mass_kg,
            sil_host::model::Mounting::Gimbal { .. } => f64::NAN,
        };
        write!(out, "| {seed} | {mass_kg:.3} | {arms}, {frame} | {} | {rate_hz} | {columns} ", order.join(" "))?;
        if self.held.is_empty() {
            return writeln!(out, "| | | {} |", self.failure);
        }
        let worst = |of: &str| {
            let errors = self.held.iter().filter(|held| held.name.ends_with(of));
            errors.map(|held| 100.0 * (held.value / held.truth - 1.0).abs()).fold(0.0, f64::max)
        };
        let right = self.held.iter().filter(|held| held.is_right()).count();
        let lag = self.held.iter().find(|held| held.name == "motor_lag_s");
        let lag = lag.map_or(String::new(), |lag| {
            format!(
                "{:.1} for {:.1} ({:.1} to {:.1})",
                1e3 * lag.value,
                1e3 * lag.truth,
                1e3 * lag.interval[0],
                1e3 * lag.interval[1]
            )
        });
        writeln!(
            out,
            "| {:.1}, {:.1}, {:.1} | {lag} | {right} of {} |",
            worst("roll"),
            worst("pitch"),
            worst("yaw"),
            self.held.len()
        )
    }
}

/// Over all vehicles.
pub struct Total<'a>(pub &'a [Outcome]);

impl Total<'_> {
    /// Share of the intervals that hold their truth, %.
    pub fn right_pct(&self) -> f64 {
        let all: Vec<&Held> = self.0.iter().flat_map(|outcome| &outcome.held).collect();
        100.0 * all.iter().filter(|held| held.is_right()).count() as f64 / all.len().max(1) as f64
    }
}

impl fmt::Display for Total<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "| vehicle | mass, kg | frame | motors | rows/s | columns | largest error of an effectiveness: roll, \
             pitch, yaw, % | lag, ms | intervals right |\n|---|---|---|---|---|---|---|---|---|"
        )?;
        self.0.iter().try_for_each(|outcome| write!(out, "{outcome}"))?;
        let columns = self.0.iter().filter(|outcome| outcome.has_right_columns).count();
        let wrong = self.0.iter().flat_map(|outcome| outcome.held.iter().filter(|held| !held.is_right()));
        writeln!(
            out,
            "\norder and signs right: {columns} of {}; intervals right: {:.1} %",
            self.0.len(),
            self.right_pct()
        )?;
        for held in wrong {
            let [low, high] = held.interval;
            writeln!(out, "  {}: {:.4} for {:.4} ({low:.4} to {high:.4})", held.name, held.value, held.truth)?;
        }
        Ok(())
    }
}
