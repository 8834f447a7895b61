//! Raw bytes as the IO chip's replies, every second with its CRC put right, and what follows for the sticks.
//!
//! `cargo +nightly fuzz run io_chip`, in the project's root. Whatever the bytes: no panic, nothing is written to a
//! firmware that is not known, and sticks are numbers in their range.
#![no_main]

use libfuzzer_sys::fuzz_target;
use shared_control::io_chip::{IoSession, IoState};
use shared_control::params::radio::RadioParams;
use shared_control::radio::RadioSetup;

const WRITE: u8 = 0x40;
/// Longer than the longest reply.
const REPLY_BYTES: usize = 50;

fuzz_target!(|bytes: &[u8]| {
    let setup = RadioSetup::new(&RadioParams { kill_channel: 5, ..RadioParams::DEFAULT }).expect("the defaults");
    let mut session = IoSession::default();
    for (number, chunk) in bytes.chunks(REPLY_BYTES).enumerate() {
        let unknown = matches!(session.report().state, IoState::Unknown(..));
        let request = session.begin_slot();
        assert!(!unknown || request.is_none_or(|request| request[0] & WRITE == 0));
        let mut reply = chunk.to_vec();
        if number % 2 == 0 {
            put_crc_right(&mut reply);
        }
        let _ = session.take(&reply);
        if let Some(sticks) = setup.sticks(&session.report().radio) {
            for value in [sticks.roll, sticks.pitch, sticks.throttle, sticks.yaw] {
                assert!((-1.0..=1.0).contains(&value));
            }
        }
    }
});

fn put_crc_right(reply: &mut [u8]) {
    let Some(count) = reply.first().map(|first| usize::from(first & 0x3f)) else { return };
    let Some(packet) = reply.get_mut(..4 + 2 * count) else { return };
    packet[1] = 0;
    packet[1] = packet.iter().fold(0u8, |crc, byte| {
        (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ 0x07 } else { crc << 1 })
    });
}
