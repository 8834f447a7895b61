//! A board's parameters as a file, in the form that ground stations save and load.
//!
//! A line is vehicle, component, name, value and type, with tabs or spaces between; `#` begins a comment. What the file
//! does not name has its default.

use std::path::{Path, PathBuf};

use shared_control::params::table::Field;
use shared_control::params::{Params, RECORD_LEN, decode};

use super::ParameterStore;
use crate::answer::board_parameters::params_file;

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum ParameterFileError {
    /// It is there and cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// A line that says nothing of a parameter, or what no parameter can be.
    #[error("{file}, line {line}: {problem}")]
    Line {
        /// The file.
        file: String,
        /// Counted from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
}

/// Reads a file; none where there is no such file.
///
/// # Errors
/// [`ParameterFileError`], with the line.
pub fn read(path: &Path, defaults: &Params) -> Result<Option<Params>, ParameterFileError> {
    match std::fs::read_to_string(path) {
        Ok(text) => parse(&text, &path.display().to_string(), defaults).map(Some),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(ParameterFileError::Unreadable { file: path.display().to_string(), source }),
    }
}

/// Reads the text of a file; `file` is what messages call it.
///
/// # Errors
/// [`ParameterFileError::Line`].
pub fn parse(text: &str, file: &str, defaults: &Params) -> Result<Params, ParameterFileError> {
    let mut params = *defaults;
    for (number, line) in (1..).zip(text.lines()) {
        let said = line.split('#').next().unwrap_or_default().trim();
        if !said.is_empty() {
            let problem = |problem| ParameterFileError::Line { file: file.to_owned(), line: number, problem };
            params = with_line(&params, said).map_err(problem)?;
        }
    }
    Ok(params)
}

fn with_line(params: &Params, line: &str) -> Result<Params, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [_, _, name, value, _] = words[..] else {
        return Err(format!("\"{line}\": expected vehicle, component, name, value and type, five words"));
    };
    let Some(field) = Field::by_name(name.as_bytes()) else {
        let names: Vec<_> = Field::ALL.into_iter().map(|field| field.row().name).collect();
        let near = names.iter().min_by_key(|known| strsim::damerau_levenshtein(known, name));
        return Err(format!("{name} is no parameter; the nearest name is {}", near.unwrap_or(&"")));
    };
    let allowed = field.row().allowed;
    let number: f32 = value.parse().map_err(|_| format!("{name}: \"{value}\" is no number"))?;
    let set = allowed.bits(number).and_then(|bits| params.with(field, bits));
    set.ok_or_else(|| format!("{name}: {value}; expected a whole number, {allowed}"))
}

/// All parameters as the text of a file.
pub fn text(name: &str, params: &Params) -> String {
    let values: Vec<_> =
        Field::ALL.into_iter().map(|field| (field.row().name, field.row().allowed.number(params.get(field)))).collect();
    params_file(name, &values)
}

/// Keeps parameters in a file, which is replaced as a whole: a reader finds the one before or the new one.
pub struct ParameterFile {
    path: PathBuf,
    name: String,
}

impl ParameterFile {
    /// Of this vehicle.
    pub fn new(path: PathBuf, name: String) -> Self {
        Self { path, name }
    }

    /// Writes it.
    ///
    /// # Errors
    /// The operating system's.
    pub fn write(&self, params: &Params) -> std::io::Result<()> {
        let mut beside = self.path.clone().into_os_string();
        beside.push(".new");
        std::fs::write(&beside, text(&self.name, params))?;
        std::fs::rename(&beside, &self.path)
    }
}

impl ParameterStore for ParameterFile {
    fn keep(&mut self, record: &[u8; RECORD_LEN]) -> bool {
        decode(record).is_ok_and(|params| self.write(&params).is_ok())
    }
}

/// Keeps parameters for as long as the program runs.
pub struct InMemory;

impl ParameterStore for InMemory {
    fn keep(&mut self, _: &[u8; RECORD_LEN]) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A value on each side of zero, and one of every kind.
    #[test]
    fn what_is_written_is_read_again() {
        let mut params = Params::DEFAULT;
        for (name, bits) in [("IMU1_ROLL_CDEG", -250i16 as u16), ("CONTROLLER", 1), ("BATT_LOW_MV", 65535)] {
            params = params.with(Field::by_name(name.as_bytes()).unwrap(), bits).unwrap();
        }
        let text = text("F450", &params);
        assert!(text.contains("1\t1\tIMU1_ROLL_CDEG\t-250\t9\n"), "{text}");
        assert_eq!(parse(&text, "a", &Params::DEFAULT).unwrap(), params);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.params");
        assert!(read(&path, &Params::DEFAULT).unwrap().is_none());
        let mut file = ParameterFile::new(path.clone(), "F450".to_owned());
        assert!(file.keep(&shared_control::params::encode(&params)));
        assert_eq!(read(&path, &Params::DEFAULT).unwrap(), Some(params));
        assert!(!ParameterFile::new(folder.path().join("no/such"), String::new()).keep(&[0; RECORD_LEN]));
    }

    #[test]
    fn a_mistake_is_named_with_its_line() {
        for (line, expected) in [
            ("1 1 CONTROLER 1 9", "line 2: CONTROLER is no parameter; the nearest name is CONTROLLER"),
            ("1 1 CONTROLLER 2 9", "line 2: CONTROLLER: 2; expected a whole number, 0 or 1"),
            ("1 1 CONTROLLER 0.5 9", "line 2: CONTROLLER: 0.5; expected a whole number, 0 or 1"),
            ("1 1 CONTROLLER one 9", "line 2: CONTROLLER: \"one\" is no number"),
            ("CONTROLLER 1", "line 2: \"CONTROLLER 1\": expected vehicle, component, name, value and type"),
        ] {
            let error = parse(&format!("# comment\n{line}\n"), "v.params", &Params::DEFAULT).unwrap_err().to_string();
            assert!(error.contains(&format!("v.params, {expected}")), "{error}");
        }
    }
}
