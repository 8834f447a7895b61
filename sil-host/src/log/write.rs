//! From a [`Log`] to a file: the same log gives the same bytes, and reading those of a CSV gives the same log to the
//! bit.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use flate2::{Compression, GzBuilder};

use super::Log;
use super::error::{LogError, LogErrorKind};
use super::quantity::Quantity;

/// Writes a log to a file: as ULog if its name ends in `.ulg`, else as CSV; compressed with a further `.gz`.
///
/// # Errors
/// The file can't be written, the log's columns differ in length, or the format has no place for one.
pub fn write_file(log: &Log, path: &Path) -> Result<(), LogError> {
    let fail = |kind| LogError { file: path.display().to_string(), line: None, column: None, kind };
    check_lengths(log).map_err(|(column, kind)| LogError { column: Some(column), ..fail(kind) })?;
    let is_ulog = super::has_extension(path, "ulg");
    let write_to = |out: &mut dyn Write| if is_ulog { super::ulog::write(log, out) } else { write(log, out) };
    let create = || -> io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        if path.extension().is_some_and(|extension| extension == "gz") {
            // no name and no time in the head, so that the bytes depend on the log alone
            let mut gzip = GzBuilder::new().write(&mut file, Compression::default());
            write_to(&mut gzip)?;
            gzip.finish()?;
        } else {
            write_to(&mut file)?;
        }
        file.flush()
    };
    create().map_err(|e| fail(LogErrorKind::Unwritable(e)))
}

/// Writes a log as CSV in the columns of docs/log-format.md, SI units, comments first. Numbers have the fewest digits
/// that read back to the same bits. Columns must be as long as `time_s`; rows beyond a shorter one are not written.
///
/// # Errors
/// Those of `out`.
pub fn write(log: &Log, mut out: impl Write) -> io::Result<()> {
    for comment in log.comments.iter().flat_map(|comment| comment.split('\n')) {
        writeln!(out, "# {comment}")?;
    }
    let present = Quantity::ALL.map(|quantity| (quantity, log.column(quantity)));
    let columns: Vec<(Quantity, &[f64])> =
        present.into_iter().filter_map(|(quantity, column)| Some((quantity, column?))).collect();
    let names: Vec<String> = columns.iter().map(|(quantity, _)| quantity.name()).collect();
    writeln!(out, "{}", names.join(","))?;
    for row in 0..log.rows() {
        for (place, (_, column)) in columns.iter().enumerate() {
            let separator = if place == 0 { "" } else { "," };
            let Some(value) = column.get(row) else {
                return Ok(());
            };
            write!(out, "{separator}{value}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn check_lengths(log: &Log) -> Result<(), (String, LogErrorKind)> {
    for quantity in Quantity::ALL {
        let found = log.column(quantity).map_or(log.rows(), <[f64]>::len);
        if found != log.rows() {
            let expected = log.rows();
            return Err((quantity.name(), LogErrorKind::UnequalColumns { expected, found }));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::log::{ROWS_MIN, parse, read};

    /// Any log that docs/log-format.md allows: motors, all optional columns or none, awkward numbers.
    fn any_log() -> impl Strategy<Value = Log> {
        let rows = ROWS_MIN..ROWS_MIN + 20;
        (rows, any::<bool>(), any::<u64>()).prop_flat_map(|(rows, optional, seed)| {
            let columns = proptest::collection::vec(-1.0..1.0_f64, rows * Quantity::ALL.len());
            let steps = proptest::collection::vec(1e-6..0.1_f64, rows);
            (columns, steps).prop_map(move |(values, steps)| {
                let mut log = Log {
                    comments: vec![format!("made of seed {seed}"), String::new()],
                    axes: [true, true, optional],
                    ..Log::default()
                };
                for (place, quantity) in Quantity::ALL.into_iter().enumerate() {
                    let values = &values[place * rows..(place + 1) * rows];
                    let column = match quantity {
                        Quantity::Time => running_sum(&steps),
                        Quantity::Motor(_) | Quantity::Thrust => values.iter().map(|v| v.abs()).collect(),
                        // the limits of docs/log-format.md are far wider than 1
                        _ => values.iter().map(|v| v * v * v * 9.99).collect(),
                    };
                    let column = match quantity {
                        Quantity::Command(_) | Quantity::Stick(_) => values.to_vec(),
                        _ => column,
                    };
                    let is_yaw = quantity.name().starts_with(['y', 'r']) && !is_required(quantity);
                    if is_required(quantity) || (optional && (is_yaw || place % 2 == 0)) {
                        log.set_column(quantity, column);
                    }
                }
                log
            })
        })
    }

    fn running_sum(steps: &[f64]) -> Vec<f64> {
        let mut time_s = -1.0;
        let next = |step: &f64| {
            time_s += step;
            time_s
        };
        steps.iter().map(next).collect()
    }

    fn is_required(quantity: Quantity) -> bool {
        use crate::axis::Axis::Yaw;
        match quantity {
            Quantity::Time | Quantity::Motor(_) => true,
            Quantity::Angle(axis) | Quantity::Rate(axis) => axis != Yaw,
            _ => false,
        }
    }

    /// What the reader adds by itself.
    fn without_reader_remarks(log: Log) -> Log {
        Log { path: String::new(), notes: Vec::new(), ..log }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn reading_what_was_written_gives_the_same_log_to_the_bit(log in any_log()) {
            let mut bytes = Vec::new();
            write(&log, &mut bytes).unwrap();
            let text = String::from_utf8(bytes).unwrap();
            let read_back = parse("log.csv", &text, None).unwrap();
            let read_back = without_reader_remarks(read_back);
            for quantity in Quantity::ALL {
                prop_assert_eq!(read_back.column(quantity), log.column(quantity), "{}", quantity.name());
            }
            prop_assert_eq!(read_back, log);
        }
    }

    fn small_log() -> Log {
        let column = |value: f64| Some(vec![value; ROWS_MIN]);
        Log {
            comments: vec!["synthetic".to_owned()],
            axes: [true, true, false],
            time_s: (0..ROWS_MIN).map(|row| row as f64 * 0.004).collect(),
            angle_rad: [column(0.1), column(-0.2), None],
            rate_rad_s: [column(1e-17), column(-0.0), None],
            motor_command: [column(0.5), column(0.5), column(0.5), column(1.0 / 3.0)],
            ..Log::default()
        }
    }

    #[test]
    fn both_kinds_of_file_read_back_and_have_the_same_bytes_each_time() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["log.csv", "log.csv.gz"] {
            let [first, again] = ["a", "b"].map(|sub| {
                let path = folder.path().join(format!("{sub}-{name}"));
                write_file(&small_log(), &path).unwrap();
                let read_back = read(&path, None).unwrap();
                assert_eq!(without_reader_remarks(read_back), small_log());
                std::fs::read(path).unwrap()
            });
            assert_eq!(first, again);
            assert_eq!(first.starts_with(&[0x1f, 0x8b]), name.ends_with("gz"));
        }
    }

    #[test]
    fn columns_of_unequal_length_are_refused() {
        let mut log = small_log();
        log.battery_v = Some(vec![11.1; ROWS_MIN - 1]);
        let path = tempfile::tempdir().unwrap().path().join("log.csv");
        let message = write_file(&log, &path).unwrap_err().to_string();
        assert!(message.ends_with("`battery_v`: expected columns of 100 values, found 99"));
    }
}
