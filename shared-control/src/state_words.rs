//! A [`State`](crate::flight_core::State) as plain words, so that two targets, which lay it out differently, can be
//! compared to the bit.
//!
//! Each part of the state writes its own words, in the order of its fields, and takes itself apart without `..`: a new
//! field that is not written does not compile. Every state has the same number of words, whatever is in its options.

use nalgebra::{UnitQuaternion, Vector3};

use crate::imu_health::ImuFault;
use crate::supervisor::{Arming, DisarmedBecause, Refusal};

/// Words of a state.
pub const STATE_WORDS: usize = 208;

/// Takes words until all have come.
#[derive(Clone, Debug)]
pub struct StateWords {
    pub(crate) words: [u32; STATE_WORDS],
    /// How many were written, those for which there was no room included.
    pub(crate) written: usize,
}

impl StateWords {
    pub(crate) const EMPTY: Self = Self { words: [0; STATE_WORDS], written: 0 };

    pub(crate) fn word(&mut self, word: u32) {
        if let Some(place) = self.words.get_mut(self.written) {
            *place = word;
        }
        self.written += 1;
    }

    pub(crate) fn number(&mut self, number: f32) {
        self.word(number.to_bits());
    }

    pub(crate) fn numbers(&mut self, numbers: &[f32]) {
        for number in numbers {
            self.number(*number);
        }
    }

    pub(crate) fn vector(&mut self, vector: &Vector3<f32>) {
        self.numbers(&[vector.x, vector.y, vector.z]);
    }

    pub(crate) fn rotation(&mut self, q: &UnitQuaternion<f32>) {
        self.numbers(&[q.w, q.i, q.j, q.k]);
    }

    /// Low word first.
    pub(crate) fn time_us(&mut self, time_us: u64) {
        self.word(time_us as u32);
        self.word((time_us >> 32) as u32);
    }

    /// 1 and the value, or zeros.
    pub(crate) fn optional_time_us(&mut self, time_us: Option<u64>) {
        self.word(u32::from(time_us.is_some()));
        self.time_us(time_us.unwrap_or_default());
    }

    pub(crate) fn arming(&mut self, arming: &Arming) {
        let (kind, detail, time_us) = match *arming {
            Arming::Armed => (0, 0, 0),
            Arming::Disarmed(because) => (1, number_of_reason(because), 0),
            Arming::MotorTest { motor, throttle_percent, until_us } => {
                (2, u32::from(motor) << 8 | u32::from(throttle_percent), until_us)
            }
            Arming::LinkLost { since_us } => (3, 0, since_us),
        };
        self.word(kind);
        self.word(detail);
        self.time_us(time_us);
    }
}

fn number_of_reason(because: DisarmedBecause) -> u32 {
    match because {
        DisarmedBecause::Start => 0,
        DisarmedBecause::Requested => 1,
        DisarmedBecause::AttitudeUnknown => 2,
        DisarmedBecause::LinkLost => 3,
        DisarmedBecause::MotorTestOver => 4,
        DisarmedBecause::ImuFailed(fault) => 0x10 + number_of_fault(fault),
        DisarmedBecause::Refused(refusal) => 0x100 + number_of_refusal(refusal),
    }
}

fn number_of_refusal(refusal: Refusal) -> u32 {
    match refusal {
        Refusal::SetpointNotFinite => 0,
        Refusal::ThrottleNotZero => 1,
        Refusal::AttitudeUnknown => 2,
        Refusal::GyroNotCalibrated => 3,
        Refusal::BatteryLow => 4,
        Refusal::LinkLost => 5,
        Refusal::ConfigurationUnconfirmed => 6,
        Refusal::FaultRecordUnread => 7,
        Refusal::Armed => 8,
        Refusal::NotArmed => 9,
        Refusal::MotorTestRunning => 10,
        Refusal::NoSuchMotor => 11,
        Refusal::BatteryAbsent => 12,
        Refusal::ImuUnhealthy(fault) => 0x20 + number_of_fault(fault),
    }
}

fn number_of_fault(fault: ImuFault) -> u32 {
    match fault {
        ImuFault::Stale => 0,
        ImuFault::BusDead => 1,
        ImuFault::Stuck => 2,
        ImuFault::OutOfRange => 3,
    }
}
