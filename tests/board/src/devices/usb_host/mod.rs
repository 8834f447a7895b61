//! A computer at the USB connector: it resets the bus, enumerates what is there (USB 2.0, section 9.1.2), and uses a
//! serial port of the CDC class (PSTN subclass 1.2). Full speed, one device, no hub.
//!
//! Time is that of the bus: a frame is 1 ms, a transaction takes its bytes and 13 more (section 5.8.4). What the device
//! does not accept, or has not got, is asked for again 0.1 ms later.

mod bus_noise;
mod control;
mod enumeration;

use std::collections::VecDeque;

use bus_noise::{BusNoise, Hurt};
pub use control::{Failure, Request};
use control::{Outcome, Transfer};
pub use enumeration::Enumerated;
use enumeration::Enumeration;

use crate::peripherals::Unmodelled;
use crate::peripherals::otg_fs::{Answer, OtgFs};
use crate::time::{TICKS_PER_US, Ticks};

const MILLISECOND: Ticks = 1000 * TICKS_PER_US;
/// From attachment to the first reset, for contacts that bounce (section 7.1.7.3).
const DEBOUNCE: Ticks = 100 * MILLISECOND;
/// A root port's reset (section 7.1.7.5), and the recovery behind it.
const RESET: Ticks = 50 * MILLISECOND;
const RECOVERY: Ticks = 10 * MILLISECOND;
/// The device has so long for its new address (section 9.2.6.3).
const ADDRESS_RECOVERY: Ticks = 2 * MILLISECOND;
const FRAME: Ticks = MILLISECOND;
/// A byte at 12 Mbit/s.
const BYTE: Ticks = TICKS_PER_US * 8 / 12;
/// Of each transaction, besides its data.
const OVERHEAD_BYTES: usize = 13;
const AGAIN: Ticks = 100 * TICKS_PER_US;
/// What a request without an answer may take (section 9.2.6.1).
const REQUEST_MAX: Ticks = 5000 * MILLISECOND;
/// Silence in a row that ends a request.
const SILENCES_MAX: u32 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bus {
    /// Nothing is plugged in, or nothing pulls D+ up.
    Empty,
    Debouncing,
    Resetting,
    /// Frames are sent.
    Alive,
    /// The computer sleeps: no frames.
    Asleep,
}

/// A pipe for bytes: endpoint, bytes of its packets, toggle.
#[derive(Clone, Copy, Debug)]
struct Pipe {
    endpoint: usize,
    packet_bytes: usize,
    toggle: bool,
}

/// The computer.
#[derive(Clone, Debug)]
pub struct UsbHost {
    plugged: bool,
    bus: Bus,
    /// When the bus gets to something next.
    next: Ticks,
    frame_at: Ticks,
    frame: u32,
    address: u8,
    packet_bytes: Option<usize>,
    waiting: VecDeque<Request>,
    transfer: Option<(Transfer, Ticks, u32)>,
    results: Vec<(Request, Result<Vec<u8>, Failure>)>,
    enumeration: Enumeration,
    input: Option<Pipe>,
    output: Option<Pipe>,
    /// Whose turn it is of the two pipes.
    input_next: bool,
    outgoing: VecDeque<u8>,
    received: Vec<u8>,
    reads: bool,
    resets: u32,
    noise: BusNoise,
}

impl Default for UsbHost {
    fn default() -> Self {
        Self {
            plugged: false,
            bus: Bus::Empty,
            next: 0,
            frame_at: 0,
            frame: 0,
            address: 0,
            packet_bytes: None,
            waiting: VecDeque::new(),
            transfer: None,
            results: Vec::new(),
            enumeration: Enumeration::default(),
            input: None,
            output: None,
            input_next: true,
            outgoing: VecDeque::new(),
            received: Vec::new(),
            reads: true,
            resets: 0,
            noise: BusNoise::default(),
        }
    }
}

impl UsbHost {
    /// Puts the plug in, or pulls it out.
    pub fn plug(&mut self, plugged: bool) {
        self.plugged = plugged;
    }

    /// Is there 5 V at the connector?
    pub fn is_plugged(&self) -> bool {
        self.plugged
    }

    /// The computer sleeps, or wakes.
    pub fn sleep(&mut self, asleep: bool) {
        match (self.bus, asleep) {
            (Bus::Alive, true) => self.bus = Bus::Asleep,
            (Bus::Asleep, false) => self.bus = Bus::Alive,
            _ => {}
        }
    }

    /// What the device is, once it has an address and a configuration.
    pub fn enumerated(&self) -> Option<&Enumerated> {
        self.enumeration.done()
    }

