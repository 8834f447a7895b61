//! A stream of bytes through the finder of frames, against a second parser that has the whole stream before it.
//!
//! Of every chunk the first byte says what it is: bytes as they are, or a frame around them, whole, with a byte
//! changed, or cut off. Whatever the bytes: exactly the frames are found that the stream holds when it is read from its
//! start, and every other byte is counted as skipped.

use shared_control::link::frame::{FRAME_MAX, Frame, FrameFinder, PAYLOAD_MAX};

const CHUNK_BYTES: usize = 40;
/// More than the longest frame, so that none is left unfinished at the end.
const TAIL_BYTES: usize = FRAME_MAX + 1;
const SIGNED: u8 = 1;

/// Some messages are understood, others are not.
fn crc_extra(message_id: u32) -> Option<u8> {
    (message_id % 3 != 2).then_some(message_id.to_le_bytes()[0].wrapping_mul(37))
}

/// CRC-16/MCRF4XX bit by bit, as its definition has it: reflected, polynomial 0x1021, start 0xFFFF.
fn crc(bytes: impl Iterator<Item = u8>) -> u16 {
    bytes.fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0x8408 } else { crc >> 1 })
    })
}

/// Appends a frame around this payload, whole and right.
fn frame_around(payload: &[u8], flags: u8, message_id: u32, stream: &mut Vec<u8>) {
    let [id0, id1, id2, _] = message_id.to_le_bytes();
    let start = stream.len();
    stream.extend([0xFD, payload.len() as u8, flags, 0, 9, 8, 7, id0, id1, id2]);
    stream.extend(payload);
    let extra = crc_extra(message_id).unwrap_or(0);
    let sum = crc(stream[start + 1..].iter().copied().chain([extra]));
    stream.extend(sum.to_le_bytes());
    if flags & SIGNED != 0 {
        stream.extend([0xFD; 13]);
    }
}

fn stream_of(bytes: &[u8]) -> Vec<u8> {
    let mut stream = Vec::new();
    for chunk in bytes.chunks(CHUNK_BYTES) {
        let (kind, start) = (chunk[0], stream.len());
        if kind % 4 == 0 {
            stream.extend(&chunk[1..]);
            continue;
        }
        frame_around(&chunk[1..], kind >> 7, u32::from(kind >> 2), &mut stream);
        let spot = start + usize::from(kind) * 7 % (stream.len() - start);
        match kind % 4 {
            1 => {}
            2 => stream[spot] ^= kind | 1,
            _ => stream.truncate(spot),
        }
    }
    stream.extend([0; TAIL_BYTES]);
    stream
}

/// Length of the frame that these bytes begin with, if they do.
fn frame_length(bytes: &[u8]) -> Option<usize> {
    let [0xFD, length, flags, _, _, _, _, id0, id1, id2, ..] = *bytes else { return None };
    let extra = crc_extra(u32::from_le_bytes([id0, id1, id2, 0]))?;
    let payload_end = 10 + usize::from(length);
    if usize::from(length) > PAYLOAD_MAX || flags > SIGNED {
        return None;
    }
    let total = payload_end + 2 + if flags == SIGNED { 13 } else { 0 };
    let whole = bytes.get(..total)?;
    let sum = crc(whole[1..payload_end].iter().copied().chain([extra]));
    (whole[payload_end..payload_end + 2] == sum.to_le_bytes()).then_some(total)
}

fn as_it_came(frame: &Frame) -> Vec<u8> {
    let signature = frame.signature.iter().flatten().copied();
    frame.header.iter().copied().chain(frame.payload.iter().copied()).chain(frame.crc).chain(signature).collect()
}

/// What holds whatever the bytes.
pub fn hold(bytes: &[u8]) {
    let stream = stream_of(bytes);
    let (mut expected, mut at) = (Vec::new(), 0);
    while at < stream.len() {
        if let Some(length) = frame_length(&stream[at..]) {
            expected.push(stream[at..at + length].to_vec());
            at += length;
        } else {
            at += 1;
        }
    }
    let mut finder = FrameFinder::default();
    let found: Vec<Frame> = stream.iter().filter_map(|byte| finder.push(*byte, crc_extra)).collect();
    assert_eq!(found.iter().map(as_it_came).collect::<Vec<_>>(), expected, "{stream:?}");
    let in_frames: usize = expected.iter().map(Vec::len).sum();
    // zeros begin no frame: behind them nothing is held
    assert_eq!(finder.bytes_skipped as usize, stream.len() - in_frames, "{stream:?}");
}
