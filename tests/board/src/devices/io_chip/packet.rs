//! Packets of the IO chip's wire: count and code, CRC-8, page, offset, then 16-bit registers, low byte first.
//!
//! PX4 `protocol.h`: polynomial 0x07 over the whole packet, the CRC's own byte taken as zero.

/// What a packet asks, or what came of it: the two upper bits of its first byte.
pub(super) const READ: u8 = 0x00;
pub(super) const WRITE: u8 = 0x40;
pub(super) const SUCCESS: u8 = 0x00;
pub(super) const CORRUPT: u8 = 0x40;
pub(super) const ERROR: u8 = 0x80;
const HEAD_BYTES: usize = 4;

/// A packet whose CRC was right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Packet {
    pub(super) code: u8,
    pub(super) count: u8,
    pub(super) page: u8,
    pub(super) offset: u8,
    /// Those that came; a short read request has none.
    pub(super) registers: Vec<u16>,
}

/// What the bytes between two idle lines are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Arrived {
    Whole(Packet),
    /// As long as it says, and damaged.
    Damaged,
    /// Shorter than it says.
    Short,
}

/// `short_reads`: a read request may consist of its head alone.
pub(super) fn parse(bytes: &[u8], short_reads: bool) -> Arrived {
    let &[first, crc, page, offset, ..] = bytes else { return Arrived::Short };
    let (code, count) = (first & 0xc0, first & 0x3f);
    let whole = HEAD_BYTES + 2 * usize::from(count);
    let head_only = short_reads && code == READ;
    let good = |length: usize| bytes.get(..length).is_some_and(|packet| crc_of(packet) == crc);
    if bytes.len() < whole && !head_only {
        return Arrived::Short;
    }
    if !(good(whole) || head_only && good(HEAD_BYTES)) {
        return Arrived::Damaged;
    }
    let registers = bytes[HEAD_BYTES..].chunks_exact(2).take(usize::from(count));
    let registers = registers.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    Arrived::Whole(Packet { code, count, page, offset, registers })
}

/// A reply's bytes.
pub(super) fn reply(code: u8, (page, offset): (u8, u8), registers: &[u16]) -> Vec<u8> {
    let mut bytes = vec![code | registers.len() as u8, 0, page, offset];
    bytes.extend(registers.iter().flat_map(|register| register.to_le_bytes()));
    bytes[1] = crc_of(&bytes);
    bytes
}

/// By long division, one bit after the other.
fn crc_of(packet: &[u8]) -> u8 {
    let mut remainder = 0u8;
    for (place, byte) in packet.iter().enumerate() {
        remainder ^= if place == 1 { 0 } else { *byte };
        for _ in 0..8 {
            remainder = remainder << 1 ^ if remainder & 0x80 != 0 { 0x07 } else { 0 };
        }
    }
    remainder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_comes_back_and_a_turned_bit_is_seen() {
        let bytes = reply(SUCCESS, (4, 0), &[0x1234, 5]);
        assert_eq!(bytes.len(), 8);
        let packet = Packet { code: 0, count: 2, page: 4, offset: 0, registers: vec![0x1234, 5] };
        assert_eq!(parse(&bytes, false), Arrived::Whole(packet));
        for bit in 8..64 {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(parse(&damaged, false), Arrived::Damaged);
        }
    }

    #[test]
    fn a_head_alone_is_a_read_request_to_some() {
        let mut head = vec![READ | 2, 0, 0, 0];
        head[1] = crc_of(&head);
        assert_eq!(parse(&head, false), Arrived::Short);
        assert!(matches!(parse(&head, true), Arrived::Whole(_)));
    }

    #[test]
    fn the_crc_is_the_polynomials_remainder() {
        // x^8 leaves x^2 + x + 1
        assert_eq!(crc_of(&[0, 0, 0, 1]), 0x07);
        // x^15 leaves x^7 + x^3 + 1
        assert_eq!(crc_of(&[0, 0, 0, 0x80]), 0x89);
    }
}
