use super::registers::{MAIN_DRIVEN, NO_SUCH_REGISTER, NOT_SAFE_FIRST, WRITE_UNRECOGNISED};
use super::*;

const STOCK: [IoFirmware; 3] = [IoFirmware::Px4V4, IoFirmware::Px4V5, IoFirmware::ArduPilot];

/// A chip and its wire.
struct Wire {
    chip: IoChip,
    now: Ticks,
}

impl Wire {
    fn to(firmware: IoFirmware) -> Self {
        Self { chip: IoChip::new(firmware, 0), now: BOOT }
    }

    /// Code and registers of the reply.
    fn ask(&mut self, code: u8, page: u8, offset: u8, registers: &[u16]) -> Option<(u8, Vec<u16>)> {
        self.send(&packet::reply(code, (page, offset), registers))
    }

    fn send(&mut self, bytes: &[u8]) -> Option<(u8, Vec<u16>)> {
        self.chip.receive(bytes, self.now);
        self.wait(IDLE);
        self.chip.tick(self.now);
        self.wait(LATENCY);
        let reply = self.chip.tick(self.now)?;
        let Arrived::Whole(packet) = packet::parse(&reply, false) else { panic!("{reply:?}") };
        Some((packet.code, packet.registers))
    }

    fn read(&mut self, page: u8, offset: u8, count: usize) -> Option<(u8, Vec<u16>)> {
        self.ask(READ, page, offset, &vec![0; count])
    }

    fn write(&mut self, page: u8, offset: u8, registers: &[u16]) -> u8 {
        self.ask(WRITE, page, offset, registers).unwrap().0
    }

    fn wait(&mut self, time: Ticks) {
        self.now += time;
    }

    /// Recognised, disarmed, safe.
    fn made_safe(firmware: IoFirmware) -> Self {
        let mut wire = Self::to(firmware);
        wire.read(0, 0, 2);
        wire.write(50, 1, &[0]);
        match firmware {
            IoFirmware::Px4V5 => wire.write(50, 15, &[0]),
            _ => wire.write(50, 14, &[22027]),
        };
        assert_eq!(wire.chip.broken, None);
        wire
    }
}

#[test]
fn each_firmware_says_which_it_is() {
    let versions = STOCK.map(|firmware| Wire::to(firmware).read(0, 0, 2).unwrap().1);
    assert_eq!(versions, [vec![4, 2], vec![5, 2], vec![4, 10]]);
    // older ArduPilot answers ERROR to more
    assert_eq!(Wire::to(IoFirmware::ArduPilot).read(0, 0, 3).unwrap().0, ERROR);
}

#[test]
fn only_ardupilot_takes_a_read_request_that_is_not_padded() {
    let mut head = packet::reply(READ, (0, 0), &[]);
    head[0] |= 2;
    // with the CRC of the new head
    head[1] = 0;
    let crc = (0..=255).find(|crc| {
        head[1] = *crc;
        matches!(packet::parse(&head, true), Arrived::Whole(_))
    });
    assert!(crc.is_some());
    let answered = STOCK.map(|firmware| Wire::to(firmware).send(&head).is_some());
    assert_eq!(answered, [false, false, true]);
}

#[test]
fn no_write_before_it_is_known_and_safe() {
    for firmware in STOCK {
        let mut wire = Wire::to(firmware);
        wire.write(50, 1, &[0]);
        assert_eq!(wire.chip.broken, Some(WRITE_UNRECOGNISED));
        let mut wire = Wire::to(firmware);
        wire.read(0, 0, 2);
        wire.write(55, 0, &[1000; 8]);
        assert_eq!(wire.chip.broken, Some(NOT_SAFE_FIRST));
        // and again after each reset of the FMU
        let mut wire = Wire::made_safe(firmware);
        wire.chip.fmu_restarted();
        wire.write(50, 1, &[0]);
        assert_eq!(wire.chip.broken, Some(WRITE_UNRECOGNISED));
    }
    let mut unknown = Wire::to(IoFirmware::Unknown(6, 2));
    unknown.read(0, 0, 2);
    unknown.write(50, 1, &[0]);
    assert_eq!(unknown.chip.broken, Some(WRITE_UNRECOGNISED));
}

#[test]
fn what_is_unknown_is_an_error_to_px4_and_none_to_ardupilot() {
    for firmware in STOCK {
        let mut wire = Wire::made_safe(firmware);
        let code = wire.write(99, 0, &[1]);
        assert_eq!(code, if firmware == IoFirmware::ArduPilot { SUCCESS } else { ERROR });
        assert_eq!(wire.chip.broken, Some(NO_SUCH_REGISTER));
    }
}

/// The gate of MAIN: on v4 safety and direct pulses, on v5 direct pulses alone, on ArduPilot safety alone.
#[test]
fn main_is_gated_as_each_firmware_does_it() {
    for firmware in STOCK {
        let mut wire = Wire::made_safe(firmware);
        wire.write(50, 1, &[0x40]);
        match firmware {
            IoFirmware::Px4V4 => wire.write(108, 0, &[1000; 8]),
            IoFirmware::Px4V5 => wire.write(109, 0, &[1000; 8]),
            _ => wire.write(55, 0, &[1000; 16]),
        };
        assert_eq!(wire.chip.main_us(wire.now), [0; 8]);
        wire.write(54, 0, &[1500; 8]);
        assert_eq!(wire.chip.take_broken(), Some(MAIN_DRIVEN));
        let driven = wire.chip.main_us(wire.now) == [1500; 8];
        assert_eq!(driven, firmware == IoFirmware::Px4V5);
        if firmware != IoFirmware::Px4V5 {
            wire.write(50, 12, &[22027]);
            assert_eq!(wire.chip.main_us(wire.now), [1500; 8]);
        }
    }
}

