//! The fuzz targets of frames and link, a short run of them on random bytes: `LINK_RUNS=N` for a longer one.

#[path = "../../fuzz/fuzz_targets/frame_bytes.rs"]
mod frame_bytes;
#[path = "../../fuzz/fuzz_targets/link_bytes.rs"]
mod link_bytes;

/// SplitMix64: a few lines, the same bytes everywhere.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Random bytes, many times, for what holds whatever they are.
fn hold_for_a_moment(hold: fn(&[u8])) {
    let runs = std::env::var("LINK_RUNS").ok().and_then(|runs| runs.parse().ok()).unwrap_or(3000);
    for seed in 0..runs {
        let mut state = seed;
        let length = next(&mut state) % 400;
        let bytes: Vec<u8> = (0..length)
            .map(|_| match next(&mut state) {
                // half of the bytes are such as frames are made of
                word if word % 2 == 0 => word.to_le_bytes()[1],
                word => [0, 1, 0xFD, 128][(word >> 8) as usize % 4],
            })
            .collect();
        let shown = bytes.clone();
        assert!(std::panic::catch_unwind(|| hold(&bytes)).is_ok(), "seed {seed}: {shown:?}");
    }
}

#[test]
fn the_frames_of_a_stream_are_found_whatever_lies_between_them() {
    hold_for_a_moment(frame_bytes::hold);
}

#[test]
fn whatever_arrives_on_the_link_changes_nothing_that_it_may_not() {
    hold_for_a_moment(link_bytes::hold);
}

/// Found by libFuzzer: a frame that is signed with the key, held up by bytes that look like the head of another, is
/// obeyed only when that has proved to be none, in the middle of unsigned bytes.
#[test]
fn a_signed_frame_that_was_held_up_is_obeyed_late() {
    let digits = concat!(
        "d5ff30fd00000000000000000000000000000096fd000000cefffd00000034117e00000000cefffd400000cefffd000000e4",
        "000000fd00000052cefffdf600000000000000000000003b0000000000000000000000000000000000000000000000000001",
        "00000000000000000000000000000096fd000000cefffd00000034117e0000000000580000cefffd400000cefffd000000e4",
        "000000fd00000052cefffdf600000000400000000000003b52435f5049000000000000000000000000000000000000000000",
        "0000000600000000007e000000010101010101010101010101010101ffffffff",
    );
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
    link_bytes::hold(&(0..digits.len()).step_by(2).map(byte).collect::<Vec<_>>());
}
