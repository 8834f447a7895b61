//! Endpoint 0: the standard requests of a device with one configuration, and those of the class.

use heapless::Vec;

use super::descriptors::{
    CONFIGURATION, CONFIGURATION_TYPE, CONFIGURATION_VALUE, CONTROL_INTERFACE, DATA_ENDPOINT, DATA_INTERFACE, DEVICE,
    DEVICE_TYPE, LANGUAGES, MANUFACTURER, NOTICE_ENDPOINT, PRODUCT, STRING_TYPE,
};

/// Bytes of an answer at most: two packets, less one byte.
pub const ANSWER_MAX: usize = 127;
/// Bytes of the line's coding: rate, stop bits, parity, data bits.
const CODING_LEN: usize = 7;
/// 57,600 baud 8N1. The port has no line; a computer reads back what it wrote.
const CODING_AT_START: [u8; CODING_LEN] = [0x00, 0xe1, 0x00, 0x00, 0, 0, 8];

/// A request: the eight bytes of a SETUP (USB 2.0 table 9-2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// bmRequestType and bRequest.
    pub kind: [u8; 2],
    /// wValue.
    pub value: u16,
    /// wIndex.
    pub index: u16,
    /// wLength: how much the host sends, or takes at most.
    pub length: u16,
}

impl Request {
    /// From its bytes.
    pub fn new(bytes: [u8; 8]) -> Self {
        let [kind, code, v0, v1, i0, i1, l0, l1] = bytes;
        let word = |low, high| u16::from_le_bytes([low, high]);
        Self { kind: [kind, code], value: word(v0, v1), index: word(i0, i1), length: word(l0, l1) }
    }
}

/// What the device does with a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Sends this much; as long as the host wants it at most.
    Send(Vec<u8, ANSWER_MAX>),
    /// Done: an empty packet says so.
    Done,
    /// The same, and from then on it has another address.
    Address(u8),
    /// Takes what follows, for [`Control::data`].
    Receive,
    /// Does not do it: a stall says so.
    Refuse,
    /// Done, and all endpoints but 0 begin anew, in use or not ([`Control::is_configured`]).
    Restart,
    /// Done, and this endpoint is halted, or goes on with its first toggle; bit 7 of its number: towards the host.
    Halt(u8, bool),
}

/// What a host has made of the device.
#[derive(Clone, Debug)]
pub struct Control {
    is_configured: bool,
    is_open: bool,
    coding: [u8; CODING_LEN],
    halted: [bool; 3],
    serial: [u8; 12],
}

impl Control {
    /// A device that no host has looked at; with the number that tells it from others.
    pub fn new(serial: [u8; 12]) -> Self {
        Self { is_configured: false, is_open: false, coding: CODING_AT_START, halted: [false; 3], serial }
    }

    /// The bus was reset, or the cable pulled.
    pub fn reset(&mut self) {
        *self = Self::new(self.serial);
    }

    /// Is it in use?
    pub fn is_configured(&self) -> bool {
        self.is_configured
    }

    /// Has a program the port open (DTR)?
    pub fn is_open(&self) -> bool {
        self.is_configured && self.is_open
    }

    /// Takes a request.
    pub fn take(&mut self, request: &Request) -> Reply {
        let reply = self.reply(request);
        match reply {
            Reply::Send(mut bytes) => {
                bytes.truncate(request.length.into());
                Reply::Send(bytes)
            }
            reply => reply,
        }
    }

    /// Takes what came with the request that was answered with [`Reply::Receive`]: a line coding is all that can.
    pub fn data(&mut self, bytes: &[u8]) {
        if let Some(coding) = bytes.first_chunk() {
            self.coding = *coding;
        }
    }