/// 500 ms to the failsafe page, 500 ms to the disarmed page, 200 ms to the failsafe page.
#[test]
fn an_fmu_that_falls_silent_is_lost_in_each_ones_time() {
    for (firmware, after_ms, pulse) in
        [(IoFirmware::Px4V4, 500, 1500), (IoFirmware::Px4V5, 500, 900), (IoFirmware::ArduPilot, 200, 1500)]
    {
        let mut wire = Wire::to(firmware);
        wire.chip.leave_armed();
        wire.chip.direct_us = [1600; 8];
        wire.read(0, 0, 2);
        let heard = wire.chip.last_packet.unwrap();
        assert_eq!(wire.chip.main_us(heard + after_ms * 1000 * TICKS_PER_US - 1), [1600; 8]);
        assert_eq!(wire.chip.main_us(heard + after_ms * 1000 * TICKS_PER_US), [pulse; 8], "{firmware:?}");
    }
}

#[test]
fn the_button_is_held_for_a_second() {
    for firmware in STOCK {
        let mut wire = Wire::made_safe(firmware);
        wire.write(50, 1, &[IO_ARM_OK]);
        let flags = |wire: &mut Wire| match firmware {
            IoFirmware::ArduPilot => wire.read(1, 0, 11).unwrap().1[10] & 0xff,
            IoFirmware::Px4V5 => wire.read(1, 2, 1).unwrap().1[0] >> 14 & 1,
            _ => wire.read(1, 2, 1).unwrap().1[0] >> 12 & 1,
        };
        wire.chip.press(true, wire.now);
        wire.wait(BUTTON_HELD / 2);
        wire.chip.tick(wire.now);
        assert_eq!(flags(&mut wire), 0);
        wire.wait(BUTTON_HELD / 2);
        wire.chip.tick(wire.now);
        assert_eq!(flags(&mut wire), 1, "{firmware:?}");
        if firmware == IoFirmware::Px4V5 {
            wire.write(50, 14, &[0]);
            assert_eq!(flags(&mut wire), 0);
        }
    }
}

#[test]
fn a_receiver_is_lost_after_a_fifth_of_a_second() {
    for firmware in STOCK {
        let mut wire = Wire::to(firmware);
        let mut channels = [1500; CHANNELS];
        channels[7] = 1234;
        wire.chip.radio_frame(&channels, false, wire.now);
        let (heard, at): (fn(&[u16]) -> bool, _) = match firmware {
            IoFirmware::ArduPilot => (|registers| registers[0] >> 9 & 1 == 1, 2),
            _ => (|registers| registers[1] >> 4 & 1 == 1, 6),
        };
        let registers = wire.read(4, 0, 18).unwrap().1;
        assert!(heard(&registers));
        assert_eq!((registers[at], registers[at + 7]), (1500, 1234));
        wire.wait(LOST_FOR);
        assert!(!heard(&wire.read(4, 0, 18).unwrap().1));
        wire.chip.radio_frame(&channels, true, wire.now);
        let registers = wire.read(4, 0, 18).unwrap().1;
        let failsafe = if firmware == IoFirmware::ArduPilot { registers[0] >> 8 & 1 } else { registers[1] >> 1 & 1 };
        assert_eq!((failsafe, heard(&registers)), (1, false));
    }
}

const LOST_FOR: Ticks = 200_000 * TICKS_PER_US;

#[test]
fn arming_and_safety_outlive_the_fmu_but_not_the_chip() {
    let mut wire = Wire::made_safe(IoFirmware::Px4V4);
    wire.chip.leave_armed();
    wire.chip.fmu_restarted();
    assert!(wire.chip.is_safety_off() && wire.chip.main_us(wire.now) != [0; 8]);
    wire.chip.restart(wire.now);
    assert!(!wire.chip.is_safety_off() && wire.chip.main_us(wire.now) == [0; 8]);
    assert_eq!(wire.read(0, 0, 2), None, "it starts");
    wire.wait(BOOT);
    assert!(wire.read(0, 0, 2).is_some());
    // a button that is held then keeps the bootloader
    wire.chip.press(true, wire.now);
    wire.chip.restart(wire.now);
    wire.wait(2 * BOOT);
    assert_eq!(wire.read(0, 0, 2), None);
}

#[test]
fn corrupt_packets_are_answered_as_such_or_come_damaged() {
    let mut wire = Wire::to(IoFirmware::Px4V5);
    wire.chip.set_fault(Some(IoFault::Corrupt(500)));
    let mut seen = [0; 3];
    for _ in 0..200 {
        wire.chip.receive(&packet::reply(READ, (0, 0), &[0; 2]), wire.now);
        wire.wait(IDLE);
        wire.chip.tick(wire.now);
        wire.wait(LATENCY);
        match wire.chip.tick(wire.now).map(|reply| packet::parse(&reply, false)) {
            Some(Arrived::Whole(packet)) if packet.code == SUCCESS => seen[0] += 1,
            Some(Arrived::Whole(packet)) if packet.code == CORRUPT => seen[1] += 1,
            _ => seen[2] += 1,
        }
    }
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
}
