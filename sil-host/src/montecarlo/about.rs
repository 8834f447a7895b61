//! What a file of rows says of itself, so that an answer can be made from files alone.

use serde::{Deserialize, Serialize};

use super::study::{Column, Kind, Row, Study};

/// A study in words and names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Name of the model.
    pub model: String,
    /// What is flown.
    pub scenario: String,
    /// Seed of all draws.
    pub seed: u64,
    /// Its controllers, each with the options by which `sil fly` flies it.
    pub controllers: Vec<(String, String)>,
    /// What rows hold.
    pub columns: Vec<AboutColumn>,
    /// Two studies of the same text have the same rows.
    pub identity: String,
}

/// A column with its value in the vehicle without tolerances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AboutColumn {
    /// Its name.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
    /// Of the vehicle without tolerances.
    pub nominal: Option<f64>,
}

impl About {
    /// Of a study; `options` are those by which `sil fly` flies each of its controllers.
    pub fn of(study: &Study, scenario: &str, options: &[String]) -> Self {
        let Row { values, .. } = study.fly_nominal();
        let column = |(column, nominal): (&Column, Option<f64>)| AboutColumn {
            name: column.name.clone(),
            kind: column.kind,
            nominal,
        };
        Self {
            model: study.lot().nominal().name.clone(),
            scenario: scenario.to_owned(),
            seed: study.seed(),
            controllers: study.controllers().map(str::to_owned).zip(options.iter().cloned()).collect(),
            columns: study.columns().iter().zip(values).map(column).collect(),
            identity: study.identity(),
        }
    }

    /// The columns without their values.
    pub fn plain_columns(&self) -> Vec<Column> {
        self.columns.iter().map(|column| Column { name: column.name.clone(), kind: column.kind }).collect()
    }

    /// The command that flies one of the vehicles again, under the controller of a column.
    pub fn command(&self, run: u64, column: &str) -> String {
        let of_column =
            |(name, _): &&(String, String)| column.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'));
        let options = self.controllers.iter().find(of_column).map_or("", |(_, options)| options.as_str());
        format!("sil fly --draw {}:{run}{options}", self.seed)
    }
}