    /// So often has the bus been reset.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// Has a program open the port, as an operating system does: line coding (115,200 baud, 8N1), then DTR and RTS.
    pub fn open(&mut self) {
        let interface = self.enumerated().map_or(0, |device| device.control_interface).into();
        self.request(Request::write(0x21, 0x20, 0, interface, &[0x00, 0xc2, 0x01, 0x00, 0, 0, 8]));
        self.request(Request::write(0x21, 0x22, 0b11, interface, &[]));
    }

    /// The program ends.
    pub fn close(&mut self) {
        let interface = self.enumerated().map_or(0, |device| device.control_interface).into();
        self.request(Request::write(0x21, 0x22, 0, interface, &[]));
    }

    /// Makes a request, behind those that wait.
    pub fn request(&mut self, request: Request) {
        self.waiting.push_back(request);
    }

    /// What came of each request since the last call, those of the enumeration included.
    pub fn take_results(&mut self) -> Vec<(Request, Result<Vec<u8>, Failure>)> {
        std::mem::take(&mut self.results)
    }

    /// Bytes to the port.
    pub fn send(&mut self, bytes: &[u8]) {
        self.outgoing.extend(bytes);
    }

    /// Bytes that have not gone over yet.
    pub fn unsent(&self) -> usize {
        self.outgoing.len()
    }

