//! Raw bytes as what arrives on the link, through receiver, commander and telemetry.
//!
//! Of every chunk the first byte says what it is: bytes as they are, or the payload of a message that is understood,
//! framed, or signed, or signed with another key. Whatever the bytes: no panic, set-points are numbers in their range,
//! the vehicle speaks in frames, and while a key is in force nothing that is not signed with it commands.

use shared_control::config::Controller;
use shared_control::exchange::Exchange;
use shared_control::flight_core::State;
use shared_control::link::frame::{FRAME_MAX, FrameWriter};
use shared_control::link::parameters::QUIET_US;
use shared_control::link::signing::{Key, Signer, SigningRecord};
use shared_control::link::{
    Chore, Commander, Guard, LinkSettings, LogStore, Order, Receiver, Telemetry, VehicleStatus,
};
use shared_control::params::Params;
use shared_control::radio::StickCurves;
use shared_control::setup::Setup;
use shared_control::signals::ArmingBlocks;

/// Message id and last byte of the CRC of what is understood (`message_definitions/v1.0/common.xml`).
const UNDERSTOOD: [(u32, u8); 17] = [
    (0, 50),
    (20, 214),
    (21, 159),
    (23, 168),
    (43, 132),
    (69, 243),
    (75, 158),
    (76, 152),
    (82, 49),
    (107, 108),
    (110, 84),
    (111, 34),
    (117, 128),
    (119, 116),
    (121, 237),
    (122, 203),
    (256, 71),
];
const CHUNK_BYTES: usize = 48;
/// Bytes after which a frame has been found, if it is: itself, and a longest one that held it up.
const HELD_UP_MAX: usize = 2 * FRAME_MAX;

/// Everything between two ends of a line, but for the control loop.
struct Vehicle {
    receiver: Receiver,
    guard: Guard,
    commander: Commander,
    telemetry: Telemetry,
    status: VehicleStatus,
    logs: Logs,
    time_us: u64,
    is_keyed: bool,
    bytes_heard: usize,
    /// Bytes that were heard before each frame that is signed with the key and was not obeyed yet.
    rightly_signed: Vec<usize>,
}

/// So many logs of a kilobyte, until they are erased.
struct Logs(u16);

const LOG_BYTES: u32 = 1000;

impl LogStore for Logs {
    fn count(&mut self) -> u16 {
        self.0
    }

    fn size_bytes(&mut self, id: u16) -> u32 {
        if id < self.0 { LOG_BYTES } else { 0 }
    }

    fn read(&mut self, id: u16, offset: u32, piece: &mut [u8]) -> usize {
        let left = self.size_bytes(id).saturating_sub(offset);
        piece.len().min(left as usize)
    }

    fn erase(&mut self) {
        self.0 = 0;
    }
}

impl Vehicle {
    fn hear(&mut self, byte: u8) {
        self.bytes_heard += 1;
        let Some(order) = self.receiver.receive(byte, &mut self.guard) else { return };
        if self.is_keyed && !matches!(order, Order::HilTick(_)) {
            self.answer_for(&order);
        }
        let (answer, chore) = self.commander.order(&order, self.time_us);
        answer.into_iter().for_each(|answer| self.telemetry.answer(answer));
        if chore.as_ref().is_some_and(Chore::changes_parameters) {
            self.commander.await_change();
        }
        match chore {
            Some(Chore::Parameters(request)) => {
                self.telemetry.serve_parameters(&request, &self.status, |_| true);
            }
            Some(Chore::Tell(inquiry)) => self.telemetry.tell(&inquiry),
            Some(Chore::SetUpSigning(setup)) => {
                self.telemetry.set_up_signing(&setup, (&self.status, self.time_us), |_| true);
            }
            Some(Chore::Files(request)) => self.telemetry.take_file_request(&request),
            Some(Chore::Logs(request)) => self.telemetry.take_log_request(&request, &mut self.logs),
            Some(Chore::CalibrateLevel) => self.telemetry.calibrate_level(&self.status, |_| true),
            Some(Chore::StoreConfiguration) => self.telemetry.store_configuration(|_| true),
            Some(Chore::ClearFaultRecord | Chore::Restart) | None => {}
        }
    }

