//! A log as somebody else would have written it: motors in another order, perhaps axes that count the other way,
//! nothing but gyro, attitude, accelerometer and motors.

use sil_host::axis::Axis;
use sil_host::log::{self, Log, Map, Quantity, draft};

use super::Drawn;

/// By how much the axes of an X are turned from those of a plus, deg.
const PLUS_DEG: f64 = 45.0;

impl Drawn {
    /// What of its flight is read back from a file of other columns, by a map that was drafted from it alone.
    ///
    /// # Errors
    /// In words: the draft could not be used.
    ///
    /// # Panics
    /// The temporary file can't be written.
    pub fn read_back(&self, flown: &Log) -> Result<Log, String> {
        let name = format!("identification-{}-{}.csv", std::process::id(), self.seed);
        let path = std::env::temp_dir().join(name);
        let text = match self.is_plus {
            true => self.text(&flown.clone().turned(-PLUS_DEG).map_err(|error| error.to_string())?),
            false => self.text(flown),
        };
        std::fs::write(&path, &text).expect("a temporary file");
        let draft = draft::draft(&path);
        let _ = std::fs::remove_file(&path);
        let draft = draft.map_err(|error| error.to_string())?.ok_or("taken for a flight controller's log")?;
        if !draft.problems.is_empty() {
            return Err(draft.problems.join("; "));
        }
        let map = Map::parse("the draft", &draft.toml).map_err(|error| error.to_string())?;
        log::parse(&path.display().to_string(), &text, Some(&map)).map_err(|error| error.to_string())
    }

    /// The columns, a row per line.
    fn text(&self, flown: &Log) -> String {
        let quantities =
            Axis::ALL.into_iter().flat_map(|axis| [Quantity::Angle(axis), Quantity::Rate(axis), Quantity::Accel(axis)]);
        let mut columns = vec![("time_s".to_owned(), 1.0, Quantity::Time)];
        columns.extend(quantities.map(|quantity| (quantity.name(), self.sign(quantity), quantity)));
        let motors = (0..4).map(|motor| (format!("motor{}", self.order[motor] + 1), 1.0, Quantity::Motor(motor)));
        columns.extend(motors);
        let names: Vec<&str> = columns.iter().map(|(name, ..)| name.as_str()).collect();
        let values: Vec<(f64, &[f64])> =
            columns.iter().map(|(_, sign, quantity)| (*sign, flown.column(*quantity).unwrap_or_default())).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..flown.rows() {
            let cells: Vec<String> = values.iter().map(|(sign, column)| format!("{:.7}", sign * column[row])).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }

    /// Forward-left-up has y and z the other way.
    fn sign(&self, quantity: Quantity) -> f64 {
        let is_turned = matches!(
            quantity,
            Quantity::Angle(Axis::Pitch | Axis::Yaw)
                | Quantity::Rate(Axis::Pitch | Axis::Yaw)
                | Quantity::Accel(Axis::Pitch | Axis::Yaw)
        );
        if self.is_flu && is_turned { -1.0 } else { 1.0 }
    }
}
