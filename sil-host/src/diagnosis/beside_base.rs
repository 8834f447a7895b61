//! The search beside a base model. What a cause does, of which nothing is known yet, may make terms of that base model
//! seem harmful that are not: where it says so once the cause is known, the search begins anew beside the larger one.
//!
//! ```text
//! .-> base model -> hypotheses beside it -> search -> the base model once more, with the causes in it
//! '-------------------------- it has more terms <--'
//! ```

use super::base::{self, USUAL_LAG_AND_DELAY_S};
use super::few_commands;
use super::fitted::Fitted;
use super::found::Found;
use super::judge;
use super::kinematics::Kinematics;
use super::known::Known;
use super::search::Search;
use crate::diagnosis::fitting::fit::Term;
use crate::effects::Scope;

/// Searches beside one base model after the other, each larger than the one before.
pub(super) const BASES_MAX: usize = 3;

/// What may be beside the base models of a log, and in them.
pub(super) struct BesideBase<'a> {
    pub(super) scope: &'a Scope,
    pub(super) known: &'a Known,
    pub(super) sensors: &'a Kinematics,
    /// What base models are made of.
    pub(super) ordinary: &'a [Fitted],
    /// The log has so few of the commands that only its sensors can be judged.
    pub(super) few_commands: bool,
}

impl BesideBase<'_> {
    /// Searches, and concludes from the last search what is wanted.
    pub(super) fn search<'e, T>(
        &'e self,
        search: Search<'e>,
        base: &[Term<'e>],
        bases: usize,
        conclude: impl FnOnce(&Search<'_>, Found<'_>) -> T,
    ) -> T {
        let beside = Fitted::beside(self.scope, |axis| base::is_trimmed(base, axis));
        let mut catalogue = self.known.leaves(self.sensors.informed(beside));
        catalogue.retain(|effect| !self.few_commands || few_commands::is_asked(effect));
        let search = search.from(base, &catalogue);
        let found = search.run();
        match (bases > 1).then(|| larger_base(&search, self.ordinary, &found)).flatten() {
            Some(base) => self.search(search, &base, bases - 1, conclude),
            None => conclude(&search, found),
        }
    }
}

/// The base model with what is useful of all that is ordinary once the causes are known; none if that is no more than
/// it has.
fn larger_base<'e>(search: &Search<'e>, ordinary: &'e [Fitted], found: &Found<'e>) -> Option<Vec<Term<'e>>> {
    let lacks = |effect: &Fitted| !search.always.iter().any(|term| term.effect.is_the_same(effect));
    let is_cause = |term: &&Term<'e>| !ordinary.iter().any(|effect| effect.is_the_same(term.effect));
    let chosen = &found.refitted.chosen;
    let causes: Vec<Term<'e>> = chosen.terms[search.always.len()..].iter().filter(is_cause).cloned().collect();
    if causes.is_empty() || !ordinary.iter().any(lacks) {
        return None;
    }
    let begun = |effect: &'e Fitted| {
        let as_found = chosen.terms.iter().find(|term| term.effect.is_the_same(effect)).map(|term| term.values.clone());
        Term { effect, values: as_found.unwrap_or_else(|| effect.beginning(&USUAL_LAG_AND_DELAY_S)) }
    };
    let gains = chosen.terms[..search.gains.len()].iter().cloned();
    let terms = gains.chain(ordinary.iter().map(begun)).chain(causes.iter().cloned()).collect();
    let mut useful = judge::useful(search, search.refitted(terms, &chosen.starts), causes.len()).terms;
    useful.truncate(useful.len() - causes.len());
    useful.iter().any(|term| lacks(term.effect)).then_some(useful)
}
