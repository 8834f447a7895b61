//! MAVLink 2 frames: found in a stream of bytes that may hold anything, and written.
//!
//! Layout (<https://mavlink.io/en/guide/serialization.html>): 0xFD, payload length, incompatibility flags,
//! compatibility flags, sequence, system, component, message id (3 bytes), payload without its trailing zeros, CRC (2
//! bytes), and 13 bytes of signature if the first incompatibility flag says so. Whether that is right, [`Guard`] says.
//!
//! [`Guard`]: super::signing::Guard

use mavlink::{MAV_STX_V2, MavlinkVersion, MessageData, calculate_crc};

use super::signing::signature::{SIGNATURE_LEN, Signer};

/// Longest payload that is taken: that of `FILE_TRANSFER_PROTOCOL`, the longest message that is understood.
pub const PAYLOAD_MAX: usize = 254;
/// Longest frame that is taken or written.
pub const FRAME_MAX: usize = HEADER_LEN + PAYLOAD_MAX + CRC_LEN + SIGNATURE_LEN;

/// Bytes of a header.
pub const HEADER_LEN: usize = 10;
/// Bytes of a CRC.
pub const CRC_LEN: usize = 2;
const FLAG_SIGNED: u8 = 1;

/// A frame whose CRC is right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// System that sent it.
    pub system_id: u8,
    /// Component that sent it.
    pub component_id: u8,
    /// Message id.
    pub message_id: u32,
    /// Payload without its trailing zeros.
    pub payload: heapless::Vec<u8, PAYLOAD_MAX>,
    /// As it came.
    pub header: [u8; HEADER_LEN],
    /// As it came.
    pub crc: [u8; CRC_LEN],
    /// What follows the CRC, where the frame is signed.
    pub signature: Option<[u8; SIGNATURE_LEN]>,
}

/// Finds frames in a stream. After bytes that make no frame it starts again at the next 0xFD among those it
/// holds, so no garbage, however it looks, costs a frame that follows it.
#[derive(Clone, Debug, Default)]
pub struct FrameFinder {
    held: heapless::Vec<u8, FRAME_MAX>,
    /// Bytes that belonged to no frame that is understood.
    pub bytes_skipped: u32,
}

/// Why the first byte begins no frame.
enum NoFrame {
    /// Not enough bytes yet.
    Yet,
    /// None that is understood.
    Ever,
}

impl FrameFinder {
    /// Takes one byte. `crc_extra` gives the CRC's last byte for a message id, none for messages that nobody wants.
    pub fn push(&mut self, byte: u8, crc_extra: impl Fn(u32) -> Option<u8>) -> Option<Frame> {
        // never full: `look` decides at the latest when the longest frame is complete
        if self.held.push(byte).is_err() {
            self.held.clear();
        }
        // each round takes at least one byte away
        while !self.held.is_empty() {
            match self.look(&crc_extra) {
                Err(NoFrame::Yet) => return None,
                Err(NoFrame::Ever) => {
                    let next = self.held.iter().skip(1).position(|byte| *byte == MAV_STX_V2);
                    let skipped = next.map_or(self.held.len(), |at| at.saturating_add(1));
                    self.take_away(skipped);
                    self.bytes_skipped = self.bytes_skipped.saturating_add(skipped as u32);
                }
                Ok((frame, length)) => {
                    self.take_away(length);
                    return Some(frame);
                }
            }
        }
        None
    }

