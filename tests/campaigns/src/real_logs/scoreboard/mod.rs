//! The scoreboard: how right the diagnosis is on every real log, by what the logs themselves can say about it.
//!
//! ```text
//! entries: every log that is read, its stretches in flight
//!     -> score: the answer to all of it -> channels (held-out error, fit), implausible (bounds, signs)
//!               the answers to its halves -> agreement (names, z of the sizes)
//!               the answers to eight other cuts -> how often each name is found
//!     -> summary: by vehicle, and against the goals -> table, JSON
//! ```
//!
//! Nothing in it knows a truth about the vehicles. Everything but the times is the same in every run, whatever the
//! number of threads; with a limited patience it depends on the machine which cuts are tried.

mod agreement;
mod answer;
mod channels;
mod cuts;
mod entries;
mod implausible;
mod score;
mod summary;
mod table;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;

pub use answer::{Named, sized_terms};
pub use channels::{COMMAND_MIN, command_std};
pub use cuts::spans_of;
pub use entries::{Entry, entries, files_of};
pub use score::{Effort, LogScore, score};
pub use summary::Summary;
pub use table::{of_log, of_summary};

/// All scores with their summary.
#[derive(Debug, Serialize)]
pub struct Scoreboard {
    /// Over all logs.
    pub summary: Summary,
    /// Log by log.
    pub logs: Vec<LogScore>,
}

impl Scoreboard {
    /// Of the scores of some logs.
    pub fn of(logs: Vec<LogScore>) -> Scoreboard {
        Scoreboard { summary: Summary::of(&logs.iter().collect::<Vec<_>>()), logs }
    }
}

/// Does something with each of some logs or files, so many side by side, each in one thread; the results in the order
/// of the logs. `done` is called with each, and its number, as it is there.
///
/// # Panics
/// The system has no threads to give.
pub fn side_by_side<E: Sync, T: Send>(
    entries: &[E],
    threads: usize,
    of: impl Fn(&E) -> T + Sync,
    done: impl Fn(usize, &T) + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
                while let Some((place, entry)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|place| Some((place, entries.get(place)?)))
                {
                    let result = pool.install(|| of(entry));
                    done(place, &result);
                    results.lock().expect("no thread panics here").push((place, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("no thread panics here");
    results.sort_by_key(|(place, _)| *place);
    results.into_iter().map(|(_, result)| result).collect()
}
