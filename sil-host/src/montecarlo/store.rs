//! Rows in Parquet files, in parts of 200 runs that appear whole or not at all: what was interrupted goes on, and parts
//! from anywhere are put together in the order of their runs.

use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::about::About;
use super::draw::DrawError;
use super::parquet_file::{FileError, RowFile, write_file};
use super::study::{Row, Study};

/// Runs of a part: seconds of work, so that a kill loses no more.
pub const PART_RUNS: u64 = 200;

/// Parts of a row group of the whole file: few enough to be held, many enough that a million runs have 100 groups.
const PARTS_OF_GROUP: usize = 50;

/// Runs that each thread has at least between two meetings, so that waiting for the last costs little.
const RUNS_OF_THREAD: u64 = 16;

/// Rows that can't be collected.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        source: FileError,
    },
    /// Rows that were flown with other numbers.
    #[error(
        "{}: holds another study (model, controller, scenario, seed or version differ): choose another name, or remove \
         it",
        path.display()
    )]
    OtherStudy {
        /// The file or the folder.
        path: PathBuf,
    },
    /// A vehicle.
    #[error(transparent)]
    Draw(#[from] DrawError),
}

/// Which runs of a study are flown here: those of every n-th part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Runs of the whole study.
    pub runs: u64,
    /// Which shard, from 1.
    pub shard: u64,
    /// Of how many.
    pub shards: u64,
}

/// What collecting came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collected {
    /// Runs flown now.
    pub flown: u64,
    /// Runs that were there already.
    pub found: u64,
}

/// Runs whose rows appear together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The first run.
    pub begin: u64,
    /// The run after the last.
    pub end: u64,
}

impl Share {
    fn parts(&self) -> Vec<Part> {
        let all = (0..self.runs.div_ceil(PART_RUNS)).filter(|part| part % self.shards == self.shard - 1);
        let part = |index: u64| Part { begin: index * PART_RUNS, end: (index * PART_RUNS + PART_RUNS).min(self.runs) };
        all.map(part).collect()
    }
}

impl Part {
    fn runs(&self) -> u64 {
        self.end - self.begin
    }

    fn path(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{:09}-{:09}.parquet", self.begin, self.end - 1))
    }

    /// Where its rows stand while those of the rows of `out` that are left are flown.
    pub fn path_beside(&self, out: &Path) -> PathBuf {
        self.path(&parts_folder(out))
    }
}