    /// The frame that the first byte begins, and its length.
    fn look(&self, crc_extra: impl Fn(u32) -> Option<u8>) -> Result<(Frame, usize), NoFrame> {
        if self.held.first() != Some(&MAV_STX_V2) {
            return Err(NoFrame::Ever);
        }
        let [_, length, incompatible, _, _, system_id, component_id, id0, id1, id2, rest @ ..] = self.held.as_slice()
        else {
            return Err(NoFrame::Yet);
        };
        let message_id = u32::from_le_bytes([*id0, *id1, *id2, 0]);
        let payload_len = usize::from(*length);
        let Some(extra) = crc_extra(message_id) else { return Err(NoFrame::Ever) };
        if payload_len > PAYLOAD_MAX || incompatible & !FLAG_SIGNED != 0 {
            return Err(NoFrame::Ever);
        }
        let signature_len = if incompatible & FLAG_SIGNED == 0 { 0 } else { SIGNATURE_LEN };
        let total = HEADER_LEN + payload_len + CRC_LEN + signature_len;
        let (Some(payload), Some(checked)) = (rest.get(..payload_len), self.held.get(1..HEADER_LEN + payload_len))
        else {
            return Err(NoFrame::Yet);
        };
        let behind = rest.get(payload_len..).unwrap_or_default();
        let (Some((crc, behind)), true) = (behind.split_first_chunk::<CRC_LEN>(), self.held.len() >= total) else {
            return Err(NoFrame::Yet);
        };
        if calculate_crc(checked, extra) != u16::from_le_bytes(*crc) {
            return Err(NoFrame::Ever);
        }
        let signature = behind.first_chunk().filter(|_| signature_len > 0).copied();
        let (Ok(payload), Some(header)) = (heapless::Vec::from_slice(payload), self.held.first_chunk().copied()) else {
            return Err(NoFrame::Ever);
        };
        let (system_id, component_id) = (*system_id, *component_id);
        Ok((Frame { system_id, component_id, message_id, payload, header, crc: *crc, signature }, total))
    }

    fn take_away(&mut self, count: usize) {
        let count = count.min(self.held.len());
        self.held.rotate_left(count);
        self.held.truncate(self.held.len() - count);
    }
}

/// The message of a frame, if the frame carries this one and its fields have values that exist.
pub fn message<D: MessageData>(frame: &Frame) -> Option<D> {
    if frame.message_id == D::ID { D::deser(MavlinkVersion::V2, &frame.payload).ok() } else { None }
}

/// Numbers, writes and, where there is a key, signs the frames of one sender.
#[derive(Clone, Copy, Debug)]
pub struct FrameWriter {
    system_id: u8,
    component_id: u8,
    sequence: u8,
    signer: Option<Signer>,
}