    /// Each order needs a frame that is signed with the key. It need not be the last that was heard: what lies
    /// unfinished in the receiver may hold it up, or swallow it.
    fn answer_for(&mut self, order: &Order) {
        let oldest = self.bytes_heard.saturating_sub(HELD_UP_MAX);
        self.rightly_signed.retain(|from| *from >= oldest);
        assert!(!self.rightly_signed.is_empty(), "{order:?}");
        self.rightly_signed.remove(0);
    }

    /// Whatever was set can be flown, and is taken whole.
    fn bring_into_use(&mut self) {
        if let Some(wanted) = self.telemetry.parameters_wanted(self.time_us).copied() {
            let setup = Setup::new(&wanted).expect("what a record can hold");
            let next = Exchange::new(&wanted, &setup);
            let mut config = setup.config;
            assert!(next.take_up(&mut config, &mut State::default(), &mut self.commander));
            self.receiver.use_curves(&StickCurves::new(&wanted.pilot));
            self.telemetry.parameters_in_use(&wanted, &next.senseless());
        }
        self.commander.settle(self.telemetry.parameters_settled(&self.status));
    }

    fn pass(&mut self) {
        self.time_us += 10_000;
        self.bring_into_use();
        let commands = self.commander.commands(self.time_us);
        for share in [commands.setpoint.roll_rad, commands.setpoint.pitch_rad] {
            assert!(share.abs() <= 1.1, "{commands:?}");
        }
        assert!((0.0..=1.0).contains(&commands.setpoint.throttle), "{commands:?}");
        let seen = (self.guard.latest_seen(), self.guard.refused);
        let terms = self.telemetry.update_signing(seen, self.time_us, |_| true);
        self.guard.follow(&terms);
        let mut said = heapless::Vec::<u8, 280>::new();
        self.telemetry.poll(self.time_us, &self.status, &mut said);
        self.telemetry.send_files(self.time_us, &self.status, &mut self.logs, &mut said);
        let mut rest = said.as_slice();
        while !rest.is_empty() {
            let is_signed = rest[2] & 1 == 1;
            assert!(rest[0] == 0xFD && is_signed == terms.key.is_some(), "{said:?}");
            rest = &rest[12 + usize::from(rest[1]) + if is_signed { 13 } else { 0 }..];
        }
    }
}

/// What holds whatever the bytes.
pub fn hold(bytes: &[u8]) {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let (key, other) = (Key::new([1; 32]).expect("not zeros"), Key::new([2; 32]).expect("not zeros"));
    let is_keyed = first & 1 == 1;
    let kept = SigningRecord { key: is_keyed.then_some(key), ..SigningRecord::default() };
    let settings = LinkSettings::NOMINAL;
    let mut vehicle = Vehicle {
        receiver: Receiver::new(settings),
        guard: Guard::open(),
        commander: Commander::new(&settings, ArmingBlocks::default()),
        telemetry: Telemetry::new(&settings, &Params::DEFAULT).with_signing(kept),
        status: VehicleStatus::at_start(Controller::Cascade),
        logs: Logs(3),
        time_us: 0,
        is_keyed,
        bytes_heard: 0,
        rightly_signed: Vec::new(),
    };
    let mut writer = FrameWriter::new(255, 190);
    vehicle.pass();
    for chunk in bytes.chunks(CHUNK_BYTES) {
        let kind = chunk[0];
        if kind % 5 == 0 {
            chunk.iter().for_each(|byte| vehicle.hear(*byte));
        } else {
            let signer = match kind % 5 {
                3 => Some(key),
                4 => Some(other),
                _ => None,
            };
            *writer.signer() = signer.map(|key| Signer::new(key, kind / 5));
            if let Some(signer) = writer.signer() {
                signer.set_clock(vehicle.time_us / 10);
            }
            let mut frame = heapless::Vec::<u8, 100>::new();
            assert!(writer.write_payload(UNDERSTOOD[usize::from(kind) % UNDERSTOOD.len()], &chunk[1..], &mut frame));
            if signer == Some(key) {
                vehicle.rightly_signed.push(vehicle.bytes_heard);
            }
            frame.iter().for_each(|byte| vehicle.hear(*byte));
        }
        vehicle.pass();
    }
    vehicle.time_us += QUIET_US;
    vehicle.pass();
    assert!(!vehicle.commander.commands(vehicle.time_us).blocks.parameters_waiting, "all that was set is in use");
}
