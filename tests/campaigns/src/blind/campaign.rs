//! The blind campaigns: what is hidden, how often, and what is reported of the answers.

use rayon::prelude::*;

use super::case::Case;
use super::outcome::Outcome;
use super::score::{Score, percent};

/// A kind of cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Campaign {
    /// One effect, control at the log's rate.
    Singles,
    /// Nothing.
    Nominal,
    /// One effect, control at 400 Hz, logs at 100 and 200 Hz.
    LostCommands,
    /// Two effects.
    Pairs,
    /// Three.
    Triples,
    /// Something that no catalogue has.
    Outside,
    /// One effect in free flight, control at the log's rate.
    Free,
    /// One effect or none, in a vehicle of which everything is a little off.
    Reality,
}

impl Campaign {
    /// All, in the order of the issue.
    pub const ALL: [Campaign; 8] = [
        Campaign::Singles,
        Campaign::Nominal,
        Campaign::LostCommands,
        Campaign::Pairs,
        Campaign::Triples,
        Campaign::Outside,
        Campaign::Free,
        Campaign::Reality,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Campaign::Singles => "singles",
            Campaign::Nominal => "nominal",
            Campaign::LostCommands => "lost-commands",
            Campaign::Pairs => "pairs",
            Campaign::Triples => "triples",
            Campaign::Outside => "outside",
            Campaign::Free => "free",
            Campaign::Reality => "reality",
        }
    }

    /// Cases of the whole campaign.
    pub fn cases(self) -> u64 {
        match self {
            Campaign::Singles => 200,
            Campaign::Nominal | Campaign::LostCommands | Campaign::Reality => 100,
            Campaign::Pairs | Campaign::Triples => 60,
            Campaign::Outside => 70,
            Campaign::Free => 40,
        }
    }

    /// Seeds of about a tenth of it, and how many of them are answered right: fewer is a step back. All effects occur
    /// among the singles, every second where commands are lost, all kinds of things outside the catalogue, and mass,
    /// drag, ground, wind and rotors in free flight. Of those that imitate reality it is seven, for each takes half a
    /// minute, in which each step of the search has something to do (a spring that costs a roll channel 1.7 %, 17; an
    /// onset behind other causes, 26; dry friction beside viscous, 44).
    pub fn tenth(self) -> (Vec<u64>, usize) {
        match self {
            Campaign::Singles => ((0..20).collect(), 20),
            Campaign::Nominal => ((0..10).collect(), 10),
            Campaign::LostCommands => ((0..10).map(|k| 2 * k).collect(), 10),
            Campaign::Pairs => ((0..6).collect(), 6),
            Campaign::Triples => ((0..6).collect(), 5),
            Campaign::Outside => ((0..7).collect(), 7),
            Campaign::Free => (vec![0, 5, 10, 15, 21], 5),
            Campaign::Reality => (vec![1, 10, 17, 26, 44, 60, 76], 7),
        }
    }

    /// A case of it with a log of this length.
    pub fn case(self, seed: u64, duration_s: f64) -> Case {
        match self {
            Campaign::Singles => Case::single(seed, duration_s),
            Campaign::Nominal => Case::nominal(seed, duration_s),
            Campaign::LostCommands => Case::with_lost_commands(seed, duration_s),
            Campaign::Pairs => Case::combined(seed, duration_s, 2),
            Campaign::Triples => Case::combined(seed, duration_s, 3),
            Campaign::Outside => Case::outside(seed, duration_s),
            Campaign::Free => Case::free(seed, duration_s),
            Campaign::Reality => Case::reality(seed, duration_s),
        }
    }

    /// Makes cases and has them diagnosed; `observer` sees each as it is done.
    pub fn run(self, seeds: &[u64], duration_s: f64, observer: impl Fn(&Case, &Outcome) + Sync) -> Score {
        let one = |seed: &u64| {
            let case = self.case(*seed, duration_s);
            let outcome = Outcome::of(&case);
            observer(&case, &outcome);
            outcome
        };
        Score { outcomes: seeds.par_iter().with_max_len(1).map(one).collect() }
    }

    /// The tables.
    pub fn report(self, score: &Score) -> String {
        let rows: Vec<(&str, &str, f64)> = match self {
            Campaign::Singles | Campaign::LostCommands | Campaign::Free => vec![
                (
                    "first finding right",
                    if self == Campaign::LostCommands { "90 %" } else { "98 %" },
                    score.first_is_right(),
                ),
                ("with a further finding that is not there", "at most 5 %", score.false_findings()),
                ("size within 10 %, of right names", "90 %", score.sized()),
                ("value +- 1.96 std holds the truth", "90 to 99 %", score.covered()),
            ],
            Campaign::Nominal => vec![("without a finding", "99 %", score.without_finding())],
            Campaign::Pairs | Campaign::Triples => vec![
                ("all named", if self == Campaign::Pairs { "90 %" } else { "75 %" }, score.all_named()),
                ("with a finding that is not there", "", score.false_findings()),
                ("size within 10 %, of right names", "", score.sized()),
                ("value +- 1.96 std holds the truth", "", score.covered()),
            ],
            Campaign::Reality => vec![
                ("cause named, of those that the log shows", "95 %", score.shown_is_named()),
                ("nothing false told as certain", "95 %", score.nothing_false()),
                ("lag and delay, lift, trims all right", "95 %", score.base_is_right()),
            ],
            Campaign::Outside => vec![
                ("unknown_effect or partly_explained", "90 %", score.unknown_admitted()),
                ("explained by something that is not there", "0", score.explained()),
                ("signature says axis or motor, and quantity", "", score.signed()),
            ],
        };
        let mut text =
            format!("### {}, {} cases\n\n| | goal | measured |\n|---|---|---|\n", self.name(), score.outcomes.len());
        for (what, goal, share) in rows {
            text += &format!("| {what} | {goal} | {} |\n", percent(share));
        }
        text += &format!("\nVerdicts: {}.\n", score.verdicts());
        if let Campaign::Singles | Campaign::LostCommands | Campaign::Free = self {
            for table in [score.by_size(), score.confusion()] {
                text += &format!("\n{table}");
            }
        }
        // with lost commands the true model's own error hangs on what is made of them
        if self == Campaign::Reality {
            text += &format!("\n{}", score.beside_reality());
        }
        if !matches!(self, Campaign::Outside | Campaign::LostCommands | Campaign::Reality) {
            text += &format!("\n{}", score.gains());
        }
        text
    }
}

/// Every campaign's [`Campaign::tenth`]. All cases are one heap of work for all cores: a campaign that waited for the
/// last case of the one before it would leave cores idle.
pub fn tenth(duration_s: f64) -> Vec<(Campaign, Score)> {
    let cases: Vec<(Campaign, u64)> = Campaign::ALL
        .into_iter()
        .flat_map(|campaign| campaign.tenth().0.into_iter().map(move |seed| (campaign, seed)))
        .collect();
    let outcome = |(campaign, seed): &(Campaign, u64)| (*campaign, Outcome::of(&campaign.case(*seed, duration_s)));
    let outcomes: Vec<(Campaign, Outcome)> = cases.par_iter().with_max_len(1).map(outcome).collect();
    let of = |campaign| outcomes.iter().filter(move |of| of.0 == campaign).map(|of| of.1.clone()).collect();
    Campaign::ALL.into_iter().map(|campaign| (campaign, Score { outcomes: of(campaign) })).collect()
}
