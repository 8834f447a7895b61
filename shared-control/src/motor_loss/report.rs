//! What is said of the motors on the link and in the log: few bytes, as it waits in queues.

use super::Stage;
use super::detector::Suspicion;

/// How the motors are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorReport {
    /// How far a loss is beyond doubt.
    pub verdict: Verdict,
    /// The motor that it is about, 1 to 4; 0 where none is.
    pub motor: u8,
    /// Share of its lift that it lacks, 1/1000; of one that is lost, as it was found.
    pub lacks_permille: u16,
}

/// A [`Stage`] without its numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// All four lift what they should, or nobody looks.
    #[default]
    Whole,
    /// One seems to lift less.
    Suspected,
    /// One is given up.
    Lost,
    /// One was found to lift less than it should, and is told to lift more.
    Weak,
}

impl Verdict {
    /// Its number on the link.
    pub fn number(self) -> u32 {
        match self {
            Verdict::Whole => 0,
            Verdict::Suspected => 1,
            Verdict::Lost => 2,
            Verdict::Weak => 3,
        }
    }
}

impl MotorReport {
    /// Of a stage, of the share of its lift that the motor lacks, and of the weakest motor if nothing else is said.
    pub(super) fn new(stage: Stage, lacks_share: f32, weakest: Option<(usize, f32)>) -> Self {
        let (verdict, motor, lacks_share) = match (stage, weakest) {
            (Stage::Whole, None) => return Self::default(),
            (Stage::Whole, Some((motor, lacks_share))) => (Verdict::Weak, motor, lacks_share),
            (Stage::Suspected(Suspicion { motor, .. }), _) => (Verdict::Suspected, motor, lacks_share),
            (Stage::Lost(motor), _) => (Verdict::Lost, motor, lacks_share),
        };
        // a share of 0 to 1; `as` makes 0 of what is no number
        Self { verdict, motor: (motor & 3) as u8 + 1, lacks_permille: (1000.0 * lacks_share) as u16 }
    }

    /// The motor that is given up, 1 to 4.
    pub fn lost_motor(&self) -> Option<u8> {
        (self.verdict == Verdict::Lost).then_some(self.motor)
    }

    /// The same as figures with their names.
    pub fn figures(&self) -> [(&'static str, u32); 3] {
        [
            ("mot_state", self.verdict.number()),
            ("mot_number", self.motor.into()),
            ("mot_lack", self.lacks_permille.into()),
        ]
    }
}