/// Flies what is missing of a share and leaves all of its rows in one file, in the order of their runs. `progress` gets
/// the runs that are there and how many there will be.
///
/// # Errors
/// [`StoreError`]; what was flown until then is kept.
pub fn collect(
    study: &Study,
    about: &About,
    share: &Share,
    out: &Path,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Collected, StoreError> {
    let parts = share.parts();
    let total: u64 = parts.iter().map(Part::runs).sum();
    let folder = parts_folder(out);
    let Some(missing) = missing(about, share, out)? else {
        return Ok(Collected { flown: 0, found: total });
    };
    let flown: u64 = missing.iter().map(Part::runs).sum();
    let done = std::sync::atomic::AtomicU64::new(total - flown);
    progress(total - flown, total);
    let fly = |run: u64| {
        let row = study.fly(run)?;
        progress(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, total);
        Ok::<Row, DrawError>(row)
    };
    let at_a_time = (rayon::current_num_threads() as u64 * RUNS_OF_THREAD).div_ceil(PART_RUNS) as usize;
    for parts in missing.chunks(at_a_time) {
        let runs: Vec<u64> = parts.iter().flat_map(|part| part.begin..part.end).collect();
        let mut rows = runs.into_par_iter().map(fly).collect::<Result<Vec<Row>, DrawError>>()?.into_iter();
        for part in parts {
            let of_part: Vec<Row> = rows.by_ref().take(part.runs() as usize).collect();
            write_part(about, of_part, &part.path(&folder))?;
        }
    }
    let groups = parts.chunks(PARTS_OF_GROUP).map(|parts| {
        let mut rows = Vec::new();
        for part in parts {
            RowFile::open(&part.path(&folder))?.for_each(&mut |row| rows.push(row))?;
        }
        Ok(rows)
    });
    write_file(out, about, groups).map_err(at(out))?;
    fs::remove_dir_all(&folder).map_err(|source| at(&folder)(source.into()))?;
    Ok(Collected { flown, found: total - flown })
}

/// The parts of a share that are not there yet, with a folder for them; none if the file of its rows is whole.
///
/// # Errors
/// [`StoreError`].
pub fn missing(about: &About, share: &Share, out: &Path) -> Result<Option<Vec<Part>>, StoreError> {
    let (parts, folder) = (share.parts(), parts_folder(out));
    if out.exists() && !folder.exists() {
        let file = open(out, about)?;
        if file.rows() == parts.iter().map(Part::runs).sum::<u64>() {
            return Ok(None);
        }
        take_over(out, about, &parts, &folder)?;
    }
    fs::create_dir_all(&folder).map_err(|source| at(&folder)(source.into()))?;
    let mut missing = Vec::new();
    for part in parts {
        let path = part.path(&folder);
        if !path.exists() || open(&path, about)?.rows() != part.runs() {
            missing.push(part);
        }
    }
    Ok(Some(missing))
}

/// Flies one part, one run after the other, and writes its rows.
///
/// # Errors
/// [`StoreError`].
pub fn fly_part(study: &Study, about: &About, part: &Part, path: &Path) -> Result<(), StoreError> {
    let rows = (part.begin..part.end).map(|run| study.fly(run)).collect::<Result<Vec<Row>, DrawError>>()?;
    write_part(about, rows, path)
}

fn write_part(about: &About, rows: Vec<Row>, path: &Path) -> Result<(), StoreError> {
    write_file(path, about, [Ok(rows)].into_iter()).map_err(at(path))
}

/// Makes parts of a file of the same study with other runs.
fn take_over(out: &Path, about: &About, parts: &[Part], folder: &Path) -> Result<(), StoreError> {
    fs::create_dir_all(folder).map_err(|source| at(folder)(source.into()))?;
    let mut pending: Vec<Row> = Vec::new();
    let mut result = Ok(());
    let mut take = |row: Row| {
        let Some(part) = parts.iter().find(|part| (part.begin..part.end).contains(&row.run)) else { return };
        if row.run == part.begin {
            pending.clear();
        }
        let is_last = row.run + 1 == part.end;
        pending.push(row);
        if is_last && pending.len() as u64 == part.runs() && result.is_ok() {
            result = write_part(about, std::mem::take(&mut pending), &part.path(folder));
        }
    };
    RowFile::open(out).and_then(|file| file.for_each(&mut take)).map_err(at(out))?;
    result
}

/// Opens a file that must be of the same study.
fn open(path: &Path, about: &About) -> Result<RowFile, StoreError> {
    let file = RowFile::open(path).map_err(at(path))?;
    if file.about().identity == about.identity {
        return Ok(file);
    }
    Err(StoreError::OtherStudy { path: path.to_owned() })
}

/// Reads the rows of files of one study, one after the other; says what it is.
///
/// # Errors
/// [`StoreError`] for a file that can't be read, and for files of several studies.
pub fn read_rows(paths: &[PathBuf], mut take: impl FnMut(&About, Row)) -> Result<Option<About>, StoreError> {
    let mut about: Option<About> = None;
    for path in paths {
        let file = match &about {
            None => RowFile::open(path).map_err(at(path))?,
            Some(about) => open(path, about)?,
        };
        let about = &*about.get_or_insert_with(|| file.about().clone());
        file.for_each(&mut |row| take(about, row)).map_err(at(path))?;
    }
    Ok(about)
}

fn parts_folder(out: &Path) -> PathBuf {
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(".parts");
    out.with_file_name(name)
}

fn at(path: &Path) -> impl Fn(FileError) -> StoreError {
    let path = path.to_owned();
    move |source| StoreError::File { path: path.clone(), source }
}
