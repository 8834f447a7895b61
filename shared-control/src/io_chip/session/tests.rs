use super::*;
use crate::io_chip::packet::Registers;
use proptest::prelude::*;
extern crate std;
use std::vec::Vec;

/// A chip as simple as can be: pages by (page, offset), the last writes.
struct Chip {
    identity: [u16; 2],
    status: Vec<u16>,
    radio: Vec<u16>,
    writes: Vec<(u8, u8, u16)>,
}

impl Chip {
    fn new(identity: [u16; 2]) -> Self {
        Self { identity, status: std::vec![0; 13], radio: std::vec![0; 22], writes: Vec::new() }
    }

    fn answer(&mut self, request: &Bytes) -> Bytes {
        let (count, page, offset) = (usize::from(request[0] & 0x3f), request[2], usize::from(request[3]));
        let mut registers = Registers::new();
        if request[0] & 0x40 != 0 {
            self.writes.push((page, request[3], u16::from_le_bytes([request[4], request[5]])));
        } else {
            assert_eq!(request.len(), 4 + 2 * count, "padded");
            let source: &[u16] = match page {
                0 => &self.identity,
                1 => &self.status,
                4 => &self.radio,
                _ => panic!("page {page}"),
            };
            registers.extend_from_slice(&source[offset..offset + count]).unwrap();
        }
        reply(&registers)
    }
}

/// The bytes of a reply, by the packet that a write of the same words would be.
fn reply(registers: &[u16]) -> Bytes {
    let mut bytes = Bytes::new();
    bytes.extend_from_slice(&[registers.len() as u8, 0, 0, 0]).unwrap();
    bytes.extend(registers.iter().flat_map(|register| register.to_le_bytes()));
    let crc = bytes.iter().fold(0u8, |crc, byte| {
        (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ 0x07 } else { crc << 1 })
    });
    bytes[1] = crc;
    bytes
}

/// So many slots, all of them answered.
fn run(session: &mut IoSession, chip: &mut Chip, slots: usize) {
    for _ in 0..slots {
        let mut request = session.begin_slot();
        let mut asked = 0;
        while let Some(bytes) = request {
            asked += 1;
            assert!(asked <= 10, "a slot has an end");
            request = session.take(&chip.answer(&bytes));
        }
    }
}

fn silence(session: &mut IoSession, slots: usize) {
    for _ in 0..slots {
        session.begin_slot();
    }
}

const STOCK: [([u16; 2], Firmware); 3] =
    [([4, 2], Firmware::Px4V4), ([5, 2], Firmware::Px4V5), ([4, 10], Firmware::ArduPilot)];

#[test]
fn each_firmware_is_recognised_and_made_safe_in_the_first_slot() {
    for (identity, firmware) in STOCK {
        let (mut session, mut chip) = (IoSession::default(), Chip::new(identity));
        run(&mut session, &mut chip, 1);
        assert_eq!((session.report().state, session.report().safety), (IoState::Known(firmware), Safety::On));
        let safe = if firmware == Firmware::Px4V5 { (50, 15, 0) } else { (50, 14, 22027) };
        assert_eq!(chip.writes[..2], [(50, 1, 0), safe]);
        assert!(chip.writes.iter().all(|(page, _, value)| *page == 50 || *value == 1000));
        let count = chip.writes.len();
        run(&mut session, &mut chip, 100);
        assert_eq!(chip.writes.len(), count, "from then on it is only read");
    }
}

#[test]
fn an_unknown_firmware_is_written_nothing() {
    for identity in [[3, 2], [6, 2], [4, 3], [5, 10], [0xffff, 0xffff]] {
        let (mut session, mut chip) = (IoSession::default(), Chip::new(identity));
        run(&mut session, &mut chip, 1000);
        assert_eq!(session.report().state, IoState::Unknown(identity[0], identity[1]));
        assert!(chip.writes.is_empty() && !session.report().radio.heard);
        // until another one stands there
        chip.identity = [4, 2];
        run(&mut session, &mut chip, 25);
        assert_eq!(session.report().state, IoState::Known(Firmware::Px4V4));
    }
}