impl FrameWriter {
    /// A sender that has sent nothing.
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self { system_id, component_id, sequence: 0, signer: None }
    }

    /// Who signs from now on, if anybody does.
    pub fn signer(&mut self) -> &mut Option<Signer> {
        &mut self.signer
    }

    /// Appends a frame. False, and nothing written, if there is no room for it.
    pub fn write<D: MessageData, const N: usize>(&mut self, data: &D, out: &mut heapless::Vec<u8, N>) -> bool {
        let mut payload = [0; 255];
        let length = data.ser(MavlinkVersion::V2, &mut payload).min(payload.len());
        self.write_payload((D::ID, D::EXTRA_CRC), payload.get(..length).unwrap_or_default(), out)
    }

    /// The same with a payload of at most 255 bytes, for what the dialect's types cannot say: extensions of messages,
    /// numbers without a name.
    pub fn write_payload<const N: usize>(
        &mut self,
        (message_id, extra_crc): (u32, u8),
        payload: &[u8],
        out: &mut heapless::Vec<u8, N>,
    ) -> bool {
        // the first byte stays, whatever it is
        let zeros = payload.iter().skip(1).rev().take_while(|byte| **byte == 0).count();
        let length = payload.len() - zeros;
        let [id0, id1, id2, _] = message_id.to_le_bytes();
        let (flags, signature_len) = if self.signer.is_some() { (FLAG_SIGNED, SIGNATURE_LEN) } else { (0, 0) };
        let [system, component] = [self.system_id, self.component_id];
        let header = [MAV_STX_V2, length as u8, flags, 0, self.sequence, system, component, id0, id1, id2];
        if out.capacity() - out.len() < HEADER_LEN + length + CRC_LEN + signature_len {
            return false;
        }
        let start = out.len();
        let fits = out.extend_from_slice(&header).is_ok()
            && out.extend_from_slice(payload.get(..length).unwrap_or_default()).is_ok();
        let crc = calculate_crc(out.get(start + 1..).unwrap_or_default(), extra_crc);
        self.sequence = self.sequence.wrapping_add(1);
        let written = fits && out.extend_from_slice(&crc.to_le_bytes()).is_ok();
        let Some(signer) = &mut self.signer else { return written };
        let signature = signer.sign(out.get(start..).unwrap_or_default());
        written && out.extend_from_slice(&signature).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTRA: u8 = 50;

    /// A frame as the page of the serialisation has it, with this payload, and with a signature if `signed`.
    fn bytes(payload: &[u8], signed: bool) -> heapless::Vec<u8, 512> {
        let flags = if signed { FLAG_SIGNED } else { 0 };
        let mut frame = heapless::Vec::from_slice(&[0xFD, payload.len() as u8, flags, 0, 7, 3, 4, 0, 0, 0]).unwrap();
        frame.extend_from_slice(payload).unwrap();
        let crc = calculate_crc(&frame[1..], EXTRA);
        frame.extend_from_slice(&crc.to_le_bytes()).unwrap();
        if signed {
            frame.extend_from_slice(&[0xFD; 13]).unwrap();
        }
        frame
    }

    /// How many bytes it takes until the frame is found, if it is.
    fn found_after(finder: &mut FrameFinder, stream: &[u8]) -> Option<(usize, Frame)> {
        (1..).zip(stream).find_map(|(count, byte)| Some((count, finder.push(*byte, |_| Some(EXTRA))?)))
    }

    /// Written where it just fits behind what is there already; with one byte less nothing is, and no number is used.
    #[test]
    fn a_frame_is_written_whole_or_not_at_all() {
        use mavlink::dialects::common::COMMAND_ACK_DATA;
        let data = COMMAND_ACK_DATA::DEFAULT;
        let mut writer = FrameWriter::new(1, 1);
        let mut long = heapless::Vec::<u8, 100>::new();
        assert!(writer.write(&data, &mut long));
        // without its trailing zeros a payload is at least one byte long
        assert_eq!(long.len(), HEADER_LEN + 1 + CRC_LEN);
        let mut twice = heapless::Vec::<u8, 26>::new();
        assert!(writer.write(&data, &mut twice) && writer.write(&data, &mut twice));
        assert_eq!([twice[4], twice[13 + 4]], [1, 2], "numbered one after the other");
        let mut once = heapless::Vec::<u8, 25>::new();
        assert!(writer.write(&data, &mut once) && !writer.write(&data, &mut once));
        assert_eq!((once.len(), writer.sequence), (13, 4));
    }

    /// Each is found with its own last byte, and nothing of it is left to be taken for garbage.
    #[test]
    fn a_frame_ends_with_its_last_byte() {
        let payload = [0x5A; PAYLOAD_MAX];
        let mut finder = FrameFinder::default();
        for length in [0, 1, 40, PAYLOAD_MAX] {
            for signed in [true, false] {
                let stream = bytes(&payload[..length], signed);
                let (count, frame) = found_after(&mut finder, &stream).unwrap();
                assert_eq!((count, frame.payload.as_slice()), (stream.len(), &payload[..length]));
                assert_eq!((frame.system_id, frame.component_id, frame.message_id), (3, 4, 0));
                assert_eq!((finder.held.len(), finder.bytes_skipped), (0, 0), "{length} {signed}");
            }
        }
        assert_eq!(found_after(&mut finder, &bytes(&[0x5A; PAYLOAD_MAX + 1], false)), None, "one more is too many");
        assert_eq!(bytes(&payload, true).len(), FRAME_MAX, "the longest just fits");
    }
}
