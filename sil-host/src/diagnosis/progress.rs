//! How far a diagnosis is, for whoever waits for it.

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
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

/// Is called whenever something has been done.
pub type Observer<'a> = &'a (dyn Fn(Progress) + Sync);
