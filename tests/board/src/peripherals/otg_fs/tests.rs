//! The registers and the bus by themselves: a device of one endpoint besides 0, by hand.

use super::*;

const CLOCK: Option<Ticks> = Some(7);
const GUSBCFG: u32 = 0x00c;
const GINTSTS: u32 = 0x014;
const GRXSTSP: u32 = 0x020;
const DCFG: u32 = 0x800;
const DIEPCTL0: u32 = 0x900;
const DIEPTSIZ0: u32 = 0x910;
const DOEPCTL0: u32 = 0xb00;
const DOEPTSIZ0: u32 = 0xb10;
const CNAK: u32 = 1 << 26;
const EPENA: u32 = 1 << 31;

/// Attached, reset, with FIFOs.
fn device() -> OtgFs {
    let mut usb = OtgFs::default();
    usb.set_phy_cycle(CLOCK);
    usb.set_connector(true, true);
    let settings = [(GUSBCFG, 1 << 30 | 6 << 10), (0x038, PWRDWN | VBUSBSEN), (DCFG, DCFG_AT_RESET | FULL_SPEED)];
    for (register, value) in settings.into_iter().chain([(0x024, 64), (0x028, 16 << 16 | 64)]) {
        usb.write(register, value, 0).unwrap();
    }
    assert!(usb.is_attached());
    usb.bus_reset_begins();
    usb.bus_reset_ends().unwrap();
    usb
}

fn why(result: Result<(), Unmodelled>) -> &'static str {
    result.expect_err("it should be refused").0
}

#[test]
fn a_request_is_taken_and_answered() {
    let mut usb = device();
    usb.write(DOEPTSIZ0, 3 << 29 | 1 << 19 | 64, 0).unwrap();
    assert_eq!(usb.setup(0, &[0x80, 6, 0, 1, 0, 0, 18, 0]), Answer::Ack);
    assert_eq!(usb.setup(1, &[0; 8]), Answer::Silence, "of another address");
    assert_eq!(usb.input(0, 0), Answer::Nak);
    assert_ne!(usb.read(GINTSTS, 0).unwrap() & RXFLVL, 0);
    assert_eq!(usb.read(GRXSTSP, 0).unwrap(), 6 << 17 | 8 << 4);
    assert_eq!([usb.read(0x1000, 0).unwrap(), usb.read(0x1000, 0).unwrap()], [0x0100_0680, 0x0012_0000]);
    assert_eq!(usb.read(GRXSTSP, 0).unwrap(), 4 << 17);
    assert_eq!(usb.read(0xb08, 0).unwrap() & STUP, STUP);
    // five bytes, a packet that is not full
    usb.write(DIEPTSIZ0, 1 << 19 | 5, 0).unwrap();
    usb.write(DIEPCTL0, EPENA | CNAK, 0).unwrap();
    usb.write(0x1000, 0x0403_0201, 0).unwrap();
    assert_eq!(usb.input(0, 0), Answer::Nak, "not all of it is there yet");
    usb.write(0x1000, 5, 0).unwrap();
    assert_eq!(usb.input(0, 0), Answer::Data(vec![1, 2, 3, 4, 5], true));
    assert_eq!(usb.read(0x908, 0).unwrap() & XFRC, XFRC);
    assert_eq!(usb.output(0, 0, &[], true), Answer::Nak, "not enabled");
    usb.write(DOEPCTL0, EPENA | CNAK, 0).unwrap();
    assert_eq!(usb.output(0, 0, &[], true), Answer::Ack);
}

#[test]
fn an_address_counts_behind_the_status_stage_and_a_reset_does_not_take_it_back() {
    let mut usb = device();
    usb.setup(0, &[0, 5, 9, 0, 0, 0, 0, 0]);
    assert_eq!(usb.input(0, 0), Answer::Nak);
    usb.write(DCFG, DCFG_AT_RESET | FULL_SPEED | 9 << 4, 0).unwrap();
    usb.write(DIEPTSIZ0, 1 << 19, 0).unwrap();
    usb.write(DIEPCTL0, EPENA | CNAK, 0).unwrap();
    assert_eq!(usb.input(9, 0), Answer::Silence);
    assert_eq!(usb.input(0, 0), Answer::Data(Vec::new(), true));
    assert_eq!(usb.input(9, 0), Answer::Nak);
    usb.bus_reset_begins();
    usb.bus_reset_ends().unwrap();
    // the image has to write 0
    assert_eq!(usb.setup(0, &[0; 8]), Answer::Silence);
}

#[test]
fn without_clock_lines_voltage_or_pull_up_nobody_is_there() {
    let mut usb = device();
    usb.set_phy_cycle(Some(8));
    assert!(!usb.is_attached());
    usb.set_phy_cycle(CLOCK);
    usb.set_connector(false, true);
    assert!(!usb.is_attached() && usb.read(0x004, 0).unwrap() & SEDET != 0);
    usb.set_connector(true, false);
    assert!(!usb.is_attached());
    usb.set_connector(true, true);
    usb.write(0x804, SDIS, 0).unwrap();
    assert!(!usb.is_attached());
}

#[test]
fn what_the_manual_forbids_is_refused() {
    let mut usb = device();
    assert_eq!(usb.read(GRXSTSP, 0).unwrap_err().0, "status popped while the receive FIFO is empty");
    usb.setup(0, &[0; 8]);
    usb.input(0, 0);
    usb.read(GRXSTSP, 0).unwrap();
    assert_eq!(usb.read(GRXSTSP, 0).unwrap_err().0, "the next status popped before all data of the packet were read");
    usb.read(0x1000, 0).unwrap();
    usb.read(0x1000, 0).unwrap();
    assert_eq!(usb.read(0x1000, 0).unwrap_err().0, "more read from the receive FIFO than the packet holds");
    usb.write(DIEPTSIZ0, 1 << 19 | 4, 0).unwrap();
    usb.write(DIEPCTL0, EPENA | CNAK, 0).unwrap();
    assert_eq!(why(usb.write(DIEPTSIZ0, 0, 0)), "transfer size written while the endpoint is enabled");
    usb.write(0x1000, 0, 0).unwrap();
    assert_eq!(why(usb.write(0x1000, 0, 0)), "more written into a transmit FIFO than the transfer has");
    let mut overlapping = device();
    overlapping.write(0x028, 16 << 16 | 63, 0).unwrap();
    overlapping.write(DIEPTSIZ0, 1 << 19, 0).unwrap();
    assert_eq!(
        why(overlapping.write(DIEPCTL0, EPENA | CNAK, 0)),
        "FIFOs that overlap, are too short or beyond 320 words"
    );
    let mut hasty = device();
    hasty.write(GUSBCFG, 1 << 30 | 5 << 10, 0).unwrap();
    hasty.bus_reset_begins();
    assert_eq!(why(hasty.bus_reset_ends()), "turnaround time for another clock of the AHB");
    assert_eq!(
        why(hasty.write(0x010, CSRST, 0).and_then(|()| hasty.write(0x018, 0, 1))),
        "OTG_FS written to during its reset"
    );
    assert!(hasty.read(0x400, 0).is_err(), "host mode");
}
