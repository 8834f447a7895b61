//! Several logs of one vehicle as one, a gap between them.

use super::{Log, LogError, LogErrorKind, Quantity};

/// Time between two logs, s: a gap at any rate of rows, which no window crosses.
const BETWEEN_S: f64 = 100.0;

impl Log {
    /// Several logs one behind the other, with the columns that all of them have; the names, facts and notes are the
    /// first one's. Windows do not cross from one to the next.
    ///
    /// # Errors
    /// Without any log.
    pub fn joined(logs: &[Log]) -> Result<Log, LogError> {
        let Some(first) = logs.first() else {
            let kind = LogErrorKind::TooFewRows(0);
            return Err(LogError { file: String::new(), line: None, column: None, kind });
        };
        if logs.len() == 1 {
            return Ok(first.clone());
        }
        let mut later_s = vec![0.0];
        for pair in logs.windows(2) {
            let (end_s, start_s) = (pair[0].time_s.last(), pair[1].time_s.first());
            let end_s = end_s.copied().unwrap_or_default() + later_s.last().copied().unwrap_or_default();
            later_s.push(end_s + BETWEEN_S - start_s.copied().unwrap_or_default());
        }
        let all: Vec<&Log> = logs.iter().collect();
        let mut joined = columns_of_all(&all, &later_s, |_| true);
        joined.axes = core::array::from_fn(|axis| logs.iter().all(|log| log.axes[axis]));
        if logs.iter().any(|log| log.sent_commands.is_some()) {
            let commands: Vec<&Log> = logs.iter().map(Log::commands).collect();
            let is_command = |quantity| {
                matches!(quantity, Quantity::Time | Quantity::Motor(_) | Quantity::Command(_) | Quantity::Thrust)
            };
            joined.sent_commands = Some(Box::new(columns_of_all(&commands, &later_s, is_command)));
        }
        Ok(Log {
            path: first.path.clone(),
            comments: first.comments.clone(),
            notes: first.notes.clone(),
            flight_controller: first.flight_controller.clone(),
            facts: first.facts.clone(),
            active_when: first.active_when,
            motor_per_axis_command: first.motor_per_axis_command,
            rig: first.rig,
            ..joined
        })
    }
}

/// The columns that all logs have, each log so much later.
fn columns_of_all(logs: &[&Log], later_s: &[f64], is_wanted: impl Fn(Quantity) -> bool) -> Log {
    let mut joined = Log::default();
    for quantity in Quantity::ALL.into_iter().filter(|quantity| is_wanted(*quantity)) {
        let columns: Option<Vec<&[f64]>> = logs.iter().map(|log| log.column(quantity)).collect();
        let Some(columns) = columns else { continue };
        let of_log = |(column, later_s): (&&[f64], &f64)| -> Vec<f64> {
            let by = if quantity == Quantity::Time { *later_s } else { 0.0 };
            column.iter().map(|value| value + by).collect()
        };
        joined.set_column(quantity, columns.iter().zip(later_s).flat_map(of_log).collect());
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(from_s: f64, rows: u32) -> Log {
        let time_s: Vec<f64> = (0..rows).map(|row| from_s + 0.01 * f64::from(row)).collect();
        let motor = Some(vec![0.5; time_s.len()]);
        let sent = Log {
            time_s: vec![from_s, from_s + 0.005],
            motor_command: [None, None, None, Some(vec![0.1, 0.2])],
            ..Log::default()
        };
        Log {
            axes: [true; 3],
            motor_command: [const { None }; 4].map(|_: Option<Vec<f64>>| motor.clone()),
            time_s,
            sent_commands: Some(Box::new(sent)),
            ..Log::default()
        }
    }

    #[test]
    fn logs_follow_each_other_after_a_gap_with_what_all_of_them_have() {
        let (one, mut two) = (log(3.0, 100), log(0.0, 50));
        two.battery_v = Some(vec![11.0; 50]);
        let joined = Log::joined(&[one.clone(), two, one.clone()]).unwrap();
        assert_eq!(joined.rows(), 250);
        let gaps = joined.time_s.windows(2).filter(|pair| pair[1] - pair[0] > joined.longest_regular_step_s()).count();
        assert!(gaps == 2 && joined.time_s.windows(2).all(|pair| pair[1] > pair[0]));
        assert!(joined.battery_v.is_none() && joined.motors().is_some());
        let sent = joined.sent_commands.as_ref().unwrap();
        assert_eq!(sent.motor_command[3].as_deref(), Some(&[0.1, 0.2, 0.1, 0.2, 0.1, 0.2][..]));
        // commands keep their place beside the rows
        assert!((sent.time_s[2] - joined.time_s[100]).abs() < 1e-9);
        assert_eq!(Log::joined(std::slice::from_ref(&one)).unwrap(), one);
        assert!(Log::joined(&[]).is_err());
    }
}
