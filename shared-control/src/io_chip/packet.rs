//! Packets: one byte of code and count, CRC-8, page, offset, then 16-bit registers, low byte first.

/// Registers that a packet of ours has at most.
pub const REGISTERS_MAX: usize = 22;
/// Bytes of such a packet.
pub const PACKET_MAX: usize = HEAD + 2 * REGISTERS_MAX;
const HEAD: usize = 4;
const CODE: u8 = 0xc0;
const WRITE: u8 = 0x40;
const SUCCESS: u8 = 0x00;
const ERROR: u8 = 0x80;

/// A packet's bytes.
pub type Bytes = heapless::Vec<u8, PACKET_MAX>;
/// Registers of a page.
pub type Registers = heapless::Vec<u16, REGISTERS_MAX>;

/// What the FMU asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// So many registers from a place on.
    Read {
        /// Page.
        page: u8,
        /// First register.
        offset: u8,
        /// How many, at most [`REGISTERS_MAX`].
        count: u8,
    },
    /// The same value into so many registers from a place on.
    Write {
        /// Page.
        page: u8,
        /// First register.
        offset: u8,
        /// How many, at most [`REGISTERS_MAX`].
        count: u8,
        /// What goes into each.
        value: u16,
    },
}

impl Request {
    /// Its bytes. A read is as long as its answer: PX4's firmware drops one that is shorter.
    pub fn bytes(&self) -> Bytes {
        let (code, page, offset, count, value) = match *self {
            Request::Read { page, offset, count } => (0, page, offset, count, 0),
            Request::Write { page, offset, count, value } => (WRITE, page, offset, count, value),
        };
        let mut bytes = Bytes::new();
        // what has no room is left out: nothing here is that long
        let _ = bytes.extend_from_slice(&[code | count, 0, page, offset]);
        for _ in 0..count {
            let _ = bytes.extend_from_slice(&value.to_le_bytes());
        }
        let crc = crc_of(&bytes);
        if let Some(place) = bytes.get_mut(1) {
            *place = crc;
        }
        bytes
    }
}

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Done; of a read with the registers.
    Done(Registers),
    /// The chip's firmware refuses.
    Refused,
}

impl Reply {
    /// The reply to a request; none if the bytes are damaged, or answer something else.
    pub fn to(request: &Request, bytes: &[u8]) -> Option<Reply> {
        let (first, crc) = (*bytes.first()?, *bytes.get(1)?);
        let count = usize::from(first & !CODE);
        let packet = bytes.get(..HEAD + 2 * count)?;
        if crc_of(packet) != crc {
            return None;
        }
        let expected = match request {
            Request::Read { count, .. } => usize::from(*count),
            Request::Write { .. } => 0,
        };
        match first & CODE {
            SUCCESS if count == expected => Some(Reply::Done(registers(packet))),
            ERROR => Some(Reply::Refused),
            _ => None,
        }
    }
}

fn registers(packet: &[u8]) -> Registers {
    packet
        .get(HEAD..)
        .unwrap_or_default()
        .chunks_exact(2)
        .map_while(|pair| Some(word(pair)))
        .take(REGISTERS_MAX)
        .collect()
}

fn word(pair: &[u8]) -> u16 {
    pair.iter().rev().fold(0, |word, byte| word << 8 | u16::from(*byte))
}

/// CRC-8 with polynomial 0x07 over the packet, its own byte taken as zero.
fn crc_of(packet: &[u8]) -> u8 {
    packet.iter().enumerate().fold(0, |crc, (place, byte)| {
        let index = crc ^ if place == 1 { 0 } else { *byte };
        CRC.get(usize::from(index)).copied().unwrap_or_default()
    })
}

/// The remainder of each byte.
static CRC: [u8; 256] = crc_table();

const fn crc_table() -> [u8; 256] {
    let mut table = [0; 256];
    let mut index = 0;
    while index < 256 {
        let mut remainder = index as u8;
        let mut bit = 0;
        while bit < 8 {
            remainder = if remainder & 0x80 != 0 { remainder << 1 ^ 0x07 } else { remainder << 1 };
            bit += 1;
        }
        table[index] = remainder;
        index += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const READ: Request = Request::Read { page: 4, offset: 0, count: 3 };

    /// Bytes of a reply, its CRC found by trying all.
    fn reply(code: u8, words: &[u16]) -> Bytes {
        let mut bytes: Bytes = [code | words.len() as u8, 0, 0, 0].into_iter().collect();
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        bytes[1] = crc_of(&bytes);
        bytes
    }

    #[test]
    fn the_crc_is_the_catalogues_crc_8() {
        // CRC-8/SMBUS: 0xF4 of "123456789"; the second byte, which is left out here, is made zero by the first
        let whole = b"123456789".iter().fold(0u8, |crc, byte| CRC[usize::from(crc ^ byte)]);
        assert_eq!(whole, 0xf4);
        assert_eq!((crc_of(&[0, 0, 0, 1]), crc_of(&[0, 0xff, 0, 1])), (0x07, 0x07));
    }

    #[test]
    fn a_read_request_is_as_long_as_its_answer() {
        let bytes = READ.bytes();
        assert_eq!((bytes.len(), bytes[0], bytes[2], bytes[3]), (10, 3, 4, 0));
        let write = Request::Write { page: 50, offset: 14, count: 1, value: 22027 }.bytes();
        assert_eq!((write[0], &write[2..]), (0x41, &[50, 14, 0x0b, 0x56][..]));
    }

    #[test]
    fn only_the_answer_to_the_request_is_one() {
        let done = |words: &[u16]| Some(Reply::Done(words.iter().copied().collect()));
        assert_eq!(Reply::to(&READ, &reply(SUCCESS, &[1, 2, 3])), done(&[1, 2, 3]));
        // a late answer to another question has another length
        assert_eq!(Reply::to(&READ, &reply(SUCCESS, &[1, 2])), None);
        assert_eq!(Reply::to(&READ, &reply(SUCCESS, &[])), None);
        assert_eq!(Reply::to(&READ, &reply(0x40, &[])), None, "the chip received it damaged");
        assert_eq!(Reply::to(&READ, &reply(ERROR, &[])), Some(Reply::Refused));
        let write = Request::Write { page: 50, offset: 1, count: 1, value: 0 };
        assert_eq!(Reply::to(&write, &reply(SUCCESS, &[])), done(&[]));
    }

    proptest! {
        #[test]
        fn any_bytes_are_taken(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
            let _ = Reply::to(&READ, &bytes);
        }

        /// A CRC of this kind finds every burst of up to 8 bits.
        #[test]
        fn a_damaged_byte_is_no_answer(words in any::<[u16; 3]>(), at in 0usize..10, flip in 1u8..) {
            let mut bytes = reply(SUCCESS, &words);
            // page and offset count too
            bytes[at] ^= flip;
            let taken = Reply::to(&READ, &bytes);
            prop_assert!(taken.is_none(), "{:?}", taken);
        }
    }
}
