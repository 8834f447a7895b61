//! Every way that the solver's passes can go.
//!
//! As long as it is known on which side of each threshold each input came out, every input is an affine function of the
//! parameters, and each threshold a plane: the set of all parameters is split there, and both parts are followed.

use super::polytope::{Affine, Polytope};
use super::program::{Held, Law, Program, Rule};

/// What an enumeration found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found<const D: usize> {
    /// Parts of the parameter set, by their passes less 1.
    pub by_passes: Vec<Parts<D>>,
    /// Cuts that left a part too thin to be followed.
    pub slivers: u64,
    /// Inside a part that was not solved within the passes allowed.
    pub unsolved: Option<[f64; D]>,
}

/// The parts that take the same number of passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts<const D: usize> {
    /// How many.
    pub count: u64,
    /// Of all together.
    pub volume: f64,
    /// Inside the first of them.
    pub example: [f64; D],
}

impl<const D: usize> Found<D> {
    /// The greatest number of passes.
    pub fn most(&self) -> usize {
        self.by_passes.len()
    }

    /// How many parts.
    pub fn count(&self) -> u64 {
        self.by_passes.iter().map(|parts| parts.count).sum()
    }

    /// What the parts cover.
    pub fn volume(&self) -> f64 {
        self.by_passes.iter().map(|parts| parts.volume).sum()
    }

    fn add(&mut self, piece: &Polytope<D>, passes: usize) {
        let example = piece.center();
        while self.by_passes.len() < passes {
            self.by_passes.push(Parts { count: 0, volume: 0.0, example });
        }
        let parts = &mut self.by_passes[passes - 1];
        if parts.count == 0 {
            parts.example = example;
        }
        parts.count += 1;
        parts.volume += piece.volume();
    }
}

/// Where the passes begin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Start {
    /// Which inputs are held.
    pub guess: Vec<Held>,
    /// Passes that went before.
    pub passes: usize,
}

impl Start {
    /// With everything free.
    pub fn cold(inputs: usize) -> Self {
        Self { guess: vec![Held::Free; inputs], passes: 0 }
    }
}

/// Follows every way from a start, for all parameters in `piece`, and calls `see` with each part that was solved and its number of
/// passes. With a `doubt` above 0, a wish so near a threshold may come out on either side: parts then overlap, and what is found
/// holds for any arithmetic whose wishes are off by no more.
pub fn enumerate<const D: usize>(
    program: &Program<D>,
    piece: Polytope<D>,
    start: &Start,
    doubt: f64,
    passes_max: usize,
    mut see: impl FnMut(&Polytope<D>, usize),
) -> Found<D> {
    let mut found = Found { by_passes: Vec::new(), slivers: 0, unsolved: None };
    let mut nodes = vec![(piece, start.guess.clone(), start.passes + 1)];
    while let Some((piece, guess, pass)) = nodes.pop() {
        if pass > passes_max {
            found.unsolved = Some(piece.center());
            return found;
        }
        let laws = program.laws(&guess);
        let rule = Rule::of_pass(pass);
        let mut roll_out = RollOut { laws: &laws, guess: &guess, rule, doubt, slivers: 0, ends: Vec::new() };
        roll_out.follow(piece, &mut Vec::new(), &mut Vec::new());
        found.slivers += roll_out.slivers;
        for (piece, next) in roll_out.ends {
            if next == guess {
                found.add(&piece, pass);
                see(&piece, pass);
            } else {
                nodes.push((piece, next, pass + 1));
            }
        }
    }
    found
}

/// One pass over one part.
struct RollOut<'a, const D: usize> {
    laws: &'a [Law<D>],
    guess: &'a [Held],
    rule: Rule,
    doubt: f64,
    slivers: u64,
    /// Parts and the guess that each comes to.
    ends: Vec<(Polytope<D>, Vec<Held>)>,
}

impl<const D: usize> RollOut<'_, D> {
    /// From the input after those in `inputs` on.
    fn follow(&mut self, mut piece: Polytope<D>, inputs: &mut Vec<Affine<D>>, next: &mut Vec<Held>) {
        if let Some(end) = self.rule.ends_with(next, self.guess) {
            return self.ends.push((piece, end));
        }
        let wish = self.laws[inputs.len()].wish(inputs);
        let (thresholds, ways) = self.rule.ways(self.guess[inputs.len()]);
        for (index, (held, input)) in ways.iter().enumerate() {
            let (here, rest) = match thresholds.get(index) {
                // on both sides the same guess, and the input is continuous: no doubt
                Some(threshold) if ways[index + 1].0 == *held => self.split(piece, &wish, *threshold, 0.0),
                Some(threshold) => self.split(piece, &wish, *threshold, self.doubt),
                None => (Some(piece), None),
            };
            if let Some(here) = here {
                inputs.push(input.map_or(wish, Affine::constant));
                next.push(*held);
                self.follow(here, inputs, next);
                inputs.pop();
                next.pop();
            }
            let Some(rest) = rest else { return };
            piece = rest;
        }
    }

    /// Where the wish may be below the threshold and where it may be above.
    fn split(
        &mut self,
        piece: Polytope<D>,
        wish: &Affine<D>,
        threshold: f64,
        doubt: f64,
    ) -> (Option<Polytope<D>>, Option<Polytope<D>>) {
        let mut at = |piece: Polytope<D>, threshold: f64| {
            let sides = piece.split(&Affine { constant: wish.constant - threshold, ..*wish });
            self.slivers += u64::from(sides.has_sliver);
            (sides.below, sides.above)
        };
        if doubt > 0.0 {
            (at(piece.clone(), threshold + doubt).0, at(piece, threshold - doubt).1)
        } else {
            at(piece, threshold)
        }
    }
}
