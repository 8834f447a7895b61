//! How far a diagnosis is, for whoever waits for it.

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// The base model is fitted, from several starts.
    Fitting {
        /// Starts done.
        done: usize,
        /// Of so many.
        total: usize,
    },
    /// A vehicle is identified.
    Identifying {
        /// Fits done.
        done: usize,
        /// Of so many.
        total: usize,
    },
    /// Hypotheses are tried beside the effects that were found so far; how many rounds there will be shows only at the
    /// end.
    Searching {
        /// Effects in the model.
        effects: usize,
        /// Hypotheses tried in this round.
        done: usize,
        /// Of so many.
        total: usize,
    },
    /// The effects are chosen again over other cuts of the log.
    Cutting {
        /// Cuts searched.
        done: usize,
        /// Of so many.
        total: usize,
    },
    /// Numbers of flights are found, to compare one with the others.
    Comparing {
        /// Flights done.
        done: usize,
        /// Of so many.
        total: usize,
    },
    /// Errors are taken apart, gains and intervals computed.
    Judging,
    /// Manoeuvres are flown in simulation that might separate effects that the log cannot separate.
    Separating {
        /// Manoeuvres flown.
        done: usize,
        /// Of so many.
        total: usize,
    },
}

impl Progress {
    /// How much of the present step is done, of how much, and the step in words.
    pub fn step(self) -> (usize, usize, String) {
        match self {
            Progress::Fitting { done, total } => (done, total, "fitting the base model".to_owned()),
            Progress::Identifying { done, total } => (done, total, "identifying the vehicle".to_owned()),
            Progress::Searching { effects: 0, done, total } => (done, total, "testing effects".to_owned()),
            Progress::Searching { effects, done, total } => {
                (done, total, format!("{effects} found, testing for another"))
            }
            Progress::Cutting { done, total } => (done, total, "searching other cuts of the log".to_owned()),
            Progress::Comparing { done, total } => (done, total, "comparing flights".to_owned()),
            Progress::Judging => (1, 1, "judging the findings".to_owned()),
            Progress::Separating { done, total } => (done, total, "looking for a separating flight".to_owned()),
        }
    }
}

/// Is called whenever something has been done.
pub type Observer<'a> = &'a (dyn Fn(Progress) + Sync);