#[test]
fn channels_are_read_where_each_firmware_has_them() {
    for (identity, firmware) in STOCK {
        let (mut session, mut chip) = (IoSession::default(), Chip::new(identity));
        let first = if firmware == Firmware::ArduPilot { 2 } else { 6 };
        chip.radio[first] = 1111;
        chip.radio[first + 7] = 1888;
        (chip.radio[0], chip.radio[1]) = if firmware == Firmware::ArduPilot { (8 | 2 << 8, 0) } else { (8, 1 << 4) };
        run(&mut session, &mut chip, 2);
        let radio = session.report().radio;
        assert_eq!((radio.heard, radio.channel_us(1), radio.channel_us(8)), (true, Some(1111), Some(1888)));
        assert_eq!((radio.channel_us(9), radio.channel_us(0), radio.channel_us(200)), (None, None, None));
        // the receiver says that it hears no transmitter
        (chip.radio[0], chip.radio[1]) =
            if firmware == Firmware::ArduPilot { (8 | 3 << 8, 0) } else { (8, 1 << 4 | 2) };
        run(&mut session, &mut chip, 1);
        assert!(!session.report().radio.heard);
    }
}

#[test]
fn the_button_is_the_chips_affair_or_the_fmus() {
    for (identity, firmware) in STOCK {
        let (mut session, mut chip) = (IoSession::default(), Chip::new(identity));
        run(&mut session, &mut chip, 15);
        assert_eq!(session.report().safety, Safety::On);
        match firmware {
            Firmware::Px4V4 => chip.status[2] = 1 << 12,
            Firmware::Px4V5 => chip.status[2] = 1 << 14,
            Firmware::ArduPilot => chip.status[10] = 1,
        }
        chip.writes.clear();
        run(&mut session, &mut chip, 10);
        assert_eq!(session.report().safety, Safety::Off);
        let said: &[_] = if firmware == Firmware::Px4V5 { &[(50, 15, 1), (50, 14, 0)] } else { &[] };
        assert_eq!(chip.writes, said);
        chip.status[2] = if firmware == Firmware::Px4V5 { 1 << 14 } else { 0 };
        chip.status[10] = 0;
        run(&mut session, &mut chip, 10);
        assert_eq!(session.report().safety, Safety::On);
    }
}

#[test]
fn a_chip_that_pauses_is_made_safe_again_and_one_that_stays_away_is_silent() {
    let (mut session, mut chip) = (IoSession::default(), Chip::new([4, 2]));
    (chip.radio[0], chip.radio[1]) = (8, 1 << 4);
    run(&mut session, &mut chip, 3);
    chip.writes.clear();
    silence(&mut session, 3);
    run(&mut session, &mut chip, 1);
    assert!(chip.writes.is_empty(), "three lost packets are no restart");
    silence(&mut session, 10);
    assert!(session.report().radio.heard, "what was heard 50 ms ago still counts");
    run(&mut session, &mut chip, 1);
    assert_eq!(chip.writes[0], (50, 1, 0));
    silence(&mut session, 21);
    assert_eq!((session.report().state, session.report().radio.heard), (IoState::Silent, false));
    run(&mut session, &mut chip, 2);
    assert!(session.report().radio.heard);
}

#[test]
fn at_the_start_it_is_waited_for() {
    let mut session = IoSession::default();
    silence(&mut session, 400);
    assert_eq!(session.report().state, IoState::Unheard);
    silence(&mut session, 1);
    assert_eq!(session.report().state, IoState::Silent);
}

proptest! {
    /// Whatever comes over the wire, nothing is written to a chip that has not said who it is.
    #[test]
    fn noise_brings_about_no_write(
        noise in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..60), 0..50),
    ) {
        let mut session = IoSession::default();
        for bytes in noise {
            let mut request = session.begin_slot();
            prop_assert!(request.take().is_none_or(|bytes| bytes[0] & 0x40 == 0));
            let next = session.take(&bytes);
            prop_assert!(next.is_none());
        }
    }
}
