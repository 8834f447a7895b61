//! Rows as one Parquet file: `run` as a whole number, what was drawn and the figures as numbers or nothing, whether a
//! flight was lost as a truth value; what the study is as JSON under the key `sil.montecarlo`.

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::column::reader::get_typed_column_reader;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{BoolType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::about::About;
use super::study::{Kind, Row};

/// Under which a file says what study it is of.
const ABOUT_KEY: &str = "sil.montecarlo";

/// A file of rows that can't be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The operating system.
    #[error("cannot be read or written: {0}")]
    Io(#[from] std::io::Error),
    /// The format.
    #[error("not a Parquet file as sil writes it: {0}")]
    Parquet(#[from] ParquetError),
    /// What the file says of itself.
    #[error("no rows of a study: expected a file that sil montecarlo wrote ({0})")]
    NoStudy(String),
}

/// Writes a file that appears whole or not at all, a row group for each of these.
pub(super) fn write_file(
    path: &Path,
    about: &About,
    groups: impl Iterator<Item = Result<Vec<Row>, FileError>>,
) -> Result<(), FileError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".unfinished");
    let unfinished = path.with_file_name(name);
    let mut file = File::create(&unfinished)?;
    write(&mut file, about, groups)?;
    file.sync_all()?;
    Ok(fs::rename(&unfinished, path)?)
}

fn write(
    file: &mut File,
    about: &About,
    groups: impl Iterator<Item = Result<Vec<Row>, FileError>>,
) -> Result<(), FileError> {
    let json = serde_json::to_string(about).map_err(|error| FileError::NoStudy(error.to_string()))?;
    let properties = WriterProperties::builder()
        .set_key_value_metadata(Some(vec![KeyValue::new(ABOUT_KEY.to_owned(), json)]))
        // hardly any two numbers are equal
        .set_dictionary_enabled(false)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_created_by(format!("sil {}", env!("CARGO_PKG_VERSION")))
        .build();
    let mut writer = SerializedFileWriter::new(file, schema(about)?, Arc::new(properties))?;
    for rows in groups {
        let rows = rows?;
        let mut group = writer.next_row_group()?;
        let mut index = 0;
        while let Some(mut column) = group.next_column()? {
            write_column(column.untyped(), &rows, index)?;
            column.close()?;
            index += 1;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

/// Column 0 is the run, column k the value k - 1.
fn write_column(column: &mut ColumnWriter<'_>, rows: &[Row], index: usize) -> Result<(), FileError> {
    let value = |row: &Row| row.values.get(index.wrapping_sub(1)).copied().flatten();
    match column {
        ColumnWriter::Int64ColumnWriter(column) => {
            let runs: Vec<i64> = rows.iter().map(|row| row.run as i64).collect();
            column.write_batch(&runs, None, None)?;
        }
        ColumnWriter::BoolColumnWriter(column) => {
            let lost: Vec<bool> = rows.iter().map(|row| value(row) == Some(1.0)).collect();
            column.write_batch(&lost, None, None)?;
        }
        ColumnWriter::DoubleColumnWriter(column) => {
            let numbers: Vec<f64> = rows.iter().filter_map(value).collect();
            let levels: Vec<i16> = rows.iter().map(|row| i16::from(value(row).is_some())).collect();
            column.write_batch(&numbers, Some(&levels), None)?;
        }
        _ => return Err(FileError::NoStudy("a column of another type".to_owned())),
    }
    Ok(())
}

fn schema(about: &About) -> Result<TypePtr, ParquetError> {
    let field = |name: &str, physical, repetition| {
        Type::primitive_type_builder(name, physical).with_repetition(repetition).build().map(Arc::new)
    };
    let mut fields = vec![field("run", Physical::INT64, Repetition::REQUIRED)?];
    for column in &about.columns {
        fields.push(match column.kind {
            Kind::Lost => field(&column.name, Physical::BOOLEAN, Repetition::REQUIRED)?,
            Kind::Drawn | Kind::Figure => field(&column.name, Physical::DOUBLE, Repetition::OPTIONAL)?,
        });
    }
    Type::group_type_builder("runs").with_fields(fields).build().map(Arc::new)
}

/// A file of rows.
pub(super) struct RowFile {
    reader: SerializedFileReader<File>,
    about: About,
}

impl RowFile {
    pub(super) fn open(path: &Path) -> Result<Self, FileError> {
        let reader = SerializedFileReader::new(File::open(path)?)?;
        let metadata = reader.metadata().file_metadata();
        let entry = metadata.key_value_metadata().and_then(|all| all.iter().find(|entry| entry.key == ABOUT_KEY));
        let json = entry.and_then(|entry| entry.value.as_deref());
        let json = json.ok_or_else(|| FileError::NoStudy(format!("it lacks the key {ABOUT_KEY}")))?;
        let about: About = serde_json::from_str(json).map_err(|error| FileError::NoStudy(error.to_string()))?;
        if *metadata.schema() != *schema(&about)? {
            return Err(FileError::NoStudy("its columns are not those that it names".to_owned()));
        }
        Ok(Self { reader, about })
    }

    pub(super) fn about(&self) -> &About {
        &self.about
    }

    pub(super) fn rows(&self) -> u64 {
        self.reader.metadata().file_metadata().num_rows().unsigned_abs()
    }

    /// Every row in the order of the file, a row group in memory at a time.
    pub(super) fn for_each(&self, take: &mut dyn FnMut(Row)) -> Result<(), FileError> {
        for group in 0..self.reader.num_row_groups() {
            let group = self.reader.get_row_group(group)?;
            let count = group.metadata().num_rows().unsigned_abs() as usize;
            let mut runs = Vec::with_capacity(count);
            get_typed_column_reader::<Int64Type>(group.get_column_reader(0)?)
                .read_records(count, None, None, &mut runs)?;
            let mut rows: Vec<Row> =
                runs.into_iter().map(|run: i64| Row { run: run.unsigned_abs(), values: Vec::new() }).collect();
            for (index, column) in self.about.columns.iter().enumerate() {
                let reader = group.get_column_reader(index + 1)?;
                let values: Vec<Option<f64>> = if column.kind == Kind::Lost {
                    let mut lost = Vec::with_capacity(count);
                    get_typed_column_reader::<BoolType>(reader).read_records(count, None, None, &mut lost)?;
                    lost.into_iter().map(|lost| Some(f64::from(u8::from(lost)))).collect()
                } else {
                    let (mut numbers, mut levels) = (Vec::with_capacity(count), Vec::with_capacity(count));
                    get_typed_column_reader::<DoubleType>(reader).read_records(
                        count,
                        Some(&mut levels),
                        None,
                        &mut numbers,
                    )?;
                    let mut numbers = numbers.into_iter();
                    levels.into_iter().map(|level| if level == 1 { numbers.next() } else { None }).collect()
                };
                rows.iter_mut().zip(values).for_each(|(row, value)| row.values.push(value));
            }
            rows.into_iter().for_each(&mut *take);
        }
        Ok(())
    }
}
