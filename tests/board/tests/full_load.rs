//! Everything at once for a long time: the MPC with all its free inputs, the flight log on a card with real cards'
//! pauses, TELEM1's line full of messages both ways, USB as full as its bus allows both ways, the radio through the IO
//! chip. No step is late, no pulse moves by a tick.
//!
//! `FULL_LOAD_S=600 cargo test -p emulated-board --test full_load -- --nocapture` (behind `cargo fw`) flies ten minutes
//! of it, which take half an hour on a busy computer; without the variable it is a short flight.

use std::io::Cursor;

use emulated_board::pilot::{MIDDLE_US, PITCH, ROLL};
use emulated_board::time::{TICKS_PER_US, seconds};
use emulated_board::{Content, Flight, Ground, MILLISECOND, Pauses, SdCard, Transmitter};
use fatfs::{FatType, FileSystem, FsOptions};
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, FILE_TRANSFER_PROTOCOL_DATA, HEARTBEAT_DATA, MavCmd, MavType, PARAM_REQUEST_LIST_DATA,
};
use shared_control::config::Controller;
use shared_control::params::Params;
use shared_control::params::radio::RadioParams;

/// Of the flight, where nobody says another: some of the card's long pauses fall into it.
const USUAL_S: u64 = 10;
/// How often the sticks move and the lines are looked at.
const SLICE_MS: u64 = 10;
/// From one move of the sticks to the next; a new attitude in the middle of each settled one.
const STICK_MS: u64 = 700;
/// TELEM1 at 57,600 baud carries 5,760 bytes a second; a heartbeat has 21. A hundredth is left for the line list.
const HEARTBEATS_S: u64 = 5760 * 99 / 100 / 21;
/// What waits for USB at least, so that its bus never idles.
const USB_AHEAD_BYTES: usize = 4096;
/// The log's, with the MPC (docs/pixhawk.md), rounded up, and a file system around it.
const LOG_BYTES_S: usize = 100_000;
const CARD_BYTES_MIN: usize = 32 << 20;
/// The loop's interrupt (TIM3).
const LOOP: u8 = 29;
/// Messages that can be had at a rate of one's own, at intervals that the line has no room for together.
const STREAMS: [f32; 7] = [30.0, 31.0, 83.0, 36.0, 65.0, 105.0, 1.0];
/// Steps that the log may leave out, 1/1000: where several of the card's long pauses, 100 to 250 ms in one of 25
/// writes, come close together, the ring's 0.65 s are used up (1.4 in ten minutes).
const LEFT_OUT_PERMILLE_MAX: u64 = 5;
/// From an FTP burst to the next: a burst is two dozen pieces.
const BURST_MS: u64 = 200;

const LOADED: Params = Params {
    controller: Controller::Mpc,
    control_horizon: 30,
    radio: RadioParams { flies: true, kill_channel: 5, ..RadioParams::DEFAULT },
    ..Params::DEFAULT
};

fn duration_s() -> u64 {
    let said = std::env::var("FULL_LOAD_S").ok();
    said.map_or(USUAL_S, |text| text.parse().expect("FULL_LOAD_S is a number of seconds"))
}

/// Room for the whole flight's log.
fn card(flight_s: u64) -> SdCard {
    let bytes = CARD_BYTES_MIN.max((flight_s as usize + 10) * LOG_BYTES_S * 5 / 4).next_multiple_of(1 << 20);
    SdCard::new(Content::formatted(FatType::Fat16, bytes), Pauses::USUAL, 1)
}

/// Bytes of the only log.
fn log_bytes(flight: &mut Flight) -> u64 {
    let image = flight.machine.with_card(|card| card.content().image()).expect("a card");
    let volume = FileSystem::new(Cursor::new(image), FsOptions::new()).unwrap();
    let sizes: Vec<u64> = volume.root_dir().iter().map(|entry| entry.unwrap().len()).collect();
    assert_eq!(sizes.len(), 1, "logs: {sizes:?}");
    sizes[0]
}

/// MAVLink FTP: sequence, session, operation, and what belongs to it.
fn file_request(sequence: u16, opcode: u8, data: &[u8]) -> FILE_TRANSFER_PROTOCOL_DATA {
    let mut payload = [0; 251];
    payload[..2].copy_from_slice(&sequence.to_le_bytes());
    (payload[3], payload[4]) = (opcode, if data.is_empty() { 128 } else { data.len() as u8 });
    payload[12..12 + data.len()].copy_from_slice(data);
    FILE_TRANSFER_PROTOCOL_DATA { target_network: 0, target_system: 1, target_component: 1, payload }
}

/// Who fills the lines, and how much they have sent and heard.
struct Load {
    usb: Ground,
    telem1_heartbeats: u64,
    files_asked: u16,
    begin_ms: u64,
}

impl Load {
    /// What all may have at their own rates, requested until the vehicle says that there is no room.
    fn request_streams(&mut self, flight: &mut Flight) {
        let (command, target_system, target_component) = (MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, 1, 1);
        for message in STREAMS {
            for interval_us in [20_000.0, 50_000.0, 200_000.0] {
                let data = COMMAND_LONG_DATA {
                    command,
                    param1: message,
                    param2: interval_us,
                    target_system,
                    target_component,
                    ..COMMAND_LONG_DATA::DEFAULT
                };
                self.usb.send(&mut flight.machine, &data);
                flight.run_for(30 * MILLISECOND);
            }
        }
    }