    fn reply(&mut self, request: &Request) -> Reply {
        let [low, high] = request.value.to_le_bytes();
        let interface = request.index <= u16::from(DATA_INTERFACE) && self.is_configured;
        match request.kind {
            // to the device
            [0x80, 0x00] => send(&[0, 0]),
            [0x80, 0x06] => self.descriptor(high, low),
            [0x80, 0x08] => send(&[if self.is_configured { CONFIGURATION_VALUE } else { 0 }]),
            [0x00, 0x05] if low < 0x80 && high == 0 => Reply::Address(low),
            [0x00, 0x09] if high == 0 && (low == 0 || low == CONFIGURATION_VALUE) => {
                let (coding, serial) = (self.coding, self.serial);
                *self = Self { is_configured: low != 0, coding, ..Self::new(serial) };
                Reply::Restart
            }
            // to an interface; each has one setting
            [0x81, 0x00] if interface => send(&[0, 0]),
            [0x81, 0x0a] if interface => send(&[0]),
            [0x01, 0x0b] if interface && request.value == 0 => Reply::Done,
            // to an endpoint: is it halted?
            [0x82, 0x00] => self.halted(request.index).map_or(Reply::Refuse, |halted| send(&[u8::from(*halted), 0])),
            [0x02, 0x01] if request.value == 0 => self.halt(request.index, false),
            [0x02, 0x03] if request.value == 0 => self.halt(request.index, true),
            // of the class
            [0x21, 0x20] if self.is_for_class(request) && usize::from(request.length) == CODING_LEN => Reply::Receive,
            [0xa1, 0x21] if self.is_for_class(request) => send(&self.coding),
            [0x21, 0x22] if self.is_for_class(request) => {
                self.is_open = low & 1 != 0;
                Reply::Done
            }
            _ => Reply::Refuse,
        }
    }

    fn is_for_class(&self, request: &Request) -> bool {
        self.is_configured && request.index == CONTROL_INTERFACE.into()
    }

    fn descriptor(&self, kind: u8, index: u8) -> Reply {
        match (kind, index) {
            (DEVICE_TYPE, 0) => send(&DEVICE),
            (CONFIGURATION_TYPE, 0) => send(&CONFIGURATION),
            (STRING_TYPE, 0) => send(&LANGUAGES),
            (STRING_TYPE, 1) => string(MANUFACTURER.bytes()),
            (STRING_TYPE, 2) => string(PRODUCT.bytes()),
            (STRING_TYPE, 3) => {
                let digit = |nibble: u8| if nibble < 10 { b'0' + nibble } else { b'A' + nibble - 10 };
                string(self.serial.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 0xf)]))
            }
            _ => Reply::Refuse,
        }
    }

    /// The mark of an endpoint that there is.
    fn halted(&mut self, index: u16) -> Option<&mut bool> {
        const DATA_IN: u16 = DATA_ENDPOINT as u16 | 0x80;
        const NOTICE_IN: u16 = NOTICE_ENDPOINT as u16 | 0x80;
        const DATA_OUT: u16 = DATA_ENDPOINT as u16;
        let place = match index {
            DATA_IN => 0,
            DATA_OUT => 1,
            NOTICE_IN => 2,
            _ => return None,
        };
        self.halted.get_mut(place).filter(|_| self.is_configured)
    }

    fn halt(&mut self, index: u16, halted: bool) -> Reply {
        let Some(mark) = self.halted(index) else { return Reply::Refuse };
        *mark = halted;
        Reply::Halt(index as u8, halted)
    }
}

fn send(bytes: &[u8]) -> Reply {
    Vec::from_slice(bytes).map_or(Reply::Refuse, Reply::Send)
}

/// A string descriptor of ASCII (section 9.6.7): UTF-16, low byte first.
fn string(text: impl Iterator<Item = u8>) -> Reply {
    let mut bytes = Vec::new();
    let mut whole = bytes.extend_from_slice(&[0, STRING_TYPE]).is_ok();
    for character in text {
        whole &= bytes.extend_from_slice(&[character, 0]).is_ok();
    }
    let length = bytes.len() as u8;
    if let Some(first) = bytes.first_mut() {
        *first = length;
    }
    if whole { Reply::Send(bytes) } else { Reply::Refuse }
}
