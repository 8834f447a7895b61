//! Control transfers. USB 2.0 sections 8.5.3 and 9.3.

use crate::peripherals::otg_fs::{Answer, OtgFs};

/// Bytes of a packet of endpoint 0, as long as the device has not said how many: a shorter one ends the stage.
const PACKET_BYTES_AT_FIRST: usize = 64;

/// A request: its eight bytes, and what follows them towards the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// bmRequestType: bit 7 is set where the device answers.
    pub kind: u8,
    /// bRequest.
    pub code: u8,
    /// wValue.
    pub value: u16,
    /// wIndex.
    pub index: u16,
    /// wLength, where the device answers.
    pub length: u16,
    /// What the host sends with it.
    pub data: Vec<u8>,
}

impl Request {
    /// One that the device answers with at most so many bytes.
    pub fn read(kind: u8, code: u8, value: u16, index: u16, length: u16) -> Self {
        Self { kind, code, value, index, length, data: Vec::new() }
    }

    /// One that goes to the device with these bytes.
    pub fn write(kind: u8, code: u8, value: u16, index: u16, data: &[u8]) -> Self {
        Self { kind, code, value, index, length: data.len() as u16, data: data.to_vec() }
    }

    fn bytes(&self) -> [u8; 8] {
        let [value, index, length] = [self.value, self.index, self.length].map(u16::to_le_bytes);
        [self.kind, self.code, value[0], value[1], index[0], index[1], length[0], length[1]]
    }

    fn is_read(&self) -> bool {
        self.kind & 0x80 != 0
    }
}

/// Why a request was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The device has refused it.
    Stalled,
    /// It has not answered in time, or is gone.
    TimedOut,
    /// It has sent more than was asked for, or a packet of another toggle.
    Confused,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Setup,
    Data,
    Status,
}

/// A request under way.
#[derive(Clone, Debug)]
pub(super) struct Transfer {
    pub(super) request: Request,
    stage: Stage,
    toggle: bool,
    moved: Vec<u8>,
}

impl Transfer {
    pub(super) fn new(request: Request) -> Self {
        Self { request, stage: Stage::Setup, toggle: true, moved: Vec::new() }
    }

    /// One transaction: bytes that it moved, and what the whole came to, if it is over.
    pub(super) fn step(
        &mut self,
        device: &mut OtgFs,
        address: u8,
        packet_bytes: Option<usize>,
    ) -> (Outcome, Option<Result<Vec<u8>, Failure>>) {
        let packet = packet_bytes.unwrap_or(PACKET_BYTES_AT_FIRST);
        match self.stage {
            Stage::Setup => match device.setup(address, &self.request.bytes()) {
                Answer::Ack => {
                    self.stage = if self.request.length > 0 { Stage::Data } else { Stage::Status };
                    (Outcome::Moved(8), None)
                }
                _ => (Outcome::Silence, None),
            },
            Stage::Data if self.request.is_read() => self.take(device.input(address, 0), packet),
            Stage::Data => {
                let rest = &self.request.data[self.moved.len()..];
                let bytes = rest[..rest.len().min(packet)].to_vec();
                let answer = device.output(address, 0, &bytes, self.toggle);
                if answer == Answer::Ack {
                    self.moved.extend_from_slice(&bytes);
                    self.toggle = !self.toggle;
                    if self.moved.len() == self.request.data.len() {
                        self.stage = Stage::Status;
                    }
                }
                outcome(&answer, bytes.len())
            }
            Stage::Status if self.request.is_read() => {
                let answer = device.output(address, 0, &[], true);
                let done = (answer == Answer::Ack).then(|| Ok(std::mem::take(&mut self.moved)));
                let (outcome, failed) = outcome(&answer, 0);
                (outcome, done.or(failed))
            }
            Stage::Status => match device.input(address, 0) {
                Answer::Data(bytes, true) if bytes.is_empty() => (Outcome::Moved(0), Some(Ok(Vec::new()))),
                Answer::Data(..) => (Outcome::Moved(0), Some(Err(Failure::Confused))),
                answer => outcome(&answer, 0),
            },
        }
    }

    /// The device's answer to an IN token of the data stage.
    fn take(&mut self, answer: Answer, packet: usize) -> (Outcome, Option<Result<Vec<u8>, Failure>>) {
        let Answer::Data(bytes, toggle) = answer else { return outcome(&answer, 0) };
        self.moved.extend_from_slice(&bytes);
        if toggle != self.toggle || self.moved.len() > usize::from(self.request.length) {
            return (Outcome::Moved(bytes.len()), Some(Err(Failure::Confused)));
        }
        self.toggle = !self.toggle;
        if bytes.len() < packet || self.moved.len() == usize::from(self.request.length) {
            self.stage = Stage::Status;
        }
        (Outcome::Moved(bytes.len()), None)
    }
}

/// What one transaction came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// So many bytes went over.
    Moved(usize),
    /// The device wants to be asked again.
    Nak,
    /// No answer.
    Silence,
}

fn outcome(answer: &Answer, bytes: usize) -> (Outcome, Option<Result<Vec<u8>, Failure>>) {
    match answer {
        Answer::Nak => (Outcome::Nak, None),
        Answer::Silence => (Outcome::Silence, None),
        Answer::Stall => (Outcome::Moved(0), Some(Err(Failure::Stalled))),
        Answer::Ack | Answer::Data(..) => (Outcome::Moved(bytes), None),
    }
}
