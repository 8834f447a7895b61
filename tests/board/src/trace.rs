//! The firmware's record of its last step, read out of the image's memory.

use shared_control::record::trace::StepTrace;
use shared_control::signals::IMU_SAMPLES_MAX;

use crate::machine::Machine;

/// Reads words one after the other, in the order of the fields.
struct Words<'a>(std::slice::ChunksExact<'a, u8>);

impl Words<'_> {
    fn word(&mut self) -> Option<u32> {
        self.0.next().map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn words<const N: usize>(&mut self) -> Option<[u32; N]> {
        let mut words = [0; N];
        for word in &mut words {
            *word = self.word()?;
        }
        Some(words)
    }

    fn samples(&mut self) -> Option<[[u32; 8]; IMU_SAMPLES_MAX]> {
        let mut samples = StepTrace::EMPTY.sample;
        for sample in &mut samples {
            *sample = self.words()?;
        }
        Some(samples)
    }
}

/// The record at this address (symbol `FLIGHT_TRACE`).
pub fn step_trace(machine: &mut Machine, address: u32) -> Option<StepTrace> {
    let bytes = machine.bytes(address, size_of::<StepTrace>())?;
    let mut words = Words(bytes.chunks_exact(4));
    // fields are evaluated in the order in which they stand, which is that of the structure
    let trace = StepTrace {
        step: words.word()?,
        time_us: words.words()?,
        samples: words.word()?,
        sample: words.samples()?,
        samples_second: words.word()?,
        sample_second: words.samples()?,
        setpoint: words.words()?,
        arming_request: words.words()?,
        link_age: words.words()?,
        blocks: words.words()?,
        battery: words.words()?,
        plan: words.words()?,
        exchanges: words.word()?,
        taught: words.words()?,
        compare_counts: words.words()?,
        arming: words.word()?,
        imu_unit: words.word()?,
        imu_health: words.word()?,
        standby_health: words.word()?,
        source: words.word()?,
        commands: words.words()?,
        unmet_torque_nm: words.words()?,
        wrench: words.words()?,
        attitude: words.words()?,
        rate: words.words()?,
        bias: words.words()?,
        rate_target: words.words()?,
        state: words.words()?,
    };
    words.word().is_none().then_some(trace)
}