    /// Bytes from the port since the last call.
    pub fn take_received(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.received)
    }

    /// Whether anybody reads the port; who does not keeps it open all the same.
    pub fn set_reading(&mut self, reads: bool) {
        self.reads = reads;
    }

    /// So many of a thousand transactions lose a packet or a handshake from now on, by a cable that is too long.
    pub fn disturb(&mut self, permille: u32) {
        self.noise.set(permille);
    }

    /// Transactions that were disturbed so far.
    pub fn disturbed(&self) -> u32 {
        self.noise.hurt()
    }

    pub(crate) fn next_event(&self) -> Option<Ticks> {
        (self.bus != Bus::Empty).then_some(self.next)
    }

    /// All that is due on the bus.
    pub(crate) fn tick(&mut self, device: &mut OtgFs, now: Ticks) -> Result<(), Unmodelled> {
        let attached = self.plugged && device.is_attached();
        if attached == (self.bus == Bus::Empty) {
            self.attach(attached, device, now);
        }
        while self.bus != Bus::Empty && self.next <= now {
            let at = self.next;
            self.step(device, at)?;
        }
        Ok(())
    }

    /// Something is there, or is gone.
    fn attach(&mut self, attached: bool, device: &mut OtgFs, now: Ticks) {
        if attached {
            (self.bus, self.next) = (Bus::Debouncing, now + DEBOUNCE);
            return;
        }
        let failed =
            self.transfer.take().map(|(transfer, ..)| transfer.request).into_iter().chain(self.waiting.drain(..));
        self.results.extend(failed.map(|request| (request, Err(Failure::TimedOut))));
        self.bus = Bus::Empty;
        self.enumeration = Enumeration::default();
        (self.input, self.output) = (None, None);
        self.outgoing.clear();
        device.suspend();
    }

    fn step(&mut self, device: &mut OtgFs, at: Ticks) -> Result<(), Unmodelled> {
        match self.bus {
            Bus::Empty => {}
            Bus::Debouncing => {
                device.bus_reset_begins();
                (self.bus, self.next, self.resets) = (Bus::Resetting, at + RESET, self.resets + 1);
            }
            Bus::Resetting => {
                device.bus_reset_ends()?;
                (self.bus, self.address) = (Bus::Alive, 0);
                (self.next, self.frame_at) = (at + FRAME, at + FRAME);
                let first = self.enumeration.after_reset();
                self.begin(first, at + RECOVERY);
            }
            Bus::Asleep => {
                // three frames are missing by now
                device.suspend();
                self.next = at + 3 * FRAME;
                self.frame_at = self.next;
            }
            Bus::Alive => self.work(device, at),
        }
        Ok(())
    }

    /// A frame's beginning, or a transaction.
    fn work(&mut self, device: &mut OtgFs, at: Ticks) {
        if at >= self.frame_at {
            device.resume();
            self.frame += 1;
            device.start_of_frame(self.frame);
            self.frame_at += FRAME;
        }
        let outcome = if self.transfer.is_some() {
            self.control(device, at)
        } else if let Some(request) = self.waiting.pop_front() {
            self.begin(request, at);
            self.control(device, at)
        } else {
            self.pipes(device)
        };
        let after = match outcome {
            Some(Outcome::Moved(bytes)) => (bytes + OVERHEAD_BYTES) as Ticks * BYTE,
            Some(Outcome::Nak | Outcome::Silence) => AGAIN,
            None => FRAME,
        };
        self.next = if self.bus == Bus::Alive { (at + after).min(self.frame_at) } else { self.next };
    }

    fn begin(&mut self, request: Request, at: Ticks) {
        self.transfer = Some((Transfer::new(request), at, 0));
    }

    fn control(&mut self, device: &mut OtgFs, at: Ticks) -> Option<Outcome> {
        let (address, packet) = (self.address, self.packet_bytes);
        let (transfer, begin, silences) = self.transfer.as_mut()?;
        if at < *begin {
            return None;
        }
        let (outcome, mut over) = match self.noise.draw() {
            Hurt::Token => (Outcome::Silence, None),
            _ => transfer.step(device, address, packet),
        };
        *silences = if outcome == Outcome::Silence { *silences + 1 } else { 0 };
        if *silences >= SILENCES_MAX || at > *begin + REQUEST_MAX {
            over = Some(Err(Failure::TimedOut));
        }
        if let Some(result) = over
            && let Some((transfer, ..)) = self.transfer.take()
        {
            self.finish(transfer.request, result, device, at);
        }
        Some(outcome)
    }

    fn finish(&mut self, request: Request, result: Result<Vec<u8>, Failure>, device: &mut OtgFs, at: Ticks) {
        self.results.push((request.clone(), result.clone()));
        let Some(next) = self.enumeration.take(&request, &result) else { return };
        match next {
            enumeration::Next::Reset { packet_bytes } => {
                self.packet_bytes = Some(packet_bytes);
                device.bus_reset_begins();
                (self.bus, self.next, self.resets) = (Bus::Resetting, at + RESET, self.resets + 1);
            }
            enumeration::Next::Request(request) => self.begin(request, at),
            enumeration::Next::Addressed(address, request) => {
                self.address = address;
                self.begin(request, at + ADDRESS_RECOVERY);
            }
            enumeration::Next::Done => {
                let pipe = |(endpoint, packet_bytes)| Pipe { endpoint, packet_bytes, toggle: false };
                let device = self.enumeration.done();
                self.input = device.and_then(|device| device.bulk_in).map(pipe);
                self.output = device.and_then(|device| device.bulk_out).map(pipe);
            }
        }
    }

    /// A packet of bytes in or out, in turns.
    fn pipes(&mut self, device: &mut OtgFs) -> Option<Outcome> {
        self.input_next = !self.input_next;
        let wants_in = self.reads && self.input.is_some();
        let wants_out = !self.outgoing.is_empty() && self.output.is_some();
        match (wants_in, wants_out, self.input_next) {
            (true, false, _) | (true, true, true) => self.read(device),
            (_, true, _) => self.write(device),
            (false, false, _) => None,
        }
    }

    fn read(&mut self, device: &mut OtgFs) -> Option<Outcome> {
        let pipe = self.input.as_mut()?;
        let answer = match self.noise.draw() {
            Hurt::Nothing => device.input(self.address, pipe.endpoint),
            Hurt::Token => return Some(Outcome::Silence),
            Hurt::Data => {
                device.input_without_acknowledgement(self.address, pipe.endpoint);
                return Some(Outcome::Silence);
            }
            Hurt::Handshake => device.input_without_acknowledgement(self.address, pipe.endpoint),
        };
        match answer {
            Answer::Data(bytes, toggle) => {
                // a packet of the other toggle is one that was had before
                if toggle == pipe.toggle {
                    self.received.extend(&bytes);
                    pipe.toggle = !pipe.toggle;
                }
                Some(Outcome::Moved(bytes.len()))
            }
            _ => Some(Outcome::Nak),
        }
    }

    fn write(&mut self, device: &mut OtgFs) -> Option<Outcome> {
        let pipe = self.output.as_mut()?;
        let count = self.outgoing.len().min(pipe.packet_bytes);
        let bytes: Vec<u8> = self.outgoing.range(..count).copied().collect();
        let hurt = self.noise.draw();
        if matches!(hurt, Hurt::Token | Hurt::Data) {
            return Some(Outcome::Silence);
        }
        if device.output(self.address, pipe.endpoint, &bytes, pipe.toggle) != Answer::Ack {
            return Some(Outcome::Nak);
        }
        if hurt == Hurt::Handshake {
            // it was taken, and comes again
            return Some(Outcome::Silence);
        }
        self.outgoing.drain(..count);
        pipe.toggle = !pipe.toggle;
        Some(Outcome::Moved(count))
    }
}