    /// Keeps both lines full for a while.
    fn run(&mut self, flight: &mut Flight, duration_ms: u64) {
        let heartbeat = HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT };
        for slice in 0..duration_ms / SLICE_MS {
            let passed_ms = flight.machine.now() / MILLISECOND - self.begin_ms;
            while self.telem1_heartbeats < passed_ms * HEARTBEATS_S / 1000 {
                flight.ground.heartbeat(&mut flight.machine);
                self.telem1_heartbeats += 1;
            }
            while flight.machine.with_usb(|computer| computer.unsent()) < USB_AHEAD_BYTES {
                self.usb.send(&mut flight.machine, &heartbeat);
            }
            let at_ms = slice * SLICE_MS;
            if at_ms.is_multiple_of(1000) {
                let list = PARAM_REQUEST_LIST_DATA { target_system: 1, target_component: 1 };
                self.usb.send(&mut flight.machine, &list);
            }
            if at_ms.is_multiple_of(BURST_MS) {
                // open it, then have it in bursts, again and again
                let (opcode, name) = if self.files_asked == 0 { (4, &b"/parameters.json"[..]) } else { (15, &b""[..]) };
                self.files_asked += 1;
                let request = file_request(self.files_asked, opcode, name);
                self.usb.send(&mut flight.machine, &request);
            }
            flight.run_for(SLICE_MS * MILLISECOND);
            self.usb.listen(&mut flight.machine);
        }
    }
}

#[test]
fn no_step_is_late_with_link_log_usb_and_io_at_full_load() {
    let flight_s = duration_s();
    let mut flight = Flight::new(&LOADED, 1);
    flight.transmitter = Some(Transmitter::new());
    flight.machine.insert_card(card(flight_s));
    flight.machine.with_usb(|computer| computer.plug(true));
    flight.run_for(2000 * MILLISECOND);
    flight.machine.with_usb(|computer| {
        assert!(computer.enumerated().is_some());
        computer.open();
    });
    flight.mute();
    let begin_ms = flight.machine.now() / MILLISECOND;
    let mut load = Load { usb: Ground::on_usb(), telem1_heartbeats: 0, files_asked: 0, begin_ms };
    load.request_streams(&mut flight);
    flight.take_off_by_radio();
    load.begin_ms = flight.machine.now() / MILLISECOND;
    let (steps, begin) = (flight.twin.steps(), flight.machine.now());
    let attitudes = [1300, 1700, MIDDLE_US, 1755, 1245, MIDDLE_US];
    let mut moves = 0;
    while flight.machine.now() < begin + flight_s * 1000 * MILLISECOND {
        flight.set_stick(ROLL, attitudes[moves % attitudes.len()]);
        flight.set_stick(PITCH, attitudes[(moves / 2) % attitudes.len()]);
        moves += 1;
        load.run(&mut flight, STICK_MS);
    }
    let (steps, passed_s) = (flight.twin.steps() - steps, seconds(flight.machine.now() - begin));
    let profile = flight.machine.profile();
    let worst_cycles = profile.cycles_of_interrupt(LOOP).iter().copied().max().unwrap_or(0);
    let awake_permille = 1000.0 * (1.0 - seconds(profile.asleep()) / passed_s);
    let counted = ["LOOP_OVERRUNS", "LATE_PLANS", "LOG_STEPS_LEFT_OUT", "USB_DROPPED", "IO_DAMAGED", "ORDERS_DROPPED"]
        .map(|name| (name, flight.counter(name)));
    println!("{passed_s:.1} s, {steps} steps, {moves} moves of the sticks; {counted:?}; {:?}", flight.twin.planned());
    println!("loop's worst {worst_cycles} cycles of 420,000, awake {awake_permille:.0} permille");
    let delay = flight.vehicle.borrow().delays().range();
    assert_eq!(delay, Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)), "pulses are late");
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    assert_eq!((counted[0].1, flight.machine.counters().resets), (0, 0));
    assert_eq!(counted[1].1, 0, "late plans");
    assert!(u64::from(counted[2].1) * 1000 <= LEFT_OUT_PERMILLE_MAX * steps, "steps not in the log");
    // all was as full as is said above
    let heard = load.usb.bytes_heard() as f64 / passed_s;
    let unsent = flight.machine.with_usb(|computer| computer.unsent());
    println!("USB heard {heard:.0} bytes/s, {unsent} wait; {} heartbeats to TELEM1", load.telem1_heartbeats);
    assert!(heard > 5_000.0 && flight.ground.heartbeats() as f64 > 0.9 * passed_s, "{heard} bytes/s");
    flight.machine.with_usb(|computer| computer.plug(false));
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flight.run_for(3000 * MILLISECOND);
    let log_bytes = log_bytes(&mut flight);
    println!("{log_bytes} bytes of log");
    assert!(log_bytes as f64 > 0.9 * passed_s * 95_000.0, "{log_bytes} bytes");
}
